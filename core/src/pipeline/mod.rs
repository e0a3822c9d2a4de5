//! The table of contents: one asset's journey through the stages.

pub mod options;

pub use crate::measure::Focus;
pub use options::{OPTIONS, OptionSpec, Options, Resolution, Sampling, Solver};

use crate::asset::Asset;
use crate::error::{Error, Result};
use crate::finished::Finished;
use crate::measure::Report;
use crate::read::{Limits, Upload};
use crate::watch::Watch;
use crate::write::BundleFile;

/// The version that stands in reports and manifests.
pub const ENGINE_VERSION: &str = env!("CARGO_PKG_VERSION");

/// What a conversion returns.
pub struct Conversion {
    pub asset: Asset,
    pub finished: Finished,
    pub report: Report,
    /// `asset.glb` and `report.json`, deterministic to the byte.
    pub files: Vec<BundleFile>,
    /// Where a picture should look: the edge on which the source's mip maps disagree most although its
    /// level 0 agrees.
    pub focus: Option<Focus>,
}

/// Converts a model.
///
/// # Errors
/// Input errors of [`crate::read::read`]; `InvalidOptions`, `TextureTooLarge`, `NothingToConvert`,
/// `Canceled`.
pub fn convert(
    _upload: &Upload,
    _options: &Options,
    _limits: &Limits,
    _watch: &dyn Watch,
) -> Result<Conversion> {
    Err(Error::internal("conversion is not written yet"))
}

/// Measures a model: a converted file by its own coordinates, a plain source by its mip maps.
pub fn check(_upload: &Upload, _options: &Options, _limits: &Limits, _watch: &dyn Watch) -> Result<Report> {
    Err(Error::internal("checking is not written yet"))
}
