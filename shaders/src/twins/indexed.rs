//! The CPU twins of `mesh_color_texture_indexed.wgsl`: same names, same arithmetic, f32 throughout.

use glam::{UVec2, Vec2, Vec4};
use meshcolor::finished::{BlockClass, BlockTable};
use meshcolor::image::{Image, Transfer};

use super::{MctLevel, MctPick, mct_lambda, mct_sample_level};

#[cfg(test)]
mod tests;

/// Blocks of one shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MctBlockClass {
    /// `r` along x and `s` along y: a face has `2^r` by `2^s` segments at level 0.
    pub exponents: UVec2,
    /// Faces along each axis.
    pub cells: UVec2,
    /// Texels from the end of the last face to the next block: at a level whose faces have `k` segments, `k + 2` at
    /// most.
    pub gap: UVec2,
    /// Texels from the start of the block to its first face, `k + 1` at most.
    pub shift: UVec2,
}

/// Where one level has the blocks of a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MctBlockGrid {
    /// First texel of the grid.
    pub origin: UVec2,
    /// Blocks in a row.
    pub columns: u32,
    /// Blocks of other classes that stand in the grid before this one's.
    pub first: u32,
}

/// What a fragment knows of its block: the local coordinate there, its number, and its class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MctBlockPlace {
    pub local: Vec2,
    pub number: u32,
    pub shape: MctBlockClass,
}

/// A table as shaders hold it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MctBlockTable {
    pub classes: Vec<MctBlockClass>,
    /// Class `n` of a level stands at `level * classes.len() + n`.
    pub grids: Vec<MctBlockGrid>,
}

impl MctBlockTable {
    /// The table of indexed coordinates that `Finished::check_coordinates` lets pass.
    pub fn new(table: &BlockTable) -> Self {
        let class = |class: &BlockClass| MctBlockClass {
            exponents: UVec2::from_array(class.exponents.map(u32::from)),
            cells: UVec2::from_array(class.cells),
            gap: UVec2::from_array(class.gap),
            shift: UVec2::from_array(class.shift),
        };
        let grids = table.levels.iter().flat_map(|level| {
            let entries = level.columns.iter().zip(&level.firsts).zip(&level.origins);
            entries.map(|((&columns, &first), &origin)| MctBlockGrid {
                origin: UVec2::from_array(origin),
                columns,
                first,
            })
        });
        Self { classes: table.classes.iter().map(class).collect(), grids: grids.collect() }
    }

    /// A class at a level.
    pub fn grid(&self, class: usize, level: u32) -> MctBlockGrid {
        self.grids[level as usize * self.classes.len() + class]
    }

    /// The classes as they stand in a buffer, 32 bytes each.
    pub fn class_words(&self) -> Vec<[u32; 8]> {
        let words = |class: &MctBlockClass| {
            let MctBlockClass { exponents: e, cells: c, gap: g, shift: s } = class;
            [e.x, e.y, c.x, c.y, g.x, g.y, s.x, s.y]
        };
        self.classes.iter().map(words).collect()
    }

    /// The grids as they stand in a buffer, 16 bytes each.
    pub fn grid_words(&self) -> Vec<[u32; 4]> {
        self.grids.iter().map(|grid| [grid.origin.x, grid.origin.y, grid.columns, grid.first]).collect()
    }
}

/// Segments of a face at `level`: `k = (2^max(r - level, 0), 2^max(s - level, 0))`.
pub fn mct_block_segments(shape: MctBlockClass, level: u32) -> UVec2 {
    UVec2::ONE << (shape.exponents.max(UVec2::splat(level)) - level)
}

/// The place of a local coordinate in the image of `level`, in texels of that image.
pub fn mct_indexed_place(at: MctBlockPlace, grid: MctBlockGrid, level: u32) -> Vec2 {
    let segments = mct_block_segments(at.shape, level);
    let number = grid.first + at.number;
    let block = UVec2::new(number % grid.columns, number / grid.columns);
    let pitch = at.shape.cells * segments + at.shape.gap.min(segments + 2);
    let first = block * pitch + at.shape.shift.min(segments + 1) + grid.origin;
    at.local * segments.as_vec2() + (first.as_vec2() + 0.5)
}

/// log2 of texels of level 0 per pixel, from the screen-space derivatives of `local`; the larger one decides.
pub fn mct_indexed_lambda(local_dx: Vec2, local_dy: Vec2, shape: MctBlockClass) -> f32 {
    let segments = mct_block_segments(shape, 0).as_vec2();
    mct_lambda(local_dx * segments, local_dy * segments)
}

/// The trilinear value of a stack; `grids` are the table's entries for the class, and `levels` those of the
/// stack, for `pick.finer` and `pick.coarser`.
pub fn mct_sample_indexed_stack(
    stack: (&Image, Transfer),
    at: MctBlockPlace,
    pick: MctPick,
    grids: [MctBlockGrid; 2],
    levels: [MctLevel; 2],
) -> Vec4 {
    let (stack, transfer) = stack;
    let finer = mct_sample_level(stack, transfer, mct_indexed_place(at, grids[0], pick.finer), levels[0]);
    let coarser = mct_sample_level(stack, transfer, mct_indexed_place(at, grids[1], pick.coarser), levels[1]);
    finer.lerp(coarser, pick.fraction)
}
