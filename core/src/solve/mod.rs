//! The representability problem: change the samples as little as possible so that every texel can be stored.
//!
//! ```text
//! minimize Σ_p a_p x_p²   subject to   0 <= k + wᵀ (c + x) <= 1   for every rule (k, w)
//! ```
//!
//! `c` are the wanted samples of one level, `x` their change, `a` sample areas. One component of one level is
//! one [`Problem`]. `global` solves it as islands of the rules that bind, `exact` as a whole by a library,
//! and `local` as the papers do, which can tear what two faces share.

mod active;
mod exact;
mod fronts;
mod global;
mod interior;
mod island;
mod local;
mod matrix;
mod problem;
mod step;
#[cfg(test)]
mod tests;

pub use exact::{VARIABLES_MAX, solve_exactly};
pub use global::solve;
pub use local::{FaceChange, LocalSolution, solve_locally};
pub use problem::{Problem, Solution, TOLERANCE};

/// What is done about texels that the format cannot store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// No solve: they are clamped (shows the damage).
    Clamp,
    /// Face by face (MCT 3.4).
    Local,
    /// The whole level at once, to a stated tolerance.
    Global,
    /// The whole level at once by a library's interior point method.
    Exact,
}
