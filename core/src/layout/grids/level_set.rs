//! The simple way to set a level out: grids one under the other, the highest rows first, and in what they leave free those of
//! lower ones. Most rows of blocks have no others beside them then, so that there are many bands to be painted at once.
//! Classes that come down to one size at some level have to follow each other.

use std::ops::Range;

use super::super::{Band, Class};
use super::ClassGrid;

/// Widths that are tried for a level, around that of a square.
const WIDTHS_TRIED: u32 = 192;
/// The narrowest and the widest of them, as shares of the square's side.
const WIDTH_SHARES: [f64; 2] = [0.5, 1.2];

/// Grids of up to so many rows, or texels, may have rows that are equally long. They and what stands beside them are one
/// band.
const EVEN_ROWS_MAX: u32 = 8;
const SMALL_TEXELS: u64 = 1 << 17;
/// So many of the best widths are looked at more closely.
const REFINED_COUNT: usize = 24;

/// Blocks of one size at a level.
#[derive(Clone, Debug)]
struct Grid {
    classes: Range<usize>,
    /// All of its blocks, by their numbers in the layout.
    blocks: Range<usize>,
    footprint: [u32; 2],
    columns: u32,
    origin: [u32; 2],
}

impl Grid {
    /// The columns with which it stands in a gap, if it does.
    fn columns_in(&self, gap: &Gap) -> Option<u32> {
        let count = self.blocks.len() as u32;
        let columns = (gap.size[0] / self.footprint[0]).min(count);
        (columns > 0 && count.div_ceil(columns) * self.footprint[1] <= gap.size[1]).then_some(columns)
    }

    /// What it leaves of the gap that it stands in: right of it, below it, and behind its last block.
    fn gaps_left(&self, gap: &Gap) -> [Gap; 3] {
        let [width, height] = [self.width(), self.height()];
        let [x, y] = gap.origin;
        let behind = match self.blocks.len() as u32 % self.columns {
            0 => 0,
            last_row => self.columns - last_row,
        } * self.footprint[0];
        [
            Gap { origin: [x + width, y], size: [gap.size[0] - width, gap.size[1]] },
            Gap { origin: [x, y + height], size: [width, gap.size[1] - height] },
            Gap {
                origin: [x + width - behind, y + height - self.footprint[1]],
                size: [behind, self.footprint[1]],
            },
        ]
    }

    fn row_count(&self) -> u32 {
        (self.blocks.len() as u32).div_ceil(self.columns)
    }

    fn height(&self) -> u32 {
        self.row_count() * self.footprint[1]
    }

    fn bottom(&self) -> u32 {
        self.origin[1] + self.height()
    }

    fn width(&self) -> u32 {
        self.columns.min(self.blocks.len() as u32) * self.footprint[0]
    }
}

/// A rectangle without blocks: first texel and size.
#[derive(Clone, Copy)]
struct Gap {
    origin: [u32; 2],
    size: [u32; 2],
}

/// The grids of a level.
pub(super) struct LevelSet {
    grids: Vec<Grid>,
}

impl LevelSet {
    /// The least texels of all widths that are tried.
    pub(super) fn narrowest(classes: &[Class], level: usize, side_limit: u32) -> Self {
        let mut grids = grids(classes, level);
        // High rows first: what they leave free takes the grids of lower ones.
        grids.sort_by_key(|grid| std::cmp::Reverse((grid.footprint[1], grid.footprint[0])));
        let texels = |grid: &Grid| {
            u64::from(grid.footprint[0]) * u64::from(grid.footprint[1]) * grid.blocks.len() as u64
        };
        let side = (grids.iter().map(texels).sum::<u64>() as f64).sqrt();
        let widest_block = grids.iter().map(|grid| grid.footprint[0]).max().unwrap_or(1);
        let [low, high] = WIDTH_SHARES
            .map(|share| ((side * share) as u32).clamp(widest_block, side_limit.max(widest_block)));
        let step = ((high - low) / WIDTHS_TRIED).max(1);
        let key = |set: &Self| {
            let [width, height] = set.size();
            (width.max(height) > side_limit, u64::from(width) * u64::from(height), width)
        };
        let can_be_even = |width: u32, grid: &Grid| {
            let columns = (width / grid.footprint[0]).max(1);
            (grid.blocks.len() as u32).div_ceil(columns) <= EVEN_ROWS_MAX || texels(grid) <= SMALL_TEXELS
        };
        let mut tried = Vec::new();
        for width in (low..=high).step_by(step as usize) {
            let even: Vec<bool> = grids.iter().map(|grid| can_be_even(width, grid)).collect();
            for even in [vec![false; grids.len()], even] {
                tried.push((key(&Self::of_width(&grids, width, &even)), width, even));
            }
        }
        tried.sort_by_key(|(key, ..)| *key);
        tried.truncate(REFINED_COUNT);
        // Of the best the other way for one grid after the other.
        let refined = tried.into_iter().map(|(mut least, width, mut even)| {
            for number in 0..grids.len() {
                even[number] = !even[number] && can_be_even(width, &grids[number]);
                let changed = key(&Self::of_width(&grids, width, &even));
                if changed < least {
                    least = changed;
                } else {
                    even[number] = !even[number] && can_be_even(width, &grids[number]);
                }
            }
            (least, width, even)
        });
        let best = refined.min_by_key(|(key, ..)| *key);
        best.map_or(Self { grids: Vec::new() }, |(_, width, even)| Self::of_width(&grids, width, &even))
    }

