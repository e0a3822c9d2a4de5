//! The samples whose reconstruction is nearest to the source over the surface (L2 projection).
//!
//! `M c = b` over all samples at once, `b` the source against the samples' hats, `M` their
//! [mass matrix](super::mass), by conjugate gradients, each component a system of its own. The
//! preconditioner is the lumped mass `M 1`, on triangles and quads the diagonal times 2 or 9/4. So on faces as fine as
//! their edges the eigenvalues lie between 1/4 (triangles) or 1/9 (quads) and 1, whatever the mesh and the weights
//! (A. Wathen, "Realistic eigenvalue bounds for the Galerkin mass matrix", 1987), and steps are few. A coarser edge
//! lowers the lower bound somewhat; the upper one holds on every mesh.
//!
//! What is minimized: for data and opaque color the squared difference by surface area, in linear light;
//! for color with an alpha each cell's share times its mean alpha (and a little, so that what is transparent
//! has the source's color too), the alpha itself by area alone; for normals the squared difference of
//! vectors, which later stages make unit vectors again.
//!
//! A fit swings beyond the source beside a step. Samples of a format with a range are brought back: they are
//! clamped, and a few projected gradient steps let their neighbors make up for it.

use glam::{DVec4, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use super::gather::{Borders, cell_areas, gather_sums, interiors};
use super::mass::{Mass, cell_index};
use super::quadrature::{CellSums, Quadrature, Subject};
use super::samples::strata_of;
use crate::colors::{LevelNumbering, Shape};
use crate::error::Result;
use crate::math::mean::TRANSPARENT_WEIGHT;
use crate::source::SurfaceSource;
use crate::watch::Watch;

/// Conjugate gradient steps at most: twice what the bounds on the eigenvalues of quads ask for 1e-6.
const STEP_LIMIT: u32 = 60;
/// Steps after clamping.
const PROJECTED_STEPS: u32 = 8;
/// Samples summed in one go; part of the order of summation.
const CHUNK: usize = 8192;

/// How a fit went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    pub step_count: u32,
    /// Root mean square, by area, of what one more preconditioned step would change, of the largest component
    /// (1 is the whole range).
    pub residual: f64,
    /// Where the fit was to end.
    pub tolerance: f64,
    /// Samples that had to be brought into [0, 1].
    pub clamped_count: u64,
}

impl Fit {
    pub fn is_converged(&self) -> bool {
        self.residual <= self.tolerance
    }
}

/// Fits all samples, starting from `values`.
pub fn fit(
    source: &SurfaceSource<'_>,
    numbering: &LevelNumbering<'_>,
    values: Vec<Vec4>,
    watch: &dyn Watch,
) -> Result<(Vec<Vec4>, Fit)> {
    let cell_areas = cell_areas(numbering);
    let mut borders = Borders::new(numbering);
    let (wanted, color_weights) = integrate(source, numbering, &cell_areas, &mut borders, watch)?;
    let mass = Mass { numbering, cell_areas: &cell_areas, color_weights };
    let mut solver = Solver::new(&mass, values, wanted, borders, watch)?;
    let tolerance = if source.channel.image.bits() == 8 { 1e-5 } else { 1e-6 };
    let (step_count, residual) = solver.descend(tolerance, watch)?;
    let clamped_count = match source.channel.bounds() {
        Some(bounds) => solver.bring_into_range(bounds, tolerance, watch)?,
        None => 0,
    };
    Ok((solver.values, Fit { step_count, residual, tolerance, clamped_count }))
}

type CellWeights = Option<Vec<Vec<f32>>>;

