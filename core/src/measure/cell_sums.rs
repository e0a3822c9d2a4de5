//! Weighted sums of a channel's source, at points of the surface and in its [cells](super::cells).
//!
//! Every sum is made twice, over points of its own: what both differ by tells how far they are off.

use glam::{IVec2, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::cells::{self, Cells, Cut};
use super::graph::Graph;
use super::judge::{Meaning, axes, interpolated, tilt};
use super::original::Original;
use super::points::bits;
use super::surface::Surface;
use super::texels::Texels;
use crate::finished::Frame;
use crate::source::painted::PaintedChannel;

/// Triangles handled in one go.
const CHUNK: usize = 64;

/// Triangles whose first corners share a square of the image so wide are summed together.
const TILE_TEXELS: f32 = 64.0;

/// Points of each half in an innermost cell of weight 1, and at most.
const POINTS_PER_WEIGHT: f32 = 2.0;
const POINTS_MOST: f32 = 4.0;

/// A channel's source as it is averaged.
pub struct Averaged<'a> {
    pub graph: &'a Graph,
    pub surface: &'a Surface<'a>,
    pub original: Original<'a>,
}

/// The source on one triangle.
pub struct OnTriangle<'a> {
    content: Content<'a>,
    /// Of the corners, in texels of an image, or in the unit domain of a face with mesh colors.
    places: [Vec2; 3],
    /// For normals: the frames of the corners, and the scale.
    frames: Option<(&'a [Frame; 3], f32)>,
    /// Of the corners, what multiplies the image.
    tints: Option<[Vec4; 3]>,
}

enum Content<'a> {
    Image(Texels<'a>),
    /// With the face.
    Painted(&'a PaintedChannel<'a>, u32),
}

impl Averaged<'_> {
    /// By the triangle's number in the graph.
    pub fn on(&self, triangle: u32) -> OnTriangle<'_> {
        let (part, triangle) = self.graph.place(triangle);
        let vertices = self.surface.parts[part].triangles[triangle];
        let frames = match (self.original.meaning(), self.original.corner_frames(part, triangle)) {
            (Meaning::Normal { scale }, Some(frames)) => Some((frames, scale)),
            _ => None,
        };
        match self.original {
            Original::Image(origin) => {
                let texels = origin.texels(origin.image);
                let size_texels = texels.size_texels();
                OnTriangle {
                    content: Content::Image(texels),
                    places: origin.corner_uvs(part, vertices).map(|uv| uv * size_texels),
                    frames,
                    tints: origin.corner_tints(part, vertices),
                }
            }
            Original::Painted(painted) => {
                let place = painted.place(part, triangle);
                let content = Content::Painted(painted.channel, place.face);
                OnTriangle { content, places: place.corners, frames, tints: None }
            }
        }
    }

    /// Whether color counts by how much of it is seen.
    pub fn weighs_by_alpha(&self) -> bool {
        self.original.meaning() == Meaning::Color && matches!(self.original.components(), 2 | 4)
    }

    /// Both halves' sums in every cell, weighted by area.
    pub fn in_cells(&self, cells: &Cells) -> Vec<[Sums; 2]> {
        let cuts = cells.cuts();
        // In the order of the image, so that its texels are still near when they are read again; those of faces are near anyway.
        let mut order: Vec<u32> = (0..cuts.len() as u32).collect();
        order.sort_by_cached_key(|&number| {
            let on = self.on(cuts[number as usize].triangle);
            let at = match on.content {
                Content::Image(_) => (on.places[0] / TILE_TEXELS).as_ivec2(),
                Content::Painted(..) => IVec2::ZERO,
            };
            (at.y, at.x, number)
        });
        let chunks: Vec<Vec<[Sums; 2]>> =
            order.par_chunks(CHUNK).map(|order| self.innermost(cuts, order)).collect();
        let mut starts = Vec::with_capacity(cuts.len());
        let mut count = 0;
        for cut in cuts {
            starts.push(count);
            count += cut.cell_count();
        }
        let mut innermost = vec![<[Sums; 2]>::default(); count];
        for (order, chunk) in order.chunks(CHUNK).zip(&chunks) {
            let mut rest = chunk.as_slice();
            for &number in order {
                let number = number as usize;
                let (own, others) = rest.split_at(cuts[number].cell_count());
                innermost[starts[number]..][..own.len()].copy_from_slice(own);
                rest = others;
            }
        }
        cells.gathered(innermost, |sum, other| {
            sum.iter_mut().zip(other).for_each(|(sum, other)| sum.add_times(other, 1.0));
        })
    }

    /// Those of the innermost cells of some triangles.
    fn innermost(&self, cuts: &[Cut], order: &[u32]) -> Vec<[Sums; 2]> {
        let weighs_by_alpha = self.weighs_by_alpha();
        let cuts = || order.iter().map(|&number| &cuts[number as usize]);
        let mut sums = Vec::with_capacity(cuts().map(Cut::cell_count).sum());
        let deepest = cuts().map(|cut| cut.depth).max().unwrap_or(0);
        let corners: Vec<Vec<[Vec3; 3]>> = (0..=deepest).map(cells::corners).collect();
        let mut places = Vec::new();
        for cut in cuts() {
            let (source, corners) = (self.on(cut.triangle), &corners[cut.depth as usize]);
            let count = points_of_half(cut);
            places.clear();
            for (number, corners) in corners.iter().enumerate() {
                source.scatter(corners, u64::from(cut.triangle) << 24 | number as u64, count, &mut places);
            }
            let weight = cut.share / count as f32;
            let by_cell = corners.iter().zip(places.chunks(2 * count as usize));
            sums.extend(
                by_cell.map(|(corners, places)| source.in_cell(corners, places, weight, weighs_by_alpha)),
            );
        }
        sums
    }
}

