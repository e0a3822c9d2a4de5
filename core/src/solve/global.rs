//! Which rules bind: violated groups come in, islands of them are solved, until nothing is violated.
//!
//! A rule that never comes in holds anyway, so the outcome is the optimum over all rules.

use rayon::prelude::*;

use crate::assign::Links;
use crate::math::partition::Partition;

use super::active::solve_active;
use super::interior::{Outcome, solve_island};
use super::island::Island;
use super::problem::{Problem, Solution, TOLERANCE};

/// Rules beside violated ones come in with them where they are this near to a bound: most of them would be
/// pushed out and cost another round. By round, the last one for all that follow: 1/2 are all rules, since
/// what is left to the later rounds would come in bit by bit.
const NEAR_BOUND: [f64; 3] = [0.03, 0.3, 0.5];
/// How many rules away from what came in that is looked for: a change next to a region that is black or
/// white runs far into it.
const RINGS: usize = 10;
/// Each round takes in what the last one pushed out of range; more than a few are rare.
const ROUNDS_MAX: usize = 200;
const NOWHERE: u32 = u32::MAX;

/// Solves to [`TOLERANCE`]. The result depends on nothing but the problem.
pub fn solve(problem: &Problem<'_>, canceled: &(dyn Fn() -> bool + Sync)) -> Solution {
    let (residual, violated_count) = problem.violations(problem.wanted);
    let mut solution = Solution { residual, violated_count, ..Solution::unchanged(problem) };
    if violated_count == 0 {
        return solution;
    }
    let mut state = State::new(problem, &mut solution);
    for round in 0..ROUNDS_MAX {
        if !state.admit_violated(round) || canceled() {
            break;
        }
        state.solve_islands(canceled);
    }
    solution.residual = problem.violations(&solution.values).0;
    solution.objective = problem.objective(&solution.values);
    solution
}

struct State<'a> {
    problem: &'a Problem<'a>,
    links: &'a Links,
    solution: &'a mut Solution,
    /// By group of rules.
    is_active: Vec<bool>,
    /// By group: the round in which its rules were last looked at.
    looked_at: Vec<usize>,
    /// By variable: its own bounds are in.
    is_bounded: Vec<bool>,
    /// Rows that are in.
    active_rows: Vec<usize>,
    /// By variable: an active row is about it.
    is_touched: Vec<bool>,
    /// Variables that active rows connect.
    islands: Partition,
    /// By first variable of a row: the row came in after its island was last solved.
    is_stale: Vec<bool>,
    /// By variable: its island took the interior method.
    is_costly: Vec<bool>,
    /// Variables that were solved since violations were last looked for; all of them at first.
    moved: Vec<u32>,
    /// By variable, its place in its island, while that is put together; else [`NOWHERE`].
    places: Vec<u32>,
}

impl<'a> State<'a> {
    fn new(problem: &'a Problem<'a>, solution: &'a mut Solution) -> Self {
        let variable_count = problem.wanted.len();
        Self {
            problem,
            links: problem.rules.links(),
            solution,
            is_active: vec![false; problem.rules.group_count()],
            looked_at: vec![usize::MAX; problem.rules.group_count()],
            is_bounded: vec![false; variable_count],
            active_rows: Vec::new(),
            is_touched: vec![false; variable_count],
            islands: Partition::new(variable_count),
            is_stale: vec![false; variable_count],
            is_costly: vec![false; variable_count],
            moved: (0..variable_count as u32).collect(),
            places: vec![NOWHERE; variable_count],
        }
    }

    /// Takes in what is violated and not yet in, and what is near to it. Returns whether there was any.
    fn admit_violated(&mut self, round: usize) -> bool {
        let near_bound = NEAR_BOUND[round.min(NEAR_BOUND.len() - 1)];
        let (problem, links) = (self.problem, self.links);
        let before = self.active_rows.len();
        let moved = std::mem::take(&mut self.moved);
        let mut frontier = Vec::new();
        for &variable in &moved {
            for &group in links.groups(variable) {
                let is_new = std::mem::replace(&mut self.looked_at[group as usize], round) != round;
                let is_violated = |row| problem.violation(row, &self.solution.values) > TOLERANCE;
                let is_out = is_new && !self.is_active[group as usize];
                if is_out && problem.rules.group(group as usize).any(is_violated) {
                    self.admit_group(group, &mut frontier);
                }
            }
            let row = problem.rules.len() + variable as usize;
            let is_free = problem.bounds.is_some() && !self.is_bounded[variable as usize];
            if is_free && problem.violation(row, &self.solution.values) > TOLERANCE {
                self.is_bounded[variable as usize] = true;
                self.admit_row(row, std::iter::once(variable), &mut frontier);
            }
        }
        self.admit_around_costly(&moved, &mut frontier);
        for _ in 0..RINGS {
            for variable in std::mem::take(&mut frontier) {
                for &group in links.groups(variable) {
                    if !self.is_active[group as usize] && self.is_near(group, near_bound) {
                        self.admit_group(group, &mut frontier);
                    }
                }
            }
        }
        self.active_rows.len() > before
    }

