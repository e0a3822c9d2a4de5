//! One island of rules by a feasible primal-dual interior point method.
//!
//! (S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optimization 2,
//! 1992.) It starts at the constant that keeps every rule and never leaves the rules, so whatever it ends
//! with can be stored. The number of steps hardly depends on how the rules lean on each other, which first-
//! order methods cannot say: beyond vertex colors the rules of a face are nearly parallel.

use super::island::Island;
use super::matrix::Matrix;

/// Mean of slack times multiplier at which a solution may be good: slack of active rules in the order of
/// 1e-7.
const COMPLEMENTARITY: f64 = 1e-8;
/// Share of the objective that it may still fall by; below [`TIGHT`] nobody asks.
const GAP: f64 = 2e-4;
/// Mean of slack times multiplier at which a solution of any size is good.
const TIGHT: f64 = 1e-13;
/// Below this steps only lose digits.
const EXHAUSTED: f64 = 1e-14;
/// Largest entry of the gradient at which a solution is good: a change in the order of 1e-7.
const STATIONARITY: f64 = 1e-7;
const STEPS_MAX: u64 = 60;
/// Share of the way to the nearest bound that a step takes.
const CAUTION: f64 = 0.99;
/// What a solve with the factored matrix may leave of its right side before it is repeated for the rest.
const REFINED: f64 = 1e-9;

pub struct Outcome {
    /// By [`Island::variables`].
    pub values: Vec<f64>,
    pub step_count: u64,
    /// Largest entry of the gradient that is left.
    pub dual_residual: f64,
    /// Mean of slack times multiplier that is left.
    pub complementarity: f64,
}

/// The least change from `wanted` in the measure of `weights`, both by the problem's variables; at `center`
/// every rule holds with room to spare.
pub fn solve_island(
    island: &Island,
    wanted: &[f64],
    weights: &[f64],
    center: f64,
    canceled: &(dyn Fn() -> bool + Sync),
) -> Outcome {
    let pick = |all: &[f64]| island.variables().iter().map(|&v| all[v as usize]).collect::<Vec<f64>>();
    let mut iterate = Iterate::new(island, pick(wanted), pick(weights), center);
    let mut step_count = 0;
    if let Some(mut matrix) = Matrix::new(island) {
        let mut best: Option<(Rest, Vec<f64>, [Vec<f64>; 2])> = None;
        while step_count < STEPS_MAX && !iterate.is_good() && !canceled() {
            // Rounding ends the method where the system can no longer be factored, where no step is left
            // or where slack and multipliers have lost their digits; every iterate keeps every rule.
            if iterate.complementarity() < EXHAUSTED || !iterate.step(&mut matrix) {
                break;
            }
            step_count += 1;
            let rest = iterate.rest();
            if iterate.complementarity() <= COMPLEMENTARITY && best.as_ref().is_none_or(|best| rest < best.0)
            {
                best = Some((rest, iterate.values.clone(), iterate.multipliers.clone()));
            }
        }
        if let Some((_, values, multipliers)) = best.filter(|best| best.0 < iterate.rest()) {
            iterate.restore(values, multipliers);
        }
    }
    if !iterate.is_sound() {
        iterate.approach_wanted();
        iterate.try_one_value();
    }
    let (dual_residual, complementarity) = (iterate.dual_residual(), iterate.complementarity());
    Outcome { values: iterate.values, step_count, dual_residual, complementarity }
}

/// What is left: whether the gradient is too large, and then how large, else slack times multiplier.
type Rest = (bool, f64);

/// A point strictly inside all rules, and multipliers above zero.
struct Iterate<'a> {
    island: &'a Island,
    wanted: Vec<f64>,
    weights: Vec<f64>,
    values: Vec<f64>,
    /// Distance to the low bounds, then to the high ones.
    slack: [Vec<f64>; 2],
    multipliers: [Vec<f64>; 2],
    /// `a (y - c) - Wᵀ (z_low - z_high)`, zero at the optimum; kept up to date.
    gradient: Vec<f64>,
    room: Room,
}

/// Room that steps use again.
#[derive(Default)]
struct Room {
    stiffness: Vec<f64>,
    predictor: Direction,
    corrector: Direction,
    right: Vec<f64>,
    rest: Vec<f64>,
    rows: Vec<f64>,
}

/// Of values, rows (the low slack grows as they do, the high one falls) and multipliers.
#[derive(Default)]
struct Direction {
    values: Vec<f64>,
    rows: Vec<f64>,
    multipliers: [Vec<f64>; 2],
}

/// How a row's value moves the slack of each side.
const SIGNS: [f64; 2] = [1.0, -1.0];