/// The right side `b`, and the weights of the cells' colors.
fn integrate(
    source: &SurfaceSource<'_>,
    numbering: &LevelNumbering<'_>,
    cell_areas: &[f32],
    borders: &mut Borders,
    watch: &dyn Watch,
) -> Result<(Vec<Vec4>, CellWeights)> {
    let is_weighted = source.channel.is_alpha_weighted();
    let mut wanted = vec![Vec4::ZERO; numbering.sample_count()];
    let (shared, inner) = wanted.split_at_mut(numbering.shared_count());
    let faces = interiors(numbering, inner).into_par_iter().zip(borders.parts()).enumerate();
    let integrate_face =
        |room: &mut Quadrature, (face, (interior, border)): (usize, (&mut [Vec4], &mut [Vec4]))| {
            let shape = numbering.shape(face);
            let strata = strata_of(source, numbering, face);
            let subject = Subject { source, numbering, face, strata, by_alpha: false, watch };
            let mut weights = Vec::new();
            let weigh = |cell: [u32; 2], sums: &mut CellSums| {
                if is_weighted {
                    weigh_by_alpha(shape, cell, sums, &mut weights);
                }
            };
            let mut slots = interior.iter_mut();
            room.integrate(&subject, weigh, |j, row| shape.put_row(j, row, &mut slots, border))?;
            interior.iter_mut().chain(border).for_each(|value| *value *= cell_areas[face]);
            Ok(weights)
        };
    let weights = faces.map_init(Quadrature::default, integrate_face).collect::<Result<Vec<_>>>()?;
    gather_sums(numbering, borders, shared);
    Ok((wanted, is_weighted.then_some(weights)))
}

/// Multiplies a cell's color by its mean alpha and keeps that for the mass matrix.
fn weigh_by_alpha(shape: Shape, cell: [u32; 2], sums: &mut CellSums, weights: &mut Vec<f32>) {
    let area = if shape.is_triangle { 0.5 } else { 1.0 };
    let is_whole = shape.is_triangle && cell[0] + cell[1] + 1 < shape.segments[0];
    let first = cell_index(shape, cell);
    let end = first + if is_whole { 2 } else { 1 };
    weights.resize(weights.len().max(end), 0.0);
    for (sums, weight) in sums.iter_mut().zip(&mut weights[first..end]) {
        let alpha = sums.iter().map(|sum| sum.w).sum::<f32>() / area;
        *weight = alpha + TRANSPARENT_WEIGHT;
        sums.iter_mut().for_each(|sum| *sum = (sum.xyz() * *weight).extend(sum.w));
    }
}

struct Solver<'a> {
    mass: &'a Mass<'a>,
    values: Vec<Vec4>,
    /// `b - M values`.
    residuals: Vec<Vec4>,
    /// One over the lumped mass: of color, and of alpha.
    scales: Vec<[f32; 2]>,
    total_mass: DVec4,
    direction: Vec<Vec4>,
    product: Vec<Vec4>,
    borders: Borders,
}

impl<'a> Solver<'a> {
    fn new(
        mass: &'a Mass<'a>,
        values: Vec<Vec4>,
        wanted: Vec<Vec4>,
        mut borders: Borders,
        watch: &dyn Watch,
    ) -> Result<Self> {
        let mut product = vec![Vec4::ZERO; values.len()];
        let mut direction = vec![Vec4::ONE; values.len()];
        mass.multiply(&direction, &mut product, &mut borders, watch)?;
        let total_mass = sum(values.len(), |range| product[range].iter().map(|mass| mass.as_dvec4()).sum());
        let scales = product.par_iter().map(|mass| [1.0 / mass.x, 1.0 / mass.w]).collect();
        mass.multiply(&values, &mut product, &mut borders, watch)?;
        let mut residuals = wanted;
        residuals.par_iter_mut().zip(&product).for_each(|(residual, product)| *residual -= *product);
        direction.fill(Vec4::ZERO);
        Ok(Self { mass, values, residuals, scales, total_mass, direction, product, borders })
    }

    /// Conjugate gradients to the tolerance, or to the limit. Returns the steps taken and the residual.
    fn descend(&mut self, tolerance: f64, watch: &dyn Watch) -> Result<(u32, f64)> {
        let mut energy = self.energy();
        let mut turn = Vec4::ZERO;
        let mut step = 0;
        loop {
            let residual = (energy / self.total_mass).max_element().max(0.0).sqrt();
            if residual <= tolerance || step == STEP_LIMIT {
                return Ok((step, residual));
            }
            step += 1;
            self.turn(turn);
            self.mass.multiply(&self.direction, &mut self.product, &mut self.borders, watch)?;
            let curvature = self.dot(&self.direction, &self.product);
            let length = ratio(energy, curvature);
            self.advance(length);
            let next = self.energy();
            turn = ratio(next, energy);
            energy = next;
        }
    }

