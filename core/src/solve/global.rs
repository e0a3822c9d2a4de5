//! Which rules bind: violated groups come in, islands of them are solved, until nothing is violated.
//!
//! A rule that never comes in holds anyway, so the outcome is the optimum over all rules.

use rayon::prelude::*;

use crate::assign::Rules;
use crate::math::partition::Partition;

use super::interior::{Island, IslandRow, Outcome};

/// Largest violation that is let pass, in linear values: a hundredth of a code in the darkest sRGB.
pub const TOLERANCE: f64 = 1e-6;
/// Rules beside violated ones come in with them where they are this near to a bound: most of them would be
/// pushed out and cost another round.
const NEAR_BOUND: f64 = 0.03;
/// Each round takes in what the last one pushed out of range; more than a few are rare.
const ROUNDS_MAX: usize = 200;

/// One component of one level.
pub struct Problem<'a> {
    pub rules: &'a Rules,
    /// Wanted value of each variable.
    pub wanted: &'a [f64],
    /// Weight `a` of each variable's change, above 0.
    pub weights: &'a [f64],
    /// Value of every variable at which every rule holds with room to spare: 1/2 for stored values (rules
    /// sum to 1), 0 for normals.
    pub center: f64,
    /// Whether the variables themselves are stored (colors and data: a copied texel is the sample) and so
    /// have to stay in [0, 1] too.
    pub is_stored: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    pub values: Vec<f64>,
    /// Rules that the wanted values break.
    pub violated_count: u64,
    /// Newton steps of the island that took most.
    pub step_count: u64,
    /// Largest violation that is left over all rules.
    pub residual: f64,
    /// Largest entry of the stationarity condition that is left, over the islands.
    pub dual_residual: f64,
    /// Largest mean of slack times multiplier that is left, over the islands.
    pub complementarity: f64,
}

/// Solves to [`TOLERANCE`]. The result depends on nothing but the problem. Without `moves` nothing is solved
/// and the residual is the damage that clamping will do.
pub fn solve(problem: &Problem<'_>, moves: bool, canceled: &(dyn Fn() -> bool + Sync)) -> Solution {
    let mut state = State::new(problem);
    let violated_count = state.row_range().filter(|&row| state.violation(row) > TOLERANCE).count() as u64;
    if moves && violated_count > 0 {
        for _ in 0..ROUNDS_MAX {
            if !state.admit_violated() || canceled() {
                break;
            }
            state.solve_islands(canceled);
        }
    }
    let residual = state.row_range().map(|row| state.violation(row)).fold(0.0, f64::max);
    let State { values, step_count, dual_residual, complementarity, .. } = state;
    Solution { values, violated_count, step_count, residual, dual_residual, complementarity }
}

/// Rules that values break by more than the tolerance.
pub fn violated_count(rules: &Rules, values: &[f64]) -> u64 {
    (0..rules.len()).filter(|&row| violation(row_value(rules, row, values)) > TOLERANCE).count() as u64
}

fn row_value(rules: &Rules, row: usize, values: &[f64]) -> f64 {
    let terms = rules.terms(row).iter();
    let sum: f64 = terms.map(|&(variable, weight)| values[variable as usize] * weight).sum();
    sum + f64::from(rules.constant(row))
}

fn violation(value: f64) -> f64 {
    (-value).max(value - 1.0).max(0.0)
}

struct State<'a> {
    problem: &'a Problem<'a>,
    values: Vec<f64>,
    /// By group of rules, then by variable where variables are stored.
    is_active: Vec<bool>,
    /// Rows that are in, group by group.
    active_rows: Vec<usize>,
    /// By variable: an active row is about it.
    is_touched: Vec<bool>,
    /// Variables that active rows connect.
    islands: Partition,
    /// By first variable of a row: the row came in after its island was last solved.
    is_stale: Vec<bool>,
    step_count: u64,
    dual_residual: f64,
    complementarity: f64,
}

impl<'a> State<'a> {
    fn new(problem: &'a Problem<'a>) -> Self {
        let variable_count = problem.wanted.len();
        Self {
            problem,
            values: problem.wanted.to_vec(),
            is_active: vec![false; problem.rules.group_count() + variable_count],
            active_rows: Vec::new(),
            is_touched: vec![false; variable_count],
            islands: Partition::new(variable_count),
            is_stale: vec![false; variable_count],
            step_count: 0,
            dual_residual: 0.0,
            complementarity: 0.0,
        }
    }

