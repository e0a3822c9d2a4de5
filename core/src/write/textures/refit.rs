//! A remedy for the seams of blocks: those on one side of an edge are fitted to what the other side got.
//!
//! In each round every second block aims at what the other texels of its samples are decoded to, and is made
//! anew for that, pushed beyond by what it was off by. It takes the old one's place where it comes nearer
//! by the weighted sum of squares and no texel that it shares gets farther off. So the two sides draw
//! together, away from the true codes by less than blocks are anyhow. Normals are left as they are: faces store them
//! in frames of their own, so the two sides do not aim at the same code.
//!
//! Making blocks takes nearly all the time, so only those are made that are pushed by a code or more.

mod tiles;

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::error::Result;
use crate::finished::Finished;
use crate::image::{Image, Pixels};

use super::Level;
use super::blocks::{BLOCK_BYTES, Blocks, SIDE, TEXELS};
use tiles::{Tile, beside_each_other, tile_texel};

/// What is added to an aim in each round: this many times what the texel is off by. All blocks have had two
/// turns after four rounds.
const GAINS: [f32; 4] = [1.0, 1.0, 2.0, 2.0];
/// The weight of texels that no other face holds, to 1 for the others.
const WEIGHT_INSIDE: f32 = 0.1;
/// The share of the true code in an aim, so that both sides do not drift.
const TRUE_SHARE: f32 = 0.2;
/// How far an aim may be from the true code: what is off by more is not worth following.
const REACH_CODES: f32 = 4.0;

/// Blocks that differ less across edges, or `None` where none were found, or the level has no codes or holds
/// normals. Each of `groups` holds the numbers, `y · width + x`, of two texels or more that hold one sample.
///
/// # Errors
/// `Internal` where the library refuses the blocks.
pub fn refit(
    finished: &Finished,
    [texture, number]: [usize; 2],
    blocks: &Blocks,
    groups: &[Vec<u32>],
) -> Result<Option<Blocks>> {
    let level = Level::of(&finished.textures[texture], number);
    let Pixels::U8(source) = &level.image.pixels else { return Ok(None) };
    if level.is_normal || groups.is_empty() {
        return Ok(None);
    }
    let format = BTreeSet::from([blocks.format]);
    let mut fit = Fit::new(level.image, &blocks.decode(&level)?.0, groups);
    let mut current = blocks.clone();
    let mut is_changed = false;
    for (round, gain) in GAINS.into_iter().enumerate() {
        fit.follow(groups);
        let tiles = fit.pushed(round, gain, source);
        if tiles.is_empty() {
            continue;
        }
        let image = beside_each_other(&tiles, level.image.components);
        let pushed = Level { image: &image, ..level };
        let Some(made) = Blocks::encode(&pushed, &format)? else { break };
        let decoded = made.decode(&pushed)?.0;
        let blocks = made.texels.bytes.chunks_exact(BLOCK_BYTES);
        for (number, (tile, made)) in tiles.iter().zip(blocks).enumerate() {
            let got = std::array::from_fn(|k| codes(&decoded, tile_texel(&decoded, number, k)));
            if fit.take_if_better(tile.block, &got) {
                current.texels.bytes[tile.block * BLOCK_BYTES..][..BLOCK_BYTES].copy_from_slice(made);
                is_changed = true;
            }
        }
    }
    Ok(is_changed.then_some(current))
}

/// A level between two rounds. Codes are those of `Image::normalized`, by texel.
struct Fit<'a> {
    image: &'a Image,
    /// The components that are stored.
    stored: &'static [usize],
    /// Blocks in a row.
    columns: usize,
    /// What texels are to be decoded to, and what they are decoded to.
    aims: Vec<[f32; 4]>,
    got: Vec<[f32; 4]>,
    is_shared: Vec<bool>,
    /// Blocks that have shared texels.
    touched: Vec<usize>,
}

/// How far a block is off.
#[derive(Default)]
struct Cost {
    /// The weighted sum of squares.
    sum: f32,
    /// The largest of a shared texel.
    worst: f32,
}

