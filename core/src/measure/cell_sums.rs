//! Weighted sums of a channel's source, at points of the surface and in its [cells](super::cells).
//!
//! Every sum is made twice, over points of its own: what both differ by tells how far they are off.

use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::averages::folded;
use super::cells::{self, Cells, Cut};
use super::graph::Graph;
use super::judge::{Meaning, interpolated, object_normal};
use super::origin::Origin;
use super::points::uniform;
use super::surface::Surface;
use super::texels::Texels;
use crate::finished::Frame;

/// Triangles handled in one go.
const CHUNK: usize = 64;

/// Points of each half in an innermost cell of weight 1, and at most.
const POINTS_PER_WEIGHT: f32 = 2.0;
const POINTS_MOST: f32 = 4.0;

/// A channel's source as it is averaged.
pub struct Averaged<'a> {
    pub graph: &'a Graph,
    pub surface: &'a Surface<'a>,
    pub origin: &'a Origin<'a>,
    pub texels: Texels<'a>,
}

/// The source on one triangle.
pub struct OnTriangle<'a> {
    texels: &'a Texels<'a>,
    /// Of the corners, in texels.
    places: [Vec2; 3],
    /// For normals: the frames of the corners, and the scale.
    frames: Option<(&'a [Frame; 3], f32)>,
}

impl Averaged<'_> {
    /// By the triangle's number in the graph.
    pub fn on(&self, triangle: u32) -> OnTriangle<'_> {
        let (part, triangle) = self.graph.place(triangle);
        let vertices = self.surface.parts[part].triangles[triangle];
        let size_texels = self.texels.size_texels();
        let frames = match (self.origin.meaning, self.origin.corner_frames(part, triangle)) {
            (Meaning::Normal { scale }, Some(frames)) => Some((frames, scale)),
            _ => None,
        };
        OnTriangle {
            texels: &self.texels,
            places: self.origin.corner_uvs(part, vertices).map(|uv| uv * size_texels),
            frames,
        }
    }

    /// Whether color counts by how much of it is seen.
    pub fn weighs_by_alpha(&self) -> bool {
        self.origin.meaning == Meaning::Color && matches!(self.origin.components, 2 | 4)
    }

    /// Both halves' sums in every cell, weighted by area.
    pub fn in_cells(&self, cells: &Cells) -> Vec<[Sums; 2]> {
        let weighs_by_alpha = self.weighs_by_alpha();
        let chunks: Vec<Vec<[Sums; 2]>> = cells
            .cuts()
            .par_chunks(CHUNK)
            .map(|cuts| {
                let mut sums = Vec::new();
                let mut corners: Vec<Vec<[Vec3; 3]>> = Vec::new();
                for cut in cuts {
                    while corners.len() <= cut.depth as usize {
                        corners.push(cells::corners(corners.len() as u32));
                    }
                    let source = self.on(cut.triangle);
                    let innermost = corners[cut.depth as usize].iter().enumerate();
                    sums.extend(innermost.map(|(number, corners)| {
                        source.in_cell(corners, cut, number as u64, weighs_by_alpha)
                    }));
                }
                sums
            })
            .collect();
        cells.gathered(chunks.concat(), |sum, other| {
            sum.iter_mut().zip(other).for_each(|(sum, other)| *sum = *sum + *other);
        })
    }
}

impl OnTriangle<'_> {
    /// What is filtered; of a normal map what it adds to the mesh's own normal, in object space.
    pub fn value(&self, at: Vec3) -> Vec4 {
        let [a, b, c] = self.places;
        let value = self.texels.bilinear(a * at.x + b * at.y + c * at.z);
        match self.frames {
            Some((frames, scale)) => {
                let frame = interpolated(frames, at);
                (object_normal(value, scale, &frame) - frame.normal.normalize_or_zero()).extend(1.0)
            }
            None => Vec4::from(value),
        }
    }

    /// Both halves over one innermost cell: evenly spread points that are shifted at random, independently.
    fn in_cell(&self, corners: &[Vec3; 3], cut: &Cut, number: u64, weighs_by_alpha: bool) -> [Sums; 2] {
        let count = (cut.weight * POINTS_PER_WEIGHT).round().clamp(1.0, POINTS_MOST);
        let weight = cut.share / count;
        let counter = u64::from(cut.triangle) << 24 | number;
        let [a, b, c] = *corners;
        [0, 2].map(|dimension| {
            let shift = (uniform(counter, dimension), uniform(counter, dimension + 1));
            let mut sums = Sums::default();
            for point in 0..count as usize {
                let (second, third) = folded(point, shift);
                let at = a + (b - a) * second as f32 + (c - a) * third as f32;
                sums.add(self.value(at), weight, weighs_by_alpha);
            }
            sums
        })
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Red, green and blue weighted by `color_weight`, alpha by `weight`.
    sum: Vec4,
    color_weight: f32,
    pub weight: f32,
}

impl Sums {
    pub fn add(&mut self, value: Vec4, weight: f32, weighs_by_alpha: bool) {
        let color_weight = if weighs_by_alpha { weight * value.w } else { weight };
        self.sum += value * Vec3::splat(color_weight).extend(weight);
        self.color_weight += color_weight;
        self.weight += weight;
    }

    /// Adds another's sums, times a factor.
    pub fn add_times(&mut self, other: &Self, factor: f32) {
        self.sum += other.sum * factor;
        self.color_weight += other.color_weight * factor;
        self.weight += other.weight * factor;
    }

    pub fn mean(&self) -> Vec4 {
        let color_weight = self.color_weight.max(f32::MIN_POSITIVE);
        self.sum / Vec3::splat(color_weight).extend(self.weight)
    }

    /// How much of the average is seen, 0 to 1.
    pub fn alpha(&self) -> f32 {
        self.color_weight / self.weight
    }
}

impl std::ops::Add for Sums {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self.add_times(&other, 1.0);
        self
    }
}