    /// Where an island of the interior method comes again, everything about its variables comes in: a step
    /// costs hardly more, and another round costs all of them.
    fn admit_around_costly(&mut self, moved: &[u32], frontier: &mut Vec<u32>) {
        if !moved.iter().any(|&variable| self.is_costly[variable as usize]) {
            return;
        }
        let mut stale_roots = vec![false; self.is_stale.len()];
        self.mark_stale(&mut stale_roots);
        for &variable in moved {
            let root = self.islands.root(variable);
            if self.is_costly[variable as usize] && stale_roots[root as usize] {
                for &group in self.links.groups(variable) {
                    if !self.is_active[group as usize] {
                        self.admit_group(group, frontier);
                    }
                }
            }
        }
    }

    fn is_near(&self, group: u32, near_bound: f64) -> bool {
        let rules = self.problem.rules;
        let is_near =
            |row| !(near_bound..=1.0 - near_bound).contains(&rules.value(row, &self.solution.values));
        rules.group(group as usize).any(is_near)
    }

    /// Marks the islands that have new rows.
    fn mark_stale(&mut self, roots: &mut [bool]) {
        for at in 0..self.is_stale.len() {
            if self.is_stale[at] {
                roots[self.islands.root(at as u32) as usize] = true;
            }
        }
    }

    fn admit_group(&mut self, group: u32, frontier: &mut Vec<u32>) {
        let rules = self.problem.rules;
        self.is_active[group as usize] = true;
        for row in rules.group(group as usize) {
            self.admit_row(row, rules.terms(row).iter().map(|term| term.0), frontier);
        }
    }

    fn admit_row(&mut self, row: usize, variables: impl Iterator<Item = u32>, frontier: &mut Vec<u32>) {
        let mut first = None;
        for variable in variables {
            let first = *first.get_or_insert(variable);
            self.islands.join(first, variable);
            self.is_stale[first as usize] = true;
            if !std::mem::replace(&mut self.is_touched[variable as usize], true) {
                frontier.push(variable);
            }
        }
        // A row without terms binds nothing.
        if first.is_some() {
            self.active_rows.push(row);
        }
    }

    fn first_variable(&self, row: usize) -> u32 {
        let rules = self.problem.rules;
        match row.checked_sub(rules.len()) {
            Some(variable) => variable as u32,
            None => rules.terms(row)[0].0,
        }
    }

    /// Solves every island that has new rows, in the order of their lowest variables, and writes its
    /// variables.
    fn solve_islands(&mut self, canceled: &(dyn Fn() -> bool + Sync)) {
        let mut stale_roots = vec![false; self.is_stale.len()];
        self.mark_stale(&mut stale_roots);
        self.is_stale.fill(false);
        let mut keyed: Vec<(u32, usize)> = Vec::with_capacity(self.active_rows.len());
        for at in 0..self.active_rows.len() {
            let row = self.active_rows[at];
            let first = self.first_variable(row);
            let root = self.islands.root(first);
            if stale_roots[root as usize] {
                keyed.push((root, row));
            }
        }
        keyed.sort_unstable();
        let chunks = keyed.chunk_by(|a, b| a.0 == b.0);
        let islands: Vec<Island> = chunks.map(|chunk| self.island(chunk)).collect();
        let Problem { wanted, weights, center, .. } = *self.problem;
        let solved: Vec<(Outcome, bool)> = islands
            .par_iter()
            .map(|island| match solve_active(island, wanted, weights) {
                Some(outcome) => (outcome, false),
                None => (solve_island(island, wanted, weights, center, canceled), true),
            })
            .collect();
        for (island, (outcome, is_costly)) in islands.iter().zip(solved) {
            for (&variable, value) in island.variables().iter().zip(outcome.values) {
                self.solution.values[variable as usize] = value;
                self.is_costly[variable as usize] |= is_costly;
            }
            self.moved.extend_from_slice(island.variables());
            let solution = &mut *self.solution;
            solution.step_count = solution.step_count.max(outcome.step_count);
            solution.dual_residual = solution.dual_residual.max(outcome.dual_residual);
            solution.complementarity = solution.complementarity.max(outcome.complementarity);
        }
    }

    /// The island of rows that are keyed alike.
    fn island(&mut self, keyed: &[(u32, usize)]) -> Island {
        let rules = self.problem.rules;
        let terms = |row: usize| if row < rules.len() { rules.terms(row) } else { &[] };
        let bounded = |row: usize| row.checked_sub(rules.len()).map(|variable| variable as u32);
        let mut variables: Vec<u32> = Vec::new();
        for &(_, row) in keyed {
            for variable in terms(row).iter().map(|term| term.0).chain(bounded(row)) {
                if std::mem::replace(&mut self.places[variable as usize], 0) == NOWHERE {
                    variables.push(variable);
                }
            }
        }
        variables.sort_unstable();
        for (place, &variable) in variables.iter().enumerate() {
            self.places[variable as usize] = place as u32;
        }
        let mut island = Island::new(variables, rules.is_affine());
        for &(_, row) in keyed {
            let place = |(variable, weight): (u32, f64)| (self.places[variable as usize], weight);
            let range = self.problem.range(row);
            match bounded(row) {
                Some(variable) => island.push(std::iter::once(place((variable, 1.0))), 0.0, range),
                None => {
                    let constant = f64::from(rules.constant(row));
                    island.push(terms(row).iter().copied().map(place), constant, range);
                }
            }
        }
        island.variables().iter().for_each(|&variable| self.places[variable as usize] = NOWHERE);
        island
    }
}
