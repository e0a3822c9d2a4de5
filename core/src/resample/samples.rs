//! The value of every sample: the source at its place, or integrated against its hat function.
//!
//! Work goes face by face over the cells of the face's grid; what a face sees at its border is handed out
//! as weighted means, and edges and vertices are the area-weighted mean of what their faces see.

use glam::Vec4;
use rayon::prelude::*;

use crate::colors::{LevelNumbering, edge_point};
use crate::error::Result;
use crate::math::mean::WeightedMean;
use crate::source::SurfaceSource;
use crate::watch::{self, Watch};

/// A cell of the grid is cut into at most this many strata a side.
const STRATA_MAX: f32 = 8.0;
/// And a face's side into this many, so that no face takes forever; a coarser look aliases.
const STRATA_PER_SIDE_MAX: u32 = 4096;
/// A face of no area still has a say where no other has, in shares of the mean face.
const AREA_FLOOR: f32 = 1e-9;

/// How a sample gets its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// The source at the sample's position.
    Point,
    /// The source times the sample's hat function (1 at the sample, 0 at its neighbors), in strata: so many
    /// along a side of a cell of the grid, or as many as it is wide in source texels.
    Filtered(Option<u8>),
    /// The samples whose interpolation is nearest to the source (L2 projection).
    Fitted,
}

/// All samples of level 0, by their numbers.
pub fn sample(
    source: &SurfaceSource<'_>,
    numbering: &LevelNumbering<'_>,
    sampling: Sampling,
    watch: &dyn Watch,
) -> Result<Vec<Vec4>> {
    let canvas = numbering.canvas;
    let mut values = vec![Vec4::ZERO; numbering.sample_count()];
    let (shared, mut interiors) = values.split_at_mut(numbering.shared_count());
    let mut slots = Vec::with_capacity(canvas.faces.len());
    for face in 0..canvas.faces.len() {
        let (slot, rest) = interiors.split_at_mut(numbering.face_range(face).len());
        slots.push(slot);
        interiors = rest;
    }
    let total_area: f64 = canvas.faces.iter().map(|face| f64::from(face.area)).sum();
    let mean_area = total_area / canvas.faces.len() as f64;
    let borders = (slots.into_par_iter().enumerate())
        .map(|(face, interior)| {
            watch::check(watch)?;
            let mut view = FaceView::new(source, numbering, face, mean_area);
            match sampling {
                Sampling::Point => view.fetch_points(),
                Sampling::Filtered(_) | Sampling::Fitted => view.integrate_cells(watch)?,
            }
            Ok(view.hand_out(interior))
        })
        .collect::<Result<Vec<_>>>()?;
    gather(numbering, sampling, &borders, shared);
    Ok(values)
}

/// What one face sees of its own grid.
struct FaceView<'a> {
    source: &'a SurfaceSource<'a>,
    numbering: &'a LevelNumbering<'a>,
    face: usize,
    is_triangle: bool,
    segments: u32,
    /// Area of one cell in shares of the mean face.
    cell_weight: f32,
    means: Vec<WeightedMean>,
}

impl<'a> FaceView<'a> {
    fn new(
        source: &'a SurfaceSource<'a>,
        numbering: &'a LevelNumbering<'a>,
        face: usize,
        mean_area: f64,
    ) -> Self {
        let canvas_face = &numbering.canvas.faces[face];
        let segments = numbering.segments(face);
        let side = segments as usize + 1;
        // Where no face has any area all count the same.
        let share = if mean_area > 0.0 { (f64::from(canvas_face.area) / mean_area) as f32 } else { 1.0 };
        Self {
            source,
            numbering,
            face,
            is_triangle: canvas_face.is_triangle(),
            segments,
            cell_weight: share.max(AREA_FLOOR) / (segments * segments) as f32,
            means: vec![WeightedMean::default(); side * side],
        }
    }

