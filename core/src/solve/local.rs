//! The papers' own ways, face by face: MCT 3.4 beyond vertex colors, MCT 3.1 for border texels.
//!
//! Beyond vertex colors each face gets the least change that puts its violated texels on their limits,
//! one texel more at each step (MCT equations 3 to 5). Faces that share a sample end with different
//! versions of it, so they store their own and the surface shows a seam. Border texels change the shared
//! samples themselves, over and over until all fit, so these do not tear.

use rayon::prelude::*;

use crate::assign::Rules;

use super::problem::{Problem, Solution, TOLERANCE, violation};

/// Rounds over the border texels: each brings values closer, and a few suffice (MCT 3.1).
const SWEEPS_MAX: u64 = 100;
/// Texels of a face beyond vertex colors, and so steps of MCT 3.4.
const STEPS_MAX: usize = 9;
/// Directions whose share of the largest is below this are told apart by rounding alone.
const RANK: f64 = 1e-13;

/// What faces store instead of the shared values.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceChange {
    /// The group of rules; [`Rules::face`] tells whose it is.
    pub group: usize,
    /// Variable and value.
    pub values: Vec<(u32, f64)>,
}

pub struct LocalSolution {
    /// Its values are, of each variable, the version that was changed most.
    pub solution: Solution,
    /// What faces share: the wanted values, changed for border texels.
    pub shared: Vec<f64>,
    pub faces: Vec<FaceChange>,
}

/// Changes what is violated, face by face. What is left out of range is the solution's residual.
pub fn solve_locally(problem: &Problem<'_>) -> LocalSolution {
    let rules = problem.rules;
    let (_, violated_count) = problem.violations(problem.wanted);
    let mut solution = Solution { violated_count, ..Solution::unchanged(problem) };
    let mut shared = problem.wanted.to_vec();
    solution.step_count = sweep_borders(rules, &mut shared);
    let solved: Vec<(Option<FaceChange>, f64)> =
        (0..rules.group_count()).into_par_iter().map(|group| solve_group(rules, group, &shared)).collect();
    solution.values.clone_from(&shared);
    let mut faces = Vec::new();
    for (change, left) in solved {
        solution.residual = solution.residual.max(left);
        faces.extend(change);
    }
    for &(variable, value) in faces.iter().flat_map(|face: &FaceChange| &face.values) {
        let (wanted, most) = (problem.wanted[variable as usize], &mut solution.values[variable as usize]);
        if (value - wanted).abs() > (*most - wanted).abs() {
            *most = value;
        }
    }
    solution.objective = problem.objective(&solution.values);
    LocalSolution { solution, shared, faces }
}

/// MCT 3.1: what a border texel lacks is shared out among its samples, a third each for one between two
/// edge samples. Returns the number of rounds.
fn sweep_borders(rules: &Rules, values: &mut [f64]) -> u64 {
    let borders: Vec<usize> = (0..rules.group_count())
        .filter(|&group| rules.face(group).is_none())
        .flat_map(|group| rules.group(group))
        .collect();
    for sweep in 0..SWEEPS_MAX {
        let mut is_done = true;
        for &row in &borders {
            let value = rules.value(row, values);
            if violation(value) <= TOLERANCE {
                continue;
            }
            is_done = false;
            let square: f64 = rules.terms(row).iter().map(|(_, weight)| weight * weight).sum();
            if square > 0.0 {
                let share = (value.clamp(0.0, 1.0) - value) / square;
                rules.terms(row).iter().for_each(|&(v, weight)| values[v as usize] += share * weight);
            }
        }
        if is_done {
            return sweep;
        }
    }
    SWEEPS_MAX
}

