//! Figures of a layout, from finished coordinates alone: which texels any triangle's filtering can reach,
//! and how many faces stand in blocks of what size.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::edges::{EdgePair, Side};
use super::report::{CoordinatesKind, LayoutLevel, LayoutReport, TableReport};
use super::surface::Surface;
use crate::asset::Asset;
use crate::finished::{Finished, FinishedTriangle};

/// The layout of one material. `sample_counts` are the distinct mesh color samples of each level, where
/// the caller knows them.
pub fn report(
    asset: &Asset,
    finished: &Finished,
    surface: &Surface<'_>,
    sample_counts: Option<&[u64]>,
) -> LayoutReport {
    let sizes: Vec<[u32; 2]> = finished
        .textures
        .iter()
        .find(|texture| texture.is_of(surface.material, 0))
        .map(|texture| texture.levels.iter().map(|image| image.size()).collect())
        .unwrap_or_default();
    let levels = sizes.par_iter().enumerate().map(|(level, &size)| {
        let allocated_texels = u64::from(size[0]) * u64::from(size[1]);
        let used = used_texels(surface, level, size);
        let distinct = sample_counts.and_then(|counts| counts.get(level));
        LayoutLevel {
            level: level as u32,
            size,
            allocated_texels,
            waste: 1.0 - used as f64 / allocated_texels.max(1) as f64,
            efficiency: distinct.map(|&count| count as f64 / allocated_texels.max(1) as f64),
        }
    });
    let mut report = blocks(surface);
    report.material_name = asset.materials.get(surface.material).map(|m| m.name.clone()).unwrap_or_default();
    report.levels = levels.collect();
    report
}

/// Faces and their blocks. Two triangles on both sides of a diagonal whose texels both read are the halves of a
/// quad face, or a merged pair. (Faces beside each other in a larger block share a straight edge.)
fn blocks(surface: &Surface<'_>) -> LayoutReport {
    let joined = surface.pairs.iter().filter(|pair| is_joined(surface, pair)).count() as u64;
    let faces = || surface.parts.iter().flat_map(|part| &part.geometry.faces);
    let quad_count = faces().filter(|face| face.count == 4).count() as u64;
    let face_count = faces().count() as u64;
    let triangle_count = surface.triangle_count() as u64;
    let mut exponents = Vec::new();
    for part in &surface.parts {
        let exponent = |triangle| part.coordinates.exponent(triangle);
        let mut triangles = part.placed.iter();
        for face in &part.geometry.faces {
            let drawn = face.triangles().len();
            let exponent = triangles.by_ref().take(drawn).map(exponent).max().unwrap_or(0);
            if exponents.len() <= exponent {
                exponents.resize(exponent + 1, 0);
            }
            exponents[exponent] += 1;
        }
    }
    // The same in all parts.
    let table = surface.parts.first().and_then(|part| part.coordinates.table());
    LayoutReport {
        material: surface.material,
        material_name: String::new(),
        face_count,
        quad_count,
        merged_pair_count: joined.saturating_sub(quad_count),
        lone_triangle_count: triangle_count.saturating_sub(2 * joined.max(quad_count)),
        exponents,
        coordinates: if table.is_some() { CoordinatesKind::Indexed } else { CoordinatesKind::FourD },
        table: table.map(|table| TableReport {
            class_count: table.classes.len() as u64,
            byte_count: table.byte_count() as u64,
        }),
        levels: Vec::new(),
    }
}

fn placed<'a>(surface: &Surface<'a>, side: &Side) -> &'a FinishedTriangle {
    &surface.part(side).placed[side.triangle as usize]
}

/// Whether the sides of a pair are one slanted edge of one block, with their triangles left and right of it.
fn is_joined(surface: &Surface<'_>, pair: &EdgePair) -> bool {
    let (a, b) = (placed(surface, &pair.a), placed(surface, &pair.b));
    let (ends_a, ends_b) = (pair.a.ends(), pair.ends_of_b());
    let [from, to] = ends_a.map(|end| a.corners[end]);
    let is_one_edge = a.anchor == b.anchor && [from, to] == ends_b.map(|end| b.corners[end]);
    let along = to - from;
    let side = |triangle: &FinishedTriangle, corner: u8| {
        along.perp_dot(triangle.corners[(usize::from(corner) + 2) % 3] - from)
    };
    is_one_edge && along.x != 0.0 && along.y != 0.0 && side(a, pair.a.corner) * side(b, pair.b.corner) < 0.0
}

