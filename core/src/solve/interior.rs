//! One island of rules by a feasible primal-dual interior point method.
//!
//! (S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optimization 2,
//! 1992.) It starts at the constant that keeps every rule and never leaves the rules, so whatever it ends
//! with can be stored. The number of steps hardly depends on how the rules lean on each other, which first-
//! order methods cannot say: beyond vertex colors the rules of a face are nearly parallel.

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat};

/// Mean of slack times multiplier at which a solution is good: slack of active rules in the order of 1e-8.
const COMPLEMENTARITY: f64 = 1e-11;
/// Below this steps only lose digits.
const EXHAUSTED: f64 = 1e-14;
/// Largest entry of the gradient at which a solution is good: a change in the order of 1e-8.
const STATIONARITY: f64 = 1e-8;
const STEPS_MAX: u64 = 60;
/// Share of the way to the nearest bound that a step takes.
const CAUTION: f64 = 0.99;

/// `0 <= constant + terms · y <= 1`.
pub struct IslandRow {
    /// Variable and weight.
    pub terms: Vec<(u32, f64)>,
    pub constant: f64,
}

/// Rules that share variables, with rows scaled to unit length.
pub struct Island {
    variables: Vec<u32>,
    /// Terms by local variable.
    rows: Vec<Vec<(u32, f64)>>,
    low: Vec<f64>,
    high: Vec<f64>,
}

pub struct Outcome {
    /// By [`Island::variables`].
    pub values: Vec<f64>,
    pub step_count: u64,
    pub dual_residual: f64,
    pub complementarity: f64,
}

impl Island {
    pub fn new(rows: Vec<IslandRow>) -> Self {
        let mut variables: Vec<u32> =
            rows.iter().flat_map(|row| row.terms.iter().map(|term| term.0)).collect();
        variables.sort_unstable();
        variables.dedup();
        let mut island = Self { rows: Vec::with_capacity(rows.len()), low: vec![], high: vec![], variables };
        for row in rows {
            let length = row.terms.iter().map(|(_, weight)| weight * weight).sum::<f64>().sqrt();
            if length == 0.0 {
                continue;
            }
            let local = |variable| island.variables.binary_search(&variable).unwrap_or(0) as u32;
            island.rows.push(row.terms.iter().map(|&(v, weight)| (local(v), weight / length)).collect());
            island.low.push(-row.constant / length);
            island.high.push((1.0 - row.constant) / length);
        }
        island
    }

    pub fn variables(&self) -> &[u32] {
        &self.variables
    }

    /// `wanted` and `weights` are indexed by the problem's variables; `center` keeps every rule.
    pub fn solve(
        &self,
        wanted: &[f64],
        weights: &[f64],
        center: f64,
        canceled: &(dyn Fn() -> bool + Sync),
    ) -> Outcome {
        let pick = |all: &[f64]| self.variables.iter().map(|&v| all[v as usize]).collect::<Vec<f64>>();
        let mut iterate = Iterate::new(self, pick(wanted), pick(weights), center);
        let mut step_count = 0;
        if let Some(system) = System::new(self) {
            let mut best: Option<(f64, Vec<f64>, [Vec<f64>; 2])> = None;
            while step_count < STEPS_MAX && !iterate.is_good() && !canceled() {
                // Rounding ends the method where the system can no longer be factored, where no step is left
                // or where slack and multipliers have lost their digits; every iterate keeps every rule.
                if iterate.complementarity() < EXHAUSTED || !iterate.step(&system) {
                    break;
                }
                step_count += 1;
                let rest = iterate.dual_residual();
                if iterate.complementarity() <= COMPLEMENTARITY
                    && best.as_ref().is_none_or(|(least, ..)| rest < *least)
                {
                    best = Some((rest, iterate.values.clone(), iterate.multipliers.clone()));
                }
            }
            if let Some((_, values, multipliers)) =
                best.filter(|(least, ..)| *least < iterate.dual_residual())
            {
                iterate.restore(values, multipliers);
            }
        }
        if !iterate.is_good() {
            iterate.approach_wanted();
        }
        let (dual_residual, complementarity) = (iterate.dual_residual(), iterate.complementarity());
        Outcome { values: iterate.values, step_count, dual_residual, complementarity }
    }

    /// `W y`.
    fn apply(&self, y: &[f64]) -> Vec<f64> {
        let row = |terms: &Vec<(u32, f64)>| terms.iter().map(|&(v, weight)| weight * y[v as usize]).sum();
        self.rows.iter().map(row).collect()
    }

    /// `out += Wᵀ z`.
    fn add_transposed(&self, z: impl Iterator<Item = f64>, out: &mut [f64]) {
        for (terms, z) in self.rows.iter().zip(z) {
            terms.iter().for_each(|&(v, weight)| out[v as usize] += weight * z);
        }
    }
}

/// The sparse matrix `diag(a) + Wᵀ D W`: its pattern and order of elimination, found once.
struct System {
    pattern: SymbolicSparseColMat<u32>,
    order: Argsort<u32>,
    elimination: SymbolicLlt<u32>,
}

