//! A remedy for the seams of blocks: those on one side of an edge are fitted to what the other side got.
//!
//! In each round every second block aims at what the other texels of its samples are decoded to, and is made
//! anew for that, pushed beyond by what it was off by. It takes the old one's place where it comes nearer
//! by the weighted sum of squares and no texel that it shares gets farther off. So the two sides draw
//! together, away from the true codes by less than blocks are anyhow. Normals are left as they are: faces store them
//! in frames of their own, so the two sides do not aim at the same code.

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::error::Result;
use crate::finished::Finished;
use crate::image::{Image, Pixels};

use super::Level;
use super::blocks::{BLOCK_BYTES, Blocks, SIDE};

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
/// `Internal` where the library refuses a level.
pub fn refit(
    finished: &Finished,
    [texture, number]: [usize; 2],
    blocks: &Blocks,
    groups: &[Vec<u32>],
) -> Result<Option<Blocks>> {
    let level = Level::of(&finished.textures[texture], number);
    let Pixels::U8(codes) = &level.image.pixels else { return Ok(None) };
    if level.is_normal || groups.is_empty() {
        return Ok(None);
    }
    let format = BTreeSet::from([blocks.format]);
    let columns = blocks.texels.size[0] as usize / SIDE;
    let mut aims = Aims::new(level.image, groups);
    let mut current = blocks.clone();
    let mut is_changed = false;
    for (round, gain) in GAINS.into_iter().enumerate() {
        let decoded = current.decode(&level)?.0;
        aims.follow(&decoded, groups);
        let image = Image { pixels: Pixels::U8(aims.pushed(&decoded, groups, gain, codes)), ..*level.image };
        let Some(other) = Blocks::encode(&Level { image: &image, ..level }, &format)? else { break };
        let [before, after] = [&decoded, &other.decode(&level)?.0].map(|decoded| aims.costs(decoded));
        let others = other.texels.bytes.chunks_exact(BLOCK_BYTES);
        let pairs = current.texels.bytes.chunks_exact_mut(BLOCK_BYTES).zip(others);
        for (number, (own, other)) in pairs.enumerate() {
            // Like a chessboard, because neighbors that both give way would miss each other.
            let is_turn = (number % columns + number / columns + round).is_multiple_of(2);
            if is_turn && after[number].is_better(&before[number]) {
                own.copy_from_slice(other);
                is_changed = true;
            }
        }
    }
    Ok(is_changed.then_some(current))
}

/// What texels are to be decoded to.
struct Aims<'a> {
    image: &'a Image,
    /// The components of `Image::normalized` that are stored.
    stored: &'static [usize],
    /// By texel.
    codes: Vec<[f32; 4]>,
    weights: Vec<f32>,
}

/// How far a block is off.
struct Cost {
    /// The weighted sum of squares.
    sum: f32,
    /// The largest of a shared texel.
    worst: f32,
}

impl Cost {
    fn is_better(&self, other: &Self) -> bool {
        self.sum < other.sum && self.worst <= other.worst
    }
}

impl<'a> Aims<'a> {
    fn new(image: &'a Image, groups: &[Vec<u32>]) -> Self {
        let mut weights = vec![WEIGHT_INSIDE; image.texel_count()];
        groups.iter().flatten().for_each(|&texel| weights[texel as usize] = 1.0);
        let stored: &[usize] = match image.components {
            1 => &[0],
            2 => &[0, 3],
            3 => &[0, 1, 2],
            _ => &[0, 1, 2, 3],
        };
        let codes = (0..image.texel_count() as u32).map(|texel| codes(image, texel)).collect();
        Self { image, stored, codes, weights }
    }

    /// Aims the texels of each group at what the others of it are decoded to, in the mean.
    fn follow(&mut self, decoded: &Image, groups: &[Vec<u32>]) {
        for group in groups {
            let got: Vec<[f32; 4]> = group.iter().map(|&texel| codes(decoded, texel)).collect();
            for (texel, own) in group.iter().zip(&got) {
                let truth = codes(self.image, *texel);
                self.codes[*texel as usize] = [0, 1, 2, 3].map(|k| {
                    let others = got.iter().map(|codes| codes[k]).sum::<f32>() - own[k];
                    let off = (1.0 - TRUE_SHARE) * (others / (group.len() - 1) as f32 - truth[k]);
                    truth[k] + off.clamp(-REACH_CODES, REACH_CODES)
                });
            }
        }
    }

    /// Aimed less decoded code.
    fn lack(&self, decoded: &Image, texel: u32) -> [f32; 4] {
        let (aim, got) = (self.codes[texel as usize], codes(decoded, texel));
        [0, 1, 2, 3].map(|k| aim[k] - got[k])
    }

    /// The codes with those of the groups pushed by what they lack.
    fn pushed(&self, decoded: &Image, groups: &[Vec<u32>], gain: f32, codes: &[u8]) -> Vec<u8> {
        let count = usize::from(self.image.components);
        let mut codes = codes.to_vec();
        for &texel in groups.iter().flatten() {
            let lack = self.lack(decoded, texel);
            let codes = &mut codes[texel as usize * count..][..count];
            for (code, &k) in codes.iter_mut().zip(self.stored) {
                *code = (f32::from(*code) + gain * lack[k]).round() as u8;
            }
        }
        codes
    }

    /// Of each block, row by row.
    fn costs(&self, decoded: &Image) -> Vec<Cost> {
        let [width, height] = self.image.size();
        let side = SIDE as u32;
        let of_block = |column: u32, row: u32| {
            let mut cost = Cost { sum: 0.0, worst: 0.0 };
            for y in row * side..height.min((row + 1) * side) {
                for x in column * side..width.min((column + 1) * side) {
                    let texel = y * width + x;
                    let weight = self.weights[texel as usize];
                    let lack = self.lack(decoded, texel);
                    cost.sum += weight * self.stored.iter().map(|&k| lack[k] * lack[k]).sum::<f32>();
                    if weight == 1.0 {
                        cost.worst = self.stored.iter().map(|&k| lack[k].abs()).fold(cost.worst, f32::max);
                    }
                }
            }
            cost
        };
        let columns = width.div_ceil(side);
        let rows = (0..height.div_ceil(side)).into_par_iter();
        rows.flat_map_iter(|row| (0..columns).map(move |column| (column, row)))
            .map(|(column, row)| of_block(column, row))
            .collect()
    }
}

fn codes(image: &Image, texel: u32) -> [f32; 4] {
    image.normalized(texel % image.width, texel / image.width).map(|value| value * 255.0)
}
