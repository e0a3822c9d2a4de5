//! A remedy for the seams of blocks: texels that other faces hold too count more than the others.
//!
//! Encoders weigh all texels of a block the same. So those that count more are asked for the opposite of
//! what they are off by, on top of their codes; blocks are made anew for that, and one that comes nearer to
//! the true codes by the weighted sum of squares takes the old one's place. What both sides of an edge are off by
//! falls, and so does the jump between them; no block can get worse.

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::error::Result;
use crate::finished::Finished;
use crate::image::{Image, Pixels};

use super::Level;
use super::blocks::{BLOCK_BYTES, BlockFormat, Blocks, SIDE};

/// What is added in each round: this many times what a texel is off by.
const GAINS: [f32; 3] = [1.0, 0.5, 2.0];
/// The weight of texels that no other face holds, to 1 for the others.
const WEIGHT_INSIDE: f32 = 0.1;

/// Blocks that hold the texels of `groups` better, or `None` where there are none, or the level has no
/// codes. Each group holds the numbers, `y · width + x`, of texels that hold one sample.
///
/// # Errors
/// `Internal` where the library refuses a level.
pub fn refit(
    finished: &Finished,
    [texture, number]: [usize; 2],
    blocks: &Blocks,
    groups: &[Vec<u32>],
) -> Result<Option<Blocks>> {
    let level = Level::of(&finished.textures[texture], number);
    let Pixels::U8(codes) = &level.image.pixels else { return Ok(None) };
    let format = BTreeSet::from([blocks.format]);
    let mut weights = vec![WEIGHT_INSIDE; level.image.texel_count()];
    groups.iter().flatten().for_each(|&texel| weights[texel as usize] = 1.0);
    let held = Held { image: level.image, stored: stored(blocks.format, &level), weights };
    let mut best = None;
    let mut current = blocks.clone();
    for gain in GAINS {
        let decoded = current.decode(&level)?.0;
        let mut targets = codes.clone();
        held.push(&decoded, groups, gain, &mut targets);
        let image = Image { pixels: Pixels::U8(targets), ..*level.image };
        let Some(other) = Blocks::encode(&Level { image: &image, ..level }, &format)? else { break };
        let [before, after] = [&decoded, &other.decode(&level)?.0].map(|decoded| held.costs(decoded));
        let pairs = current
            .texels
            .bytes
            .chunks_exact_mut(BLOCK_BYTES)
            .zip(other.texels.bytes.chunks_exact(BLOCK_BYTES));
        let mut changed_count = 0;
        for ((own, other), (before, after)) in pairs.zip(before.into_iter().zip(after)) {
            if after < before {
                own.copy_from_slice(other);
                changed_count += 1;
            }
        }
        if changed_count > 0 {
            best = Some(current.clone());
        }
    }
    Ok(best)
}

/// The components that a format keeps of a level, of red, green, blue and alpha.
fn stored(format: BlockFormat, level: &Level<'_>) -> &'static [usize] {
    match level.image.components {
        1 => &[0],
        2 => &[0, 3],
        _ if format == BlockFormat::Bc5 => &[0, 1],
        3 => &[0, 1, 2],
        _ => &[0, 1, 2, 3],
    }
}

/// The true codes, and how much each texel counts.
struct Held<'a> {
    image: &'a Image,
    stored: &'static [usize],
    weights: Vec<f32>,
}

impl Held<'_> {
    /// True less decoded code of one texel.
    fn lack(&self, decoded: &Image, x: u32, y: u32) -> [f32; 4] {
        let [wanted, got] = [self.image, decoded].map(|image| image.normalized(x, y));
        [0, 1, 2, 3].map(|k| 255.0 * (wanted[k] - got[k]))
    }

    /// The weighted sum of squares of each block.
    fn costs(&self, decoded: &Image) -> Vec<f32> {
        let [width, height] = self.image.size();
        let side = SIDE as u32;
        let of_block = |column: u32, row: u32| -> f32 {
            let mut sum = 0.0;
            for y in row * side..height.min((row + 1) * side) {
                for x in column * side..width.min((column + 1) * side) {
                    let lack = self.lack(decoded, x, y);
                    let squares: f32 = self.stored.iter().map(|&k| lack[k] * lack[k]).sum();
                    sum += self.weights[(y * width + x) as usize] * squares;
                }
            }
            sum
        };
        let columns = width.div_ceil(side);
        let rows = (0..height.div_ceil(side)).into_par_iter();
        rows.flat_map_iter(|row| (0..columns).map(move |column| (column, row)))
            .map(|(column, row)| of_block(column, row))
            .collect()
    }

    /// Adds what the texels of the groups lack, times the gain, to their codes.
    fn push(&self, decoded: &Image, groups: &[Vec<u32>], gain: f32, codes: &mut [u8]) {
        let (width, count) = (self.image.width, usize::from(self.image.components));
        for &texel in groups.iter().flatten() {
            let lack = self.lack(decoded, texel % width, texel / width);
            let codes = &mut codes[texel as usize * count..][..count];
            for (code, &k) in codes.iter_mut().zip(self.stored) {
                *code = (f32::from(*code) + gain * lack[k]).round() as u8;
            }
        }
    }
}
