//! Polygons as files list them: corners that name positions, coordinates and normals each by a number of its own.

use glam::{Vec2, Vec3, Vec4};

/// Stands for "the corner names none".
pub const NONE: u32 = u32::MAX;

/// Indices into the lists of a [`Soup`], counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Corner {
    pub position: u32,
    pub texcoord: u32,
    pub normal: u32,
}

/// A polygon: `corners[first..first + count]`, at least three.
#[derive(Clone, Copy, Debug)]
pub struct Polygon {
    pub first: usize,
    pub count: usize,
    /// Which mesh it is of.
    pub object: usize,
    /// Number of a material, or [`NONE`].
    pub material: u32,
    /// Where it stands in the file, see [`Soup::place`].
    pub number: usize,
}

/// Every index that a polygon's corner has is in range, or [`NONE`]; a position never is.
#[derive(Debug, Default)]
pub struct Soup {
    /// The file's name, for messages.
    pub file: String,
    /// What stands between the file's name and the number of a polygon in messages.
    pub separator: &'static str,
    pub positions: Vec<Vec3>,
    /// Linear colors of the first positions; complete where it is as long as `positions`.
    pub colors: Vec<Vec4>,
    /// Whether the colors' alpha is the file's.
    pub has_alpha: bool,
    /// In glTF's convention: v downwards.
    pub texcoords: Vec<Vec2>,
    pub normals: Vec<Vec3>,
    pub corners: Vec<Corner>,
    pub polygons: Vec<Polygon>,
}

impl Soup {
    pub fn place(&self, polygon: &Polygon) -> String {
        format!("{}{}{}", self.file, self.separator, polygon.number)
    }

    pub fn corners(&self, polygon: &Polygon) -> &[Corner] {
        &self.corners[polygon.first..][..polygon.count]
    }

    /// Whether every position has a color.
    pub fn is_colored(&self) -> bool {
        !self.colors.is_empty() && self.colors.len() == self.positions.len()
    }
}
