//! One component of one level, and what a solve of it ends in.

use crate::assign::Rules;

/// Largest violation that is let pass, in linear values: a hundredth of a code in the darkest sRGB.
pub const TOLERANCE: f64 = 1e-6;

/// One component of one level.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    pub rules: &'a Rules,
    /// Wanted value of each variable.
    pub wanted: &'a [f64],
    /// Weight `a` of each variable's change, above 0.
    pub weights: &'a [f64],
    /// Value of every variable at which every rule holds with room to spare: 1/2 for stored values (rules
    /// sum to 1), 0 for normals.
    pub center: f64,
    /// What the variables themselves have to stay in: colors and data, which viewers see as they are. `None` for
    /// normals.
    pub bounds: Option<[f64; 2]>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    pub values: Vec<f64>,
    /// Rules that the wanted values break.
    pub violated_count: u64,
    /// Newton steps of the island that took most, or rules that came in or went; steps of a face of [`super::Solver::Local`].
    pub step_count: u64,
    /// `Σ a x²`.
    pub objective: f64,
    /// Largest violation that is left over all rules.
    pub residual: f64,
    /// Largest entry of the stationarity condition that is left, over the islands.
    pub dual_residual: f64,
    /// Largest mean of slack times multiplier that is left, over the islands.
    pub complementarity: f64,
}

impl Solution {
    /// The wanted values as they are.
    pub fn unchanged(problem: &Problem<'_>) -> Self {
        Self {
            values: problem.wanted.to_vec(),
            violated_count: 0,
            step_count: 0,
            objective: 0.0,
            residual: 0.0,
            dual_residual: 0.0,
            complementarity: 0.0,
        }
    }
}

impl Problem<'_> {
    /// Rules first; then, where variables have bounds, one for each variable.
    pub fn row_count(&self) -> usize {
        self.rules.len() + if self.bounds.is_some() { self.wanted.len() } else { 0 }
    }

    /// What a row has to stay in.
    pub fn range(&self, row: usize) -> [f64; 2] {
        if row < self.rules.len() {
            [0.0, 1.0]
        } else {
            self.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY])
        }
    }

    /// How far a row is out of its range, at least 0.
    pub fn violation(&self, row: usize, values: &[f64]) -> f64 {
        let [low, high] = self.range(row);
        let value = match row.checked_sub(self.rules.len()) {
            Some(variable) => values[variable],
            None => self.rules.value(row, values),
        };
        (low - value).max(value - high).max(0.0)
    }

    /// Largest violation over all rows, and the number of those beyond [`TOLERANCE`].
    pub fn violations(&self, values: &[f64]) -> (f64, u64) {
        (0..self.row_count()).fold((0.0, 0), |(max, count), row| {
            let violation = self.violation(row, values);
            (f64::max(max, violation), count + u64::from(violation > TOLERANCE))
        })
    }

    /// `Σ a x²`.
    pub fn objective(&self, values: &[f64]) -> f64 {
        let terms = values.iter().zip(self.wanted).zip(self.weights);
        terms.map(|((y, c), a)| a * (y - c) * (y - c)).sum()
    }
}

pub fn violation(value: f64) -> f64 {
    (-value).max(value - 1.0).max(0.0)
}
