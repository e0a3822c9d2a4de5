//! Where every face stands in the level images: blocks, their packing, coordinates.
//!
//! A block is a rectangle of `n + 1` by `m + 1` texels for a quad, its longer side along x, or of `n + 4` by `n + 1` for two lone triangles,
//! the second turned by 180° and shifted by three texels: each of the two needs a line of border texels of its
//! own (MCT 3.1), which the increments of MCT Algorithm 1 leave no room for. Of one segment they have two by two texels each, so that a
//! shift of two is enough; indexed coordinates have that ([`twin_shift`]).
//!
//! Two kinds of coordinates name a block's place. 4D ones ([`scaled`]) shrink all places by the same factor from level to
//! level, packed as in the paper ([`rows`]) or closer ([`shelves`]); indexed ones ([`grids`]) name a block's number, and every level has grids of its own.

mod blocks;
mod grids;
mod rows;
mod scaled;
mod shelves;
mod split;
#[cfg(test)]
mod tests;

pub use blocks::LoneTriangles;
pub use grids::{CLASS_COUNT_MAX, ClassGrid, Packing, Page, parted};
pub use split::split;

use std::ops::Range;

use glam::{DVec2, Vec2};

use crate::colors::{Resolutions, Shape};
use crate::error::{Error, ErrorCode, Result};
use crate::mesh::{CanvasFace, CanvasMesh};

/// Texels that a block with 4D coordinates keeps to the next, at every level: `b` of MCT 3.4, so that footprints stay
/// apart beyond vertex colors too.
pub const SEPARATION: u32 = 2;
/// Shift of the second lone triangle of a block, in texels: with 4D coordinates of every level, with indexed ones as far as
/// [`twin_shift`] does not say less.
pub const TWIN_SHIFT: u32 = 3;
/// See [`Coordinates::leaves_alone`].
const LONE_EXPONENT_MAX: u8 = 1;
/// Larger textures than any device takes, and samples are numbered in 32 bits, three to a normal.
const SIDE_MAX: u32 = 32_768;

/// Shift of the second lone triangle of a block with indexed coordinates where sides have so many segments: no more than puts it
/// beside the first one's square.
pub fn twin_shift(segments: u32) -> u32 {
    TWIN_SHIFT.min(segments + 1)
}

/// How a viewer finds a face's texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// `u_s / 2^level + u_δ` (MCT equation 2), in rows, each face with one exponent: the paper's baseline.
    ScaledInRows,
    /// The same in shelves, and quads may be elongated.
    Scaled,
    /// The number of a block in its class, and a table of classes and levels.
    Indexed,
}

impl Coordinates {
    /// Whether quads get an exponent along each axis.
    pub fn are_elongated(self) -> bool {
        self != Self::ScaledInRows
    }

    /// Whether each lone triangle of an exponent has a block of its own, of `(n + 1)²` texels: with indexed coordinates, where
    /// that is at every level no more than half of what two take. (For larger exponents it is more at level 0.)
    pub fn leaves_alone(self, exponent: u8) -> bool {
        self == Self::Indexed && exponent <= LONE_EXPONENT_MAX
    }
}

/// What a layout is made from.
pub struct LayoutRequest<'a> {
    pub canvas: &'a CanvasMesh,
    pub resolutions: &'a Resolutions,
    /// By face: the edge that a lone triangle puts on its diagonal.
    pub diagonals: &'a [u8],
    pub level_count: usize,
    /// A square of this side is the most that all faces may take.
    pub side_limit: u32,
    /// Largest side of a part, with 4D coordinates. (Blocks with indexed ones get their parts in [`crate::pack`].)
    pub part_side: u32,
    pub coordinates: Coordinates,
}

/// Faces in one block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockKind {
    Quad(u32),
    Lone(u32),
    /// Two unrelated triangles of one exponent.
    Twins([u32; 2]),
}

/// A block at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    pub kind: BlockKind,
    /// Of its sides at level 0, along x and y.
    pub exponents: [u8; 2],
    pub place: Place,
}

/// A block's place at all levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Its first texel at a level of its part is `origin / 2^level + offset`: `u_s`, a multiple of its sides, and
    /// `u_δ - 1/2`.
    Scaled { part: u32, origin: [u32; 2], offset: [u32; 2] },
    /// Its class, and its number there.
    Indexed { class: u32, number: u32 },
}

/// A face inside its block: corners on the block's unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Placement {
    pub block: u32,
    /// By corner: 0 or 1 along x and y.
    pub corners: [[u8; 2]; 4],
    /// [`TWIN_SHIFT`] for the second of two lone triangles, else 0. With indexed coordinates coarse levels have less:
    /// [`Layout::shift`].
    pub shift: u32,
}

/// Blocks that are laid out in one grid: of equal sides and faces, and of as many lone triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Class {
    /// Faces along each axis.
    pub cells: [u32; 2],
    /// Of each of its faces.
    pub exponents: [u8; 2],
    /// Triangles alone in a block: 0 where it has quads, 1 or 2.
    pub lone_count: u8,
    pub block_count: u32,
}

