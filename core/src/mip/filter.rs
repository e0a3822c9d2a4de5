//! One level from the level before it.

use glam::Vec4;
use rayon::prelude::*;

use crate::colors::{FaceGrid, LevelNumbering};
use crate::error::Result;
use crate::math::mean::WeightedMean;
use crate::watch::{self, Watch};

/// Computes the samples of `coarse` from those of `fine`, the level before it.
///
/// With `by_alpha` colors are weighted by alpha. Normals are averaged as vectors: they shorten where
/// they differ, which is what the next level has to weigh them by; whoever stores them normalizes.
pub fn coarsen(
    fine: &LevelNumbering<'_>,
    coarse: &LevelNumbering<'_>,
    values: &[Vec4],
    by_alpha: bool,
    watch: &dyn Watch,
) -> Result<Vec<Vec4>> {
    watch::check(watch)?;
    let filter = Filter { fine, coarse, values, by_alpha };
    let topology = coarse.topology;
    let mut out = Vec::with_capacity(coarse.sample_count());
    let fans = (0..topology.fan_count()).into_par_iter().map(|fan| filter.fan(fan));
    out.par_extend(fans);
    let strips = (0..topology.strips.len()).into_par_iter().map(|strip| filter.strip(strip));
    out.extend(strips.collect::<Vec<_>>().into_iter().flatten());
    watch::check(watch)?;
    let faces = (0..coarse.canvas.faces.len())
        .into_par_iter()
        .map_init(FaceGrid::default, |grid, face| filter.interior(face, grid));
    out.extend(faces.collect::<Vec<_>>().into_iter().flatten());
    Ok(out)
}

struct Filter<'a> {
    fine: &'a LevelNumbering<'a>,
    coarse: &'a LevelNumbering<'a>,
    values: &'a [Vec4],
    by_alpha: bool,
}

