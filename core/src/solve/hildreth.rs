//! Hildreth's method: coordinate ascent on the dual, one rule at a time, with over-relaxation.
//!
//! (C. Hildreth, "A quadratic programming procedure", Naval Research Logistics Quarterly 4, 1957.) A rule
//! `lo <= wᵀy <= hi` with multiplier `λ` moves `y` along `w/a`; the step keeps `λ` of the sign of the bound it
//! leans on, and zero inside. Rules enter when they are violated first; one that never is does not bind.

use crate::assign::Rules;

/// Largest violation that is left, in linear values.
pub const TOLERANCE: f64 = 1e-6;
const SWEEPS_MAX: u64 = 20_000;
/// Between 0 and 2 converges; above 1 speeds rules along that lean on each other.
const RELAXATION: f64 = 1.5;

/// One component of one level.
pub struct Problem<'a> {
    pub rules: &'a Rules,
    /// Wanted value of each variable.
    pub wanted: &'a [f64],
    /// Weight `a` of each variable's change, above 0.
    pub weights: &'a [f64],
    /// Whether the variables themselves are stored (colors and data: a copied texel is the sample) and so
    /// have to stay in [0, 1] too.
    pub is_stored: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    pub values: Vec<f64>,
    pub violated_count: u64,
    pub sweep_count: u64,
    /// Largest violation that is left over all rules.
    pub residual: f64,
}

/// Solves to [`TOLERANCE`], or says in `residual` how near it came. The result depends on nothing but the
/// problem.
///
/// Without `moves` nothing is solved and the residual is the damage that clamping will do.
pub fn solve(problem: &Problem<'_>, moves: bool, canceled: &dyn Fn() -> bool) -> Solution {
    let mut state = State::new(problem);
    let violated_count = state.admit_violated();
    let mut sweep_count = 0;
    if moves && violated_count > 0 {
        loop {
            sweep_count += state.relax(SWEEPS_MAX - sweep_count, canceled);
            if state.admit_violated() == 0 || sweep_count >= SWEEPS_MAX || canceled() {
                break;
            }
        }
    }
    let residual = (0..state.row_count()).map(|row| state.violation(row)).fold(0.0, f64::max);
    Solution { values: state.values, violated_count, sweep_count, residual }
}

struct State<'a> {
    problem: &'a Problem<'a>,
    values: Vec<f64>,
    is_active: Vec<bool>,
    active: Vec<ActiveRow>,
}

struct ActiveRow {
    row: u32,
    multiplier: f64,
    /// `wᵀ diag(1/a) w`.
    stiffness: f64,
}

impl<'a> State<'a> {
    fn new(problem: &'a Problem<'a>) -> Self {
        Self {
            problem,
            values: problem.wanted.to_vec(),
            is_active: vec![false; problem.rules.len() + problem.wanted.len()],
            active: Vec::new(),
        }
    }

    /// Rules first; then, where variables are stored, one rule for each.
    fn row_count(&self) -> usize {
        self.problem.rules.len() + if self.problem.is_stored { self.problem.wanted.len() } else { 0 }
    }

    fn row_value(&self, row: usize) -> f64 {
        if row >= self.problem.rules.len() {
            return self.values[row - self.problem.rules.len()];
        }
        let terms = self.problem.rules.terms(row).iter();
        let sum: f64 = terms.map(|&(variable, weight)| self.values[variable as usize] * f64::from(weight)).sum();
        sum + f64::from(self.problem.rules.constant(row))
    }

    fn violation(&self, row: usize) -> f64 {
        let value = self.row_value(row);
        (-value).max(value - 1.0).max(0.0)
    }

    /// Adds the rules that are violated and not yet in; returns how many.
    fn admit_violated(&mut self) -> u64 {
        let before = self.active.len();
        for row in 0..self.row_count() {
            if self.is_active[row] || self.violation(row) <= TOLERANCE {
                continue;
            }
            let stiffness = self.stiffness(row);
            self.is_active[row] = true;
            self.active.push(ActiveRow { row: row as u32, multiplier: 0.0, stiffness });
        }
        (self.active.len() - before) as u64
    }

    fn stiffness(&self, row: usize) -> f64 {
        let weights = self.problem.weights;
        if row >= self.problem.rules.len() {
            return 1.0 / weights[row - self.problem.rules.len()];
        }
        let terms = self.problem.rules.terms(row).iter();
        terms.map(|&(variable, weight)| f64::from(weight).powi(2) / weights[variable as usize]).sum()
    }

    /// Sweeps over the active rules until no step moves a rule's value by more than a part of the tolerance.
    fn relax(&mut self, sweeps_max: u64, canceled: &dyn Fn() -> bool) -> u64 {
        let mut active = std::mem::take(&mut self.active);
        let mut sweeps = 0;
        while sweeps < sweeps_max {
            sweeps += 1;
            let mut largest: f64 = 0.0;
            for rule in &mut active {
                largest = largest.max(self.step(rule));
            }
            if largest <= 0.5 * TOLERANCE || sweeps % 64 == 0 && canceled() {
                break;
            }
        }
        self.active = active;
        sweeps
    }

    /// One relaxed step of one rule's multiplier; returns by how much the rule's value moved.
    fn step(&mut self, rule: &mut ActiveRow) -> f64 {
        let value = self.row_value(rule.row as usize);
        // Where the value would stand without this rule's push.
        let free = value - rule.multiplier * rule.stiffness;
        let target = (free.clamp(0.0, 1.0) - free) / rule.stiffness;
        let mut next = rule.multiplier + RELAXATION * (target - rule.multiplier);
        if next * target <= 0.0 {
            next = target; // over-relaxation must not push against a bound that does not bind
        }
        let change = next - rule.multiplier;
        rule.multiplier = next;
        self.push(rule.row as usize, change);
        (change * rule.stiffness).abs()
    }

    /// Moves the variables of a rule along `change * w / a`.
    fn push(&mut self, row: usize, change: f64) {
        let Problem { rules, weights, .. } = self.problem;
        if row >= rules.len() {
            let variable = row - rules.len();
            self.values[variable] += change / weights[variable];
            return;
        }
        for &(variable, weight) in rules.terms(row) {
            let variable = variable as usize;
            self.values[variable] += change * f64::from(weight) / weights[variable];
        }
    }
}
