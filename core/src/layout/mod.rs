//! Where every face stands in the level images: blocks, their packing, 4D coordinates.
//!
//! A block is a square of `n + 1` texels for a quad, or a rectangle of `n + 4` by `n + 1` for two lone triangles, the second turned by 180° and shifted by three texels: each
//! of the two needs a line of border texels of its own (MCT 3.1), which the increments of MCT Algorithm 1
//! leave no room for.

mod rows;
#[cfg(test)]
mod tests;

pub use rows::{LayoutRequest, arrange};

use glam::{DVec2, Vec2};

/// Texels that a block keeps to the next, at every level: `b` of MCT 3.4, so that footprints stay apart
/// beyond vertex colors too.
pub const SEPARATION: u32 = 2;
/// Constant shift of the second lone triangle of a block, in texels of every level.
pub const TWIN_SHIFT: u32 = 3;

/// Faces in one block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockKind {
    Quad(u32),
    Lone(u32),
    /// Two unrelated triangles of one exponent.
    Twins([u32; 2]),
}

/// A block at its place: at a level, texel `origin / 2^level + offset`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    pub kind: BlockKind,
    /// Segments a side at level 0.
    pub segments: u32,
    /// `u_s` of its first texel, a multiple of `segments`.
    pub origin: [u32; 2],
    /// `u_δ - 1/2`.
    pub offset: [u32; 2],
}

/// A face inside its block: corners on the block's unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Placement {
    pub block: u32,
    /// By corner: 0 or 1 along x and y.
    pub corners: [[u8; 2]; 4],
    /// [`TWIN_SHIFT`] for the second of two lone triangles, else 0.
    pub shift: u32,
}

/// All faces of one material.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// In packing order, row by row.
    pub blocks: Vec<Block>,
    /// First block of each row.
    pub row_starts: Vec<usize>,
    /// By face.
    pub placements: Vec<Placement>,
    /// Width and height by level, texels.
    pub sizes: Vec<[u32; 2]>,
}

impl BlockKind {
    /// The first of its faces, by which blocks have an order.
    fn first(self) -> u32 {
        match self {
            BlockKind::Quad(face) | BlockKind::Lone(face) | BlockKind::Twins([face, _]) => face,
        }
    }

    pub fn faces(self) -> impl Iterator<Item = usize> {
        let (first, second) = match self {
            BlockKind::Quad(face) | BlockKind::Lone(face) => (face, None),
            BlockKind::Twins([first, second]) => (first, Some(second)),
        };
        std::iter::once(first).chain(second).map(|face| face as usize)
    }

    /// Whether it holds triangles that have nothing to do with each other.
    pub fn is_lone(self) -> bool {
        matches!(self, BlockKind::Lone(_) | BlockKind::Twins(_))
    }

    /// Extra columns beyond `n + 1`.
    fn extra_columns(self) -> u32 {
        match self {
            BlockKind::Quad(_) | BlockKind::Lone(_) => 0,
            BlockKind::Twins(_) => TWIN_SHIFT,
        }
    }
}

impl Layout {
    pub fn level_count(&self) -> usize {
        self.sizes.len()
    }

    /// The blocks of each row.
    pub fn rows(&self) -> impl Iterator<Item = &[Block]> {
        let ends = self.row_starts.iter().skip(1).copied().chain([self.blocks.len()]);
        self.row_starts.iter().zip(ends).map(|(&start, end)| &self.blocks[start..end])
    }

    /// The block that a face has a part in.
    pub fn block(&self, face: usize) -> &Block {
        &self.blocks[self.placements[face].block as usize]
    }

    /// `u_s` of a face's corner.
    pub fn scaled(&self, face: usize, corner: usize) -> Vec2 {
        let block = self.block(face);
        let unit = self.placements[face].corners[corner];
        let axis = |k: usize| (block.origin[k] + u32::from(unit[k]) * block.segments) as f32;
        Vec2::new(axis(0), axis(1))
    }

    /// `u_δ` of a face.
    pub fn offset(&self, face: usize) -> Vec2 {
        let block = self.block(face);
        let shift = self.placements[face].shift;
        Vec2::new((block.offset[0] + shift) as f32 + 0.5, block.offset[1] as f32 + 0.5)
    }
}

impl Block {
    /// Whether the block is beyond vertex colors at a level.
    pub fn is_beyond(&self, level: usize) -> bool {
        self.segments >> level == 0
    }

    /// First texel at a level up to vertex colors of the block.
    pub fn texel(&self, level: usize) -> [u32; 2] {
        [0, 1].map(|k| (self.origin[k] >> level) + self.offset[k])
    }

    /// The block's first corner at any level in texels from the center of texel 0; exact.
    pub fn corner(&self, level: usize) -> DVec2 {
        let scale = (-(level as f64)).exp2();
        let axis = |k: usize| f64::from(self.origin[k]) * scale + f64::from(self.offset[k]);
        DVec2::new(axis(0), axis(1))
    }

    /// One past the last texel that the block may touch at a level.
    pub fn end(&self, level: usize) -> [u32; 2] {
        let extra = [self.kind.extra_columns(), 0];
        [0, 1].map(|k| {
            let last = (self.origin[k] + self.segments) >> level;
            // Beyond vertex colors the corner lies between texels, or on one with a spare texel beside it.
            let spare = u32::from(self.is_beyond(level));
            last + self.offset[k] + extra[k] + spare + 1
        })
    }
}
