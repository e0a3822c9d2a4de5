//! The filters of mesh colors themselves, on the CPU: what textures made from the same samples are held against.
//!
//! C. Yuksel, J. Keyser, D. House, "Mesh Colors", section 4 (MC 4). A place on a face is `(s, t)` of its unit domain: on
//! a triangle the barycentrics of corners 1 and 2, on a quad the unit square with corners (0,0), (1,0), (1,1), (0,1). Times the
//! face's segments it falls among grid points, of which it takes up to four with weights that sum to 1. Values are what
//! the samples hold: linear light for color, the stored number for data. Normals are mixed as vectors and not made unit.
//!
//! An edge belongs to all its faces at the smallest exponent that they have along it (MCT 3.2), where MC 4.2 keeps the
//! largest and has the coarse face ignore it. So a grid point of a finer face may lie between two samples, and every
//! filter of one level gives the same value on an edge from each of its faces (up to rounding), cuts apart.
//!
//! Everything stays in the face that is asked for, as MC 4.3 has it: a level's samples on edges and vertices hold what is
//! beyond them already, and a long footprint is cut off where the face ends. The color of a pixel that several
//! faces cover is the mean over these faces, by the share that each covers, as with multisampling.

mod cell;
mod footprint;
#[cfg(test)]
mod tests;

pub use footprint::{Footprint, PROBES_MAX};

use glam::{Vec2, Vec4};

use crate::colors::{LevelNumbering, Shape};

/// The samples of one level.
#[derive(Clone, Copy)]
pub struct Level<'a> {
    pub numbering: &'a LevelNumbering<'a>,
    /// By sample, see [`LevelNumbering`].
    pub values: &'a [Vec4],
}

/// What a triangle shows between its samples.
#[derive(Clone, Copy, Debug)]
pub enum Triangles<'a> {
    /// The linear function through the three samples around a place (MC 4.1).
    Linear,
    /// What a bilinear unit makes of a triangle that stands as half a square of texels (MCT 3.1): bilinear in whole
    /// cells, linear in those that the diagonal cuts. By face: the corner at the right angle, below 3. It differs from
    /// `Linear` by a quarter of `c00 + c11 - c10 - c01` of a whole cell at most, in its middle, and not at all on lines
    /// between samples along the two sides at the right angle.
    HalfSquares(&'a [u8]),
}

/// Mesh colors of one channel. Functions take `face` below the number of the canvas' faces, or panic; a place outside
/// of the face is taken back to it, and a level beyond the last is the last one.
#[derive(Clone, Copy)]
pub struct MeshColors<'a> {
    levels: &'a [Level<'a>],
    triangles: Triangles<'a>,
}

impl<'a> MeshColors<'a> {
    /// Level 0 first, all of one canvas. `None` where there is no level, where they are in another order, or where a
    /// list has another length than what it is about.
    pub fn new(levels: &'a [Level<'a>], triangles: Triangles<'a>) -> Option<Self> {
        let is_whole = |(number, level): (usize, &Level<'_>)| {
            level.numbering.level == number && level.values.len() == level.numbering.sample_count()
        };
        let face_count = levels.first()?.numbering.canvas.faces.len();
        let fits = match triangles {
            Triangles::Linear => true,
            Triangles::HalfSquares(corners) => {
                corners.len() == face_count && corners.iter().all(|corner| *corner < 3)
            }
        };
        (fits && levels.iter().enumerate().all(is_whole)).then_some(Self { levels, triangles })
    }

    /// The sample of the largest weight (MC 4.1), of equal ones that of the lowest number: cells of a triangle are
    /// hexagons, those of a quad squares. Where an edge is coarser than the face, weights of points between two of its
    /// samples are shared out to these, so that the same sample is found from the other side.
    pub fn nearest(&self, face: usize, at: Vec2, level: usize) -> Vec4 {
        let Level { numbering, values } = self.level(level);
        let mut weights = [(u32::MAX, 0.0); 8];
        let mut add = |sample: u32, weight: f32| {
            let slot = weights.iter_mut().find(|(known, _)| *known == sample || *known == u32::MAX);
            if let Some(slot) = slot {
                *slot = (sample, slot.1 + weight);
            }
        };
        for ((i, j), weight) in self.points(numbering, face, at) {
            let tap = numbering.tap(face, i, j);
            add(tap.samples[0], weight * (1.0 - tap.second));
            add(tap.samples[1], weight * tap.second);
        }
        let mut best = weights[0];
        for (sample, weight) in weights.into_iter().filter(|(sample, _)| *sample != u32::MAX) {
            if weight > best.1 || (weight == best.1 && sample < best.0) {
                best = (sample, weight);
            }
        }
        values[best.0 as usize]
    }

    /// Linear in a triangle's cells, bilinear in a quad's (MC 4.1 and 3.4).
    pub fn linear(&self, face: usize, at: Vec2, level: usize) -> Vec4 {
        let Level { numbering, values } = self.level(level);
        let points = self.points(numbering, face, at).into_iter();
        points.map(|((i, j), weight)| numbering.tap(face, i, j).value(values) * weight).sum()
    }

    /// Between two levels, `lambda` counted in levels: `linear` of both, mixed by the fraction. Below 0 and what is no
    /// number are level 0.
    pub fn trilinear(&self, face: usize, at: Vec2, lambda: f32) -> Vec4 {
        let lambda = lambda.max(0.0).min((self.levels.len() - 1) as f32);
        let (finer, fraction) = (lambda as usize, lambda.fract());
        let value = self.linear(face, at, finer);
        if fraction == 0.0 { value } else { value.lerp(self.linear(face, at, finer + 1), fraction) }
    }

    /// At the level whose samples are as far apart as the footprint is long (MC 4.2): `lambda = log2` of its longer
    /// axis in samples of level 0.
    pub fn mip_mapped(&self, face: usize, at: Vec2, footprint: Footprint) -> Vec4 {
        self.trilinear(face, at, footprint.lambda(self.shape(face)))
    }

    /// The mean of [`Self::trilinear`] at even distances along the longer axis (MC 4.3, which stays in one level): so
    /// many as the shorter axis goes into it, [`PROBES_MAX`] at most, at the level whose samples are as far apart. They
    /// are spread over what lies in the face of the axis; a footprint as long as wide is `mip_mapped`.
    pub fn anisotropic(&self, face: usize, at: Vec2, footprint: Footprint) -> Vec4 {
        let probes = footprint.probes(self.shape(face), at);
        let count = probes.count as f32;
        probes.places().map(|at| self.trilinear(face, at, probes.lambda)).sum::<Vec4>() / count
    }

    fn level(&self, level: usize) -> Level<'a> {
        self.levels[level.min(self.levels.len() - 1)]
    }

    /// The grid of level 0.
    fn shape(&self, face: usize) -> Shape {
        self.levels[0].numbering.shape(face)
    }

    fn points(&self, numbering: &LevelNumbering<'_>, face: usize, at: Vec2) -> cell::Points {
        let right = match self.triangles {
            Triangles::Linear => None,
            Triangles::HalfSquares(corners) => Some(corners[face]),
        };
        cell::points(numbering.shape(face), at, right)
    }
}