impl System {
    fn new(island: &Island) -> Option<Self> {
        let mut entries: Vec<Pair<u32, u32>> =
            (0..island.variables.len() as u32).map(|v| Pair { row: v, col: v }).collect();
        for terms in &island.rows {
            for &(a, _) in terms {
                for &(b, _) in terms.iter().filter(|term| term.0 <= a) {
                    entries.push(Pair { row: a, col: b });
                }
            }
        }
        let n = island.variables.len();
        let (pattern, order) = SymbolicSparseColMat::try_new_from_indices(n, n, &entries).ok()?;
        let elimination = SymbolicLlt::try_new(pattern.as_ref(), Side::Lower).ok()?;
        Some(Self { pattern, order, elimination })
    }

    /// Factors the matrix for the diagonals `a` and `d`.
    fn factor(&self, island: &Island, a: &[f64], d: &[f64]) -> Option<Llt<u32, f64>> {
        let mut values = a.to_vec();
        for (terms, d) in island.rows.iter().zip(d) {
            for &(a, weight_a) in terms {
                for &(_, weight_b) in terms.iter().filter(|term| term.0 <= a) {
                    values.push(d * weight_a * weight_b);
                }
            }
        }
        let matrix = SparseColMat::new_from_argsort(self.pattern.clone(), &self.order, &values).ok()?;
        Llt::try_new_with_symbolic(self.elimination.clone(), matrix.as_ref(), Side::Lower).ok()
    }
}

/// `diag(a) + Wᵀ D W`, factored, with its `D`.
struct Matrix {
    factor: Llt<u32, f64>,
    stiffness: Vec<f64>,
}

/// A point strictly inside all rules, and multipliers above zero.
struct Iterate<'a> {
    island: &'a Island,
    wanted: Vec<f64>,
    weights: Vec<f64>,
    values: Vec<f64>,
    /// Distance to the low bounds, then to the high ones.
    slack: [Vec<f64>; 2],
    multipliers: [Vec<f64>; 2],
}

impl<'a> Iterate<'a> {
    fn new(island: &'a Island, wanted: Vec<f64>, weights: Vec<f64>, center: f64) -> Self {
        /// Start of slack times multiplier: what a change of a tenth is worth.
        const START: f64 = 1e-2;
        let values = vec![center; wanted.len()];
        let rows = island.apply(&values);
        let low = rows.iter().zip(&island.low).map(|(row, low)| row - low).collect::<Vec<_>>();
        let high = rows.iter().zip(&island.high).map(|(row, high)| high - row).collect::<Vec<_>>();
        let multipliers = [&low, &high].map(|slack| slack.iter().map(|s| START / s).collect());
        Self { island, wanted, weights, values, slack: [low, high], multipliers }
    }

    fn complementarity(&self) -> f64 {
        let products = |side: usize| -> f64 {
            self.slack[side].iter().zip(&self.multipliers[side]).map(|(s, z)| s * z).sum()
        };
        (products(0) + products(1)) / (2 * self.slack[0].len()) as f64
    }

    /// Goes back to an earlier point.
    fn restore(&mut self, values: Vec<f64>, multipliers: [Vec<f64>; 2]) {
        let rows = self.island.apply(&values);
        self.slack[0] = rows.iter().zip(&self.island.low).map(|(row, low)| row - low).collect();
        self.slack[1] = rows.iter().zip(&self.island.high).map(|(row, high)| high - row).collect();
        self.values = values;
        self.multipliers = multipliers;
    }

    /// Goes straight towards the wanted values as far as every rule holds: what can be said without the
    /// optimum is at least nearer than the center.
    fn approach_wanted(&mut self) {
        let values: Vec<f64> = self.wanted.iter().zip(&self.values).map(|(c, y)| c - y).collect();
        let low = self.island.apply(&values);
        let slack = [low.clone(), low.iter().map(|d| -d).collect()];
        let multipliers = [vec![0.0; low.len()], vec![0.0; low.len()]];
        let direction = Direction { values, slack, multipliers };
        let length = self.reach(&direction).clamp(0.0, 1.0);
        self.advance(&direction, length);
    }

    fn dual_residual(&self) -> f64 {
        self.gradient().iter().fold(0.0, |max: f64, entry| max.max(entry.abs()))
    }

    fn is_good(&self) -> bool {
        self.complementarity() <= COMPLEMENTARITY && self.dual_residual() <= STATIONARITY
    }

    /// `a (y - c) - Wᵀ (z_low - z_high)`, zero at the optimum.
    fn gradient(&self) -> Vec<f64> {
        let mut gradient: Vec<f64> = (self.values.iter().zip(&self.wanted).zip(&self.weights))
            .map(|((y, c), a)| a * (y - c))
            .collect();
        let [low, high] = &self.multipliers;
        self.island.add_transposed(low.iter().zip(high).map(|(low, high)| high - low), &mut gradient);
        gradient
    }

