//! The mass matrix of the samples over the surface, never formed.
//!
//! `M = Σ_f T_fᵀ M_f T_f`: `T_f` gives a face's grid from all samples (copies, and on a finer face's edge
//! mixes of two), `M_f` holds the integrals of products of hats over the face's cells, each cell counting by
//! its weight.

use glam::Vec4;
use rayon::prelude::*;

use super::gather::{Borders, gather_sums, interiors};
use crate::colors::{LevelNumbering, Shape};
use crate::error::Result;
use crate::watch::{self, Watch};

pub struct Mass<'a> {
    pub numbering: &'a LevelNumbering<'a>,
    /// By face.
    pub cell_areas: &'a [f32],
    /// By face the weight of each cell's color, in the order of [`cell_index`]; none where all count alike.
    pub color_weights: Option<Vec<Vec<f32>>>,
}

/// Where a cell's first half stands among its face's cells; a triangle's second halves follow the first ones.
pub fn cell_index(shape: Shape, [i, j]: [u32; 2]) -> usize {
    let [i, j, n] = [i, j, shape.segments[0]].map(|k| k as usize);
    if shape.is_triangle { j * (2 * n - j) + 2 * i } else { j * n + i }
}

/// Rows of a face in work.
#[derive(Default)]
struct Room {
    border: Vec<Vec4>,
    /// Values of the row below and above the cells.
    low: Vec<Vec4>,
    high: Vec<Vec4>,
    /// Their products.
    low_sum: Vec<Vec4>,
    high_sum: Vec<Vec4>,
}

impl Mass<'_> {
    /// `product = M values`. `borders` is room to work in.
    pub fn multiply(
        &self,
        values: &[Vec4],
        product: &mut [Vec4],
        borders: &mut Borders,
        watch: &dyn Watch,
    ) -> Result<()> {
        let (shared, inner) = product.split_at_mut(self.numbering.shared_count());
        let faces = interiors(self.numbering, inner).into_par_iter().zip(borders.parts()).enumerate();
        faces.try_for_each_init(Room::default, |room, (face, (interior, border))| {
            watch::check(watch)?;
            let area = self.cell_areas[face];
            match &self.color_weights {
                None => self.multiply_face(room, values, face, (interior, border), |_| Vec4::splat(area)),
                Some(weights) => {
                    let weights = &weights[face];
                    let weight = |cell: usize| Vec4::splat(area * weights[cell]).with_w(area);
                    self.multiply_face(room, values, face, (interior, border), weight);
                }
            }
            Ok(())
        })?;
        gather_sums(self.numbering, borders, shared);
        Ok(())
    }

    fn multiply_face(
        &self,
        room: &mut Room,
        values: &[Vec4],
        face: usize,
        (interior, border): (&mut [Vec4], &mut [Vec4]),
        weight: impl Fn(usize) -> Vec4,
    ) {
        let shape = self.numbering.shape(face);
        let [n, m] = shape.segments;
        room.border.clear();
        for edge in 0..shape.edge_count() {
            let taps = (0..shape.edge_segments(edge))
                .map(|along| self.numbering.edge_tap(face, edge, along).value(values));
            room.border.extend(taps);
        }
        let mut inner = values[self.numbering.face_range(face)].iter();
        let mut slots = interior.iter_mut();
        let side = n as usize + 1;
        for row in [&mut room.low, &mut room.high, &mut room.low_sum, &mut room.high_sum] {
            row.clear();
            row.resize(side, Vec4::ZERO);
        }
        shape.take_row(0, &mut room.low, &mut inner, &room.border);
        for j in 0..m {
            let count = shape.point_count(j + 1) as usize;
            shape.take_row(j + 1, &mut room.high[..count], &mut inner, &room.border);
            let first = cell_index(shape, [0, j]);
            if shape.is_triangle {
                room.multiply_triangle_cells(shape.cell_count(j) as usize, |cell| weight(first + cell));
            } else {
                room.multiply_quad_cells(|cell| weight(first + cell));
            }
            shape.put_row(j, &room.low_sum[..shape.point_count(j) as usize], &mut slots, border);
            std::mem::swap(&mut room.low, &mut room.high);
            std::mem::swap(&mut room.low_sum, &mut room.high_sum);
            room.high_sum.fill(Vec4::ZERO);
        }
        shape.put_row(m, &room.low_sum[..shape.point_count(m) as usize], &mut slots, border);
    }
}

impl Room {
    /// A row of triangles of half a cell each: their mass matrix is a twelfth of the area, doubled on the
    /// diagonal.
    fn multiply_triangle_cells(&mut self, count: usize, weight: impl Fn(usize) -> Vec4) {
        const SHARE: f32 = 0.5 / 12.0;
        let (x0, x1) = (&self.low[..count + 1], &self.high[..count]);
        let (y0, y1) = (&mut self.low_sum[..count + 1], &mut self.high_sum[..count]);
        for i in 0..count {
            let [a, b, c] = [x0[i], x0[i + 1], x1[i]];
            let (sum, share) = (a + b + c, weight(2 * i) * SHARE);
            y0[i] += (sum + a) * share;
            y0[i + 1] += (sum + b) * share;
            y1[i] += (sum + c) * share;
            if i + 1 < count {
                let d = x1[i + 1];
                let (sum, share) = (b + c + d, weight(2 * i + 1) * SHARE);
                y0[i + 1] += (sum + b) * share;
                y1[i] += (sum + c) * share;
                y1[i + 1] += (sum + d) * share;
            }
        }
    }

    /// A row of quads: the product of two matrices (2 1; 1 2) / 6.
    fn multiply_quad_cells(&mut self, weight: impl Fn(usize) -> Vec4) {
        const SHARE: f32 = 1.0 / 36.0;
        let count = self.low.len() - 1;
        for i in 0..count {
            let mix = |row: &[Vec4]| [row[i] * 2.0 + row[i + 1], row[i] + row[i + 1] * 2.0];
            let ([a, b], [c, d]) = (mix(&self.low), mix(&self.high));
            let share = weight(i) * SHARE;
            self.low_sum[i] += (a * 2.0 + c) * share;
            self.low_sum[i + 1] += (b * 2.0 + d) * share;
            self.high_sum[i] += (a + c * 2.0) * share;
            self.high_sum[i + 1] += (b + d * 2.0) * share;
        }
    }
}
