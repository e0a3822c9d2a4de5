//! Mesh color samples: exponents, who shares which sample, and their numbers at every level (MC section 3).
//!
//! A face of exponent `r` has `n = 2^r` segments a side. Its grid points are `(i, j)`: on a triangle
//! `i, j >= 0, i + j <= n` at `((n-i-j) v0 + i v1 + j v2) / n`; on a quad `0 <= i, j <= n` at `(i/n, j/n)`
//! of the unit square with corners (0,0), (1,0), (1,1), (0,1).

mod areas;
mod levels;
mod numbering;
#[cfg(test)]
mod tests;
mod topology;

pub use areas::{SampleAreas, SamplePlace};
pub use levels::{LEVEL_MAX, level_count};
pub use numbering::{FaceGrid, LevelNumbering, Tap, edge_point};
pub use topology::{ChannelTopology, Strip};

use crate::mesh::CanvasMesh;

/// Resolution exponents, shared by all channels of one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resolutions {
    /// By face.
    pub faces: Vec<u8>,
}

impl Resolutions {
    pub fn max(&self) -> u8 {
        self.faces.iter().copied().max().unwrap_or(0)
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
