//! One island of rules by a feasible primal-dual interior point method.
//!
//! (S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optimization 2,
//! 1992.) It starts between the wanted values and the constant that keeps every rule and never leaves the
//! rules, so whatever it ends with can be stored. The number of steps hardly depends on how the rules lean on each other, which first-
//! order methods cannot say: beyond vertex colors the rules of a face are nearly parallel.

use super::island::Island;
use super::matrix::Matrix;
use super::problem::TOLERANCE;
use super::step::{Direction, Room};

/// Mean of slack times multiplier, and largest entry of the gradient, at which a solution may be good: a
/// change in the order of 1e-6.
const COMPLEMENTARITY: f64 = 1e-6;
const STATIONARITY: f64 = 1e-6;
/// Share of the objective that it may still fall by; below [`TIGHT`] nobody asks.
const GAP: f64 = 5e-4;
/// Mean of slack times multiplier at which a solution of any size is good.
const TIGHT: f64 = 1e-13;
/// Below this steps only lose digits.
const EXHAUSTED: f64 = 1e-14;
const STEPS_MAX: u64 = 60;

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
pub(super) struct Iterate<'a> {
    pub(super) island: &'a Island,
    pub(super) wanted: Vec<f64>,
    pub(super) weights: Vec<f64>,
    pub(super) values: Vec<f64>,
    /// Distance to the low bounds, then to the high ones.
    pub(super) slack: [Vec<f64>; 2],
    pub(super) multipliers: [Vec<f64>; 2],
    /// `a (y - c) - Wᵀ (z_low - z_high)`, zero at the optimum; kept up to date.
    pub(super) gradient: Vec<f64>,
    pub(super) room: Room,
    /// Something by row, for a moment.
    scratch: Vec<f64>,
}

impl<'a> Iterate<'a> {
    /// Starts as far from the wanted values, on the way to the center, as every rule needs to hold with about
    /// as much room as it lacked: where little is missing, the optimum is near.
    fn new(island: &'a Island, wanted: Vec<f64>, weights: Vec<f64>, center: f64) -> Self {
        /// Start of slack times multiplier: at most what a change of a tenth is worth, and less where the
        /// wanted values lack less; a start that is too low costs more steps than one that is too high.
        const START: f64 = 1e-2;
        const START_OF_LACK: f64 = 10.0;
        // The largest lack of a texel, which at the center has half a range to spare, and of a unit row.
        let (mut lack, mut unit_lack): (f64, f64) = (0.0, 0.0);
        for row in 0..island.row_count() {
            let value = island.row_of(row, &wanted);
            let by = (island.low()[row] - value).max(value - island.high()[row]);
            let by = by.max(TOLERANCE * island.scale(row));
            unit_lack = unit_lack.max(by);
            lack = lack.max(by / island.scale(row));
        }
        let share = (2.0 * lack / (0.5 + lack)).min(1.0);
        let mean_weight = weights.iter().sum::<f64>() / weights.len() as f64;
        let start = (START_OF_LACK * mean_weight * unit_lack * unit_lack).min(START);
        let mut iterate = Self {
            island,
            values: wanted.iter().map(|value| value + share * (center - value)).collect(),
            wanted,
            weights,
            slack: Default::default(),
            multipliers: Default::default(),
            gradient: Vec::new(),
            room: Room::default(),
            scratch: Vec::new(),
        };
        iterate.update_slack();
        iterate.multipliers = [0, 1].map(|side| iterate.slack[side].iter().map(|s| start / s).collect());
        iterate.update_gradient();
        iterate
    }

    fn update_slack(&mut self) {
        let Self { island, scratch, slack, .. } = self;
        island.apply(&self.values, scratch);
        slack[0] = scratch.iter().zip(island.low()).map(|(row, low)| row - low).collect();
        slack[1] = scratch.iter().zip(island.high()).map(|(row, high)| high - row).collect();
    }

    pub(super) fn update_gradient(&mut self) {
        let terms = self.values.iter().zip(&self.wanted).zip(&self.weights);
        self.gradient.clear();
        self.gradient.extend(terms.map(|((y, c), a)| a * (y - c)));
        let [low, high] = &self.multipliers;
        self.scratch.clear();
        self.scratch.extend(low.iter().zip(high).map(|(low, high)| high - low));
        self.island.add_transposed(&self.scratch, &mut self.gradient);
    }

    pub(super) fn complementarity(&self) -> f64 {
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
        self.is_sound() && (self.complementarity() <= TIGHT || self.excess() <= GAP * self.objective())
    }

    /// How far the objective is above the optimum, at most: twice the duality gap, which is the sum of all
    /// products, and what the gradient can still win.
    fn excess(&self) -> f64 {
        let products = 2.0 * self.island.row_count() as f64 * self.complementarity();
        let gradient: f64 = self.gradient.iter().zip(&self.weights).map(|(g, a)| g * g / a).sum();
        2.0 * products + gradient
    }
}
