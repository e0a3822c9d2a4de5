//! The table of contents: one asset's journey through the stages.

mod assemble;
mod channel;
mod material;
pub mod options;
mod progress;
#[cfg(test)]
mod tests;

pub use crate::measure::Focus;
pub use options::{OPTIONS, OptionSpec, Options, Resolution, Sampling, Solver};

use crate::asset::Asset;
use crate::error::{Error, ErrorCode, Result};
use crate::finished::Finished;
use crate::measure::Report;
use crate::read::{Limits, Upload, read};
use crate::watch::{Stage, Watch};
use crate::write::BundleFile;

use assemble::assemble;
use material::{MaterialConversion, convert_material};
use progress::Progress;

/// Share of the whole journey that is the conversion itself; measuring and writing follow.
const CONVERSION_SHARE: f32 = 0.7;

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
    upload: &Upload,
    options: &Options,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<Conversion> {
    watch.stage(Stage::Read);
    let asset = read(upload, limits, watch)?;
    convert_asset(asset, options, limits, watch)
}

/// Converts a model that has been read.
pub fn convert_asset(
    asset: Asset,
    options: &Options,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<Conversion> {
    let mut progress = Progress::new(watch);
    let mut materials = convert_materials(&asset, options, limits, watch, &mut progress)?;
    let _finished = assemble(&asset, &mut materials);
    Err(Error::internal("measuring and writing are not joined yet"))
}

/// Every material that has something to convert, in order.
fn convert_materials(
    asset: &Asset,
    options: &Options,
    limits: &Limits,
    watch: &dyn Watch,
    progress: &mut Progress<'_>,
) -> Result<Vec<MaterialConversion>> {
    let mut materials = Vec::new();
    for material in 0..asset.materials.len() {
        progress.part(CONVERSION_SHARE / asset.materials.len() as f32);
        materials.extend(convert_material(asset, material, options, limits, watch, progress)?);
    }
    if materials.is_empty() {
        let detail = format!(
            "the model has {} materials and none of them has both a texture in one of the five core slots and faces; \
             give it a textured material",
            asset.materials.len()
        );
        return Err(Error::new(ErrorCode::NothingToConvert, detail).at("/materials"));
    }
    Ok(materials)
}

/// Measures a model: a converted file by its own coordinates, a plain source by its mip maps.
pub fn check(_upload: &Upload, _options: &Options, _limits: &Limits, _watch: &dyn Watch) -> Result<Report> {
    Err(Error::internal("checking is not written yet"))
}