impl Filter<'_> {
    fn add(&self, mean: &mut WeightedMean, value: Vec4, weight: f32) {
        mean.add(value, weight, self.by_alpha);
    }

    fn tap(&self, face: usize, i: u32, j: u32) -> Vec4 {
        self.fine.tap(face, i, j).value(self.values)
    }

    /// A vertex: itself, and in each face around it the neighbors at that face's own spacing: half of each
    /// edge neighbor, shared among the faces at the edge, and a quarter of a quad's inner one.
    fn fan(&self, fan: usize) -> Vec4 {
        let mut mean = WeightedMean::default();
        self.add(&mut mean, self.values[fan], 1.0);
        let topology = self.fine.topology;
        for &(face, corner) in topology.corners(fan) {
            let (face, corner) = (face as usize, usize::from(corner));
            let count = self.fine.canvas.faces[face].count();
            let segments = self.fine.segments(face);
            let before = (corner + count - 1) % count;
            for (edge, along) in [(corner, 1), (before, segments - 1)] {
                let strip = topology.strips[topology.strip_of[face][edge] as usize];
                let share = 0.5 / topology.sides(&strip).len() as f32;
                self.add(&mut mean, self.fine.edge_tap(face, edge, along).value(self.values), share);
            }
            if count == 4 {
                let (i, j) = inner_neighbor(corner, segments);
                self.add(&mut mean, self.tap(face, i, j), 0.25);
            }
        }
        mean.mean()
    }

    /// The samples along an edge: the 1-2-1 row on the edge, and from each face the rows that the hat of the
    /// edge's own spacing covers, every face with a total weight of 1 however fine it is.
    fn strip(&self, strip: usize) -> Vec<Vec4> {
        let count = self.coarse.strip_range(strip).len() as u32;
        (1..=count).map(|at| self.strip_sample(strip, 2 * at)).collect()
    }

    /// `at` counts fine segments of the strip from its low end.
    fn strip_sample(&self, strip: usize, at: u32) -> Vec4 {
        let mut mean = WeightedMean::default();
        for (neighbor, weight) in [(at - 1, 0.5), (at, 1.0), (at + 1, 0.5)] {
            let sample = self.fine.strip_sample(strip, neighbor);
            self.add(&mut mean, self.values[sample as usize], weight);
        }
        let topology = self.fine.topology;
        for side in topology.sides(&topology.strips[strip]) {
            let (face, edge) = (side.face as usize, usize::from(side.edge));
            let segments = self.fine.segments(face);
            let step = segments / self.fine.strip_segments(strip);
            let reversed = self.fine.canvas.faces[face].is_reversed(edge);
            let along = if reversed { segments - at * step } else { at * step };
            let rows = self.face_rows(face, edge, along, step);
            mean.merge(&rows, 1.0 / rows.weight());
        }
        mean.mean()
    }

    /// The face's inner samples under a hat of `2 * step` segments' reach centered on its edge; `step` is 1
    /// where the face is as fine as the edge (two samples of weight 1/2 on a triangle, three on a quad).
    fn face_rows(&self, face: usize, edge: usize, along: u32, step: u32) -> WeightedMean {
        let mut mean = WeightedMean::default();
        let is_triangle = self.fine.canvas.faces[face].is_triangle();
        let n = self.fine.segments(face) as i32;
        let (along, step) = (along as i32, step as i32);
        let reach = 2 * step;
        let scale = 1.0 / reach as f32;
        for depth in 1..reach {
            for offset in -reach + 1..reach {
                let weight = if is_triangle {
                    // Barycentric differences to the center: offset + depth, -offset, -depth in some order.
                    1.0 - offset.abs().max(depth).max((offset + depth).abs()) as f32 * scale
                } else {
                    (1.0 - offset.abs() as f32 * scale) * (1.0 - depth as f32 * scale)
                };
                let x = along + offset;
                let inside = x >= 0 && x <= n - if is_triangle { depth } else { 0 };
                if weight > 0.0 && inside {
                    let (i, j) = grid_point(is_triangle, n, edge, x, depth);
                    self.add(&mut mean, self.tap(face, i, j), weight);
                }
            }
        }
        mean
    }

    /// The samples inside a face, by MC equation 5 or the 1-2-1 product.
    fn interior(&self, face: usize, grid: &mut FaceGrid) -> Vec<Vec4> {
        let range = self.coarse.face_range(face);
        if range.is_empty() {
            return Vec::new();
        }
        self.fine.fill(face, self.values, grid);
        let stencil: &[(i32, i32, f32)] = if grid.is_triangle { &TRIANGLE_STENCIL } else { &QUAD_STENCIL };
        let n = self.coarse.segments(face);
        let mut out = Vec::with_capacity(range.len());
        for j in 1..n {
            let end = if grid.is_triangle { n - j } else { n };
            for i in 1..end {
                let mut mean = WeightedMean::default();
                for &(x, y, weight) in stencil {
                    let value = grid.at((2 * i as i32 + x) as u32, (2 * j as i32 + y) as u32);
                    self.add(&mut mean, value, weight);
                }
                out.push(mean.mean());
            }
        }
        out
    }
}

/// MC equation 5.
const TRIANGLE_STENCIL: [(i32, i32, f32); 7] =
    [(0, 0, 1.0), (-1, 0, 0.5), (1, 0, 0.5), (0, -1, 0.5), (0, 1, 0.5), (1, -1, 0.5), (-1, 1, 0.5)];

const QUAD_STENCIL: [(i32, i32, f32); 9] = [
    (0, 0, 1.0),
    (-1, 0, 0.5),
    (1, 0, 0.5),
    (0, -1, 0.5),
    (0, 1, 0.5),
    (-1, -1, 0.25),
    (1, -1, 0.25),
    (-1, 1, 0.25),
    (1, 1, 0.25),
];

/// The grid point diagonally next to a quad's corner.
fn inner_neighbor(corner: usize, n: u32) -> (u32, u32) {
    match corner {
        0 => (1, 1),
        1 => (n - 1, 1),
        2 => (n - 1, n - 1),
        _ => (1, n - 1),
    }
}

/// The grid point `x` along an edge from its first corner and `depth` inside. On a triangle a row inside is
/// shorter: `x` counts along it from where it leaves the edge before.
fn grid_point(is_triangle: bool, n: i32, edge: usize, x: i32, depth: i32) -> (u32, u32) {
    let (i, j) = match (is_triangle, edge) {
        (_, 0) => (x, depth),
        (true, 1) => (n - x - depth, x),
        (true, _) => (depth, n - x - depth),
        (false, 1) => (n - depth, x),
        (false, 2) => (n - x, n - depth),
        (false, _) => (depth, n - x),
    };
    (i as u32, j as u32)
}
