//! Source to mesh colors: how many samples a face gets, which edges stay cut, and each sample's value.

mod cuts;
mod fitted;
mod gather;
mod mass;
mod quadrature;
mod resolution;
mod samples;
mod shape;
#[cfg(test)]
mod tests;

pub use cuts::find_cuts;
pub use resolution::{Resolution, resolutions};
pub use fitted::Fit;
pub use samples::{Samples, Sampling, sample};
