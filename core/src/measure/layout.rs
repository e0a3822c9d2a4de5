//! Figures of a layout, from finished coordinates alone: which texels any triangle's filtering can reach,
//! and how many faces stand in blocks of what size.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::edges::{EdgePair, Side};
use super::report::{CoordinatesKind, LayoutLevel, LayoutReport, TableReport};
use super::subject::SampleCounts;
use super::surface::{Part, Surface};
use crate::asset::Asset;
use crate::error::Result;
use crate::finished::{Finished, FinishedPrimitive, FinishedTriangle};
use crate::math::partition::Partition;

/// The faces of one part of a material, before its texels are counted.
pub struct Tally {
    part: usize,
    report: LayoutReport,
}

/// One for each part of the surface's material that has faces, ascending.
///
/// # Errors
/// `InvalidModel` where the drawn triangles are not those of the asset's faces.
pub fn tallies(surface: &Surface<'_>) -> Result<Vec<Tally>> {
    let numbers: BTreeSet<usize> = surface.parts.iter().map(Part::part).collect();
    numbers.into_iter().map(|part| Ok(Tally { part, report: faces(surface, part)? })).collect()
}

/// The layouts, one for each set of textures, in order of the first material and its part.
pub fn reports(
    asset: &Asset,
    finished: &Finished,
    tallies: Vec<Tally>,
    counts: &[SampleCounts],
) -> Vec<LayoutReport> {
    // Textures that faces of one part of a material read have coordinates in common: they are one set.
    let mut sets = Partition::new(finished.textures.len());
    let textures = |tally: &Tally| {
        finished.textures_of(tally.report.material, tally.part).map(|(number, _)| number as u32)
    };
    for tally in &tallies {
        let mut own = textures(tally);
        if let Some(first) = own.next() {
            own.for_each(|other| sets.join(first, other));
        }
    }
    let mut pieces: BTreeMap<(usize, usize), Vec<&FinishedPrimitive>> = BTreeMap::new();
    for piece in &finished.primitives {
        pieces.entry((piece.material, piece.part)).or_default().push(piece);
    }
    let mut known: BTreeMap<u32, usize> = BTreeMap::new();
    let mut groups: Vec<Vec<Tally>> = Vec::new();
    for tally in tallies {
        let Some(set) = textures(&tally).next().map(|first| sets.root(first)) else { continue };
        let number = *known.entry(set).or_insert(groups.len());
        groups.resize_with(groups.len().max(number + 1), Vec::new);
        groups[number].push(tally);
    }
    groups.into_iter().map(|group| report((asset, finished), group, &pieces, counts)).collect()
}

/// The layout of the texture set that some parts of materials share.
fn report(
    (asset, finished): (&Asset, &Finished),
    group: Vec<Tally>,
    pieces: &BTreeMap<(usize, usize), Vec<&FinishedPrimitive>>,
    counts: &[SampleCounts],
) -> LayoutReport {
    let places: Vec<(usize, usize)> = group.iter().map(|tally| (tally.report.material, tally.part)).collect();
    let texture = places.first().and_then(|&(material, part)| finished.textures_of(material, part).next());
    let sizes: Vec<[u32; 2]> = texture
        .map(|(_, texture)| texture.levels.iter().map(|image| image.size()).collect())
        .unwrap_or_default();
    let pieces: Vec<&FinishedPrimitive> =
        places.iter().filter_map(|place| pieces.get(place)).flatten().copied().collect();
    let distinct = |level: usize| -> Option<u64> {
        let own = |&(material, part): &(usize, usize)| {
            let counts = counts.iter().find(|counts| (counts.material, counts.part) == (material, part))?;
            counts.levels.get(level).copied()
        };
        places.iter().map(own).sum()
    };
    let levels = sizes.par_iter().enumerate().map(|(level, &size)| {
        let allocated_texels = u64::from(size[0]) * u64::from(size[1]);
        let used = used_texels(&pieces, level, size);
        LayoutLevel {
            level: level as u32,
            size,
            allocated_texels,
            waste: 1.0 - used as f64 / allocated_texels.max(1) as f64,
            efficiency: distinct(level).map(|count| count as f64 / allocated_texels.max(1) as f64),
        }
    });
    let levels = levels.collect();
    let mut tallies = group.into_iter().map(|tally| tally.report);
    let mut report = tallies.next().unwrap_or_default();
    tallies.for_each(|other| report.join(&other));
    report.material_name = asset.materials.get(report.material).map(|m| m.name.clone()).unwrap_or_default();
    report.levels = levels;
    report
}

impl LayoutReport {
    /// Takes in the faces of another material of the same set.
    fn join(&mut self, other: &Self) {
        if self.materials.is_empty() {
            self.materials.push(self.material);
        }
        self.materials.push(other.material);
        self.face_count += other.face_count;
        self.quad_count += other.quad_count;
        self.merged_pair_count += other.merged_pair_count;
        self.lone_triangle_count += other.lone_triangle_count;
        self.exponents.resize(self.exponents.len().max(other.exponents.len()), 0);
        self.exponents.iter_mut().zip(&other.exponents).for_each(|(own, other)| *own += other);
    }
}

/// Faces and their blocks. Two triangles on both sides of a diagonal whose texels both read are the halves of a
/// quad face, or a merged pair. (Faces beside each other in a larger block share a straight edge.)
fn faces(surface: &Surface<'_>, part: usize) -> Result<LayoutReport> {
    let is_here = |side: &Side| surface.part(side).part() == part;
    let here = |pair: &&EdgePair| is_here(&pair.a) && is_here(&pair.b);
    let joined = surface.pairs.iter().filter(here).filter(|pair| is_joined(surface, pair)).count() as u64;
    let (mut face_count, mut quad_count, mut triangle_count) = (0, 0, 0);
    let mut exponents = Vec::new();
    let pieces = || surface.parts.iter().filter(|piece| piece.part() == part);
    for piece in pieces() {
        triangle_count += piece.triangles.len() as u64;
        let drawn: Vec<(u32, usize)> = (piece.faces()?.into_iter())
            .zip(piece.placed)
            .map(|(face, triangle)| (face, piece.coordinates.exponent(triangle)))
            .collect();
        for of_face in drawn.chunk_by(|a, b| a.0 == b.0) {
            face_count += 1;
            quad_count += u64::from(piece.geometry.faces[of_face[0].0 as usize].count == 4);
            let exponent = of_face.iter().map(|(_, exponent)| *exponent).max().unwrap_or(0);
            if exponents.len() <= exponent {
                exponents.resize(exponent + 1, 0);
            }
            exponents[exponent] += 1;
        }
    }
    // The same in all pieces.
    let table = pieces().next().and_then(|piece| piece.coordinates.table());
    Ok(LayoutReport {
        material: surface.material,
        part,
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
        ..LayoutReport::default()
    })
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
fn used_texels(pieces: &[&FinishedPrimitive], level: usize, size: [u32; 2]) -> u64 {
    let mut mask = Mask::new(size);
    for piece in pieces {
        for triangle in 0..piece.triangles.len() {
            mask.mark(std::array::from_fn(|corner| piece.place(triangle, corner, level)));
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
