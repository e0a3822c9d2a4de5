//! One level from the level before it by hat functions: vertices and edges. What is inside faces is in
//! [`super::interior`].

#[cfg(test)]
mod tests;

use glam::Vec4;
use rayon::prelude::*;

use crate::colors::{LevelNumbering, SampleAreas, Shape};
use crate::math::mean::WeightedMean;

use super::hats::{StripSide, beside, edge_grid_point, edge_taps, inner_neighbor};
use super::interior::Borders;
use super::{Beyond, MipFilter, Rungs};

/// A sample counts for at least this share of the mean one: among faces of no area all count the same.
const AREA_FLOOR: f64 = 1e-6;

pub(super) struct Filter<'a> {
    pub fine: &'a LevelNumbering<'a>,
    pub coarse: &'a LevelNumbering<'a>,
    pub values: &'a [Vec4],
    pub rungs: Rungs,
    /// What samples of the fine level weigh by area, 1 in the mean over all.
    areas: Option<SampleAreas>,
}

/// What samples of the fine level weigh by area, 1 in the mean over all.
fn area_weights(numbering: &LevelNumbering<'_>) -> SampleAreas {
    let total: f64 = numbering.canvas.faces.iter().map(|face| f64::from(face.area)).sum();
    let mean = total / numbering.sample_count().max(1) as f64;
    // A mesh without any area still has a mean to divide by.
    let mean = if mean > 0.0 { mean } else { 1.0 };
    let mut areas = SampleAreas::new(numbering);
    for area in areas.fans.iter_mut().chain(&mut areas.strips).chain(&mut areas.faces) {
        *area = (f64::from(*area) / mean).max(AREA_FLOOR) as f32;
    }
    areas
}

impl<'a> Filter<'a> {
    pub fn new(
        fine: &'a LevelNumbering<'a>,
        coarse: &'a LevelNumbering<'a>,
        values: &'a [Vec4],
        rungs: Rungs,
    ) -> Self {
        let areas = (rungs.filter == MipFilter::Area).then(|| area_weights(fine));
        Self { fine, coarse, values, rungs, areas }
    }

    pub fn fans(&self, out: &mut [Vec4]) {
        out.par_iter_mut().with_min_len(256).enumerate().for_each(|(fan, out)| *out = self.fan(fan));
    }

    pub fn strips(&self, parts: Vec<(usize, &mut [Vec4])>, borders: &Borders) {
        let parts = parts.into_par_iter().with_min_len(64);
        parts.for_each(|(strip, part)| self.strip(strip, part, borders));
    }

    fn add(&self, mean: &mut WeightedMean, sample: usize, weight: f32) {
        mean.add(self.values[sample], weight, self.rungs.by_alpha);
    }

    /// Adds a sample on a vertex.
    fn add_fan(&self, mean: &mut WeightedMean, fan: u32, weight: f32) {
        let area = self.areas.as_ref().map_or(1.0, |areas| areas.fans[fan as usize]);
        self.add(mean, fan as usize, weight * area);
    }

    fn fan(&self, fan: usize) -> Vec4 {
        let mut mean = WeightedMean::default();
        self.add_fan(&mut mean, fan as u32, 1.0);
        let before = mean;
        for &(face, corner) in self.fine.topology.corners(fan) {
            let (face, corner) = (face as usize, usize::from(corner));
            if self.fine.shape(face).is_vertex_colors() {
                if self.rungs.beyond == Beyond::OneRing {
                    self.add_ring(&mut mean, face, corner);
                }
            } else if let Some(areas) = &self.areas {
                self.add_corner_by_area(&mut mean, (face, corner), areas);
            } else {
                self.add_corner(&mut mean, face, corner);
            }
        }
        // A lone sample is kept to the last bit.
        if mean == before { self.values[fan] } else { mean.mean() }
    }

    /// The corners of a face at vertex colors (MC equation 6): half of each edge neighbor, shared among the
    /// faces at the edge, and a quarter of a quad's opposite corner.
    fn add_ring(&self, mean: &mut WeightedMean, face: usize, corner: usize) {
        let topology = self.fine.topology;
        let count = self.fine.canvas.faces[face].count();
        let before = (corner + count - 1) % count;
        for (edge, neighbor) in [(corner, (corner + 1) % count), (before, before)] {
            let strip = &topology.strips[topology.strip_of[face][edge] as usize];
            let share = 0.5 / topology.sides(strip).len() as f32;
            self.add_fan(mean, topology.fan_of[face][neighbor], share);
        }
        if count == 4 {
            self.add_fan(mean, topology.fan_of[face][(corner + 2) % 4], 0.25);
        }
    }

    /// The same at the face's own spacing.
    fn add_corner(&self, mean: &mut WeightedMean, face: usize, corner: usize) {
        let topology = self.fine.topology;
        let shape = self.fine.shape(face);
        let count = shape.edge_count();
        let before = (corner + count - 1) % count;
        for (edge, along) in [(corner, 1), (before, shape.edge_segments(before) - 1)] {
            if self.is_down(shape, edge) {
                continue;
            }
            let strip = &topology.strips[topology.strip_of[face][edge] as usize];
            let share = 0.5 / topology.sides(strip).len() as f32;
            let neighbor = self.fine.edge_tap(face, edge, along).value(self.values);
            mean.add(neighbor, share, self.rungs.by_alpha);
        }
        if count == 4 && shape.interior_count() > 0 {
            let (i, j) = inner_neighbor(corner, shape);
            self.add(mean, self.fine.inner_sample(face, i, j), 0.25);
        }
    }

