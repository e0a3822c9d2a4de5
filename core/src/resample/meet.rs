//! Edges of faces that differ in resolution.
//!
//! An edge has no more samples than the coarsest of its faces. So beside a flat face that needs few samples, one with much to show
//! loses some along their edge: about what a coarser grid shows less of it, over half of the row of cells at the edge. Where that is worth
//! the texels, the flat face gets as many samples along this edge.

use super::budget::{Candidates, Choice};
use crate::colors::Resolutions;
use crate::mesh::Side;

/// Of the row of cells beside an edge, what depends on the samples of the edge.
const EDGE_SHARE: f64 = 0.5;

impl Candidates<'_> {
    /// A choice with faces made finer along edges where that takes away at least `least_gain` (weighted error by texel and
    /// by the material's area, as [`Spent`](super::budget::Spent) counts it). `is_shared`: by canvas edge, whether some channel joins it.
    pub fn meet(&self, choice: &Choice, is_shared: impl Fn(usize) -> bool, least_gain: f64) -> Resolutions {
        let chosen = choice.resolutions(self.rates);
        let weights = self.channel_weights();
        let total: f64 = self.total_area();
        let mut met = chosen.clone();
        for (number, edge) in self.canvas.edges.iter().enumerate() {
            if !is_shared(number) {
                continue;
            }
            let sides = self.canvas.sides(edge);
            let along = |side: &Side| chosen.along(side.face as usize, side.edge.into());
            let finest = sides.iter().map(along).max().unwrap_or(0);
            for side in sides.iter().filter(|side| along(side) < finest) {
                let finer = sides.iter().filter(|other| along(other) > along(side));
                let lost: f64 = finer.map(|other| self.lost(&chosen, other, along(side), &weights)).sum();
                let face = side.face as usize;
                let raised = self.raised(met.faces[face], side, finest);
                let texels = self.texels_of(face, raised) - self.texels_of(face, met.faces[face]);
                if lost / total.max(f64::MIN_POSITIVE) >= least_gain * texels {
                    met.faces[face] = raised;
                }
            }
        }
        met
    }

    /// What a face shows less where the edge of a side has the exponent `coarse`.
    fn lost(&self, chosen: &Resolutions, side: &Side, coarse: u8, weights: &[f64]) -> f64 {
        let face = side.face as usize;
        let own = chosen.faces[face];
        let axis = usize::from(side.edge) % 2;
        let mut coarser = own;
        if self.canvas.faces[face].is_triangle() {
            coarser = [coarse; 2];
        } else {
            coarser[axis] = coarse;
        }
        let error = |exponents: [u8; 2]| {
            // Of what was judged the nearest.
            let distance =
                |known: &[u8; 2]| (0..2).map(|k| u32::from(known[k].abs_diff(exponents[k]))).sum::<u32>();
            let all = self.rates.of(face).iter().enumerate();
            let nearest = all.min_by_key(|(_, known)| distance(known)).map_or(0, |(number, _)| number);
            self.error(face, nearest as u32, weights)
        };
        let rows = f64::from(1u32 << own[1 - axis]);
        (error(coarser) - error(own)).max(0.0) * EDGE_SHARE / rows
    }

    /// Exponents with which a face has `finest` along the edge of a side: of a quad along its axis alone.
    fn raised(&self, exponents: [u8; 2], side: &Side, finest: u8) -> [u8; 2] {
        let is_triangle = self.canvas.faces[side.face as usize].is_triangle();
        let axis = usize::from(side.edge) % 2;
        [0, 1].map(|k| if is_triangle || k == axis { exponents[k].max(finest) } else { exponents[k] })
    }
}
