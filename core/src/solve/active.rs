//! One island of few binding rules by a dual active set.
//!
//! (D. Goldfarb and A. Idnani, "A numerically stable dual method for solving strictly convex quadratic
//! programs", Mathematical Programming 27, 1983.) It starts at the wanted values and takes in one violated
//! row after the other, so its cost is that of the rows that bind, where an interior point pays for all that
//! might. The change is made of the multipliers, `a x = Wᵀ z`, so nothing but the rows themselves can be
//! wrong in the end: what does not keep them is left to [`super::interior`].

use super::interior::Outcome;
use super::island::Island;
use super::problem::TOLERANCE;

#[cfg(test)]
mod tests;

/// Rows that may bind at once: each costs a row of a dense triangle.
const ACTIVE_MAX: usize = 96;
/// Rows that come in or go; an island of few needs few more than it has in the end.
const STEPS_MAX: u64 = 4 * ACTIVE_MAX as u64;
/// Violation at which a row comes in: texels are to end well within the tolerance.
const ENTERING: f64 = 0.1 * TOLERANCE;
/// Share of a row's square that has to be left beside the rows that bind, else it is made of them.
const INDEPENDENT: f64 = 1e-12;

/// `None` where too many rows bind, or where rounding leaves rows violated.
pub fn solve_active(island: &Island, wanted: &[f64], weights: &[f64]) -> Option<Outcome> {
    let pick = |all: &[f64]| island.variables().iter().map(|&v| all[v as usize]).collect::<Vec<f64>>();
    let wanted = pick(wanted);
    let mut set = ActiveSet {
        island,
        inverse: pick(weights).iter().map(|weight| 1.0 / weight).collect(),
        values: wanted.clone(),
        bounds: Vec::new(),
        multipliers: Vec::new(),
        factor: Vec::new(),
        scattered: vec![0.0; wanted.len()],
    };
    let (mut step_count, mut rows) = (0, Vec::new());
    loop {
        // Any violated row may come in next, so all are looked through only when those of before are done.
        island.apply(&set.values, &mut rows);
        let violated: Vec<usize> =
            (0..rows.len()).filter(|&row| set.lack_of(row, rows[row]).is_some()).collect();
        if violated.is_empty() {
            break;
        }
        if violated.len() > 2 * ACTIVE_MAX {
            return None;
        }
        while let Some(bound) = set.most_violated(&violated) {
            step_count += set.take_in(bound, STEPS_MAX.checked_sub(step_count)?)?;
        }
    }
    set.finish(&wanted, step_count)
}

/// A side of a row: its value times `sign` is to be at least the bound times `sign`.
#[derive(Clone, Copy)]
struct Bound {
    row: usize,
    sign: f64,
}

struct ActiveSet<'a> {
    island: &'a Island,
    /// `1 / a`, by variable.
    inverse: Vec<f64>,
    values: Vec<f64>,
    /// What binds.
    bounds: Vec<Bound>,
    /// Of `bounds`, none below 0.
    multipliers: Vec<f64>,
    /// Rows of the lower triangle `L` with `L Lᵀ = W A⁻¹ Wᵀ`, of `bounds`.
    factor: Vec<Vec<f64>>,
    /// By variable: room for one row over its variables, zero in between.
    scattered: Vec<f64>,
}

