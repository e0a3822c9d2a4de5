//! Judges finished images: seams, drift, fidelity, waste. Knows nothing of how they were made, so it can
//! judge a file from anywhere.

pub mod report;

pub use report::*;
