//! Where corners stand in the level images: the one place that knows both kinds of coordinates.
//!
//! 4D coordinates (MCT equation 2): `u_level = u_s / 2^level + u_δ`. One multiply and one addition, and
//! every block shrinks by the same factor.
//!
//! Indexed coordinates: a corner names its block, and each level lays the blocks of a class out as a grid.
//! With `k = (2^max(r - level, 0), 2^max(s - level, 0))` and `C` columns,
//! `u_level = (m mod C, m div C) · (cells · k + min(gap, k + 2)) + local · k + min(shift, k + 1) + 0.5 + origin`, where
//! `m = first + number`: classes whose blocks have come down to one size stand in one grid, one behind the other.
//! What blocks keep besides their faces is no more than a face of that level takes.
//! Corners are texel centers at every level.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::{FinishedPrimitive, FinishedTriangle};

/// How the coordinates of a primitive name texels. All primitives of a material have the same.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Coordinates {
    /// 4D coordinates: corners are `u_s`, anchors are offsets.
    #[default]
    Scaled,
    /// Indexed coordinates: corners are local, anchors are blocks of this table.
    Indexed(Arc<BlockTable>),
}

/// What the three corners of a triangle have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// `u_δ`, texels of every level.
    Offset(Vec2),
    /// Block `number` of a class of the table.
    Block { class: u32, number: u32 },
}

/// How every level lays out every class of blocks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BlockTable {
    pub classes: Vec<BlockClass>,
    /// Level 0 first, as many as the textures have.
    pub levels: Vec<TableLevel>,
}

/// Blocks of one shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BlockClass {
    /// `r` of the faces along x and `s` along y: sides of `2^r` by `2^s` segments at level 0.
    pub exponents: [u8; 2],
    /// Faces along each axis, at least 1. Neighbors in a block share the texels of their common edge.
    pub cells: [u32; 2],
    /// Texels from the last face's end to the next block's start: 1, and what a block keeps beside its faces. At a level
    /// whose faces have `k` segments, `k + 2` at most.
    pub gap: [u32; 2],
    /// Texels that the faces stand from their block's start, `k + 1` at most; below `gap`.
    pub shift: [u32; 2],
}

/// One level of a table; each list goes by class.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TableLevel {
    /// Blocks in a row, at least 1.
    pub columns: Vec<u32>,
    /// Blocks of other classes that stand in the grid before this one's.
    pub firsts: Vec<u32>,
    /// First texel of the grid.
    pub origins: Vec<[u32; 2]>,
}

/// From a triangle's corners to the image of one level, in texels: `corner · scale + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelMap {
    pub scale: Vec2,
    pub shift: Vec2,
}

impl LevelMap {
    pub fn place(&self, corner: Vec2) -> Vec2 {
        corner * self.scale + self.shift
    }
}

/// Of what [`Finished::check_coordinates`](super::Finished::check_coordinates) refuses.
const NOWHERE: LevelMap = LevelMap { scale: Vec2::NAN, shift: Vec2::NAN };

impl Coordinates {
    pub fn table(&self) -> Option<&Arc<BlockTable>> {
        match self {
            Coordinates::Scaled => None,
            Coordinates::Indexed(table) => Some(table),
        }
    }

    /// Whether an anchor is of this kind.
    pub fn fits(&self, anchor: Anchor) -> bool {
        match self {
            Coordinates::Scaled => matches!(anchor, Anchor::Offset(_)),
            Coordinates::Indexed(_) => matches!(anchor, Anchor::Block { .. }),
        }
    }

    /// The map of the triangles with this anchor. Where the coordinates do not hold what
    /// [`Finished::check_coordinates`](super::Finished::check_coordinates) checks, places are not numbers.
    pub fn map(&self, anchor: Anchor, level: usize) -> LevelMap {
        match (self, anchor) {
            (Coordinates::Scaled, Anchor::Offset(shift)) => {
                // Powers of two: exact.
                LevelMap { scale: Vec2::splat((-(level as f32)).exp2()), shift }
            }
            (Coordinates::Indexed(table), Anchor::Block { class, number }) => {
                table.map(class, number, level).unwrap_or(NOWHERE)
            }
            _ => NOWHERE,
        }
    }