    fn index(&self, i: u32, j: u32) -> usize {
        (j * (self.segments + 1) + i) as usize
    }

    fn row_end(&self, j: u32) -> u32 {
        if self.is_triangle { self.segments - j } else { self.segments }
    }

    /// The source at grid coordinates (in segments).
    fn fetch(&self, x: f32, y: f32) -> Vec4 {
        let scale = 1.0 / self.segments as f32;
        self.source.at(self.numbering.canvas, self.face, x * scale, y * scale)
    }

    fn add(&mut self, i: u32, j: u32, value: Vec4, weight: f32) {
        let at = self.index(i, j);
        self.means[at].add(value, weight * self.cell_weight, self.source.channel.is_alpha_weighted());
    }

    fn fetch_points(&mut self) {
        for j in 0..=self.segments {
            for i in 0..=self.row_end(j) {
                let value = self.fetch(i as f32, j as f32);
                self.add(i, j, value, 1.0);
            }
        }
    }

    /// Strata along a side of a cell: one for each source texel, by area.
    fn strata(&self) -> u32 {
        let [a, b, c, d] = *self.source.places(self.face);
        // Twice the area of a triangle, that of a quad: what `segments²` cells share.
        let area = if self.is_triangle { (b - a).perp_dot(c - a) } else { 0.5 * (c - a).perp_dot(d - b) };
        let strata = (area.abs().sqrt() / self.segments as f32).round().clamp(1.0, STRATA_MAX) as u32;
        strata.min((STRATA_PER_SIDE_MAX / self.segments).max(1))
    }

    fn integrate_cells(&mut self, watch: &dyn Watch) -> Result<()> {
        let fine = self.segments * self.strata();
        for row in 0..fine {
            watch::check(watch)?;
            if self.is_triangle {
                self.integrate_triangle_row(fine, row);
            } else {
                self.integrate_quad_row(fine, row);
            }
        }
        Ok(())
    }

    /// Middles of the edges of small triangles, a third of the area each: exact where the source is linear
    /// over them, since a hat is too. Every edge belongs to one triangle that opens along `+i, +j`, and inside
    /// the face to another one that opens against it.
    fn integrate_triangle_row(&mut self, fine: u32, b: u32) {
        let scale = self.segments as f32 / fine as f32;
        let share = scale * scale / 3.0;
        for a in 0..fine - b {
            let (x, y) = (a as f32, b as f32);
            let middles = [(x + 0.5, y, b == 0), (x, y + 0.5, a == 0), (x + 0.5, y + 0.5, a + b + 1 == fine)];
            for (x, y, is_border) in middles {
                let weight = if is_border { share } else { 2.0 * share };
                self.add_by_hats(x * scale, y * scale, weight);
            }
        }
    }

    /// Two Gauss points along each axis of each stratum.
    fn integrate_quad_row(&mut self, fine: u32, b: u32) {
        /// Half of 1 - 1/sqrt(3).
        const GAUSS: f32 = 0.211_324_87;
        let scale = self.segments as f32 / fine as f32;
        let points = [GAUSS, 1.0 - GAUSS];
        for a in 0..fine {
            for (x, y) in points.iter().flat_map(|y| points.map(|x| (x, *y))) {
                self.add_by_hats((a as f32 + x) * scale, (b as f32 + y) * scale, 0.25 * scale * scale);
            }
        }
    }

    /// Fetches the source at grid coordinates and hands it to the samples whose hats cover the place.
    fn add_by_hats(&mut self, x: f32, y: f32, weight: f32) {
        let value = self.fetch(x, y);
        let (i, j) = (x as u32, y as u32);
        let (x, y) = (x - i as f32, y - j as f32);
        let corners = if !self.is_triangle {
            [
                (i, j, (1.0 - x) * (1.0 - y)),
                (i + 1, j, x * (1.0 - y)),
                (i, j + 1, (1.0 - x) * y),
                (i + 1, j + 1, x * y),
            ]
        } else if x + y <= 1.0 {
            [(i, j, 1.0 - x - y), (i + 1, j, x), (i, j + 1, y), (i, j, 0.0)]
        } else {
            [(i + 1, j + 1, x + y - 1.0), (i, j + 1, 1.0 - x), (i + 1, j, 1.0 - y), (i, j, 0.0)]
        };
        for (i, j, hat) in corners {
            if hat > 0.0 {
                self.add(i, j, value, hat * weight);
            }
        }
    }

