//! Mesh color samples: exponents, who shares which sample, and their numbers at every level (MC section 3).
//!
//! A triangle of exponent `r` has `n = 2^r` segments a side. Its grid points are `(i, j)` with
//! `i, j >= 0, i + j <= n` at `((n-i-j) v0 + i v1 + j v2) / n`. A quad has an exponent along each axis (it is
//! elongated where they differ, MCT 3.6), so `n` and `m` segments: `0 <= i <= n`, `0 <= j <= m` at `(i/n, j/m)` of the unit square with
//! corners (0,0), (1,0), (1,1), (0,1).

mod areas;
mod levels;
mod numbering;
mod shape;
#[cfg(test)]
mod tests;
mod topology;

pub use areas::{SampleAreas, SamplePlace};
pub use levels::{LEVEL_MAX, level_count};
pub use numbering::{FaceGrid, LevelNumbering, Tap};
pub use shape::Shape;
pub use topology::{ChannelTopology, Strip};

use crate::mesh::CanvasMesh;

/// Resolution exponents, shared by all channels of one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resolutions {
    /// By face: along edges 0 and 2 of a quad, and along edges 1 and 3; a triangle's are equal.
    pub faces: Vec<[u8; 2]>,
}

impl Resolutions {
    /// The same along both axes of each face.
    pub fn uniform(exponents: impl IntoIterator<Item = u8>) -> Self {
        Self { faces: exponents.into_iter().map(|exponent| [exponent; 2]).collect() }
    }

    pub fn max(&self) -> u8 {
        self.faces.iter().flatten().copied().max().unwrap_or(0)
    }

    /// The exponent along an edge of a face.
    pub fn along(&self, face: usize, edge: usize) -> u8 {
        self.faces[face][edge % 2]
    }
}

/// Which canvas edges a channel does not join.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cuts {
    /// By canvas edge. Edges with one side are never cuts: there is nothing to part.
    pub edges: Vec<bool>,
}

impl Cuts {
    pub fn none(canvas: &CanvasMesh) -> Self {
        Self { edges: vec![false; canvas.edges.len()] }
    }
}

/// The exponent of a face at a level: falls by one each level, down to vertex colors.
pub fn exponent_at(exponent: u8, level: usize) -> u8 {
    exponent.saturating_sub(level.min(255) as u8)
}
