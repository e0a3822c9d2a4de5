//! The layout for indexed coordinates: every level sets out the blocks of each class in a grid of its own.
//!
//! A block's number says where it is: at a level, `first + number` counts along the rows of a grid. Classes whose
//! blocks have come down to one size may share a grid, one class after the other. A level's width is free, and so are
//! the columns of its grids: what leaves least empty is taken.
//!
//! Blocks of one shape are one class, or several ([`parted`]): they fit in more places then.
//!
//! What is painted stands the simple way ([`level_set`]), whose rows are bands for threads. What is stored is set out anew
//! ([`Page`]), more tightly ([`search`]).

mod level_set;
mod parts;
mod search;
mod skyline;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use super::blocks::{blocks, placements};
use super::{Block, Class, Layout, LayoutRequest, Place, too_large, twin_shift};
use crate::error::Result;
use level_set::LevelSet;
pub use parts::{CLASS_COUNT_MAX, parted};
use search::{Goal, search};
use skyline::Piece;

/// Levels of more texels are set out the simple way first, and others only where the search leaves more than one texel in
/// so many empty.
const LARGE_TEXELS: u64 = 1 << 18;
const TIGHT_PART: u64 = 50;

/// How long a tight way to set out the levels is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    Quick,
    /// Until no more than 2 % of a level is unread, or the work for it is done.
    Tight,
}

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
        let extra = if self.has_two() { twin_shift(n) } else { 0 };
        [self.cells[0] * n + extra + 1, self.cells[1] * m + 1]
    }

    /// Texels of a block at a level.
    pub fn texels(&self, level: usize) -> u64 {
        self.footprint(level).into_iter().map(u64::from).product()
    }

    /// Whether its blocks have two lone triangles.
    pub fn has_two(&self) -> bool {
        self.lone_count == 2
    }

    /// How many classes of the table it is: two where its blocks have two triangles.
    pub fn entry_count(&self) -> usize {
        if self.has_two() { 2 } else { 1 }
    }

    /// Texels of a block at a level that nobody reads: what lone triangles with their border texels leave of it.
    pub fn spare_texels(&self, level: usize) -> u32 {
        let [n, _] = self.segments(level);
        match self.lone_count {
            0 => 0,
            1 => n * (n - 1) / 2,
            _ if n == 1 => 0,
            _ => 2,
        }
    }

    /// Segments along a face's sides at a level.
    pub fn segments(&self, level: usize) -> [u32; 2] {
        self.exponents.map(|exponent| 1 << usize::from(exponent).saturating_sub(level))
    }

    /// Classes of blocks that come in the order of their classes, and of each block its class and its number there.
    pub fn number(blocks: impl Iterator<Item = Self>) -> (Vec<Self>, Vec<[u32; 2]>) {
        let mut classes: Vec<Self> = Vec::new();
        let mut numbers = Vec::new();
        for block in blocks {
            let new = Self { block_count: 0, ..block };
            if classes.last().is_none_or(|last| Self { block_count: 0, ..*last } != new) {
                classes.push(new);
            }
            let class = classes.len() - 1;
            numbers.push([class as u32, classes[class].block_count]);
            classes[class].block_count += 1;
        }
        (classes, numbers)
    }
}

/// The blocks of classes set out at every level.
#[derive(Clone, Debug, Default)]
pub struct Page {
    pub classes: Vec<Class>,
    /// Width and height by level, texels.
    pub sizes: Vec<[u32; 2]>,
    /// By level and class.
    pub grids: Vec<Vec<ClassGrid>>,
}

/// How one level is set out.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Level {
    size: [u32; 2],
    /// By class.
    grids: Vec<ClassGrid>,
}

