//! The table of contents: one asset's journey through the stages.

mod arrange;
mod assemble;
mod attributes;
mod bare_normals;
mod changes;
mod channel;
mod compression;
pub(crate) mod form;
mod group;
mod levels;
mod material;
pub mod options;
pub(crate) mod painted;
pub(crate) mod prepare;
mod progress;
pub mod reference;
mod report;
mod represent;
#[cfg(test)]
mod tests;
mod together;
mod vertex_colors;

pub use crate::assign::{Range, Rounding};
pub use crate::layout::{Coordinates, Packing};
pub use crate::measure::Focus;
pub use crate::mip::{Beyond, MipFilter};
pub use crate::resample::{Resolution, Sampling};
pub use crate::solve::Solver;
pub use crate::write::GeometryFormat;
pub use crate::write::textures::{BlockFormat, TextureFormat};
pub use options::{OPTIONS, OptionSpec, Options, Quality};
pub use prepare::{Content, Prepared, prepare};
pub use vertex_colors::VertexColors;

use crate::asset::Asset;
use crate::error::{Error, ErrorCode, Result, Warning};
use crate::finished::{self, Finished};
use crate::measure::{self, Report, SubjectKind};
use crate::read::{Limits, Upload, read, read_with};
use crate::source::channels;
use crate::watch::{self, Stage, Watch};
use crate::write::{self, BundleFile};

use arrange::arrange_all;
use assemble::assemble;
use group::{groups, sets};
use material::{MaterialConversion, convert_material};
use progress::Progress;
use reference::{Reference, with_filters};

/// Shares of the whole journey; writing has the rest.
const READ_SHARE: f32 = 0.05;
const CONVERSION_SHARE: f32 = 0.7;
const MEASURE_SHARE: f32 = 0.15;
/// Of the conversion: what comes before any channel's samples.
const PREPARED_SHARE: f32 = 0.2;
/// How many of reading's warnings an error repeats.
const TOLD_COUNT: usize = 3;

/// The version that stands in reports and manifests.
pub const ENGINE_VERSION: &str = env!("CARGO_PKG_VERSION");