/// Texels that bilinear filtering at some point of some triangle gives a weight.
fn used_texels(surface: &Surface<'_>, level: usize, size: [u32; 2]) -> u64 {
    let mut mask = Mask::new(size);
    for part in &surface.parts {
        for triangle in part.placed {
            mask.mark(std::array::from_fn(|corner| part.coordinates.place(triangle, corner, level)));
        }
    }
    mask.count()
}

/// One bit for each texel.
struct Mask {
    width: usize,
    height: usize,
    words_per_row: usize,
    words: Vec<u64>,
}

impl Mask {
    fn new([width, height]: [u32; 2]) -> Self {
        let (width, height) = (width as usize, height as usize);
        let words_per_row = width.div_ceil(64);
        Self { width, height, words_per_row, words: vec![0; words_per_row * height] }
    }

    fn count(&self) -> u64 {
        self.words.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// Marks the texels with a positive weight somewhere in the triangle: those whose center lies inside
    /// the triangle widened by the open square of side 2. That shape is convex, so each row has one run.
    fn mark(&mut self, corners: [Vec2; 3]) {
        // Texel centers become whole numbers. Places outside the image read its border texels.
        let size = DVec2::new(self.width as f64, self.height as f64);
        let corners = corners.map(|corner| (corner.as_dvec2() - 0.5).clamp(DVec2::NEG_ONE, size));
        let [a, b, c] = corners;
        let (low, high) = (a.min(b).min(c) - 1.0, a.max(b).max(c) + 1.0);
        let limits = outlines(corners);
        for row in above(low.y) as i64..=below(high.y) as i64 {
            let (mut from, mut to) = (low.x, high.x);
            for (normal, limit) in &limits {
                // normal · (x, row) < limit; level sides say nothing about x.
                let rest = limit - normal.y * row as f64;
                if normal.x > 0.0 {
                    to = to.min(rest / normal.x);
                } else if normal.x < 0.0 {
                    from = from.max(rest / normal.x);
                }
            }
            self.fill(row, above(from), below(to));
        }
    }

    /// Sets a run of one row, ends included, clamped as a sampler clamps.
    fn fill(&mut self, row: i64, from: f64, to: f64) {
        if from > to || self.width == 0 || self.height == 0 {
            return;
        }
        let row = row.clamp(0, self.height as i64 - 1) as usize;
        let [from, to] = [from, to].map(|x| x.clamp(0.0, (self.width - 1) as f64) as usize);
        let words = &mut self.words[row * self.words_per_row..][..self.words_per_row];
        for (number, word) in words.iter_mut().enumerate().take(to / 64 + 1).skip(from / 64) {
            let first = number * 64;
            let (start, end) = (from.max(first) - first, to.min(first + 63) - first);
            *word |= (u64::MAX >> (63 - end)) & (u64::MAX << start);
        }
    }
}

/// The smallest whole number above, and the largest below: touching gives a texel no weight. Half a
/// thousandth of rounding in the coordinates is not a weight either.
fn above(x: f64) -> f64 {
    (x + 5e-4).floor() + 1.0
}

fn below(x: f64) -> f64 {
    (x - 5e-4).ceil() - 1.0
}

/// The triangle's sides as half planes `normal · p < limit`, moved outward by the square's reach.
fn outlines(corners: [DVec2; 3]) -> [(DVec2, f64); 3] {
    std::array::from_fn(|k| {
        let (a, b, c) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let across = (b - a).perp();
        let normal = if across.dot(c - a) > 0.0 { -across } else { across };
        let reach = normal.x.abs() + normal.y.abs();
        (normal, normal.dot(a).max(normal.dot(c)) + reach)
    })
}

#[cfg(test)]
mod tests;