/// Texel rows of a level that no block crosses the ends of: from `first_row` to the next band.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Band {
    pub first_row: u32,
    /// Ranges of [`Layout::blocks`].
    pub blocks: Vec<Range<usize>>,
}

/// What becomes an image of its own: rows of the painted one, from its first column.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// Width and height by level, texels.
    pub sizes: Vec<[u32; 2]>,
    /// In the painted image, by level.
    pub first_rows: Vec<u32>,
}

/// All faces of one material.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// In packing order.
    pub blocks: Vec<Block>,
    /// By face.
    pub placements: Vec<Placement>,
    /// Width and height of what is painted by level, texels.
    pub sizes: Vec<[u32; 2]>,
    /// Of 4D coordinates: one below the other.
    pub parts: Vec<Part>,
    /// By level.
    pub bands: Vec<Vec<Band>>,
    /// Of indexed coordinates.
    pub classes: Vec<Class>,
    /// Of indexed coordinates, by level and class.
    pub grids: Vec<Vec<ClassGrid>>,
}

/// Texels that a face takes at level 0 with what keeps it from the next; of two lone triangles in a block each half.
pub fn block_texels(coordinates: Coordinates, shape: Shape) -> f64 {
    let spare = match coordinates {
        Coordinates::ScaledInRows | Coordinates::Scaled => SEPARATION,
        Coordinates::Indexed => 1,
    };
    let [n, m] = shape.segments.map(|segments| f64::from(segments + spare));
    let is_alone = coordinates.leaves_alone(shape.segments[0].ilog2() as u8);
    if shape.is_triangle && !is_alone { 0.5 * (n + f64::from(TWIN_SHIFT)) * m } else { n * m }
}

