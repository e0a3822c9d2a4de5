//! One level from the level before it: the samples inside faces.
//!
//! Each is its own fine sample and the neighbors of that, all strictly inside the same face, so all stand for
//! one area and both filters agree (MC equation 5, the 1-2-1 product on quads).

use glam::Vec4;
use rayon::prelude::*;

use crate::colors::{LevelNumbering, Shape};
use crate::math::mean::WeightedMean;

use super::filter::Filter;
use super::hats::{edge_grid_point, edge_taps};

/// Fine samples to one task.
const TASK_SAMPLES: usize = 1 << 16;

/// What a face adds to the coarse samples on its edges, where it is as fine as the edge: taken while the face
/// is at hand, as the samples beside an edge lie far apart in memory.
pub(super) struct Borders {
    /// By face, and one past the end.
    first: Vec<usize>,
    sums: Vec<Vec4>,
}

impl Borders {
    /// Room for all faces, or for none.
    fn new(coarse: &LevelNumbering<'_>, is_needed: bool) -> Self {
        let mut first = vec![0];
        for face in 0..coarse.canvas.faces.len() {
            let shape = coarse.shape(face);
            let count = if is_needed { shape.border_count() - shape.edge_count() } else { 0 };
            first.push(first[face] + count);
        }
        let sums = vec![Vec4::ZERO; first[first.len() - 1]];
        Self { first, sums }
    }

    /// What the face, whose coarse grid is `coarse`, adds at each coarse sample of an edge, from the edge's first
    /// corner; `None` where this was not worked out.
    pub fn of_edge(&self, face: usize, edge: usize, coarse: Shape) -> Option<&[Vec4]> {
        let sums = &self.sums[self.first[face]..self.first[face + 1]];
        sums.get(edge_samples(coarse, edge))
    }
}

/// Where the samples inside an edge stand among those inside all edges of its face.
fn edge_samples(shape: Shape, edge: usize) -> std::ops::Range<usize> {
    let first = shape.edge_first(edge) - edge;
    first..first + shape.edge_segments(edge) as usize - 1
}

/// Fills `out`, which begins with the first face's samples.
pub(super) fn interiors(filter: &Filter<'_>, mut out: &mut [Vec4]) -> Borders {
    let (fine, coarse) = (filter.fine, filter.coarse);
    // Weights by alpha do not sum up to the same on both sides of an edge.
    let mut borders = Borders::new(coarse, !filter.rungs.by_alpha);
    let mut sums = &mut borders.sums[..];
    let mut tasks = Vec::new();
    let face_count = coarse.canvas.faces.len();
    let mut first = 0;
    while first < face_count {
        let start = fine.face_range(first).start;
        let mut end = first + 1;
        while end < face_count && fine.face_range(end).end - start < TASK_SAMPLES {
            end += 1;
        }
        let inner_count = coarse.face_range(end - 1).end - coarse.face_range(first).start;
        let (inner, rest) = out.split_at_mut(inner_count);
        out = rest;
        let (own_sums, rest) = sums.split_at_mut(borders.first[end] - borders.first[first]);
        sums = rest;
        tasks.push((first..end, inner, own_sums));
        first = end;
    }
    let border_first = &borders.first;
    tasks.into_par_iter().for_each(|(faces, mut inner, mut sums)| {
        for face in faces {
            let (own, rest) = inner.split_at_mut(coarse.face_range(face).len());
            inner = rest;
            let (own_sums, rest) = sums.split_at_mut(border_first[face + 1] - border_first[face]);
            sums = rest;
            if filter.rungs.by_alpha {
                rows(fine, filter.values, face, own, by_alpha);
            } else {
                rows(fine, filter.values, face, own, plain);
                border_sums(filter, face, own_sums);
            }
        }
    });
    borders
}

