//! Source to mesh colors: how many samples a face gets, which edges stay cut, and each sample's value.

mod cuts;
mod resolution;
mod samples;
#[cfg(test)]
mod tests;

pub use cuts::find_cuts;
pub use resolution::{Resolution, resolutions};
pub use samples::{Sampling, sample};