/// Places every face of materials that have their textures in common: by material. With 4D coordinates their blocks stand
/// between each other in the same images; with indexed ones each material is laid out by itself.
///
/// The coordinates and limits of the first request count.
///
/// # Errors
/// `TextureTooLarge` where level 0 would exceed a limit.
pub fn arrange(requests: &[LayoutRequest<'_>]) -> Result<Vec<Layout>> {
    let Some(first) = requests.first() else { return Ok(Vec::new()) };
    let limit = first.side_limit.min(SIDE_MAX);
    // Before anything is packed: all that is counted on the way fits into 32 bits then.
    let least_side = requests.iter().map(least_texels).sum::<f64>().sqrt().ceil() as u64;
    if least_side > limit.into() {
        return Err(too_large([least_side; 2], limit));
    }
    match first.coordinates {
        Coordinates::ScaledInRows => scaled::arrange(requests, rows::pack),
        Coordinates::Scaled => scaled::arrange(requests, shelves::pack),
        Coordinates::Indexed => requests.iter().map(|request| grids::arrange(request, limit)).collect(),
    }
}

/// Of all faces, without what is left empty.
fn least_texels(request: &LayoutRequest<'_>) -> f64 {
    let faces = request.canvas.faces.iter().zip(&request.resolutions.faces);
    let shape = |(face, exponents): (&CanvasFace, &[u8; 2])| Shape {
        is_triangle: face.is_triangle(),
        segments: exponents.map(|exponent| 1 << exponent),
    };
    faces.map(|face| block_texels(request.coordinates, shape(face))).sum()
}

fn too_large([width, height]: [u64; 2], limit: u32) -> Error {
    let detail = format!(
        "the layout needs {width} x {height} texels, more than the {limit} a side that is allowed; ask for less with \
         --resolution (area:F with a smaller F, or fixed:R with a smaller R) or with --texels",
    );
    Error::new(ErrorCode::TextureTooLarge, detail).limit(limit.into(), width.max(height))
}

impl BlockKind {
    /// The same of other faces.
    fn renumbered(self, number: impl Fn(u32) -> u32) -> Self {
        match self {
            Self::Quad(face) => Self::Quad(number(face)),
            Self::Lone(face) => Self::Lone(number(face)),
            Self::Twins(faces) => Self::Twins(faces.map(number)),
        }
    }

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

    /// As [`Class::lone_count`].
    pub fn lone_count(self) -> u8 {
        match self {
            BlockKind::Quad(_) => 0,
            BlockKind::Lone(_) => 1,
            BlockKind::Twins(_) => 2,
        }
    }

    /// Whether it holds triangles that have nothing to do with each other.
    pub fn is_lone(self) -> bool {
        matches!(self, BlockKind::Lone(_) | BlockKind::Twins(_))
    }
}

impl Layout {
    pub fn level_count(&self) -> usize {
        self.sizes.len()
    }

    /// The block that a face has a part in.
    pub fn block(&self, face: usize) -> &Block {
        &self.blocks[self.placements[face].block as usize]
    }

    /// Whether a block's corners stand between texels at a level along an axis, so that its texels are extrapolated.
    pub fn is_beyond(&self, block: &Block, level: usize) -> bool {
        matches!(block.place, Place::Scaled { .. }) && usize::from(block.exponents[1]) < level
    }

    /// Whether they do along the short side, y, alone (MCT 3.6).
    pub fn is_beyond_across(&self, block: &Block, level: usize) -> bool {
        self.is_beyond(block, level) && level <= usize::from(block.exponents[0])
    }

    /// The part that a face stands in.
    pub fn part(&self, face: usize) -> usize {
        match self.block(face).place {
            Place::Scaled { part, .. } => part as usize,
            Place::Indexed { .. } => 0,
        }
    }

    fn first_row(&self, part: u32, level: usize) -> u32 {
        self.parts[part as usize].first_rows[level]
    }

    /// Texels of a level over all parts.
    pub fn texel_count(&self, level: usize) -> u64 {
        let texels = |size: [u32; 2]| size.map(u64::from).into_iter().product::<u64>();
        if self.parts.is_empty() {
            return texels(self.sizes[level]);
        }
        self.parts.iter().map(|part| texels(part.sizes[level])).sum()
    }

    /// First texel of a block, or of its footprint along an axis that is beyond vertex colors.
    pub fn first_texel(&self, block: &Block, level: usize) -> [u32; 2] {
        match block.place {
            Place::Scaled { part, origin, offset } => {
                let [x, y] = [0, 1].map(|k| (origin[k] >> level) + offset[k]);
                [x, y + self.first_row(part, level)]
            }
            Place::Indexed { class, number } => {
                let class_grid = &self.grids[level][class as usize];
                class_grid.first_texel(&self.classes[class as usize], level, number)
            }
        }
    }

    /// The block's first corner at any level in texels from the center of texel 0; exact.
    pub fn first_corner(&self, block: &Block, level: usize) -> DVec2 {
        match block.place {
            Place::Scaled { part, origin, offset } => {
                let scale = (-(level as f64)).exp2();
                let axis = |k: usize| f64::from(origin[k]) * scale + f64::from(offset[k]);
                DVec2::new(axis(0), axis(1) + f64::from(self.first_row(part, level)))
            }
            Place::Indexed { .. } => {
                let [x, y] = self.first_texel(block, level);
                DVec2::new(x.into(), y.into())
            }
        }
    }

    /// Texels along x by which a face stands from its block's start at a level.
    pub fn shift(&self, face: usize, level: usize) -> u32 {
        let shift = self.placements[face].shift;
        let block = self.block(face);
        match block.place {
            Place::Indexed { .. } if shift > 0 => {
                twin_shift(1 << usize::from(block.exponents[0]).saturating_sub(level))
            }
            _ => shift,
        }
    }

    /// What a corner's coordinates say: of 4D ones `u_s` in texels, of indexed ones 0 or 1 along the block's sides.
    pub fn corner(&self, face: usize, corner: usize) -> Vec2 {
        let block = self.block(face);
        let unit = self.placements[face].corners[corner];
        let axis = |k: usize| match block.place {
            Place::Scaled { origin, .. } => (origin[k] + (u32::from(unit[k]) << block.exponents[k])) as f32,
            Place::Indexed { .. } => unit[k].into(),
        };
        Vec2::new(axis(0), axis(1))
    }

    /// `u_δ` of a face with 4D coordinates.
    pub fn offset(&self, face: usize) -> Vec2 {
        let shift = Vec2::new(self.placements[face].shift as f32 + 0.5, 0.5);
        match self.block(face).place {
            Place::Scaled { offset: [x, y], .. } => shift + Vec2::new(x as f32, y as f32),
            Place::Indexed { .. } => shift,
        }
    }

    /// A face's corner at a level in texels, texel centers being at `.5`.
    pub fn place(&self, face: usize, corner: usize, level: usize) -> Vec2 {
        let block = self.block(face);
        let placement = &self.placements[face];
        let first = self.first_corner(block, level) + DVec2::new(self.shift(face, level).into(), 0.0) + 0.5;
        let [x, y] = placement.corners[corner].map(f64::from);
        let side = |k: usize| {
            let exponent = f64::from(block.exponents[k]) - level as f64;
            if matches!(block.place, Place::Indexed { .. }) {
                exponent.max(0.0).exp2()
            } else {
                exponent.exp2()
            }
        };
        (first + DVec2::new(x * side(0), y * side(1))).as_vec2()
    }
}

impl Layout {
    /// One past the last texel that a block may touch at a level.
    pub fn block_end(&self, block: &Block, level: usize) -> [u32; 2] {
        match block.place {
            Place::Scaled { part, .. } => {
                let [x, y] = scaled::end(block, level);
                [x, y + self.first_row(part, level)]
            }
            Place::Indexed { class, .. } => {
                let [x, y] = self.first_texel(block, level);
                let [width, height] = self.classes[class as usize].footprint(level);
                [x + width, y + height]
            }
        }
    }
}