    /// Rules first; then, where variables are stored, one for each variable.
    fn row_range(&self) -> std::ops::Range<usize> {
        0..self.problem.rules.len() + if self.problem.is_stored { self.problem.wanted.len() } else { 0 }
    }

    fn row(&self, row: usize) -> IslandRow {
        let rules = self.problem.rules;
        match row.checked_sub(rules.len()) {
            Some(variable) => IslandRow { terms: vec![(variable as u32, 1.0)], constant: 0.0 },
            None => IslandRow { terms: rules.terms(row).to_vec(), constant: f64::from(rules.constant(row)) },
        }
    }

    fn violation(&self, row: usize) -> f64 {
        let rules = self.problem.rules;
        violation(match row.checked_sub(rules.len()) {
            Some(variable) => self.values[variable],
            None => row_value(rules, row, &self.values),
        })
    }

    /// Takes in the groups that are violated and not yet in. Returns whether there were any.
    fn admit_violated(&mut self) -> bool {
        let before = self.active_rows.len();
        let rules = self.problem.rules;
        for group in 0..rules.group_count() {
            if !self.is_active[group] && rules.group(group).any(|row| self.violation(row) > TOLERANCE) {
                self.is_active[group] = true;
                rules.group(group).for_each(|row| self.admit(row));
            }
        }
        for row in rules.len()..self.row_range().end {
            let slot = rules.group_count() + row - rules.len();
            if !self.is_active[slot] && self.violation(row) > TOLERANCE {
                self.is_active[slot] = true;
                self.admit(row);
            }
        }
        if self.active_rows.len() > before {
            self.admit_neighbors();
        }
        self.active_rows.len() > before
    }

    fn admit_neighbors(&mut self) {
        let rules = self.problem.rules;
        let is_near = |state: &Self, row: usize| {
            let value = row_value(rules, row, &state.values);
            !(NEAR_BOUND..=1.0 - NEAR_BOUND).contains(&value)
        };
        let beside: Vec<usize> = (0..rules.group_count())
            .filter(|&group| !self.is_active[group])
            .filter(|&group| {
                let mut terms = rules.group(group).flat_map(|row| rules.terms(row));
                terms.any(|&(variable, _)| self.is_touched[variable as usize])
                    && rules.group(group).any(|row| is_near(self, row))
            })
            .collect();
        for group in beside {
            self.is_active[group] = true;
            rules.group(group).for_each(|row| self.admit(row));
        }
    }

    fn admit(&mut self, row: usize) {
        self.active_rows.push(row);
        let terms = self.row(row).terms;
        let Some(&(first, _)) = terms.first() else { return };
        for &(variable, _) in &terms {
            self.is_touched[variable as usize] = true;
            self.islands.join(first, variable);
        }
        self.is_stale[first as usize] = true;
    }

    /// What says which island a row is in: a row without terms binds nothing and is in the first.
    fn first_variable(&self, row: usize) -> u32 {
        let rules = self.problem.rules;
        match row.checked_sub(rules.len()) {
            Some(variable) => variable as u32,
            None => rules.terms(row).first().map_or(0, |term| term.0),
        }
    }

    /// Solves every island that has new rows, and writes its variables.
    fn solve_islands(&mut self, canceled: &(dyn Fn() -> bool + Sync)) {
        let mut keyed: Vec<(u32, usize)> = Vec::with_capacity(self.active_rows.len());
        let mut stale_roots = vec![false; self.values.len()];
        for at in 0..self.active_rows.len() {
            let row = self.active_rows[at];
            let first = self.first_variable(row);
            let root = self.islands.root(first);
            stale_roots[root as usize] |= std::mem::take(&mut self.is_stale[first as usize]);
            keyed.push((root, row));
        }
        keyed.sort_unstable();
        let islands: Vec<Island> = (keyed.chunk_by(|a, b| a.0 == b.0))
            .filter(|chunk| stale_roots[chunk[0].0 as usize])
            .map(|chunk| Island::new(chunk.iter().map(|&(_, row)| self.row(row)).collect()))
            .collect();
        let Problem { wanted, weights, center, .. } = *self.problem;
        let outcomes: Vec<Outcome> =
            islands.par_iter().map(|island| island.solve(wanted, weights, center, canceled)).collect();
        for (island, outcome) in islands.iter().zip(outcomes) {
            for (&variable, value) in island.variables().iter().zip(outcome.values) {
                self.values[variable as usize] = value;
            }
            self.step_count = self.step_count.max(outcome.step_count);
            self.dual_residual = self.dual_residual.max(outcome.dual_residual);
            self.complementarity = self.complementarity.max(outcome.complementarity);
        }
    }
}