impl<'a> Iterate<'a> {
    fn new(island: &'a Island, wanted: Vec<f64>, weights: Vec<f64>, center: f64) -> Self {
        /// Start of slack times multiplier: what a change of a tenth is worth.
        const START: f64 = 1e-2;
        let values = vec![center; wanted.len()];
        let mut iterate = Self {
            island,
            wanted,
            weights,
            values,
            slack: Default::default(),
            multipliers: Default::default(),
            gradient: Vec::new(),
            room: Room::default(),
        };
        iterate.update_slack();
        iterate.multipliers = [0, 1].map(|side| iterate.slack[side].iter().map(|s| START / s).collect());
        iterate.update_gradient();
        iterate
    }

    fn update_slack(&mut self) {
        let Self { island, room, slack, .. } = self;
        island.apply(&self.values, &mut room.rows);
        slack[0] = room.rows.iter().zip(island.low()).map(|(row, low)| row - low).collect();
        slack[1] = room.rows.iter().zip(island.high()).map(|(row, high)| high - row).collect();
    }

    fn update_gradient(&mut self) {
        let terms = self.values.iter().zip(&self.wanted).zip(&self.weights);
        self.gradient.clear();
        self.gradient.extend(terms.map(|((y, c), a)| a * (y - c)));
        let [low, high] = &self.multipliers;
        self.island.add_transposed(low.iter().zip(high).map(|(low, high)| high - low), &mut self.gradient);
    }

    fn complementarity(&self) -> f64 {
        let products = |side: usize| -> f64 {
            self.slack[side].iter().zip(&self.multipliers[side]).map(|(s, z)| s * z).sum()
        };
        (products(0) + products(1)) / (2 * self.island.row_count()).max(1) as f64
    }

    /// Goes back to an earlier point.
    fn restore(&mut self, values: Vec<f64>, multipliers: [Vec<f64>; 2]) {
        self.values = values;
        self.multipliers = multipliers;
        self.update_slack();
        self.update_gradient();
    }

    /// Goes straight towards the wanted values as far as every rule holds: what can be said without the
    /// optimum is at least nearer than the center.
    fn approach_wanted(&mut self) {
        let mut direction = Direction {
            values: self.wanted.iter().zip(&self.values).map(|(c, y)| c - y).collect(),
            rows: Vec::new(),
            multipliers: [0, 1].map(|_| vec![0.0; self.island.row_count()]),
        };
        self.island.apply(&direction.values, &mut direction.rows);
        let length = self.reach(&direction).clamp(0.0, 1.0);
        self.advance(&direction, length);
    }

    fn objective(&self) -> f64 {
        let terms = self.values.iter().zip(&self.wanted).zip(&self.weights);
        terms.map(|((y, c), a)| a * (y - c) * (y - c)).sum()
    }

    /// Far beyond vertex colors the corners of a face have to be all but equal, and the optimum is all but
    /// the mean of what hangs together. Taken, and left towards the wanted values, where it is nearer.
    fn try_one_value(&mut self) {
        if !self.island.is_affine() {
            return;
        }
        let terms = self.wanted.iter().zip(&self.weights);
        let (sum, weight) = terms.fold((0.0, 0.0), |(sum, of), (c, a)| (sum + c * a, of + a));
        let before = (self.objective(), self.values.clone(), self.multipliers.clone());
        self.restore(vec![sum / weight; self.values.len()], before.2.clone());
        let is_inside = self.slack.iter().flatten().all(|slack| *slack > 0.0);
        if is_inside {
            self.approach_wanted();
        }
        if !is_inside || self.objective() > before.0 {
            self.restore(before.1, before.2);
        }
    }

    fn dual_residual(&self) -> f64 {
        self.gradient.iter().fold(0.0, |max: f64, entry| max.max(entry.abs()))
    }

    fn rest(&self) -> Rest {
        let gradient = self.dual_residual();
        let is_open = gradient > STATIONARITY;
        (is_open, if is_open { gradient } else { self.complementarity() })
    }

    fn is_sound(&self) -> bool {
        self.complementarity() <= COMPLEMENTARITY && self.dual_residual() <= STATIONARITY
    }

    fn is_good(&self) -> bool {
        if !self.is_sound() {
            return false;
        }
        let mean = self.complementarity();
        // The duality gap of half the objective is the sum of all products.
        let gap = 4.0 * mean * self.island.row_count() as f64;
        mean <= TIGHT || gap <= GAP * self.objective()
    }

    /// One predictor and corrector; false where there is no way on.
    fn step(&mut self, matrix: &mut Matrix) -> bool {
        let mut room = std::mem::take(&mut self.room);
        let is_done = self.step_in(matrix, &mut room);
        self.room = room;
        is_done
    }