    /// Grids one under the other, and such as fit in there beside others. Rows of those that are `even` are equally
    /// long, so that what is free is one high piece at the right, not the end of the last row.
    fn of_width(sorted: &[Grid], width: u32, even: &[bool]) -> Self {
        let mut grids = Vec::with_capacity(sorted.len());
        let mut gaps: Vec<Gap> = Vec::new();
        let mut bottom = 0;
        for (grid, &is_even) in sorted.iter().zip(even) {
            let host = (0..gaps.len())
                .filter_map(|k| grid.columns_in(&gaps[k]).map(|columns| (k, columns)))
                .min_by_key(|&(k, _)| u64::from(gaps[k].size[0]) * u64::from(gaps[k].size[1]));
            let (gap, columns) = match host {
                Some((k, columns)) => (gaps.swap_remove(k), columns),
                None => {
                    let count = grid.blocks.len() as u32;
                    let most = (width / grid.footprint[0]).min(count);
                    let rows = count.div_ceil(most);
                    let columns = if is_even { count.div_ceil(rows) } else { most };
                    let size = [width, count.div_ceil(columns) * grid.footprint[1]];
                    let gap = Gap { origin: [0, bottom], size };
                    bottom += size[1];
                    (gap, columns)
                }
            };
            let placed = Grid { columns, origin: gap.origin, ..grid.clone() };
            gaps.extend(placed.gaps_left(&gap).into_iter().filter(|gap| gap.size[0] > 0 && gap.size[1] > 0));
            grids.push(placed);
        }
        Self { grids }
    }

    pub(super) fn size(&self) -> [u32; 2] {
        let right = |grid: &Grid| grid.origin[0] + grid.width();
        let width = self.grids.iter().map(right).max().unwrap_or(1);
        let height = self.grids.iter().map(Grid::bottom).max().unwrap_or(1);
        [width, height]
    }

    /// Rows of blocks, those together that stand beside each other.
    pub(super) fn bands(&self) -> Vec<Band> {
        let rows_of = |grid: &Grid| {
            let grid = grid.clone();
            (0..grid.row_count()).map(move |row| {
                let first = grid.blocks.start + (row * grid.columns) as usize;
                let blocks = first..(first + grid.columns as usize).min(grid.blocks.end);
                (grid.origin[1] + row * grid.footprint[1], grid.footprint[1], blocks)
            })
        };
        let mut rows: Vec<(u32, u32, Range<usize>)> = self.grids.iter().flat_map(rows_of).collect();
        rows.sort_by_key(|row| (row.0, row.2.start));
        let mut bands: Vec<Band> = Vec::new();
        let mut end = 0;
        for (first_row, height, blocks) in rows {
            match bands.last_mut().filter(|_| first_row < end) {
                Some(band) => band.blocks.push(blocks),
                None => bands.push(Band { first_row, blocks: std::iter::once(blocks).collect() }),
            }
            end = end.max(first_row + height);
        }
        bands
    }

    /// By class.
    pub(super) fn class_grids(&self, classes: &[Class]) -> Vec<ClassGrid> {
        let mut found = vec![ClassGrid::default(); classes.len()];
        for grid in &self.grids {
            let mut first = 0;
            for class in grid.classes.clone() {
                found[class] = ClassGrid { columns: grid.columns, first, origin: grid.origin };
                first += classes[class].block_count;
            }
        }
        found
    }
}

/// Classes of one size at a level, together.
fn grids(classes: &[Class], level: usize) -> Vec<Grid> {
    let mut grids: Vec<Grid> = Vec::new();
    let mut first_block = 0;
    for (number, class) in classes.iter().enumerate() {
        let end_block = first_block + class.block_count as usize;
        let footprint = class.footprint(level);
        let same = |last: &&mut Grid| {
            last.footprint == footprint && classes[last.classes.start].lone_count == class.lone_count
        };
        match grids.last_mut().filter(same) {
            Some(last) => {
                last.classes.end = number + 1;
                last.blocks.end = end_block;
            }
            None => grids.push(Grid {
                classes: number..number + 1,
                blocks: first_block..end_block,
                footprint,
                columns: 1,
                origin: [0; 2],
            }),
        }
        first_block = end_block;
    }
    grids
}
