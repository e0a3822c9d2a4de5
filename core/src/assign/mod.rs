//! Texel rules: every texel as a short linear combination of mesh color samples of the same level.
//!
//! Up to vertex colors a texel copies a sample (or a point of a coarser edge), and the border texels beside
//! a lone triangle's diagonal are `c3 = c1 + c2 - c0` (MCT equation 1). Beyond vertex colors the linear or
//! bilinear function through a block's corners is extrapolated to the texels around it (MCT 3.4), or along the short side
//! alone where that comes down first (MCT 3.6).

mod codec;
mod frames;
mod paint;
mod read_back;
mod rules;
#[cfg(test)]
mod tests;

pub use codec::Codec;
pub use frames::{NormalFrames, choose_frames};
pub use paint::{Need, RANGE_WIDTH, Storing, need_of_range, paint, range_of};
pub use read_back::read_back;
pub use rules::{Links, Rules, rules};

use glam::{DVec3, DVec4, Vec4};

use crate::colors::{Cuts, LevelNumbering, Tap};
use crate::layout::Layout;

/// How levels are stored where many of their texels beyond vertex colors leave [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// As every other level: codes of the source's bits.
    Unorm8,
    /// 16 bits of linear values with a scale and a bias of the level ([`crate::image::LevelRange`]).
    Scaled16,
    /// Half floats of linear values.
    Float16,
}

/// How values become codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// Each texel to the nearest code.
    Nearest,
    /// Samples first; texels that are made of samples from rounded ones, or rounded together.
    Rules,
}

/// One channel at one level, as rules and texels are made from it.
pub struct LevelChannel<'a> {
    pub layout: &'a Layout,
    pub numbering: &'a LevelNumbering<'a>,
    pub cuts: &'a Cuts,
    pub codec: Codec,
    /// Of normal channels: the frames that the stored normals refer to.
    pub frames: Option<&'a NormalFrames>,
}

impl LevelChannel<'_> {
    /// The value of a sample as the texels of `face` store it, at `(s, t)` of the face's unit domain: the
    /// value itself, or a normal in the face's frame, scaled to [0, 1].
    fn stored(&self, face: usize, value: DVec4, s: f32, t: f32) -> DVec4 {
        match self.frames {
            None => value,
            Some(frames) => {
                let to_stored = frames.to_stored(self.numbering.canvas, face, s, t).as_dmat3();
                (DVec3::splat(0.5) + to_stored * value.truncate()).extend(1.0)
            }
        }
    }

    /// Which corner of a face stands at each corner of its block's square; the square's rows, then its columns.
    fn square(&self, face: usize) -> [[Option<usize>; 2]; 2] {
        let mut corners = [[None; 2]; 2];
        for corner in 0..self.numbering.canvas.faces[face].count() {
            let [x, y] = self.layout.placements[face].corners[corner].map(usize::from);
            corners[y][x] = Some(corner);
        }
        corners
    }

    /// Whether nobody shares the edge that a lone triangle has on its diagonal: one side, or a cut.
    fn is_free(&self, face: usize, edge: usize) -> bool {
        let number = self.numbering.canvas.faces[face].edges[edge] as usize;
        let canvas = self.numbering.canvas;
        self.cuts.edges[number] || canvas.sides(&canvas.edges[number]).len() == 1
    }

    /// The corner of a lone triangle at the square's corner, and the edge on its diagonal.
    fn right_angle(&self, face: usize) -> (usize, usize) {
        let corners = &self.layout.placements[face].corners;
        let distance = |a: [u8; 2], b: [u8; 2]| a[0].abs_diff(b[0]) + a[1].abs_diff(b[1]);
        let diagonal = (0..3).find(|&k| distance(corners[k], corners[(k + 1) % 3]) == 2).unwrap_or(1);
        ((diagonal + 2) % 3, diagonal)
    }
}

/// The samples of one level as they are to be stored.
#[derive(Clone, Debug)]
pub struct LevelValues {
    pub samples: Vec<Vec4>,
    /// The vertex samples once more in 64 bits: beyond vertex colors texels weigh them by up to
    /// `4^(level - r)`.
    pub fans: Vec<DVec4>,
    /// By face and corner, the versions that faces beyond vertex colors store of their own; empty where all
    /// share `fans`.
    pub corners: Vec<[DVec4; 4]>,
}

impl LevelValues {
    pub fn new(samples: Vec<Vec4>, fan_count: usize) -> Self {
        let fans = samples[..fan_count].iter().map(|value| value.as_dvec4()).collect();
        Self { samples, fans, corners: Vec::new() }
    }

    /// What a face beyond vertex colors stores at one of its corners, whose shared sample is `fan`.
    pub fn corner(&self, face: usize, corner: usize, fan: usize) -> DVec4 {
        self.corners.get(face).map_or(self.fans[fan], |corners| corners[corner])
    }

    /// What a face sees at a grid point, in 64 bits as far as samples are.
    pub fn value(&self, Tap { samples, second }: Tap) -> DVec4 {
        let of = |sample: u32| {
            let sample = sample as usize;
            self.fans.get(sample).copied().unwrap_or_else(|| self.samples[sample].as_dvec4())
        };
        let first = of(samples[0]);
        if second == 0.0 { first } else { first.lerp(of(samples[1]), second.into()) }
    }

    /// Sets one component of one sample.
    pub fn set(&mut self, sample: usize, component: usize, value: f64) {
        self.samples[sample][component] = value as f32;
        if let Some(fan) = self.fans.get_mut(sample) {
            fan[component] = value;
        }
    }
}

/// Grid coordinates of the point of a lone triangle that lies `x` segments from corner `right` towards the
/// next corner and `y` towards the one after.
fn from_right_angle(right: usize, n: u32, x: u32, y: u32) -> (u32, u32) {
    match right {
        0 => (x, y),
        1 => (n - x - y, x),
        _ => (y, n - x - y),
    }
}

/// `(s, t)` of a face's corner on its unit domain.
fn corner_point(is_triangle: bool, corner: usize) -> (f32, f32) {
    match (is_triangle, corner) {
        (_, 0) => (0.0, 0.0),
        (_, 1) => (1.0, 0.0),
        (true, _) => (0.0, 1.0),
        (false, 2) => (1.0, 1.0),
        (false, _) => (0.0, 1.0),
    }
}