    /// Writes the interior samples and returns the border: edge by edge, each from its first corner
    /// (included) to its second (left to the next edge).
    fn hand_out(&self, interior: &mut [Vec4]) -> Vec<WeightedMean> {
        let mut slots = interior.iter_mut();
        for j in 1..self.segments {
            let end = if self.is_triangle { self.segments - j } else { self.segments };
            for (i, slot) in (1..end).zip(&mut slots) {
                *slot = self.means[self.index(i, j)].mean();
            }
        }
        let n = self.segments;
        let edge_count = if self.is_triangle { 3 } else { 4 };
        let points = (0..edge_count)
            .flat_map(|edge| (0..n).map(move |along| edge_point(self.is_triangle, n, edge, along)));
        points.map(|(i, j)| self.means[self.index(i, j)]).collect()
    }
}

/// Vertices and edges from what their faces see.
fn gather(
    numbering: &LevelNumbering<'_>,
    sampling: Sampling,
    borders: &[Vec<WeightedMean>],
    shared: &mut [Vec4],
) {
    let topology = numbering.topology;
    let (fans, strips) = shared.split_at_mut(topology.fan_count());
    fans.par_iter_mut().enumerate().for_each(|(fan, value)| {
        let mut mean = WeightedMean::default();
        for &(face, corner) in topology.corners(fan) {
            let segments = numbering.segments(face as usize);
            mean.merge(&borders[face as usize][(u32::from(corner) * segments) as usize], 1.0);
        }
        *value = mean.mean();
    });
    let first = topology.fan_count();
    for (number, strip) in topology.strips.iter().enumerate() {
        let range = numbering.strip_range(number);
        let slots = &mut strips[range.start - first..range.end - first];
        for (slot, at) in slots.iter_mut().zip(1..) {
            let mut mean = WeightedMean::default();
            for side in topology.sides(strip) {
                let view = EdgeView::new(numbering, side.face as usize, usize::from(side.edge), number);
                view.merge_into(&mut mean, &borders[side.face as usize], at, sampling);
            }
            *slot = mean.mean();
        }
    }
}

/// A face's border along one strip, which may have fewer samples.
struct EdgeView {
    segments: u32,
    first: u32,
    reversed: bool,
    /// Face segments for each segment of the strip.
    step: u32,
}

impl EdgeView {
    fn new(numbering: &LevelNumbering<'_>, face: usize, edge: usize, strip: usize) -> Self {
        let segments = numbering.segments(face);
        Self {
            segments,
            first: edge as u32 * segments,
            reversed: numbering.canvas.faces[face].is_reversed(edge),
            step: segments / numbering.strip_segments(strip),
        }
    }

    /// Adds what the face sees around strip sample `at`: on a finer face all that the strip's hat covers,
    /// widened so that the face does not count less for its narrower band.
    fn merge_into(&self, mean: &mut WeightedMean, border: &[WeightedMean], at: u32, sampling: Sampling) {
        let step = self.step as i64;
        let reach = if sampling == Sampling::Point { 0 } else { step - 1 };
        for offset in -reach..=reach {
            let from_low = (i64::from(at) * step + offset) as u32;
            let along = if self.reversed { self.segments - from_low } else { from_low };
            let weight = (1.0 - offset.abs() as f32 / step as f32) * step as f32;
            mean.merge(&border[(self.first + along) as usize], weight);
        }
    }
}
