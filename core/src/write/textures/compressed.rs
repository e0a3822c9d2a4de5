//! All levels of a conversion in blocks, where a format fits, and what a GPU reads from them.

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::error::Result;
use crate::finished::{Finished, FinishedTexture};
use crate::watch::{Watch, check};

use super::Level;
use super::blocks::{BlockFormat, Blocks};

/// Levels in blocks by texture and level; `None` where no format asked for fits.
pub struct Compressed(Vec<Vec<Option<Blocks>>>);

impl Compressed {
    /// # Errors
    /// `Canceled`; `Internal` where the library refuses a level.
    pub fn of(finished: &Finished, formats: &BTreeSet<BlockFormat>, watch: &dyn Watch) -> Result<Self> {
        let of_texture = |texture: &FinishedTexture| {
            let levels = (0..texture.levels.len()).into_par_iter();
            levels
                .map(|number| {
                    check(watch)?;
                    Blocks::encode(&Level::of(texture, number), formats)
                })
                .collect::<Result<Vec<_>>>()
        };
        Ok(Self(finished.textures.par_iter().map(of_texture).collect::<Result<_>>()?))
    }

    pub fn level(&self, texture: usize, level: usize) -> Option<&Blocks> {
        self.0.get(texture)?.get(level)?.as_ref()
    }

    /// Puts other blocks where a level has some; `blocks` gets those.
    pub fn swap(&mut self, [texture, level]: [usize; 2], blocks: &mut Blocks) {
        if let Some(own) = self.0[texture][level].as_mut() {
            std::mem::swap(own, blocks);
        }
    }

    /// The conversion as a GPU samples it.
    ///
    /// # Errors
    /// As [`Blocks::decode`].
    pub fn decoded(&self, finished: &Finished) -> Result<Finished> {
        let mut decoded = finished.clone();
        for ((texture, source), levels) in decoded.textures.iter_mut().zip(&finished.textures).zip(&self.0) {
            for (number, blocks) in levels.iter().enumerate() {
                let Some(blocks) = blocks else { continue };
                let (image, range) = blocks.decode(&Level::of(source, number))?;
                texture.levels[number] = image;
                if let Some(range) = range {
                    texture.ranges.insert(number, range);
                }
            }
        }
        Ok(decoded)
    }
}
