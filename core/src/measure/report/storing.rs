//! What was changed so that texels can be stored: by the solver, and by rounding to a range.

use serde::{Deserialize, Serialize};

/// What the representability solver did on one level.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverReport {
    pub level: u32,
    /// Constrained texel components.
    pub row_count: u64,
    /// Of these, out of range before the solve.
    pub violated_count: u64,
    pub iteration_count: u64,
    /// Largest violation that is left, linear values.
    pub residual: f64,
    /// Largest entry of the stationarity condition that is left (weights of mean 1).
    #[serde(default)]
    pub dual_residual: f64,
    /// Largest mean product of slack and multiplier that is left.
    #[serde(default)]
    pub complementarity: f64,
    /// Change of the samples, in codes.
    pub change_mean_codes: f64,
    #[serde(default)]
    pub change_p95_codes: f64,
    pub change_max_codes: f64,
    /// Largest violation that the solver lets pass, linear values.
    #[serde(default)]
    pub tolerance: f64,
    /// When it stopped, in words.
    #[serde(default)]
    pub stop_rule: String,
    /// What was to be made least: squares of the samples' changes in linear values times their areas (mean
    /// 1), summed. Of a sample that faces store differently, the version that was changed most.
    #[serde(default)]
    pub objective: f64,
    /// The same figures by stored component; a normal's three are one.
    #[serde(default)]
    pub components: Vec<SolverComponent>,
}

/// What storing did to the samples of one level in a range of its own. What the solver did before is in
/// [`SolverReport`]: there it is few samples that no range is wide enough for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StoredReport {
    pub level: u32,
    /// `scaled16` or `float16`.
    pub range: String,
    /// Change of the samples, as they are read back, in codes.
    pub change_mean_codes: f64,
    pub change_p95_codes: f64,
    pub change_max_codes: f64,
}

/// One component of one level. Those that want the same values are solved once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverComponent {
    pub variable_count: u64,
    pub violated_count: u64,
    pub iteration_count: u64,
    pub objective: f64,
    pub residual: f64,
    pub dual_residual: f64,
    pub complementarity: f64,
}
