//! The layout for indexed coordinates: every level sets out the blocks of each class in a grid of its own.
//!
//! A block's number says where it is: at a level, `first + number` counts along the rows of a grid. Classes whose
//! blocks have come down to one size share a grid, one class after the other; so their order is by exponents, and
//! those that meet at any level follow each other. A level's width is free: the one that leaves least empty is taken.

use std::ops::Range;

use super::blocks::{blocks, placements};
use super::{Band, Block, Class, Layout, LayoutRequest, Place, SIDE_MAX, TWIN_SHIFT};

/// Widths that are tried for a level, around that of a square.
const WIDTHS_TRIED: u32 = 192;
/// The narrowest and the widest of them, as shares of the square's side.
const WIDTH_SHARES: [f64; 2] = [0.7, 1.4];

/// Where a class stands at a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClassGrid {
    /// Blocks in a row.
    pub columns: u32,
    /// Blocks of other classes that stand in the grid before the first of this one.
    pub first: u32,
    /// The grid's first texel.
    pub origin: [u32; 2],
}

impl Class {
    /// Texels of a block at a level, along x and y.
    pub fn footprint(&self, level: usize) -> [u32; 2] {
        let [n, m] = self.segments(level);
        let extra = if self.is_lone { TWIN_SHIFT } else { 0 };
        [n + extra + 1, m + 1]
    }

    /// Segments along a block's sides at a level.
    pub fn segments(&self, level: usize) -> [u32; 2] {
        self.exponents.map(|exponent| 1 << usize::from(exponent).saturating_sub(level))
    }
}

impl ClassGrid {
    pub fn first_texel(&self, class: &Class, level: usize, number: u32) -> [u32; 2] {
        let place = self.first + number;
        let [width, height] = class.footprint(level);
        [self.origin[0] + place % self.columns * width, self.origin[1] + place / self.columns * height]
    }
}

/// Places every face.
pub(super) fn arrange(request: &LayoutRequest<'_>) -> Layout {
    let mut blocks = blocks(request, Place::Indexed { class: 0, number: 0 });
    blocks.sort_by_key(|block| (block.kind.is_lone(), block.exponents, block.kind.first()));
    let classes = classify(&mut blocks);
    let side_limit = request.side_limit.min(SIDE_MAX);
    let mut layout = Layout { placements: placements(request, &blocks), blocks, ..Layout::default() };
    for level in 0..request.level_count {
        let set = LevelSet::narrowest(&classes, level, side_limit);
        layout.sizes.push(set.size());
        layout.bands.push(set.bands());
        layout.grids.push(set.class_grids(&classes));
    }
    layout.classes = classes;
    layout
}

/// Numbers sorted blocks within their classes.
fn classify(blocks: &mut [Block]) -> Vec<Class> {
    let mut classes: Vec<Class> = Vec::new();
    for block in blocks {
        let new = Class { exponents: block.exponents, is_lone: block.kind.is_lone(), block_count: 0 };
        let is_known = classes.last().is_some_and(|last| Class { block_count: 0, ..*last } == new);
        if !is_known {
            classes.push(new);
        }
        let class = classes.len() - 1;
        block.place = Place::Indexed { class: class as u32, number: classes[class].block_count };
        classes[class].block_count += 1;
    }
    classes
}

/// Blocks of one size at a level.
#[derive(Clone, Debug)]
struct Grid {
    classes: Range<usize>,
    /// All of its blocks, by their numbers in the layout.
    blocks: Range<usize>,
    footprint: [u32; 2],
    columns: u32,
    origin: [u32; 2],
    /// Whether it stands in what another grid's last row left free.
    is_guest: bool,
}

