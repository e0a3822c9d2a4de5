//! Implicit heat flow where faces are at vertex colors: `(M + τ L) C' = M C` with the cotangent Laplacian
//! `L` (U. Pinkall, K. Polthier, "Computing discrete minimal surfaces and their conjugates", Experimental
//! Mathematics 2, 1993) and the surface areas `M` of the vertices.
//!
//! How long it flows: the hat filter from one level to the next spreads a color by a variance `s h²` along
//! each axis, `h²` being the area of a texel of the finer level, `4^ℓ` cells of level 0; an implicit step spreads it
//! by `2 τ`. So a face flows for `τ = s h² / 2` to the next level. From level `r` to `ℓ` that sums up to
//! `s (4^ℓ - 4^r) / 6` cells of level 0, and continues the hat filter.
//!
//! An elongated quad comes down to one row of cells first. There its two long edges exchange, point by point, what lies
//! opposite, while the hat filter goes on along them.
//!
//! A cotangent is the scalar product of two sides over twice the triangle's area, and `τ` is in proportion to
//! that area. So it cancels: what two corners exchange is a scalar product of sides, finite on any triangle.

#[cfg(test)]
mod tests;

use glam::{DVec3, DVec4, Vec4};

use crate::colors::{LevelNumbering, SampleAreas};
use crate::error::{Error, Result};

use super::exchange::{Bond, Network, exchange};

/// Variance along an axis of one level's hat filter on a quad's cells, in cells: 1-2-1 over 4.
const QUAD_SPREAD: f64 = 0.5;
/// The same on a triangle's: the root of the determinant of its covariance, as the hat of a skewed grid
/// spreads differently by direction.
const TRIANGLE_SPREAD: f64 = 0.433_012_701_892_219_3;

/// A vertex stands for at least this share of the mean vertex's area.
const MASS_FLOOR: f64 = 1e-9;

/// What alpha counts for in a color's weight where it is 0: enough to keep hidden colors apart from zero.
const TRANSPARENT_WEIGHT: f64 = 1e-5;

/// Equal parts of the flow from one level to the next. An implicit step leaves a sharp top and long tails where
/// a bell belongs, several in a row less of both: on a flat grid the error against a bell of the same
/// variance falls from 2.8 codes with one to 1.5 with two and 1.0 with three (level 3, noise).
const STEP_COUNT: usize = 3;

/// Lets the shared samples of `coarse` flow from what they are after the hat filter over finer faces. Faces
/// that were at vertex colors at the `fine` level conduct, and those of one row of cells across it; the others do not.
///
/// # Errors
/// `Internal` where the system cannot be factored.
pub(super) fn flow(
    fine: &LevelNumbering<'_>,
    coarse: &LevelNumbering<'_>,
    network: &mut Network,
    shared: &mut [Vec4],
    by_alpha: bool,
) -> Result<()> {
    let bonds = bonds(fine, coarse);
    let Some(last) = bonds.iter().map(|bond| bond.ends[1]).max() else { return Ok(()) };
    // Vertices alone, where no face is in between.
    let fan_count = coarse.topology.fan_count();
    let count = if last as usize >= fan_count { shared.len() } else { fan_count };
    let shared = &mut shared[..count];
    let mut values: Vec<DVec4> = shared.iter().map(|value| weighted(value.as_dvec4(), by_alpha)).collect();
    if exchange(network, &bonds, &masses(coarse, count), STEP_COUNT, &mut values).is_none() {
        return Err(Error::internal("the heat flow between vertices has no solution"));
    }
    for (sample, value) in shared.iter_mut().zip(values) {
        *sample = unweighted(value, by_alpha).as_vec4();
    }
    Ok(())
}

/// A color by its weight, and alpha.
fn weighted(value: DVec4, by_alpha: bool) -> DVec4 {
    if by_alpha { (value.truncate() * (value.w + TRANSPARENT_WEIGHT)).extend(value.w) } else { value }
}

fn unweighted(value: DVec4, by_alpha: bool) -> DVec4 {
    if by_alpha { (value.truncate() / (value.w + TRANSPARENT_WEIGHT)).extend(value.w) } else { value }
}