/// What a conversion returns.
pub struct Conversion {
    pub asset: Asset,
    pub finished: Finished,
    pub report: Report,
    /// `asset.glb`, `report.json` and the loose textures asked for, deterministic to the byte.
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
pub fn convert(upload: &Upload, options: &Options, limits: &Limits, watch: &dyn Watch) -> Result<Conversion> {
    watch.stage(Stage::Read);
    let asset = read_with(upload, &options.channels, limits, watch)?;
    convert_asset(asset, options, limits, watch)
}

/// Converts a model that has been read.
///
/// # Errors
/// As [`convert`], without those of reading.
pub fn convert_asset(
    asset: Asset,
    options: &Options,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<Conversion> {
    let Product { finished, report, files, focus } = convert_read(&asset, options, limits, watch)?;
    Ok(Conversion { asset, finished, report, files, focus })
}

/// A [`Conversion`] apart from its model.
pub struct Product {
    pub finished: Finished,
    pub report: Report,
    pub files: Vec<BundleFile>,
    pub focus: Option<Focus>,
}

/// Converts a model that other conversions still need.
///
/// # Errors
/// As [`convert_asset`].
pub fn convert_read(asset: &Asset, options: &Options, limits: &Limits, watch: &dyn Watch) -> Result<Product> {
    options.check()?;
    attributes::check(asset, options)?;
    let mut progress = Progress::new(watch);
    progress.part(1.0);
    progress.advance(READ_SHARE);
    let takers = vertex_colors::takers(asset, options.vertex_colors);
    let (mut materials, sets) = convert_materials(asset, options, limits, watch, &mut progress)?;
    let painted = match options.mesh_colors {
        true => painted::materials(asset, &mut materials, &takers),
        false => Vec::new(),
    };
    watch.stage(Stage::Layout);
    let groups = groups(&materials, sets, options)?;
    let finished = Finished { vertex_colors: takers, ..assemble(asset, &mut materials, &groups) };
    watch.stage(Stage::Measure);
    let extras = report::extras(&materials, &groups);
    let references = Reference::finest(asset, watch)?;
    let measured =
        with_filters(&references, |painted| measure::converted(asset, &finished, painted, &extras, watch))??;
    drop(references);
    progress.part(1.0);
    progress.advance(MEASURE_SHARE);
    let blocks = compression::compress(asset, &finished, &measured.channels, options, watch)?;
    let pngs = write::encode(&finished, watch)?;
    let compressed = blocks.as_ref().map(|blocks| &blocks.compressed);
    let source = write::textures::Source { asset, finished: &finished, pngs: &pngs, compressed };
    let loose = write::textures::files(&source, &options.textures, watch)?;
    let glb = write::glb_of(asset, &finished, pngs, options.geometry, watch)?;
    let focus = measured.focus;
    let converted = report::Converted { asset, finished: &finished, materials: &materials, groups: &groups };
    let mut report = report::of_conversion(&converted, measured, options, &glb);
    report.warnings.extend(vertex_colors::warnings(asset, options.vertex_colors, &finished.vertex_colors));
    report.compression = blocks.map(|blocks| blocks.reports).unwrap_or_default();
    let mut files = vec![
        BundleFile { path: "asset.glb".into(), bytes: glb.bytes },
        BundleFile { path: "report.json".into(), bytes: report::to_bytes(&report)? },
    ];
    if !painted.is_empty() {
        let bytes = write::mesh_colors_glb(asset, &painted, None, watch)?;
        files.push(BundleFile { path: "mesh_colors.glb".into(), bytes });
    }
    files.extend(loose);
    watch.progress(1.0);
    Ok(Product { finished, report, files, focus })
}

/// Every material that has something to convert, in order, and which of them are to have their textures in common.
fn convert_materials(
    asset: &Asset,
    options: &Options,
    limits: &Limits,
    watch: &dyn Watch,
    progress: &mut Progress<'_>,
) -> Result<(Vec<MaterialConversion>, Vec<Vec<usize>>)> {
    let takers = vertex_colors::takers(asset, options.vertex_colors);
    let of_material = |material: usize| channels(asset, material, takers.contains(&material));
    let channels: Vec<_> = (0..asset.materials.len()).map(of_material).collect();
    let mut prepared = Vec::new();
    watch.stage(Stage::Resample);
    for (material, channels) in channels.iter().enumerate() {
        watch::check(watch)?;
        prepared.extend(prepare(asset, material, channels, options, watch)?);
    }
    if prepared.is_empty() {
        let detail = format!(
            "the model has {} materials and none of them has both faces and something to convert: a texture in one of the five \
             core slots, a channel, mesh colors, or vertex colors ({}); give it a textured material, or an image by `channel`{}",
            asset.materials.len(),
            vertex_colors::rule(options.vertex_colors),
            told_of(&asset.warnings)
        );
        return Err(Error::new(ErrorCode::NothingToConvert, detail).at("/materials"));
    }
    progress.part(CONVERSION_SHARE);
    progress.advance(PREPARED_SHARE);
    watch.stage(Stage::Layout);
    let sets = sets(&prepared, options.merges);
    let arranged = arrange_all(asset, &prepared, &sets, options, limits, watch)?;
    progress.part(CONVERSION_SHARE * (1.0 - PREPARED_SHARE) / prepared.len() as f32);
    let each = prepared.into_iter().zip(arranged);
    let converted: Result<_> = each
        .map(|(prepared, arranged)| convert_material(asset, prepared, arranged, options, watch, progress))
        .collect();
    Ok((converted?, sets))
}

/// What reading left out may be why nothing is left; the first few say so.
fn told_of(warnings: &[Warning]) -> String {
    let one = |warning: &Warning| {
        format!(". While reading: {} ({}, {} of them)", warning.detail, warning.pointer, warning.count)
    };
    warnings.iter().take(TOLD_COUNT).map(one).collect()
}

/// Measures a model: a converted file by its own coordinates, a plain source by its mip maps. Of mesh colors it holds faces, exponents,
/// cuts and samples against each other.
///
/// # Errors
/// Input errors of [`crate::read::read`], and `InvalidModel` where a converted file or mesh colors contradict themselves.
pub fn check(upload: &Upload, options: &Options, limits: &Limits, watch: &dyn Watch) -> Result<Report> {
    watch.stage(Stage::Read);
    let asset = read(upload, limits, watch)?;
    let finished = finished::extract(&asset)?;
    watch.progress(READ_SHARE);
    watch.stage(Stage::Measure);
    let report = match finished {
        Some(finished) => {
            let measured = measure::converted_file(&asset, &finished, watch)?;
            report::of_check(&asset, SubjectKind::Converted, Some(&finished), measured, options)
        }
        None => {
            let mesh_colors = painted::checked(&asset)?;
            let kind = if mesh_colors.is_empty() { SubjectKind::Source } else { SubjectKind::MeshColors };
            let measured = measure::source(&asset, watch)?;
            Report { mesh_colors, ..report::of_check(&asset, kind, None, measured, options) }
        }
    };
    watch.progress(1.0);
    Ok(report)
}
