//! What was painted of materials that stand between each other in one layout with 4D coordinates: brought together, and cut
//! into the layout's parts.

use std::collections::BTreeMap;

use glam::Vec4;
use rayon::prelude::*;

use crate::assign::Codec;
use crate::image::{Image, LevelRange, Pixels, Transfer};
use crate::layout::{Block, Layout, Place};

/// One channel of one material.
pub struct Painted<'a> {
    /// All have the same parts.
    pub layout: &'a Layout,
    pub levels: Vec<Image>,
    pub ranges: BTreeMap<usize, LevelRange>,
}

/// Level images by part, and the ranges of those levels that have one.
///
/// A level that some materials store in a range is in one that holds theirs all, and [0, 1] where some have none: values
/// come back within half a step of it.
pub fn together(
    mut painted: Vec<Painted<'_>>,
    transfer: Transfer,
) -> (Vec<Vec<Image>>, BTreeMap<usize, LevelRange>) {
    let part_count = painted[0].layout.parts.len();
    if painted.len() == 1 && part_count == 1 {
        let only = painted.swap_remove(0);
        return (vec![only.levels], only.ranges);
    }
    let level_count = painted[0].levels.len();
    let stored: Vec<Stored> = (0..level_count).map(|level| Stored::new(&painted, level, transfer)).collect();
    let image = |part: usize, level: usize| stored[level].part(&painted, part, level);
    let images = |part: usize| (0..level_count).into_par_iter().map(|level| image(part, level)).collect();
    let parts = (0..part_count).map(images).collect();
    let ranges = stored.iter().enumerate().filter_map(|(level, stored)| Some((level, stored.range?)));
    (parts, ranges.collect())
}

/// How a level is stored of all materials.
struct Stored {
    /// 16 bits.
    codec: Codec,
    range: Option<LevelRange>,
    /// Whether every material has it so already.
    is_kept: bool,
}

impl Stored {
    fn new(painted: &[Painted<'_>], level: usize, transfer: Transfer) -> Self {
        let ranges = || painted.iter().map(|painted| painted.ranges.get(&level));
        let first = painted[0].ranges.get(&level).copied();
        let codec = Codec { transfer, components: painted[0].levels[level].components, bits: 16 };
        let is_kept = ranges().all(|range| range.copied() == first);
        Self { codec, range: if is_kept { first } else { spanning(ranges()) }, is_kept }
    }

    fn part(&self, painted: &[Painted<'_>], part: usize, level: usize) -> Image {
        let [width, height] = painted[0].layout.parts[part].sizes[level];
        let code_count = width as usize * height as usize * usize::from(self.codec.components);
        let is_narrow = self.is_kept && matches!(painted[0].levels[level].pixels, Pixels::U8(_));
        let mut pixels =
            if is_narrow { Pixels::U8(vec![0; code_count]) } else { Pixels::U16(vec![0; code_count]) };
        for material in painted {
            for rows in material.rows(part, level) {
                match (&mut pixels, &material.levels[level].pixels) {
                    (Pixels::U8(to), Pixels::U8(from)) => self.copy(&rows, from, to),
                    (Pixels::U16(to), Pixels::U16(from)) if self.is_kept => self.copy(&rows, from, to),
                    (Pixels::U16(to), _) => self.encode(&rows, material, level, to),
                    (Pixels::U8(_) | Pixels::F32(_), _) => {}
                }
            }
        }
        Image { width, height, components: self.codec.components, pixels }
    }

    fn copy<T: Copy>(&self, rows: &Rows, from: &[T], to: &mut [T]) {
        let count = usize::from(self.codec.components);
        for row in 0..rows.size[1] {
            let [from_texel, to_texel] = rows.first_texels(row);
            let codes = &from[from_texel * count..][..rows.size[0] as usize * count];
            to[to_texel * count..][..codes.len()].copy_from_slice(codes);
        }
    }

    fn encode(&self, rows: &Rows, material: &Painted<'_>, level: usize, to: &mut [u16]) {
        let count = usize::from(self.codec.components);
        let (image, range) = (&material.levels[level], material.ranges.get(&level));
        for row in 0..rows.size[1] {
            let [_, first] = rows.first_texels(row);
            for column in 0..rows.size[0] {
                let value =
                    image.value(rows.from[0] + column, rows.from[1] + row, self.codec.transfer, range);
                let codes = &mut to[(first + column as usize) * count..][..count];
                for (code, &component) in codes.iter_mut().zip(self.codec.stored()) {
                    *code = self.range.map_or(0, |range| range.encode(component, value[component]));
                }
            }
        }
    }
}

/// One range for all, where `None` stands for [0, 1].
fn spanning<'a>(ranges: impl Iterator<Item = Option<&'a LevelRange>>) -> Option<LevelRange> {
    let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
    for range in ranges {
        let (bias, scale) = match range {
            Some(LevelRange::Float16) => return Some(LevelRange::Float16),
            Some(LevelRange::Scaled16 { scale, bias }) => (*bias, *scale),
            None => (Vec4::ZERO, Vec4::ONE),
        };
        low = low.min(bias);
        high = high.max(bias + scale);
    }
    Some(LevelRange::spanning(low, high))
}

/// The texels of one block on their way.
struct Rows {
    /// First texel in what was painted, and in the part.
    from: [u32; 2],
    to: [u32; 2],
    /// Columns and rows.
    size: [u32; 2],
    /// Of both images.
    widths: [u32; 2],
}

impl Rows {
    /// Of a row, in what was painted and in the part.
    fn first_texels(&self, row: u32) -> [usize; 2] {
        let texel = |[x, y]: [u32; 2], width: u32| (y + row) as usize * width as usize + x as usize;
        [texel(self.from, self.widths[0]), texel(self.to, self.widths[1])]
    }
}

impl Painted<'_> {
    /// Of the blocks in a part.
    fn rows(&self, part: usize, level: usize) -> impl Iterator<Item = Rows> {
        let layout = self.layout;
        let first_row = layout.parts[part].first_rows[level];
        let widths = [layout.sizes[level][0], layout.parts[part].sizes[level][0]];
        let in_part = move |block: &&Block| matches!(block.place, Place::Scaled { part: own, .. } if own as usize == part);
        layout.blocks.iter().filter(in_part).map(move |block| {
            let (from, end) = (layout.first_texel(block, level), layout.block_end(block, level));
            let to = [from[0], from[1] - first_row];
            Rows { from, to, size: [0, 1].map(|k| end[k] - from[k]), widths }
        })
    }
}

#[cfg(test)]
mod tests;