/// What any two samples exchange; an edge's triangles together, and nothing where they repel.
fn bonds(fine: &LevelNumbering<'_>, coarse: &LevelNumbering<'_>) -> Vec<Bond> {
    let mut bonds = Vec::new();
    for (face, canvas_face) in fine.canvas.faces.iter().enumerate() {
        if !fine.is_down(face) {
            continue;
        }
        let cells = fine.texel_share(face);
        let [n, m] = fine.shape(face).segments;
        if n != m {
            across(coarse, face, usize::from(m > n), cells, &mut bonds);
            continue;
        }
        let mut add = |corners: [usize; 3], strength: f64| {
            let at = |k: usize| fine.canvas.positions[canvas_face.vertices[corners[k]] as usize].as_dvec3();
            let fan = |k: usize| fine.topology.fan_of[face][corners[k]];
            for k in 0..3 {
                let (next, last) = ((k + 1) % 3, (k + 2) % 3);
                let product = DVec3::dot(at(next) - at(k), at(last) - at(k));
                if fan(next) != fan(last) {
                    let ends = [fan(next).min(fan(last)), fan(next).max(fan(last))];
                    bonds.push(Bond { ends, conductance: strength * product });
                }
            }
        };
        if canvas_face.is_triangle() {
            // τ cot / 2 for τ = s 4^k (2 A) / 2 and cot = product / (2 A).
            add([0, 1, 2], cells * TRIANGLE_SPREAD / 4.0);
        } else {
            // The mean of both ways to split it, each triangle being half of a cell.
            for corners in [[0, 1, 2], [0, 2, 3], [1, 2, 3], [1, 3, 0]] {
                add(corners, cells * QUAD_SPREAD / 8.0);
            }
        }
    }
    merged(bonds, coarse.shared_count())
}

/// Between the two long edges of a quad of one row of cells, at the samples that both have: `τ` times the width of what
/// lies between two samples over their distance, which is `τ` over the quad's area times its length squared, shared by all.
/// `first` is the first of them.
fn across(coarse: &LevelNumbering<'_>, face: usize, first: usize, cells: f64, bonds: &mut Vec<Bond>) {
    let canvas_face = &coarse.canvas.faces[face];
    let shape = coarse.shape(face);
    let at = |k: usize| coarse.canvas.positions[canvas_face.vertices[k % 4] as usize].as_dvec3();
    let edges = [first, first + 2];
    let length = 0.5 * edges.iter().map(|&edge| at(edge).distance(at(edge + 1))).sum::<f64>();
    let strips = edges.map(|edge| coarse.topology.strip_of[face][edge] as usize);
    let count = strips.map(|strip| coarse.strip_segments(strip)).into_iter().min().unwrap_or(1);
    let conductance = 0.5 * QUAD_SPREAD * cells * length * length / f64::from(count);
    let along = shape.edge_segments(first);
    for number in 0..=count {
        let share = if number == 0 || number == count { 0.5 } else { 1.0 };
        let from_start = number * (along / count);
        let [one, other] = [(edges[0], from_start), (edges[1], along - from_start)]
            .map(|(edge, along)| coarse.edge_tap(face, edge, along).samples[0]);
        if one != other {
            bonds.push(Bond { ends: [one.min(other), one.max(other)], conductance: share * conductance });
        }
    }
}

/// One bond for each pair: the sum, where it is above zero. Sorted by counting, which keeps the order of faces
/// within a pair, so that sums have one order too.
fn merged(bonds: Vec<Bond>, sample_count: usize) -> Vec<Bond> {
    let mut first = vec![0usize; sample_count + 1];
    bonds.iter().for_each(|bond| first[bond.ends[0] as usize + 1] += 1);
    for sample in 0..sample_count {
        first[sample + 1] += first[sample];
    }
    let mut order = vec![0u32; bonds.len()];
    let mut next = first.clone();
    for (number, bond) in (0u32..).zip(&bonds) {
        let slot = &mut next[bond.ends[0] as usize];
        order[*slot] = number;
        *slot += 1;
    }
    let mut merged = Vec::with_capacity(bonds.len() / 2 + 1);
    for range in first.windows(2) {
        let own = &mut order[range[0]..range[1]];
        own.sort_by_key(|&number| bonds[number as usize].ends[1]);
        for group in own.chunk_by(|&a, &b| bonds[a as usize].ends == bonds[b as usize].ends) {
            let conductance: f64 = group.iter().map(|&number| bonds[number as usize].conductance).sum();
            if conductance > 0.0 {
                merged.push(Bond { ends: bonds[group[0] as usize].ends, conductance });
            }
        }
    }
    merged
}

/// The areas of the first `count` samples at the level that flows: after the hat filter each stands for its coarse
/// hat, so that the sum of area times color is kept.
fn masses(coarse: &LevelNumbering<'_>, count: usize) -> Vec<f64> {
    let areas = SampleAreas::new(coarse);
    let mut masses: Vec<f64> = areas.fans.iter().map(|&area| area.into()).collect();
    if count > masses.len() {
        let of_strip = |(strip, &area): (usize, &f32)| {
            std::iter::repeat_n(f64::from(area), coarse.strip_range(strip).len())
        };
        masses.extend(areas.strips.iter().enumerate().flat_map(of_strip));
    }
    let mean = masses.iter().sum::<f64>() / masses.len() as f64;
    // A mesh without any area flows to its mean at once.
    let floor = (mean * MASS_FLOOR).max(1e-100);
    masses.iter_mut().for_each(|mass| *mass = mass.max(floor));
    masses
}