/// MCT 3.4 for the texels of one group: what its faces store instead, and the largest violation that is
/// left.
fn solve_group(rules: &Rules, group: usize, shared: &[f64]) -> (Option<FaceChange>, f64) {
    let rows: Vec<usize> = rules.group(group).collect();
    let values: Vec<f64> = rows.iter().map(|&row| rules.value(row, shared)).collect();
    let is_border = rules.face(group).is_none();
    let worst = values.iter().map(|&value| violation(value)).fold(0.0, f64::max);
    if is_border || worst <= TOLERANCE {
        return (None, worst);
    }
    let mut variables: Vec<u32> = rows.iter().flat_map(|&row| rules.terms(row)).map(|term| term.0).collect();
    variables.sort_unstable();
    variables.dedup();
    let weights: Vec<Vec<f64>> = rows.iter().map(|&row| dense(rules.terms(row), &variables)).collect();
    // Row and what it lacks to its limit, in the order of coming in.
    let mut chosen: Vec<(usize, f64)> = Vec::new();
    let mut change = vec![0.0; variables.len()];
    let value_of = |row: usize, change: &[f64]| values[row] + dot(&weights[row], change);
    while chosen.len() < rows.len().min(STEPS_MAX) {
        let open = (0..rows.len()).filter(|row| chosen.iter().all(|(known, _)| known != row));
        let most =
            open.max_by(|&a, &b| violation(value_of(a, &change)).total_cmp(&violation(value_of(b, &change))));
        let Some(row) = most.filter(|&row| violation(value_of(row, &change)) > TOLERANCE) else { break };
        let limit = value_of(row, &change).clamp(0.0, 1.0);
        chosen.push((row, limit - values[row]));
        let vectors = chosen.iter().map(|&(row, _)| weights[row].clone()).collect();
        change = least_squares(vectors, chosen.iter().map(|&(_, lack)| lack).collect());
    }
    let left = (0..rows.len()).map(|row| violation(value_of(row, &change))).fold(0.0, f64::max);
    let moved = variables.iter().zip(&change).map(|(&v, change)| (v, shared[v as usize] + change));
    (Some(FaceChange { group, values: moved.collect() }), left)
}

fn dense(terms: &[(u32, f64)], variables: &[u32]) -> Vec<f64> {
    let weight = |v: &u32| terms.iter().find(|(variable, _)| variable == v).map_or(0.0, |term| term.1);
    variables.iter().map(weight).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The shortest `x` of those with the least `|A x - b|` (MCT equation 4), `rows` being those of `A`: they
/// and `b` are turned until they stand at right angles (M. R. Hestenes, "Inversion of matrices by
/// biorthogonalization and related results", 1958), without forming `AᵀA`.
fn least_squares(mut rows: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    const SWEEPS_MAX: usize = 40;
    const RIGHT_ANGLE: f64 = 1e-15;
    for _ in 0..SWEEPS_MAX {
        let mut is_done = true;
        for q in 1..rows.len() {
            for p in 0..q {
                let (square_p, square_q) = (dot(&rows[p], &rows[p]), dot(&rows[q], &rows[q]));
                let product = dot(&rows[p], &rows[q]);
                if product.abs() <= RIGHT_ANGLE * (square_p * square_q).sqrt() {
                    continue;
                }
                is_done = false;
                let slope = (square_q - square_p) / (2.0 * product);
                let tangent = slope.signum() / (slope.abs() + slope.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = cosine * tangent;
                let turn = |p: &mut f64, q: &mut f64| {
                    (*p, *q) = (cosine * *p - sine * *q, sine * *p + cosine * *q);
                };
                let (low, high) = rows.split_at_mut(q);
                low[p].iter_mut().zip(&mut high[0]).for_each(|(p, q)| turn(p, q));
                let (low, high) = b.split_at_mut(q);
                turn(&mut low[p], &mut high[0]);
            }
        }
        if is_done {
            break;
        }
    }
    let squares: Vec<f64> = rows.iter().map(|row| dot(row, row)).collect();
    let largest = squares.iter().copied().fold(0.0, f64::max);
    let mut x = vec![0.0; rows.first().map_or(0, Vec::len)];
    for ((row, b), square) in rows.iter().zip(&b).zip(squares) {
        if square > RANK * RANK * largest {
            x.iter_mut().zip(row).for_each(|(x, weight)| *x += weight * b / square);
        }
    }
    x
}