impl<'a> Fit<'a> {
    fn new(image: &'a Image, decoded: &Image, groups: &[Vec<u32>]) -> Self {
        let stored: &[usize] = match image.components {
            1 => &[0],
            2 => &[0, 3],
            3 => &[0, 1, 2],
            _ => &[0, 1, 2, 3],
        };
        let columns = (image.width as usize).div_ceil(SIDE);
        let width = image.width as usize;
        let block = |texel: usize| texel / width / SIDE * columns + texel % width / SIDE;
        let mut is_shared = vec![false; image.texel_count()];
        groups.iter().flatten().for_each(|&texel| is_shared[texel as usize] = true);
        let touched: BTreeSet<usize> = groups.iter().flatten().map(|&texel| block(texel as usize)).collect();
        let all = |image: &Image| (0..image.texel_count() as u32).map(|texel| codes(image, texel)).collect();
        let touched = touched.into_iter().collect();
        Self { image, stored, columns, aims: all(image), got: all(decoded), is_shared, touched }
    }

    /// Aims the texels of each group at what the others of it are decoded to, in the mean.
    fn follow(&mut self, groups: &[Vec<u32>]) {
        for group in groups {
            let got = |k: usize| group.iter().map(|&texel| self.got[texel as usize][k]).sum::<f32>();
            let sums = [0, 1, 2, 3].map(got);
            for &texel in group {
                let (truth, own) = (codes(self.image, texel), self.got[texel as usize]);
                self.aims[texel as usize] = [0, 1, 2, 3].map(|k| {
                    let others = (sums[k] - own[k]) / (group.len() - 1) as f32;
                    let off = (1.0 - TRUE_SHARE) * (others - truth[k]);
                    truth[k] + off.clamp(-REACH_CODES, REACH_CODES)
                });
            }
        }
    }

    /// The blocks whose turn it is, with the codes that make them come nearer to their aims: those of shared
    /// texels pushed by what they lack.
    fn pushed(&self, round: usize, gain: f32, source: &[u8]) -> Vec<Tile> {
        // Like a chessboard, because neighbors that both give way would miss each other.
        let is_turn = |block: usize| (block % self.columns + block / self.columns + round).is_multiple_of(2);
        let count = usize::from(self.image.components);
        let tile = |&block: &usize| {
            let mut is_pushed = false;
            let texels = std::array::from_fn(|k| {
                let (texel, _) = self.texel(block, k);
                let mut own = [0; 4];
                own[..count].copy_from_slice(&source[texel * count..][..count]);
                if self.is_shared[texel] {
                    for (code, &k) in own.iter_mut().zip(self.stored) {
                        let lack = self.aims[texel][k] - self.got[texel][k];
                        let pushed = (f32::from(*code) + gain * lack).round() as u8;
                        is_pushed |= pushed != *code;
                        *code = pushed;
                    }
                }
                own
            });
            is_pushed.then_some(Tile { block, texels })
        };
        self.touched.par_iter().filter(|block| is_turn(**block)).filter_map(tile).collect()
    }

    /// Texel `k` of a block, and whether the image has it: beyond, the last column and row are repeated.
    fn texel(&self, block: usize, k: usize) -> (usize, bool) {
        let [width, height] = self.image.size().map(|side| side as usize);
        let x = block % self.columns * SIDE + k % SIDE;
        let y = block / self.columns * SIDE + k / SIDE;
        (y.min(height - 1) * width + x.min(width - 1), x < width && y < height)
    }

    /// Of a block with these codes.
    fn cost(&self, block: usize, got: &[[f32; 4]; TEXELS]) -> Cost {
        let mut cost = Cost::default();
        for (k, got) in got.iter().enumerate() {
            let (texel, is_inside) = self.texel(block, k);
            if !is_inside {
                continue;
            }
            let lack = |&k: &usize| self.aims[texel][k] - got[k];
            let squares = self.stored.iter().map(lack).map(|lack| lack * lack).sum::<f32>();
            if self.is_shared[texel] {
                cost.sum += squares;
                cost.worst = self.stored.iter().map(|k| lack(k).abs()).fold(cost.worst, f32::max);
            } else {
                cost.sum += WEIGHT_INSIDE * squares;
            }
        }
        cost
    }

    /// Whether a block comes nearer to its aims with these codes; then it has them.
    fn take_if_better(&mut self, block: usize, got: &[[f32; 4]; TEXELS]) -> bool {
        let own = std::array::from_fn(|k| self.got[self.texel(block, k).0]);
        let [before, after] = [&own, got].map(|got| self.cost(block, got));
        let is_better = after.sum < before.sum && after.worst <= before.worst;
        if is_better {
            for (k, got) in got.iter().enumerate() {
                let (texel, is_inside) = self.texel(block, k);
                if is_inside {
                    self.got[texel] = *got;
                }
            }
        }
        is_better
    }
}

fn codes(image: &Image, texel: u32) -> [f32; 4] {
    image.normalized(texel % image.width, texel / image.width).map(|value| value * 255.0)
}