    fn step_in(&mut self, matrix: &mut Matrix, room: &mut Room) -> bool {
        room.stiffness.clear();
        room.stiffness.extend(
            (0..self.island.row_count()).map(|row| {
                (0..2).map(|side| self.multipliers[side][row] / self.slack[side][row]).sum::<f64>()
            }),
        );
        if !matrix.factor(self.island, &self.weights, &room.stiffness) {
            return false;
        }
        let mut predictor = std::mem::take(&mut room.predictor);
        let mut direction = std::mem::take(&mut room.corrector);
        let product = |side: usize, row: usize| self.slack[side][row] * self.multipliers[side][row];
        self.direct(matrix, room, product, &mut predictor);
        let mean = self.complementarity();
        let mean_ahead = self.complementarity_ahead(&predictor, self.reach(&predictor));
        let centering = (mean_ahead / mean).powi(3) * mean;
        let bent = |side: usize, row: usize| {
            let bend = SIGNS[side] * predictor.rows[row] * predictor.multipliers[side][row];
            product(side, row) + bend - centering
        };
        self.direct(matrix, room, bent, &mut direction);
        let mut length = (CAUTION * self.reach(&direction)).min(1.0);
        if self.complementarity_ahead(&direction, length) > (1.0 - 0.1 * length) * mean {
            // The corrector can run in circles; the plain path to a fifth of the mean cannot.
            self.direct(matrix, room, |side, row| product(side, row) - 0.2 * mean, &mut direction);
            length = (CAUTION * self.reach(&direction)).min(1.0);
        }
        let is_sound = length >= 1e-9 && direction.values.iter().all(|d| d.is_finite());
        if is_sound {
            self.advance(&direction, length);
        }
        (room.predictor, room.corrector) = (predictor, direction);
        is_sound
    }

    /// Newton's direction for the gradient and for products `s z` that are to become zero.
    fn direct(
        &self,
        matrix: &mut Matrix,
        room: &mut Room,
        product: impl Fn(usize, usize) -> f64,
        out: &mut Direction,
    ) {
        room.right.clear();
        room.right.extend(self.gradient.iter().map(|g| -g));
        let pull = |row: usize| product(1, row) / self.slack[1][row] - product(0, row) / self.slack[0][row];
        self.island.add_transposed((0..self.island.row_count()).map(pull), &mut room.right);
        self.refined(matrix, room, &mut out.values);
        self.island.apply(&out.values, &mut out.rows);
        for (side, sign) in SIGNS.into_iter().enumerate() {
            let multipliers = &mut out.multipliers[side];
            multipliers.clear();
            multipliers.extend(out.rows.iter().enumerate().map(|(row, by)| {
                let back = product(side, row) + self.multipliers[side][row] * sign * by;
                -back / self.slack[side][row]
            }));
        }
    }

    /// Solves with the factored matrix, then up to twice for what rounding left: with nearly parallel rules
    /// the matrix is ill-conditioned near the optimum.
    fn refined(&self, matrix: &mut Matrix, room: &mut Room, values: &mut Vec<f64>) {
        let largest = |all: &[f64]| all.iter().fold(0.0, |max: f64, entry| max.max(entry.abs()));
        let Room { stiffness, right, rest, rows, .. } = room;
        values.clear();
        values.resize(right.len(), 0.0);
        rest.clone_from(right);
        for pass in 0..3 {
            matrix.solve(rest);
            values.iter_mut().zip(&*rest).for_each(|(value, step)| *value += step);
            if pass == 2 {
                break;
            }
            let terms = right.iter().zip(&*values).zip(&self.weights);
            rest.clear();
            rest.extend(terms.map(|((right, y), a)| right - a * y));
            self.island.apply(values, rows);
            self.island.add_transposed(rows.iter().zip(&*stiffness).map(|(row, d)| -row * d), rest);
            if largest(rest) <= REFINED * largest(right) {
                break;
            }
        }
    }

    /// How far slack and multipliers stay above zero, at most 1.
    fn reach(&self, direction: &Direction) -> f64 {
        let mut reach = 1.0 / CAUTION;
        for (side, sign) in SIGNS.into_iter().enumerate() {
            let slack = self.slack[side].iter().zip(direction.rows.iter().map(|by| sign * by));
            let multipliers = self.multipliers[side].iter().zip(direction.multipliers[side].iter().copied());
            for (at, by) in slack.chain(multipliers) {
                if at + reach * by < 0.0 {
                    reach = -at / by;
                }
            }
        }
        reach
    }

    fn complementarity_ahead(&self, direction: &Direction, length: f64) -> f64 {
        let length = length.min(1.0);
        let mut sum = 0.0;
        for (side, sign) in SIGNS.into_iter().enumerate() {
            for (row, by) in direction.rows.iter().enumerate() {
                let slack = self.slack[side][row] + length * sign * by;
                sum += slack * (self.multipliers[side][row] + length * direction.multipliers[side][row]);
            }
        }
        sum / (2 * self.island.row_count()).max(1) as f64
    }

    fn advance(&mut self, direction: &Direction, length: f64) {
        let add = |at: &mut [f64], by: &[f64], length: f64| {
            at.iter_mut().zip(by).for_each(|(at, by)| *at += length * by);
        };
        add(&mut self.values, &direction.values, length);
        for (side, sign) in SIGNS.into_iter().enumerate() {
            add(&mut self.slack[side], &direction.rows, sign * length);
            add(&mut self.multipliers[side], &direction.multipliers[side], length);
        }
        self.update_gradient();
    }
}