impl ActiveSet<'_> {
    /// The side on which a row is violated, and by how much, at unit length.
    fn lack(&self, row: usize) -> Option<(f64, f64)> {
        self.lack_of(row, self.island.row_of(row, &self.values))
    }

    fn lack_of(&self, row: usize, value: f64) -> Option<(f64, f64)> {
        let (low, high) = (self.island.low()[row], self.island.high()[row]);
        let entering = ENTERING * self.island.scale(row);
        if value < low - entering {
            Some((1.0, low - value))
        } else if value > high + entering {
            Some((-1.0, value - high))
        } else {
            None
        }
    }

    fn most_violated(&self, rows: &[usize]) -> Option<Bound> {
        let mut most = (0.0, None);
        for &row in rows {
            if let Some((sign, lack)) = self.lack(row)
                && lack > most.0
            {
                most = (lack, Some(Bound { row, sign }));
            }
        }
        most.1
    }

    /// Brings a violated row to its bound; rows that would be pulled there are let go on the way. Returns
    /// the number of steps; `None` where there is no way, or none of so few steps.
    fn take_in(&mut self, bound: Bound, steps_max: u64) -> Option<u64> {
        let mut own = 0.0;
        for step_count in 1..=steps_max {
            let (_, lack) = self.lack(bound.row).filter(|lack| lack.0 == bound.sign)?;
            let (beside, square) = self.beside(bound);
            let left = square - dot(&beside, &beside);
            let pulls = self.back(&beside);
            let mut length = if left > INDEPENDENT * square { lack / left } else { f64::INFINITY };
            let mut leaving = None;
            for (at, (multiplier, pull)) in self.multipliers.iter().zip(&pulls).enumerate() {
                if *pull > 0.0 && multiplier / pull < length {
                    (length, leaving) = (multiplier / pull, Some(at));
                }
            }
            if !length.is_finite() {
                return None;
            }
            own += length;
            self.move_by(bound, length);
            for (at, pull) in pulls.iter().enumerate() {
                self.multipliers[at] -= length * pull;
                self.move_by(self.bounds[at], -length * pull);
            }
            let Some(at) = leaving else {
                if self.bounds.len() >= ACTIVE_MAX {
                    return None;
                }
                let mut row = beside;
                row.push(left.sqrt());
                self.factor.push(row);
                self.bounds.push(bound);
                self.multipliers.push(own);
                return Some(step_count);
            };
            self.let_go(at);
            if self.lack(bound.row).is_none() {
                // It came to its bound with the last row that left; what it took stays its share.
                return self.keep(bound, own).then_some(step_count);
            }
        }
        None
    }

    /// Takes a row in as it stands on its bound.
    fn keep(&mut self, bound: Bound, own: f64) -> bool {
        let (mut beside, square) = self.beside(bound);
        let left = square - dot(&beside, &beside);
        if !(left > INDEPENDENT * square && self.bounds.len() < ACTIVE_MAX) {
            return false;
        }
        beside.push(left.sqrt());
        self.factor.push(beside);
        self.bounds.push(bound);
        self.multipliers.push(own);
        true
    }

    /// `L⁻¹ W A⁻¹ w` of a row `w`, and `w A⁻¹ w`.
    fn beside(&mut self, bound: Bound) -> (Vec<f64>, f64) {
        let terms = self.island.terms(bound.row);
        let mut square = 0.0;
        for (v, weight) in terms {
            let scaled = bound.sign * weight * self.inverse[v as usize];
            self.scattered[v as usize] = scaled;
            square += bound.sign * weight * scaled;
        }
        let mut beside: Vec<f64> = Vec::with_capacity(self.bounds.len() + 1);
        for (row, bound) in self.factor.iter().zip(&self.bounds) {
            let product = bound.sign * self.island.row_of(bound.row, &self.scattered);
            let (before, diagonal) = row.split_at(beside.len());
            beside.push((product - dot(before, &beside)) / diagonal[0]);
        }
        for (v, _) in self.island.terms(bound.row) {
            self.scattered[v as usize] = 0.0;
        }
        (beside, square)
    }

    /// `L⁻ᵀ beside`.
    fn back(&self, beside: &[f64]) -> Vec<f64> {
        let mut out = beside.to_vec();
        for (at, row) in self.factor.iter().enumerate().rev() {
            let (before, rest) = out.split_at_mut(at);
            rest[0] /= row[at];
            before.iter_mut().zip(row).for_each(|(out, entry)| *out -= rest[0] * entry);
        }
        out
    }

    fn move_by(&mut self, bound: Bound, length: f64) {
        for (v, weight) in self.island.terms(bound.row) {
            self.values[v as usize] += length * bound.sign * weight * self.inverse[v as usize];
        }
    }

    /// Turns what is left of the triangle back into one.
    fn let_go(&mut self, at: usize) {
        self.bounds.remove(at);
        self.multipliers.remove(at);
        self.factor.remove(at);
        for k in at..self.factor.len() {
            let (a, b) = (self.factor[k][k], self.factor[k][k + 1]);
            let length = a.hypot(b);
            let (cosine, sine) = (a / length, b / length);
            for row in &mut self.factor[k..] {
                let (a, b) = (row[k], row[k + 1]);
                (row[k], row[k + 1]) = (cosine * a + sine * b, cosine * b - sine * a);
            }
            self.factor[k].truncate(k + 1);
        }
    }

    /// The values anew from the multipliers, if every row holds there.
    fn finish(mut self, wanted: &[f64], step_count: u64) -> Option<Outcome> {
        let mut pull = vec![0.0; wanted.len()];
        for (bound, multiplier) in self.bounds.iter().zip(&self.multipliers) {
            let terms = self.island.terms(bound.row);
            terms.for_each(|(v, weight)| pull[v as usize] += multiplier * bound.sign * weight);
        }
        for (at, value) in self.values.iter_mut().enumerate() {
            *value = wanted[at] + pull[at] * self.inverse[at];
        }
        let (low, high) = (self.island.low(), self.island.high());
        let holds = |row: usize| {
            let let_pass = 0.5 * TOLERANCE * self.island.scale(row);
            let value = self.island.row_of(row, &self.values);
            (low[row] - let_pass..=high[row] + let_pass).contains(&value)
        };
        let is_kept = (0..self.island.row_count()).all(holds);
        if !(is_kept && self.multipliers.iter().all(|multiplier| *multiplier >= 0.0)) {
            return None;
        }
        let entry = |at: usize| ((self.values[at] - wanted[at]) / self.inverse[at] - pull[at]).abs();
        let dual_residual = (0..wanted.len()).map(entry).fold(0.0, f64::max);
        let product = |(bound, multiplier): (&Bound, &f64)| {
            let end = if bound.sign > 0.0 { low[bound.row] } else { high[bound.row] };
            multiplier * (self.island.row_of(bound.row, &self.values) - end).abs()
        };
        let products: f64 = self.bounds.iter().zip(&self.multipliers).map(product).sum();
        let complementarity = products / (2 * self.island.row_count()).max(1) as f64;
        Some(Outcome { values: self.values, step_count, dual_residual, complementarity })
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