fn border_sums(filter: &Filter<'_>, face: usize, sums: &mut [Vec4]) {
    let fine = filter.fine;
    let (shape, coarse) = (fine.shape(face), filter.coarse.shape(face));
    if sums.is_empty() {
        return;
    }
    for edge in 0..shape.edge_count() {
        let strip = fine.topology.strip_of[face][edge] as usize;
        let taps = edge_taps(shape, edge, 1, filter.rungs.filter);
        if fine.strip_segments(strip) != shape.edge_segments(edge) {
            continue;
        }
        for (along, sum) in (2..).step_by(2).zip(&mut sums[edge_samples(coarse, edge)]) {
            for tap in taps.iter() {
                let place = (tap.offset + along, tap.depth);
                let (i, j) = edge_grid_point(shape, edge, (place.0 as u32, place.1));
                *sum += filter.values[fine.inner_sample(face, i, j)] * tap.weight;
            }
        }
    }
}

/// `own` are the coarse samples inside the face, row by row.
fn rows(
    fine: &LevelNumbering<'_>,
    values: &[Vec4],
    face: usize,
    mut own: &mut [Vec4],
    mix: impl Fn([Vec4; 3], [Vec4; 3], [Vec4; 3], bool) -> Vec4 + Copy,
) {
    let Shape { is_triangle, segments } = fine.shape(face);
    let n = segments[0] as usize;
    let mut samples = &values[fine.face_range(face)];
    // Row j of the fine samples; on a triangle each is one shorter than the one before.
    let mut next_row = |j: usize| {
        let (row, rest) = samples.split_at(if is_triangle { n - 1 - j } else { n - 1 });
        samples = rest;
        row
    };
    if own.is_empty() {
        return;
    }
    let mut low = next_row(1);
    let mut j = 2;
    while !own.is_empty() {
        let (middle, high) = (next_row(j), next_row(j + 1));
        let half = n / 2;
        let count = if is_triangle { half - j / 2 - 1 } else { half - 1 };
        let (row, rest) = own.split_at_mut(count);
        own = rest;
        if is_triangle {
            // The coarse sample i sits on fine column 2 i, which is entry 2 i - 1 of its row.
            for (i, out) in row.iter_mut().enumerate() {
                let at = 2 * i;
                let zero = Vec4::ZERO;
                *out = mix(
                    [zero, low[at + 1], low[at + 2]],
                    [middle[at], middle[at + 1], middle[at + 2]],
                    [high[at], high[at + 1], zero],
                    true,
                );
            }
        } else {
            for (i, out) in row.iter_mut().enumerate() {
                let three = |row: &[Vec4]| [row[2 * i], row[2 * i + 1], row[2 * i + 2]];
                *out = mix(three(low), three(middle), three(high), false);
            }
        }
        low = high;
        j += 2;
    }
}

/// MC equation 5: half of six neighbors; the other two corners of the nine are no neighbors.
const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.5, 0.5], [0.5, 1.0, 0.5], [0.5, 0.5, 0.0]];
const QUAD: [[f32; 3]; 3] = [[0.25, 0.5, 0.25], [0.5, 1.0, 0.5], [0.25, 0.5, 0.25]];

#[inline(always)]
fn plain(low: [Vec4; 3], middle: [Vec4; 3], high: [Vec4; 3], is_triangle: bool) -> Vec4 {
    let sides = low[1] + middle[0] + middle[2] + high[1];
    if is_triangle {
        middle[1] * 0.25 + (sides + low[2] + high[0]) * 0.125
    } else {
        middle[1] * 0.25 + sides * 0.125 + (low[0] + low[2] + high[0] + high[2]) * 0.0625
    }
}

#[inline(always)]
fn by_alpha(low: [Vec4; 3], middle: [Vec4; 3], high: [Vec4; 3], is_triangle: bool) -> Vec4 {
    let mut mean = WeightedMean::default();
    let weights = if is_triangle { &TRIANGLE } else { &QUAD };
    for (values, weights) in [low, middle, high].iter().zip(weights) {
        for (value, weight) in values.iter().zip(weights) {
            mean.add(*value, *weight, true);
        }
    }
    mean.mean()
}