    /// A corner's place in the image of `level`, in texels.
    pub fn place(&self, triangle: &FinishedTriangle, corner: usize, level: usize) -> Vec2 {
        self.map(triangle.anchor, level).place(triangle.corners[corner])
    }

    /// The place of barycentrics `at` (one weight for each corner, sum 1).
    pub fn place_at(&self, triangle: &FinishedTriangle, at: Vec3, level: usize) -> Vec2 {
        let [a, b, c] = triangle.corners;
        self.map(triangle.anchor, level).place(a * at.x + b * at.y + c * at.z)
    }

    /// A triangle's corners in texels of level 0 from a start that they have in common.
    pub fn texels(&self, triangle: &FinishedTriangle) -> [Vec2; 3] {
        let scale = self.map(triangle.anchor, 0).scale;
        triangle.corners.map(|corner| corner * scale)
    }

    /// Whether the triangle's corners are no texel centers at a level along an axis, so that the texels around them
    /// are extrapolated: beyond vertex colors, with 4D coordinates.
    pub fn is_extrapolated(&self, triangle: &FinishedTriangle, level: usize) -> bool {
        self.table().is_none() && self.sides_texels(triangle).min_element() < (level as f32).exp2()
    }

    /// The resolution exponent along the longer side of the triangle.
    pub fn exponent(&self, triangle: &FinishedTriangle) -> usize {
        f64::from(self.sides_texels(triangle).max_element()).max(1.0).log2().round() as usize
    }

    fn sides_texels(&self, triangle: &FinishedTriangle) -> Vec2 {
        let [a, b, c] = self.texels(triangle);
        a.max(b).max(c) - a.min(b).min(c)
    }
}

impl FinishedPrimitive {
    /// The place of a triangle's corner in the image of `level`, in texels.
    pub fn place(&self, triangle: usize, corner: usize, level: usize) -> Vec2 {
        self.coordinates.place(&self.triangles[triangle], corner, level)
    }

    /// The place of barycentrics `at` (one weight for each corner, sum 1).
    pub fn place_at(&self, triangle: usize, at: Vec3, level: usize) -> Vec2 {
        self.coordinates.place_at(&self.triangles[triangle], at, level)
    }
}

impl BlockClass {
    /// Texels along each side of a face at a level; at least 1.
    pub fn segments(&self, level: usize) -> [u64; 2] {
        self.exponents.map(|exponent| 1 << usize::from(exponent).saturating_sub(level).min(63))
    }
}

impl BlockTable {
    /// As the tables of the shipped WGSL stand in memory: 32 bytes a class, and 16 for each of its levels.
    pub fn byte_count(&self) -> usize {
        self.classes.len() * (32 + 16 * self.levels.len())
    }

    fn map(&self, class: u32, number: u32, level: usize) -> Option<LevelMap> {
        let of = self.classes.get(class as usize)?;
        let segments = of.segments(level);
        let first = self.first_texel(class, number, level)?;
        let both = |values: [u64; 2]| Vec2::new(values[0] as f32, values[1] as f32);
        Some(LevelMap { scale: both(segments), shift: both(first) + 0.5 })
    }

    /// The first texel of a block's first face; `None` where the table does not reach so far.
    pub fn first_texel(&self, class: u32, number: u32, level: usize) -> Option<[u64; 2]> {
        let of = self.classes.get(class as usize)?;
        let level_table = self.levels.get(level)?;
        let columns = *level_table.columns.get(class as usize)?;
        let origin = level_table.origins.get(class as usize)?;
        let segments = of.segments(level);
        let number = level_table.firsts.get(class as usize)?.checked_add(number)?;
        let block = [number.checked_rem(columns)?, number.checked_div(columns)?];
        let axis = |k: usize| {
            let gap = u64::from(of.gap[k]).min(segments[k].saturating_add(2));
            let shift = u64::from(of.shift[k]).min(segments[k].saturating_add(1));
            let pitch = u64::from(of.cells[k]).checked_mul(segments[k])?.checked_add(gap)?;
            let start = u64::from(block[k]).checked_mul(pitch)?;
            start.checked_add(shift + u64::from(origin[k]))
        };
        Some([axis(0)?, axis(1)?])
    }
}

#[cfg(test)]
mod tests;