    /// The fine samples under the coarse basis function of a vertex in one face, by their area. Along an edge
    /// that is coarser than the face the function falls at the edge's spacing, inwards at the face's own.
    fn add_corner_by_area(
        &self,
        mean: &mut WeightedMean,
        (face, corner): (usize, usize),
        areas: &SampleAreas,
    ) {
        let topology = self.fine.topology;
        let canvas_face = &self.fine.canvas.faces[face];
        let inner_area = areas.faces[face];
        let shape = self.fine.shape(face);
        let count = shape.edge_count();
        let before = (corner + count - 1) % count;
        for (edge, starts_here) in [(corner, true), (before, false)] {
            let strip = topology.strip_of[face][edge] as usize;
            let n = shape.edge_segments(edge);
            if n == 1 {
                if !self.is_down(shape, edge) {
                    let neighbor = if starts_here { (corner + 1) % count } else { before };
                    let share = 0.5 / topology.sides(&topology.strips[strip]).len() as f32;
                    self.add_fan(mean, topology.fan_of[face][neighbor], share);
                }
                continue;
            }
            let strip_segments = self.fine.strip_segments(strip);
            let reach = if strip_segments > 1 { 2 * (n / strip_segments) } else { n };
            if strip_segments > 1 {
                let is_low = starts_here != canvas_face.is_reversed(edge);
                let next = if is_low { 1 } else { strip_segments - 1 };
                let share = 0.5 / topology.sides(&topology.strips[strip]).len() as f32;
                self.add(mean, self.fine.strip_sample(strip, next) as usize, share * areas.strips[strip]);
            }
            if shape.interior_count() == 0 {
                continue;
            }
            for x in (2..reach).step_by(2) {
                let weight = inner_area * (1.0 - x as f32 / reach as f32);
                let x = if starts_here { x } else { n - x };
                for &(offset, share) in beside(shape.is_triangle) {
                    let (i, j) = edge_grid_point(shape, edge, (x.saturating_add_signed(offset), 1));
                    self.add(mean, self.fine.inner_sample(face, i, j), weight * share);
                }
            }
        }
        if count == 4 && shape.interior_count() > 0 {
            let (i, j) = inner_neighbor(corner, shape);
            self.add(mean, self.fine.inner_sample(face, i, j), 0.25 * inner_area);
        }
    }

    /// Whether a quad has come down to its two ends along an edge, but not along the other. What it exchanges
    /// that way is left to the heat flow; the one-ring mean takes it in as the neighbor that it is.
    fn is_down(&self, shape: Shape, edge: usize) -> bool {
        shape.edge_segments(edge) == 1 && self.rungs.beyond == Beyond::Heat
    }

    /// The samples along an edge: the 1-2-1 row on the edge, and what the hat covers in each face. By area
    /// each counts for its own; else every face has a total weight of 1 however fine it is.
    fn strip(&self, strip: usize, out: &mut [Vec4], borders: &Borders) {
        let topology = self.fine.topology;
        let sides: Vec<(StripSide, Option<&[Vec4]>)> = (topology.sides(&topology.strips[strip]).iter())
            .map(|side| {
                let side = self.strip_side(strip, side.face as usize, usize::from(side.edge));
                let known = borders.of_edge(side.face, side.edge, self.coarse.shape(side.face));
                let known = known.filter(|_| side.step == 1 && !side.taps.is_empty());
                (side, known)
            })
            .collect();
        let first = self.fine.strip_range(strip).start;
        let area = self.areas.as_ref().map_or(1.0, |areas| areas.strips[strip]);
        for (at, out) in (2u32..).step_by(2).zip(out) {
            let mut mean = WeightedMean::default();
            // All three lie inside the strip: the coarse sample is not at its end.
            for (sample, weight) in [(at - 1, 0.5), (at, 1.0), (at + 1, 0.5)] {
                self.add(&mut mean, first + sample as usize - 1, weight * area);
            }
            for (side, known) in &sides {
                let segments = side.shape.edge_segments(side.edge);
                let along = if side.is_reversed { segments - at * side.step } else { at * side.step };
                match known {
                    Some(sums) => mean.add(sums[along as usize / 2 - 1], side.weight, false),
                    None => self.add_side(&mut mean, side, along),
                }
            }
            *out = mean.mean();
        }
    }

    /// Adds what a face has under the hat of the sample at `along` on its edge.
    fn add_side(&self, mean: &mut WeightedMean, side: &StripSide, along: u32) {
        for tap in side.taps.iter() {
            let place = (along.saturating_add_signed(tap.offset), tap.depth);
            let (i, j) = edge_grid_point(side.shape, side.edge, place);
            self.add(mean, self.fine.inner_sample(side.face, i, j), tap.weight * side.weight);
        }
    }

    fn strip_side(&self, strip: usize, face: usize, edge: usize) -> StripSide {
        let shape = self.fine.shape(face);
        let step = shape.edge_segments(edge) / self.fine.strip_segments(strip);
        StripSide {
            face,
            edge,
            shape,
            step,
            is_reversed: self.fine.canvas.faces[face].is_reversed(edge),
            taps: edge_taps(shape, edge, step, self.rungs.filter),
            weight: self.areas.as_ref().map_or(1.0, |areas| areas.faces[face]),
        }
    }
}
