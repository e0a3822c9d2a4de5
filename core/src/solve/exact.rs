//! The yardstick: all rules and all bounds at once, by a library's interior point solver.
//!
//! (P. Goulart and Y. Chen, "Clarabel: an interior-point solver for conic programs with quadratic
//! objectives", 2024.) It shares with [`super::global`] nothing but the problem: no rule is left out, no
//! island is parted. It runs on one thread, so its outcome does not depend on their number.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};

use super::problem::{Problem, Solution};

/// Variables of one component of one level up to which a solve ends in minutes.
pub const VARIABLES_MAX: usize = 60_000;
/// Relative and absolute duality gap, and violations of unit rows.
const GAP: f64 = 1e-9;

/// The optimum over all rules; `Err` holds what the library says against the problem.
pub fn solve_exactly(problem: &Problem<'_>) -> Result<Solution, String> {
    let (residual, violated_count) = problem.violations(problem.wanted);
    let mut solution = Solution { residual, violated_count, ..Solution::unchanged(problem) };
    if violated_count == 0 {
        return Ok(solution);
    }
    let variable_count = problem.wanted.len();
    let rows = Rows::new(problem);
    let diagonal = CscMatrix::new(
        variable_count,
        variable_count,
        (0..=variable_count).collect(),
        (0..variable_count).collect(),
        problem.weights.to_vec(),
    );
    let settings = DefaultSettings {
        verbose: false,
        max_threads: 1,
        direct_solve_method: "qdldl".to_owned(),
        tol_gap_abs: GAP,
        tol_gap_rel: GAP,
        tol_feas: GAP,
        ..DefaultSettings::default()
    };
    let cones = [SupportedConeT::NonnegativeConeT(rows.bounds.len())];
    let matrix = CscMatrix::new_from_triplets(
        rows.bounds.len(),
        variable_count,
        rows.at_row,
        rows.at_variable,
        rows.weights,
    );
    let linear = vec![0.0; variable_count];
    let mut solver = DefaultSolver::new(&diagonal, &linear, &matrix, &rows.bounds, &cones, settings)
        .map_err(|error| error.to_string())?;
    solver.solve();
    let found = &solver.solution;
    if found.x.iter().any(|x| !x.is_finite()) {
        return Err(format!("no finite solution: {:?}", found.status));
    }
    solution.values = problem.wanted.iter().zip(&found.x).map(|(wanted, change)| wanted + change).collect();
    solution.step_count = u64::from(found.iterations);
    let mut gradient: Vec<f64> = problem.weights.iter().zip(&found.x).map(|(a, x)| a * x).collect();
    matrix.colptr.windows(2).zip(&mut gradient).for_each(|(ends, gradient)| {
        let entries = ends[0]..ends[1];
        let row = |at: usize| matrix.nzval[at] * found.z[matrix.rowval[at]];
        *gradient += entries.map(row).sum::<f64>();
    });
    solution.dual_residual = gradient.iter().fold(0.0, |max: f64, entry| max.max(entry.abs()));
    let products: f64 = found.s.iter().zip(&found.z).map(|(s, z)| (s * z).max(0.0)).sum();
    solution.complementarity = products / found.s.len() as f64;
    solution.residual = problem.violations(&solution.values).0;
    solution.objective = problem.objective(&solution.values);
    Ok(solution)
}

/// `w · x <= bound`, twice for every rule and every stored variable, rows of unit length.
#[derive(Default)]
struct Rows {
    at_row: Vec<usize>,
    at_variable: Vec<usize>,
    weights: Vec<f64>,
    bounds: Vec<f64>,
}

impl Rows {
    fn new(problem: &Problem<'_>) -> Self {
        let mut rows = Self::default();
        for row in 0..problem.rules.len() {
            let value = problem.rules.value(row, problem.wanted);
            rows.push(problem.rules.terms(row), value, [0.0, 1.0]);
        }
        if let Some(bounds) = problem.bounds {
            for (variable, &value) in problem.wanted.iter().enumerate() {
                rows.push(&[(variable as u32, 1.0)], value, bounds);
            }
        }
        rows
    }

    /// `low <= value + terms · x <= high`.
    fn push(&mut self, terms: &[(u32, f64)], value: f64, [low, high]: [f64; 2]) {
        let length = terms.iter().map(|(_, weight)| weight * weight).sum::<f64>().sqrt();
        if length == 0.0 {
            return;
        }
        for (sign, bound) in [(1.0, high - value), (-1.0, value - low)] {
            for &(variable, weight) in terms.iter().filter(|term| term.1 != 0.0) {
                self.at_row.push(self.bounds.len());
                self.at_variable.push(variable as usize);
                self.weights.push(sign * weight / length);
            }
            self.bounds.push(bound / length);
        }
    }
}
