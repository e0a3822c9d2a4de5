//! What each level of a channel is wanted to show, before anything is changed to be stored.

use glam::Vec4;

use crate::assign::NormalFrames;
use crate::colors::{LevelNumbering, Resolutions};
use crate::error::Result;
use crate::mip::{Coarsener, Rungs, coverage, keep_coverage};
use crate::watch::{Stage, Watch};

use super::bare_normals::{show, take_bare};

/// A channel on its way from level to level.
pub struct Levels<'a> {
    pub resolutions: &'a Resolutions,
    /// At least 1.
    pub count: usize,
    pub rungs: Rungs,
    /// Of normals, which are filtered as what they add to those of these frames.
    pub frames: Option<&'a NormalFrames>,
    /// Of a masked material: keep the share of surface above this.
    pub mask_cutoff: Option<f32>,
}

/// Buffers for the samples of levels, which go from channel to channel: fresh memory costs as much as what is
/// worked out in it.
#[derive(Default)]
pub struct Rooms {
    /// For level 0, and for odd and even ones after it.
    by_level: [Vec<Vec4>; 3],
}

impl Rooms {
    pub fn take(&mut self, level: usize) -> Vec<Vec4> {
        std::mem::take(self.of(level))
    }

    fn give_back(&mut self, level: usize, room: Vec<Vec4>) {
        *self.of(level) = room;
    }

    fn of(&mut self, level: usize) -> &mut Vec<Vec4> {
        &mut self.by_level[if level == 0 { 0 } else { 2 - level % 2 }]
    }
}

impl Levels<'_> {
    /// Visits every level with its samples, from level 0 on, whose numbering and samples are given. A visitor hands the samples
    /// back if it has no use for their memory; whatever it makes of them does not reach the next level.
    ///
    /// # Errors
    /// `Canceled`; those of [`Coarsener::coarsen`] and of the visitor.
    pub fn each(
        &self,
        (mut numbering, mut values): (LevelNumbering<'_>, Vec<Vec4>),
        rooms: &mut Rooms,
        watch: &dyn Watch,
        mut visit: impl FnMut(&LevelNumbering<'_>, Vec<Vec4>) -> Result<Vec<Vec4>>,
    ) -> Result<()> {
        let (canvas, topology) = (numbering.canvas, numbering.topology);
        if let Some(frames) = self.frames {
            take_bare(&numbering, frames, &mut values);
        }
        let mut coarsener = Coarsener::new(self.rungs);
        let mut wanted_coverage = 0.0;
        for level in 0.. {
            watch.stage(Stage::Mip);
            // Before the visitor touches this level's samples: those of the next come from what was wanted.
            let mut next = None;
            if level + 1 < self.count {
                let coarse = LevelNumbering::new(canvas, topology, self.resolutions, level + 1);
                let room = rooms.take(level + 1);
                let coarse_values = coarsener.coarsen([&numbering, &coarse], &values, room, watch)?;
                next = Some((coarse, coarse_values));
            }
            if let Some(frames) = self.frames {
                show(&numbering, frames, &mut values);
            }
            if let Some(cutoff) = self.mask_cutoff {
                if level == 0 {
                    wanted_coverage = coverage(&numbering, &values, cutoff, watch)?;
                } else {
                    keep_coverage(&numbering, &mut values, (cutoff, wanted_coverage), watch)?;
                }
            }
            rooms.give_back(level, visit(&numbering, values)?);
            let Some(coarse) = next else { break };
            (numbering, values) = coarse;
        }
        Ok(())
    }
}
