//! Which levels ask for a range, and for which: by the values that their texels would store.

use glam::Vec4;
use rayon::prelude::*;

use crate::error::Result;
use crate::image::LevelRange;
use crate::watch::{self, Watch};

use super::Painter;
use super::band::{Band, Sheet};
use super::up_to_vertex::Scratch;
use crate::assign::codec::LevelCodec;
use crate::assign::{LevelChannel, LevelValues, Range, Rounding};

/// As much outside of [0, 1] is rounding, as the solver sees it.
const TOLERANCE: f32 = 1e-6;

/// The range that a level is stored in; `None` where it stays as the source has it: in the bounded
/// format, where every face is up to its vertex colors, and where all texels lie in [0, 1]. With a range
/// nothing is to be solved.
///
/// Level 0 has none: no face is beyond vertex colors there.
///
/// # Errors
/// `Canceled`.
pub fn choose_range(
    channel: &LevelChannel<'_>,
    values: &LevelValues,
    range: Range,
    watch: &dyn Watch,
) -> Result<Option<LevelRange>> {
    let codec = LevelCodec { plain: channel.codec, range: None };
    let painter = Painter { channel, values, codec, rounding: Rounding::Nearest };
    if range == Range::Unorm8 || !channel.layout.blocks.iter().any(|block| painter.is_beyond(block)) {
        return Ok(None);
    }
    let leaves = |[low, high]: [Vec4; 2]| {
        let leaves = |&component: &usize| low[component] < -TOLERANCE || high[component] > 1.0 + TOLERANCE;
        channel.codec.stored().iter().any(leaves)
    };
    // Beyond vertex colors are few texels, and the first to leave.
    let beyond = painter.extent(true, watch)?;
    if range == Range::Float16 && leaves(beyond) {
        return Ok(Some(LevelRange::Float16));
    }
    let all = join(beyond, painter.extent(false, watch)?);
    Ok(match range {
        _ if !leaves(all) => None,
        Range::Unorm8 => None,
        Range::Scaled16 => Some(LevelRange::spanning(all[0], all[1])),
        Range::Float16 => Some(LevelRange::Float16),
    })
}

impl Painter<'_> {
    /// The least and the largest value of all texels beyond vertex colors, or up to there, by component.
    fn extent(&self, is_beyond: bool, watch: &dyn Watch) -> Result<[Vec4; 2]> {
        const NOTHING: [Vec4; 2] = [Vec4::INFINITY, Vec4::NEG_INFINITY];
        let layout = self.channel.layout;
        let width = layout.sizes[self.channel.numbering.level][0] as usize;
        let ends = layout.row_starts[1..].iter().copied().chain([layout.blocks.len()]);
        let rows: Vec<_> = layout.row_starts.iter().copied().zip(ends).collect();
        let of_row = |scratch: &mut Scratch, (start, end): (usize, usize)| -> Result<[Vec4; 2]> {
            watch::check(watch)?;
            let mut extent = NOTHING;
            let first_row = layout.blocks[start].corner(self.channel.numbering.level).y as usize;
            let mut band = Band { sheet: Sheet::Extent(&mut extent), codec: self.codec, width, first_row };
            for block in layout.blocks[start..end].iter().filter(|block| self.is_beyond(block) == is_beyond) {
                self.paint_block(&mut band, block, scratch);
            }
            Ok(extent)
        };
        let extents: Vec<_> =
            rows.into_par_iter().map_init(Scratch::default, of_row).collect::<Result<_>>()?;
        Ok(extents.into_iter().fold(NOTHING, join))
    }
}

fn join([low, high]: [Vec4; 2], [l, h]: [Vec4; 2]) -> [Vec4; 2] {
    [low.min(l), high.max(h)]
}
