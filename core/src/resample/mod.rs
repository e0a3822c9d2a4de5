//! Source to mesh colors: how many samples a face gets, which edges stay cut, and each sample's value.
//!
//! The ladder of [`Sampling`] (method: samples from a source): a fetch at the sample, the source against the
//! sample's hat, or the fit of all samples at once.

mod agree;
mod budget;
mod cuts;
mod fitted;
mod gather;
mod mass;
mod meet;
mod pairing;
mod quadrature;
mod rate;
mod resolution;
mod samples;
#[cfg(test)]
mod tests;

pub use budget::{Candidates, Choice, Spent, spend};
pub use cuts::find_cuts;
pub use fitted::Fit;
pub use pairing::{pair_triangles, pair_triangles_in_space};
pub use rate::Rates;
pub use resolution::{Resolution, WantedExponents, wanted_exponents};
pub use samples::{Samples, Sampling, sample};

/// Rows of cells that are in work at once, and columns of one window of texels.
const BAND: u32 = 32;
