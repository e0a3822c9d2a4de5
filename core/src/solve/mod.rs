//! The representability problem: change the samples as little as possible so that every texel can be stored.
//!
//! ```text
//! minimize Σ_p a_p x_p²   subject to   0 <= k + wᵀ (c + x) <= 1   for every rule (k, w)
//! ```
//!
//! `c` are the wanted samples of one level, `x` their change, `a` sample areas. MCT 3.4 solves this face by
//! face, which can tear what two faces share; here the whole level is one problem.

mod hildreth;
#[cfg(test)]
mod tests;

pub use hildreth::{Problem, Solution, TOLERANCE, solve};
