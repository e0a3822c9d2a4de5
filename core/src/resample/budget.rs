//! Exponents by what they show: as coarse as an error bound allows, and what a number of texels buys most with.

use crate::colors::{Resolutions, Shape};
use crate::mesh::CanvasMesh;

use super::rate::Rates;

/// A single point of a face may be off by this many times the bound on its root mean square.
const PEAK_FACTOR: f32 = 4.0;
/// A channel's error counts in shares of what it is with the finest exponents, or of this where that is less: the codes
/// that rounding alone leaves, squared.
const MEAN_SQUARE_FLOOR: f64 = 0.5;

/// One material with what its faces might have.
pub struct Candidates<'a> {
    pub canvas: &'a CanvasMesh,
    pub rates: &'a Rates,
    /// Texels of a block of these sides; of a lone triangle half of what two take.
    pub texels: &'a dyn Fn(Shape) -> f64,
}

/// By face, which of the [`Rates::of`] it takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    pub taken: Vec<u32>,
}

impl Choice {
    /// The finest for every face.
    pub fn finest(rates: &Rates) -> Self {
        Self { taken: vec![0; rates.face_count()] }
    }

    pub fn resolutions(&self, rates: &Rates) -> Resolutions {
        let exponents = |(face, &taken): (usize, &u32)| rates.of(face)[taken as usize];
        Resolutions { faces: self.taken.iter().enumerate().map(exponents).collect() }
    }
}

impl Candidates<'_> {
    fn texels(&self, face: usize, candidate: u32) -> f64 {
        self.texels_of(face, self.rates.of(face)[candidate as usize])
    }

    pub(super) fn texels_of(&self, face: usize, exponents: [u8; 2]) -> f64 {
        let segments = exponents.map(|exponent| 1 << exponent);
        (self.texels)(Shape { is_triangle: self.canvas.faces[face].is_triangle(), segments })
    }

    /// Of each face the fewest texels with which no channel is off by more than the bound (codes; root mean square
    /// over the face, and four times that anywhere); the finest where none are.
    pub fn within(&self, bound_codes: f32) -> Choice {
        let of_face = |face: usize| {
            let is_within = |candidate: &u32| {
                self.rates.errors(face, *candidate as usize).all(|error| {
                    error.mean_square <= bound_codes * bound_codes && error.peak <= PEAK_FACTOR * bound_codes
                })
            };
            let all = 0..self.rates.of(face).len() as u32;
            all.filter(is_within)
                .min_by(|a, b| self.texels(face, *a).total_cmp(&self.texels(face, *b)))
                .unwrap_or(0)
        };
        Choice { taken: (0..self.rates.face_count()).map(of_face).collect() }
    }

    /// What each channel's squared codes count for, so that one is not bought at the cost of another.
    pub(super) fn channel_weights(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.rates.channel_count()];
        let mut area = 0.0;
        for (number, face) in self.canvas.faces.iter().enumerate() {
            area += f64::from(face.area);
            for (sum, error) in sums.iter_mut().zip(self.rates.errors(number, 0)) {
                *sum += f64::from(face.area * error.mean_square);
            }
        }
        sums.iter()
            .map(|sum| 1.0 / (sum / area).max(MEAN_SQUARE_FLOOR))
            .map(|w| if w.is_finite() { w } else { 1.0 })
            .collect()
    }

    pub(super) fn total_area(&self) -> f64 {
        self.canvas.faces.iter().map(|face| f64::from(face.area)).sum()
    }

    /// A face's squared error over all channels, times its area.
    pub(super) fn error(&self, face: usize, candidate: u32, weights: &[f64]) -> f64 {
        let errors = self.rates.errors(face, candidate as usize).zip(weights);
        let weighted = errors.map(|(error, weight)| f64::from(error.mean_square) * weight);
        weighted.sum::<f64>() * f64::from(self.canvas.faces[face].area)
    }

    /// A face's steps from the fewest texels to those of `most`, along the lower convex hull of error over texels: each
    /// buys less than the one before.
    fn steps(&self, face: usize, most: u32, weights: &[f64]) -> (u32, Vec<Step>) {
        let point =
            |candidate: u32| (self.texels(face, candidate), self.error(face, candidate, weights), candidate);
        let limit = self.texels(face, most);
        let mut points: Vec<_> = (0..self.rates.of(face).len() as u32)
            .map(point)
            .filter(|&(texels, _, candidate)| candidate == most || texels < limit)
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut hull: Vec<(f64, f64, u32)> = Vec::new();
        for point in points {
            if hull.last().is_some_and(|last| point.1 >= last.1) {
                continue;
            }
            while let [.., before, last] = hull[..]
                && gain(before, last) <= gain(last, point)
            {
                hull.pop();
            }
            hull.push(point);
        }
        let step = |pair: &[(f64, f64, u32)]| Step {
            gain: gain(pair[0], pair[1]),
            texels: pair[1].0 - pair[0].0,
            candidate: pair[1].2,
        };
        (hull[0].2, hull.windows(2).map(step).collect())
    }
}

/// Error that a texel takes away from one point of a hull to the next.
fn gain(from: (f64, f64, u32), to: (f64, f64, u32)) -> f64 {
    (from.1 - to.1) / (to.0 - from.0)
}

struct Step {
    gain: f64,
    texels: f64,
    candidate: u32,
}

/// What a number of texels bought.
pub struct Spent {
    /// By material.
    pub choices: Vec<Choice>,
    pub texels: f64,
    /// Weighted error by texel and by the material's area that the last step took away.
    pub least_gain: f64,
}

/// Spends a number of texels over the faces of all materials where they take away most of the error, up to what each face
/// has in `most`. Faces have at least their fewest, whatever that comes to.
pub fn spend(materials: &[Candidates<'_>], most: &[Choice], texels: f64) -> Spent {
    let mut choices = Vec::with_capacity(materials.len());
    let mut steps = Vec::new();
    let mut spent = 0.0;
    for (number, (material, most)) in materials.iter().zip(most).enumerate() {
        let weights = material.channel_weights();
        let total = material.total_area();
        let mut taken = Vec::with_capacity(most.taken.len());
        for (face, &most) in most.taken.iter().enumerate() {
            let (first, own) = material.steps(face, most, &weights);
            spent += material.texels(face, first);
            taken.push(first);
            // In shares of the material's area: meshes have units of their own.
            steps.extend(
                own.into_iter().map(|step| {
                    (Step { gain: step.gain / total.max(f64::MIN_POSITIVE), ..step }, number, face)
                }),
            );
        }
        choices.push(Choice { taken });
    }
    steps.sort_by(|(a, material_a, face_a), (b, material_b, face_b)| {
        let by_gain = b.gain.total_cmp(&a.gain);
        by_gain.then((material_a, face_a).cmp(&(material_b, face_b)))
    });
    // A face whose next step is too much is done; others may have smaller ones.
    let mut is_done: Vec<Vec<bool>> = choices.iter().map(|choice| vec![false; choice.taken.len()]).collect();
    let mut least_gain = f64::INFINITY;
    for (step, material, face) in steps {
        let is_done = &mut is_done[material][face];
        *is_done |= spent + step.texels > texels;
        if !*is_done {
            spent += step.texels;
            least_gain = step.gain;
            choices[material].taken[face] = step.candidate;
        }
    }
    Spent { choices, texels: spent, least_gain }
}

#[cfg(test)]
mod tests;