    /// Clamps all samples to `bounds`, and where that changed any takes steps that stay there. Returns how many
    /// were out of range by more than the fit leaves open.
    fn bring_into_range(&mut self, bounds: [f32; 2], tolerance: f64, watch: &dyn Watch) -> Result<u64> {
        let trifle = tolerance as f32;
        let ([low, high], [lowest, highest]) = (bounds, bounds.map(Vec4::splat));
        let outside =
            |value: &&Vec4| value.min_element() < low - trifle || value.max_element() > high + trifle;
        let count = self.values.par_iter().filter(outside).count() as u64;
        let steps = if count > 0 { PROJECTED_STEPS } else { 0 };
        for step in 0..=steps {
            // No preconditioned step of length 1 goes past the minimum: no eigenvalue is larger.
            let length = if step == 0 { 0.0 } else { 1.0 };
            let samples = self.values.par_iter_mut().zip(&self.residuals).zip(&self.scales);
            samples.zip(&mut self.direction).for_each(|(((value, residual), scale), change)| {
                let next = (*value + scaled(*residual, scale) * length).clamp(lowest, highest);
                *change = next - *value;
                *value = next;
            });
            if step < steps {
                self.mass.multiply(&self.direction, &mut self.product, &mut self.borders, watch)?;
                let residuals = self.residuals.par_iter_mut().zip(&self.product);
                residuals.for_each(|(residual, product)| *residual -= *product);
            }
        }
        Ok(count)
    }

    /// `r · D⁻¹ r` by component.
    fn energy(&self) -> DVec4 {
        sum(self.residuals.len(), |range| {
            let samples = self.residuals[range.clone()].iter().zip(&self.scales[range]);
            samples.map(|(residual, scale)| (*residual * scaled(*residual, scale)).as_dvec4()).sum()
        })
    }

    fn dot(&self, a: &[Vec4], b: &[Vec4]) -> DVec4 {
        sum(a.len(), |range| a[range.clone()].iter().zip(&b[range]).map(|(a, b)| (*a * *b).as_dvec4()).sum())
    }

    /// The next direction: the preconditioned residual and so much of the one before.
    fn turn(&mut self, share: Vec4) {
        let samples = self.direction.par_iter_mut().zip(&self.residuals).zip(&self.scales);
        samples.for_each(|((direction, residual), scale)| {
            *direction = scaled(*residual, scale) + *direction * share;
        });
    }

    fn advance(&mut self, length: Vec4) {
        let steps = self.direction.par_iter().zip(&self.product);
        let samples = self.values.par_iter_mut().zip(&mut self.residuals).zip(steps);
        samples.for_each(|((value, residual), (direction, product))| {
            *value += *direction * length;
            *residual -= *product * length;
        });
    }
}

fn scaled(residual: Vec4, scale: &[f32; 2]) -> Vec4 {
    residual * Vec4::splat(scale[0]).with_w(scale[1])
}

/// `a / b`, and 0 where a component is solved or has nothing left to divide by.
fn ratio(a: DVec4, b: DVec4) -> Vec4 {
    DVec4::select(b.cmpgt(DVec4::ZERO), a / b, DVec4::ZERO).as_vec4()
}

/// A sum over samples in an order that does not depend on the number of threads.
fn sum(count: usize, of: impl Fn(std::ops::Range<usize>) -> DVec4 + Sync) -> DVec4 {
    let chunks = (0..count.div_ceil(CHUNK)).into_par_iter();
    let sums: Vec<DVec4> = chunks.map(|k| of(k * CHUNK..((k + 1) * CHUNK).min(count))).collect();
    sums.into_iter().sum()
}

#[cfg(test)]
mod tests;