    /// One predictor and corrector; false where there is no way on.
    fn step(&mut self, system: &System) -> bool {
        let stiffness = self.stiffness();
        let Some(factor) = system.factor(self.island, &self.weights, &stiffness) else { return false };
        let matrix = Matrix { factor, stiffness };
        let gradient = self.gradient();
        let products = [0, 1].map(|side| {
            (self.slack[side].iter().zip(&self.multipliers[side])).map(|(s, z)| s * z).collect::<Vec<f64>>()
        });
        let predictor = self.direction(&matrix, &gradient, &products);
        let mean = self.complementarity();
        let reach = self.reach(&predictor);
        let mean_ahead = self.complementarity_ahead(&predictor, reach);
        let centering = (mean_ahead / mean).powi(3) * mean;
        let toward = |second_order: f64, mean: f64| {
            [0, 1].map(|side| {
                let products = products[side].iter().enumerate();
                let one = |(row, product): (usize, &f64)| {
                    let bend = predictor.slack[side][row] * predictor.multipliers[side][row];
                    product + second_order * bend - mean
                };
                products.map(one).collect::<Vec<f64>>()
            })
        };
        let mut direction = self.direction(&matrix, &gradient, &toward(1.0, centering));
        let mut length = (CAUTION * self.reach(&direction)).min(1.0);
        if self.complementarity_ahead(&direction, length) > (1.0 - 0.1 * length) * mean {
            // The corrector can run in circles; the plain path to a fifth of the mean cannot.
            direction = self.direction(&matrix, &gradient, &toward(0.0, 0.2 * mean));
            length = (CAUTION * self.reach(&direction)).min(1.0);
        }
        if length.is_nan() || length < 1e-9 || direction.values.iter().any(|d| !d.is_finite()) {
            return false;
        }
        self.advance(&direction, length);
        true
    }

    /// Newton's direction for the gradient and for products `s z` that are to become zero.
    fn direction(&self, matrix: &Matrix, gradient: &[f64], products: &[Vec<f64>; 2]) -> Direction {
        let mut right: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let pull = |row: usize| products[1][row] / self.slack[1][row] - products[0][row] / self.slack[0][row];
        self.island.add_transposed((0..self.slack[0].len()).map(pull), &mut right);
        let values = self.refined(matrix, &right);
        let low = self.island.apply(&values);
        let slack = [low.clone(), low.iter().map(|d| -d).collect()];
        let multipliers = [0, 1].map(|side| {
            (0..low.len())
                .map(|row| {
                    let back = products[side][row] + self.multipliers[side][row] * slack[side][row];
                    -back / self.slack[side][row]
                })
                .collect()
        });
        Direction { values, slack, multipliers }
    }

    /// Solves with the factored matrix, then twice for what rounding left: with nearly parallel rules the
    /// matrix is ill-conditioned near the optimum.
    fn refined(&self, matrix: &Matrix, right: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; right.len()];
        let mut rest = right.to_vec();
        for _ in 0..3 {
            let step = matrix.factor.solve(&faer::Col::from_fn(rest.len(), |at| rest[at]));
            values.iter_mut().enumerate().for_each(|(at, value)| *value += step[at]);
            rest =
                (right.iter().zip(&values).zip(&self.weights)).map(|((right, y), a)| right - a * y).collect();
            let rows = self.island.apply(&values).into_iter().zip(&matrix.stiffness);
            self.island.add_transposed(rows.map(|(row, d)| -row * d), &mut rest);
        }
        values
    }

    /// What each row adds to the matrix: multiplier over slack, both sides.
    fn stiffness(&self) -> Vec<f64> {
        let one = |row: usize| (0..2).map(|side| self.multipliers[side][row] / self.slack[side][row]).sum();
        (0..self.slack[0].len()).map(one).collect()
    }

    /// How far slack and multipliers stay above zero, at most 1.
    fn reach(&self, direction: &Direction) -> f64 {
        let bound = |at: &[f64], by: &[f64]| {
            let falling = at.iter().zip(by).filter(|(_, d)| **d < 0.0);
            falling.map(|(at, d)| -at / d).fold(1.0 / CAUTION, f64::min)
        };
        let sides = (0..2).map(|side| {
            let slack = bound(&self.slack[side], &direction.slack[side]);
            slack.min(bound(&self.multipliers[side], &direction.multipliers[side]))
        });
        sides.fold(1.0 / CAUTION, f64::min)
    }

    fn complementarity_ahead(&self, direction: &Direction, length: f64) -> f64 {
        let length = length.min(1.0);
        let mut sum = 0.0;
        for side in 0..2 {
            for row in 0..self.slack[side].len() {
                let slack = self.slack[side][row] + length * direction.slack[side][row];
                sum += slack * (self.multipliers[side][row] + length * direction.multipliers[side][row]);
            }
        }
        sum / (2 * self.slack[0].len()) as f64
    }

    fn advance(&mut self, direction: &Direction, length: f64) {
        let add = |at: &mut [f64], by: &[f64]| at.iter_mut().zip(by).for_each(|(at, by)| *at += length * by);
        add(&mut self.values, &direction.values);
        for side in 0..2 {
            add(&mut self.slack[side], &direction.slack[side]);
            add(&mut self.multipliers[side], &direction.multipliers[side]);
        }
    }
}

struct Direction {
    values: Vec<f64>,
    slack: [Vec<f64>; 2],
    multipliers: [Vec<f64>; 2],
}
