//! Judges finished images: seams, drift, fidelity, waste. Knows nothing of how they were made, so it can
//! judge a file from anywhere: it pairs edges, decodes, filters and makes mip maps by itself.
//!
//! [`converted`], [`converted_file`] and [`source`] are the ways in, [`verdict`] holds the figures against
//! the bundle's guarantees.

mod averages;
mod cell_sums;
mod cells;
mod coarse_weights;
mod edges;
mod fidelity;
mod figures;
mod focus;
mod graph;
#[cfg(test)]
mod hand_made;
mod histogram;
mod judge;
mod layout;
mod mip_error;
mod mips;
mod origin;
mod original;
mod painted;
mod points;
pub mod report;
mod seams;
mod sets;
mod subject;
mod surface;
mod texels;
pub mod verdict;
mod yardstick;

pub use focus::Focus;
pub use report::*;
pub use subject::{ChannelExtras, Extras, Measured, SampleCounts, converted, converted_file, growth, source};
pub use verdict::{Judgement, judge};
pub use yardstick::Extent;