impl Page {
    /// Sets out every level as tightly as was found: by [`search`], or the simple way where that leaves much empty and the simple
    /// way less. Many classes of large blocks stand best one under the other.
    pub fn new(classes: Vec<Class>, level_count: usize, side_limit: u32, packing: Packing) -> Self {
        let footprints =
            |level: usize| -> Vec<[u32; 2]> { classes.iter().map(|class| class.footprint(level)).collect() };
        // From where all faces have come down to one segment all levels are alike.
        let last = (0..level_count).find(|&level| footprints(level) == footprints(level + 1));
        let distinct_count = last.map_or(level_count, |last| last + 1);
        let mut levels: Vec<Level> = (0..distinct_count)
            .into_par_iter()
            .map(|level| Level::new(&classes, level, side_limit, packing))
            .collect();
        while let Some(last) = levels.last().filter(|_| levels.len() < level_count) {
            levels.push(last.clone());
        }
        let (sizes, grids) = levels.into_iter().map(|level| (level.size, level.grids)).unzip();
        Self { classes, sizes, grids }
    }

    /// Whether level 0 keeps to a limit when it is set out the simple way, which takes little time; classes as for
    /// [`Page::new`], which keeps to it then too.
    pub fn fits(classes: &[Class], side_limit: u32) -> bool {
        LevelSet::narrowest(classes, 0, side_limit).size().into_iter().all(|side| side <= side_limit)
    }
}

impl Level {
    fn new(classes: &[Class], level: usize, side_limit: u32, packing: Packing) -> Self {
        let piece =
            |class: &Class| Piece { footprint: class.footprint(level), block_count: class.block_count };
        let pieces: Vec<Piece> = classes.iter().map(piece).collect();
        let spare = |class: &Class| u64::from(class.spare_texels(level)) * u64::from(class.block_count);
        let spare = classes.iter().map(spare).sum();
        let texels: u64 = pieces.iter().map(Piece::texels).sum();
        let simple = || {
            let set = LevelSet::narrowest(classes, level, side_limit);
            Self { size: set.size(), grids: set.class_grids(classes) }
        };
        let known = (texels > LARGE_TEXELS).then(simple);
        let enough = known.as_ref().map(|known| known.key(side_limit)).filter(|(is_over, _)| !is_over);
        let goal = Goal { spare, known: enough.map(|(_, texels)| texels), side_limit, packing };
        let found = search(&pieces, goal);
        let is_tight = |found: &Self| found.key(side_limit) <= (false, texels + texels / TIGHT_PART);
        match (found, known) {
            (Some(found), None) if is_tight(&found) => found,
            (found, known) => {
                let simple = known.unwrap_or_else(simple);
                found.filter(|found| found.key(side_limit) < simple.key(side_limit)).unwrap_or(simple)
            }
        }
    }

    /// The least is the best.
    fn key(&self, side_limit: u32) -> (bool, u64) {
        let [width, height] = self.size;
        (width.max(height) > side_limit, u64::from(width) * u64::from(height))
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
///
/// # Errors
/// `TextureTooLarge`.
pub(super) fn arrange(request: &LayoutRequest<'_>, side_limit: u32) -> Result<Layout> {
    let mut blocks = blocks(request, Place::Indexed { class: 0, number: 0 });
    blocks.sort_by_key(|block| (block.kind.lone_count(), block.exponents, block.kind.first()));
    let class = |block: &Block| Class {
        cells: [1, 1],
        exponents: block.exponents,
        lone_count: block.kind.lone_count(),
        block_count: 0,
    };
    let (classes, numbers) = Class::number(blocks.iter().map(class));
    for (block, [class, number]) in blocks.iter_mut().zip(numbers) {
        block.place = Place::Indexed { class, number };
    }
    let mut layout = Layout { placements: placements(request, &blocks), blocks, ..Layout::default() };
    for level in 0..request.level_count {
        let set = LevelSet::narrowest(&classes, level, side_limit);
        layout.sizes.push(set.size());
        layout.bands.push(set.bands());
        layout.grids.push(set.class_grids(&classes));
    }
    layout.classes = classes;
    let size = layout.sizes[0];
    if size.into_iter().all(|side| side <= side_limit) {
        Ok(layout)
    } else {
        Err(too_large(size.map(u64::from), side_limit))
    }
}
