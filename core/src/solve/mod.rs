//! The representability problem: change the samples as little as possible so that every texel can be stored.
//!
//! ```text
//! minimize Σ_p a_p x_p²   subject to   0 <= k + wᵀ (c + x) <= 1   for every rule (k, w)
//! ```
//!
//! `c` are the wanted samples of one level, `x` their change, `a` sample areas. MCT 3.4 solves this face by
//! face, which can tear what two faces share; here the whole level is one problem. Only what is out of range
//! is solved: rules come in when they are violated, and islands of rules that share no sample are problems
//! of their own.

mod global;
mod interior;
#[cfg(test)]
mod tests;

pub use global::{Problem, Solution, TOLERANCE, solve, violated_count};

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
