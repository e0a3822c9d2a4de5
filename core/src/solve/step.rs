//! A step of the interior point method: Newton's direction twice with one factor, and how far it leads.

use super::interior::Iterate;
use super::matrix::Matrix;

/// Share of the way to the nearest bound that a step takes.
const CAUTION: f64 = 0.99;
/// What a solve with the factored matrix may leave of its right side before it is repeated for the rest.
const REFINED: f64 = 1e-9;
/// Solves at most.
const PASSES: usize = 3;

/// Room that steps use again.
#[derive(Default)]
pub struct Room {
    stiffness: Vec<f64>,
    predictor: Direction,
    corrector: Direction,
    right: Vec<f64>,
    rest: Vec<f64>,
    /// By row, what pulls at the values.
    pull: Vec<f64>,
}

/// Of values, rows (the low slack grows as they do, the high one falls) and multipliers.
#[derive(Default)]
pub struct Direction {
    pub values: Vec<f64>,
    pub rows: Vec<f64>,
    pub multipliers: [Vec<f64>; 2],
}

/// How a row's value moves the slack of each side.
const SIGNS: [f64; 2] = [1.0, -1.0];

impl Iterate<'_> {
    /// One predictor and corrector; false where there is no way on.
    pub fn step(&mut self, matrix: &mut Matrix) -> bool {
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
        // It only tells how far to aim, so rounding does not matter.
        self.direct(matrix, room, product, 1, &mut predictor);
        let mean = self.complementarity();
        let mean_ahead = self.complementarity_ahead(&predictor, self.reach(&predictor));
        let centering = (mean_ahead / mean).powi(3) * mean;
        let bent = |side: usize, row: usize| {
            let bend = SIGNS[side] * predictor.rows[row] * predictor.multipliers[side][row];
            product(side, row) + bend - centering
        };
        self.direct(matrix, room, bent, PASSES, &mut direction);
        let mut length = (CAUTION * self.reach(&direction)).min(1.0);
        if self.complementarity_ahead(&direction, length) > (1.0 - 0.1 * length) * mean {
            // The corrector can run in circles; the plain path to a fifth of the mean cannot.
            self.direct(matrix, room, |side, row| product(side, row) - 0.2 * mean, PASSES, &mut direction);
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
        passes: usize,
        out: &mut Direction,
    ) {
        room.right.clear();
        room.right.extend(self.gradient.iter().map(|g| -g));
        let pull = |row: usize| product(1, row) / self.slack[1][row] - product(0, row) / self.slack[0][row];
        room.pull.clear();
        room.pull.extend((0..self.island.row_count()).map(pull));
        self.island.add_transposed(&room.pull, &mut room.right);
        self.solve(matrix, room, passes, out);
        for (side, sign) in SIGNS.into_iter().enumerate() {
            let multipliers = &mut out.multipliers[side];
            multipliers.clear();
            multipliers.extend(out.rows.iter().enumerate().map(|(row, by)| {
                let back = product(side, row) + self.multipliers[side][row] * sign * by;
                -back / self.slack[side][row]
            }));
        }
    }

    /// Solves for values and rows with the factored matrix, then again for what rounding left: with nearly
    /// parallel rules the matrix is ill-conditioned near the optimum.
    fn solve(&self, matrix: &mut Matrix, room: &mut Room, passes: usize, out: &mut Direction) {
        let largest = |all: &[f64]| all.iter().fold(0.0, |max: f64, entry| max.max(entry.abs()));
        let Room { stiffness, right, rest, pull, .. } = room;
        out.values.clear();
        out.values.resize(right.len(), 0.0);
        rest.clone_from(right);
        for pass in 1..=passes {
            matrix.solve(rest);
            out.values.iter_mut().zip(&*rest).for_each(|(value, step)| *value += step);
            self.island.apply(&out.values, &mut out.rows);
            if pass == passes {
                break;
            }
            let terms = right.iter().zip(&out.values).zip(&self.weights);
            rest.clear();
            rest.extend(terms.map(|((right, y), a)| right - a * y));
            pull.clear();
            pull.extend(out.rows.iter().zip(&*stiffness).map(|(row, d)| -row * d));
            self.island.add_transposed(pull, rest);
            if largest(rest) <= REFINED * largest(right) {
                break;
            }
        }
    }

    /// How far slack and multipliers stay above zero, at most 1.
    pub fn reach(&self, direction: &Direction) -> f64 {
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

    pub fn advance(&mut self, direction: &Direction, length: f64) {
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
