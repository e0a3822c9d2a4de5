//! The table of contents: one asset's journey through the stages.

mod assemble;
mod channel;
mod material;
pub mod options;
mod progress;

pub use options::{OPTIONS, OptionSpec, Options, Resolution, Sampling, Solver};

use glam::Vec3;

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

/// A place on a seam of the source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    pub mesh: usize,
    pub primitive: usize,
    /// Middle and ends of the edge in mesh space.
    pub position: Vec3,
    pub ends: [Vec3; 2],
    /// Mean of the normals of the faces at the edge, mesh space, unit length.
    pub normal: Vec3,
    /// Material channel that shows it most, an index into `Finished::textures`.
    pub texture: usize,
    /// Jump of the source at each of its levels, codes, mean along the edge.
    pub source_jumps_codes: [f32; 8],
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