impl Grid {
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
struct LevelSet {
    grids: Vec<Grid>,
}

impl LevelSet {
    /// The least texels of all widths that are tried.
    fn narrowest(classes: &[Class], level: usize, side_limit: u32) -> Self {
        let mut grids = grids(classes, level);
        // High rows first: what they leave free takes the grids of lower ones.
        grids.sort_by_key(|grid| std::cmp::Reverse((grid.footprint[1], grid.footprint[0])));
        let texels = |grid: &Grid| u64::from(grid.footprint[0]) * u64::from(grid.footprint[1]) * grid.blocks.len() as u64;
        let side = (grids.iter().map(texels).sum::<u64>() as f64).sqrt();
        let widest_block = grids.iter().map(|grid| grid.footprint[0]).max().unwrap_or(1);
        let [low, high] = WIDTH_SHARES.map(|share| ((side * share) as u32).clamp(widest_block, side_limit.max(widest_block)));
        let step = ((high - low) / WIDTHS_TRIED).max(1);
        let tried = (low..=high).step_by(step as usize).map(|width| Self::of_width(&grids, width));
        let key = |set: &Self| {
            let [width, height] = set.size();
            (width.max(height) > side_limit, u64::from(width) * u64::from(height), width)
        };
        tried.min_by_key(key).unwrap_or(Self { grids: Vec::new() })
    }

    /// Grids one under the other, as wide as allowed, and such as fit in there beside the last rows of others.
    fn of_width(sorted: &[Grid], width: u32) -> Self {
        let mut grids = Vec::with_capacity(sorted.len());
        let mut gaps: Vec<Gap> = Vec::new();
        let mut bottom = 0;
        for grid in sorted {
            let count = grid.blocks.len() as u32;
            let [block_width, block_height] = grid.footprint;
            let in_gap = |gap: &Gap| {
                let columns = (gap.size[0] / block_width).min(count);
                (columns > 0 && count.div_ceil(columns) * block_height <= gap.size[1]).then_some(columns)
            };
            let host = (0..gaps.len())
                .filter_map(|k| in_gap(&gaps[k]).map(|columns| (k, columns)))
                .min_by_key(|&(k, _)| gaps[k].size[0] * gaps[k].size[1]);
            let placed = match host {
                Some((k, columns)) => {
                    let gap = gaps.swap_remove(k);
                    let placed = Grid { columns, origin: gap.origin, is_guest: true, ..grid.clone() };
                    let taken = placed.width();
                    gaps.push(Gap {
                        origin: [gap.origin[0] + taken, gap.origin[1]],
                        size: [gap.size[0] - taken, gap.size[1]],
                    });
                    gaps.push(Gap {
                        origin: [gap.origin[0], placed.bottom()],
                        size: [taken, gap.size[1] - placed.height()],
                    });
                    placed
                }
                None => {
                    let columns = width / block_width;
                    let placed = Grid { columns, origin: [0, bottom], is_guest: false, ..grid.clone() };
                    bottom += placed.height();
                    placed
                }
            };
            // The end of the last row.
            let rest = count % placed.columns;
            if rest > 0 && placed.row_count() > 1 || !placed.is_guest && rest > 0 {
                let left = placed.origin[0] + rest * block_width;
                let right = if placed.is_guest { placed.origin[0] + placed.width() } else { width };
                gaps.push(Gap {
                    origin: [left, placed.bottom() - block_height],
                    size: [right - left, block_height],
                });
            }
            grids.push(placed);
        }
        Self { grids }
    }

    fn size(&self) -> [u32; 2] {
        let right = |grid: &Grid| grid.origin[0] + grid.width();
        let width = self.grids.iter().map(right).max().unwrap_or(1);
        let height = self.grids.iter().map(Grid::bottom).max().unwrap_or(1);
        [width, height]
    }

    /// Each row of a grid, its last one with all that stand in the end of it.
    fn bands(&self) -> Vec<Band> {
        let mut bands = Vec::new();
        for host in self.grids.iter().filter(|grid| !grid.is_guest) {
            let row = |row: u32| {
                let first = host.blocks.start + (row * host.columns) as usize;
                first..(first + host.columns as usize).min(host.blocks.end)
            };
            bands.extend((0..host.row_count()).map(|number| Band {
                first_row: host.origin[1] + number * host.footprint[1],
                blocks: std::iter::once(row(number)).collect(),
            }));
        }
        for guest in self.grids.iter().filter(|grid| grid.is_guest) {
            let last = bands.partition_point(|band| band.first_row <= guest.origin[1]) - 1;
            bands[last].blocks.push(guest.blocks.clone());
        }
        bands
    }

    /// By class.
    fn class_grids(&self, classes: &[Class]) -> Vec<ClassGrid> {
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
            last.footprint == footprint && classes[last.classes.start].is_lone == class.is_lone
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
                is_guest: false,
            }),
        }
        first_block = end_block;
    }
    grids
}