impl OnTriangle<'_> {
    /// What is filtered; of a normal map what it adds to the mesh's own normal, in object space.
    pub fn value(&self, at: Vec3) -> Vec4 {
        let value = self.filtered(self.place(at));
        let Some((frames, scale)) = self.frames else { return value * self.tint(at) };
        let [right, up, out] = axes(&interpolated(frames, at));
        if let Content::Painted(..) = self.content {
            return lean(value, out).extend(1.0);
        }
        let tilt = tilt(value, scale);
        (right * tilt.x + up * tilt.y + out * tilt.z).extend(1.0)
    }

    fn filtered(&self, place: Vec2) -> Vec4 {
        match &self.content {
            Content::Image(texels) => texels.filtered(place),
            Content::Painted(channel, face) => channel.colors.linear(*face as usize, place, 0),
        }
    }

    fn tint(&self, at: Vec3) -> Vec4 {
        self.tints.map_or(Vec4::ONE, |[a, b, c]| a * at.x + b * at.y + c * at.z)
    }

    fn place(&self, at: Vec3) -> Vec2 {
        let [a, b, c] = self.places;
        a * at.x + b * at.y + c * at.z
    }

    /// Puts the points of both halves in one innermost cell behind `places`, in texels: evenly spread and
    /// shifted at random, independently.
    fn scatter(&self, corners: &[Vec3; 3], counter: u64, count: u32, places: &mut Vec<Vec2>) {
        let [a, b, c] = corners.map(|at| self.place(at));
        let (along, across) = (b - a, c - a);
        let bits = bits(counter);
        for bits in [bits as u32, (bits >> 32) as u32] {
            let (mut x, mut y) = (bits << 16, bits & 0xffff_0000);
            for _ in 0..count {
                let (second, third) = folded(x, y);
                places.push(a + along * second + across * third);
                (x, y) = (x.wrapping_add(STEP_X), y.wrapping_add(STEP_Y));
            }
        }
    }

    /// Both halves over one innermost cell; every point has the same weight.
    fn in_cell(&self, corners: &[Vec3; 3], places: &[Vec2], weight: f32, weighs_by_alpha: bool) -> [Sums; 2] {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        // One for the whole cell, as the frame is.
        let tint = self.tint(middle);
        let turn = self.frames.map(|(frames, _)| axes(&interpolated(frames, middle)));
        let mut halves = [Sums::default(); 2];
        for (sums, places) in halves.iter_mut().zip(places.chunks(places.len() / 2)) {
            for &place in places {
                let value = self.filtered(place);
                let value = match (self.frames, turn, &self.content) {
                    (Some(_), Some([_, _, out]), Content::Painted(..)) => lean(value, out).extend(1.0),
                    (Some((_, scale)), ..) => tilt(value, scale).extend(1.0),
                    _ => value * tint,
                };
                sums.add(value, weight, weighs_by_alpha);
            }
        }
        // Normals of mesh colors stand in the mesh's space already.
        let (Some([right, up, out]), Content::Image(_)) = (turn, &self.content) else { return halves };
        halves.map(|half| Sums {
            sum: (right * half.sum.x + up * half.sum.y + out * half.sum.z).extend(half.sum.w),
            ..half
        })
    }
}

/// What a normal in the mesh's space adds to the mesh's own.
fn lean(normal: Vec4, own: Vec3) -> Vec3 {
    normal.truncate().normalize_or(own) - own
}

/// How many points each half has in an innermost cell.
fn points_of_half(cut: &Cut) -> u32 {
    (cut.weight * POINTS_PER_WEIGHT).round().clamp(1.0, POINTS_MOST) as u32
}

/// Steps of a sequence that covers the unit square evenly, in parts of 2^32: the inverse powers of the
/// plastic number (Roberts' R2 sequence).
const STEP_X: u32 = 3_242_174_889;
const STEP_Y: u32 = 2_447_445_414;

/// A point of the square in parts of 2^32, folded over the diagonal: a triangle's second and third
/// barycentrics.
fn folded(x: u32, y: u32) -> (f32, f32) {
    // 24 bits are exact in a float.
    let [x, y] = [x, y].map(|part| (part >> 8) as i32 as f32 / (1 << 24) as f32);
    if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) }
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

#[cfg(test)]
mod tests;
