//! `meshcolor edit`: changes a model that has mesh colors, and its samples with it.

use std::io::{Write, stdout};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use clap::{Args, Subcommand, ValueEnum};
use meshcolor::edit::{self, EditReport, Edited, ResolutionChange, Scheme, Selection};
use meshcolor::pipeline::MipFilter;
use meshcolor::read::{Limits, read};
use tokio::sync::watch;

use super::Outcome;
use super::arguments::RunFlags;
use super::bars::Bar;
use super::interrupt::Interrupt;
use super::outcome::{UsageError, in_file};
use super::replace::{BUNDLE_MARK, Sibling, check_free};
use crate::input;
use crate::settings::ModelLimits;
use crate::watch::{JobWatch, Progress, Stop};
use crate::work;

/// As a name of a file.
const STANDARD_OUTPUT: &str = "-";

#[derive(Args)]
pub struct Arguments {
    #[command(subcommand)]
    operation: Operation,
}

#[derive(Subcommand)]
enum Operation {
    /// Give faces more samples without a change of the picture, or fewer by the mip filter
    Resolution {
        /// Added to the exponents of a face: above 0 refines, below 0 coarsens
        #[arg(long, env = "MESHCOLOR_BY", value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(i8).range(-12..=12))]
        by: i8,
        /// What samples weigh the finer ones around them by
        #[arg(long, env = "MESHCOLOR_FILTER", default_value = "area")]
        filter: Filter,
        #[command(flatten)]
        faces: FaceFlags,
        #[command(flatten)]
        common: Common,
    },
    /// Take faces out of the model, of which some have to be left
    Delete {
        #[command(flatten)]
        faces: FaceFlags,
        #[command(flatten)]
        common: Common,
    },
    /// Split every face in four; colors are carried over as they are
    Subdivide {
        /// Where the new mesh's vertices lie
        #[arg(long, env = "MESHCOLOR_SCHEME", default_value = "midpoint")]
        scheme: SchemeName,
        #[command(flatten)]
        common: Common,
    },
    /// Paint another model with what this one shows at the nearest points, and measure the error
    Transfer {
        /// The model to paint: .glb, .gltf, .obj, .ply or .zip
        #[arg(long, env = "MESHCOLOR_TO", value_name = "MODEL")]
        to: PathBuf,
        /// Which painted material, where there are several
        #[arg(long, env = "MESHCOLOR_MATERIAL", value_name = "NUMBER")]
        material: Option<usize>,
        /// Twice, four times, … as many samples along a side as the source has for the length
        #[arg(long, env = "MESHCOLOR_FINER", value_name = "COUNT", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=12))]
        finer: u8,
        #[command(flatten)]
        common: Common,
    },
}

#[derive(Args)]
struct FaceFlags {
    /// Faces by number, as 0,3-7: triangles and quads of the material in the file's order, two triangles that are one
    /// quad counting once; all if left out
    #[arg(long, env = "MESHCOLOR_FACES", value_name = "LIST", value_parser = face_list)]
    faces: Option<FaceList>,
    /// Whose faces; needed with --faces where several materials have mesh colors
    #[arg(long, env = "MESHCOLOR_MATERIAL", value_name = "NUMBER")]
    material: Option<usize>,
}

/// Ranges, ends included.
#[derive(Clone, Debug, PartialEq, Eq)]
struct FaceList(Vec<[u32; 2]>);

#[derive(Args)]
struct Common {
    /// A model with mesh colors (`meshcolor convert --mesh-colors` writes mesh_colors.glb); `-` is standard input
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The .glb to write; `-` is standard output
    #[arg(short = 'o', long, env = "MESHCOLOR_OUT", value_name = "OUT")]
    out: PathBuf,
    /// Replace a file that is there already
    #[arg(long, env = "MESHCOLOR_FORCE")]
    force: bool,
    /// How what was done is said: as text on standard error, or as JSON on standard output
    #[arg(long, env = "MESHCOLOR_FORMAT", default_value = "text")]
    format: Format,
    #[command(flatten)]
    run: RunFlags,
    #[command(flatten)]
    limits: ModelLimits,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Filter {
    /// Nothing but their distance
    Uniform,
    /// The area that each stands for
    Area,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SchemeName {
    /// On the old faces
    Midpoint,
    /// On the surface of Loop's scheme; triangles only
    Loop,
    /// On the surface of Catmull and Clark's scheme; triangles become triangles
    CatmullClark,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Text,
    Json,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let common = arguments.operation.common();
    crate::logging::start(if common.run.quiet { "error" } else { "warn" });
    check_out(common)?;
    let stop = Arc::new(Stop::default());
    let interrupt = Interrupt::listen(stop.clone())?;
    let (sender, progress) = watch::channel(Progress::default());
    let watch = JobWatch::new(stop, sender);
    let shown = common.input.display().to_string();
    let bar = Bar::follow(shown.clone(), progress, common.run.quiet);
    let pool = work::thread_pool(common.run.threads)?;
    let done = pool.install(|| edited(&arguments.operation, &common.limits.0, &watch));
    drop(bar);
    let written = done.and_then(|edited| {
        write(&common.out, &edited.glb)?;
        Ok(edited)
    });
    match written {
        Ok(edited) => {
            match common.format {
                Format::Json => writeln!(stdout(), "{:#}", serde_json::to_value(&edited.report)?)?,
                Format::Text if !common.run.quiet => eprint!("{}", text(&common.out, &edited.report)),
                Format::Text => {}
            }
            Ok(Outcome::Fine)
        }
        Err(error) => Ok(interrupt.over(Outcome::of_error(&error))),
    }
}

fn edited(operation: &Operation, limits: &Limits, watch: &JobWatch) -> anyhow::Result<Edited> {
    let model = |path: &Path| {
        let asset = input::open(path).and_then(|upload| read(&upload, limits, watch));
        asset.map_err(|error| in_file(path, error))
    };
    let input = &operation.common().input;
    let asset = model(input)?;
    let edited = match operation {
        Operation::Resolution { by, filter, faces, .. } => {
            let filter = match filter {
                Filter::Uniform => MipFilter::Uniform,
                Filter::Area => MipFilter::Area,
            };
            edit::resolution(&asset, &faces.selection(), ResolutionChange { by: *by, filter }, limits, watch)
        }
        Operation::Delete { faces, .. } => edit::delete(&asset, &faces.selection(), limits, watch),
        Operation::Subdivide { scheme, .. } => {
            let scheme = match scheme {
                SchemeName::Midpoint => Scheme::Midpoint,
                SchemeName::Loop => Scheme::Loop,
                SchemeName::CatmullClark => Scheme::CatmullClark,
            };
            edit::subdivide(&asset, scheme, limits, watch)
        }
        Operation::Transfer { to, material, finer, .. } => {
            edit::transfer(&asset, *material, &model(to)?, *finer, limits, watch)
        }
    };
    Ok(edited.map_err(|error| in_file(input, error))?)
}

/// Refuses a name that the file cannot have.
fn check_out(common: &Common) -> anyhow::Result<()> {
    let out = &common.out;
    if out == Path::new(STANDARD_OUTPUT) {
        return match common.format {
            Format::Text => Ok(()),
            Format::Json => {
                let detail =
                    "`--format json` goes to standard output, and so does the file by `-o -`; name a file";
                Err(UsageError(detail.to_owned()).into())
            }
        };
    }
    if !out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb")) {
        let detail = format!("{} does not end in .glb, which is what is written; name it so", out.display());
        return Err(UsageError(detail).into());
    }
    check_free(out, true, common.force, BUNDLE_MARK)
}

fn write(out: &Path, glb: &[u8]) -> anyhow::Result<()> {
    if out == Path::new(STANDARD_OUTPUT) {
        return stdout().lock().write_all(glb).context("standard output");
    }
    let sibling = Sibling::of(out)?;
    std::fs::write(sibling.path(), glb).with_context(|| format!("cannot write {}", out.display()))?;
    sibling.rename_to(out)
}

fn text(out: &Path, report: &EditReport) -> String {
    let mut lines = String::new();
    for edit in &report.materials {
        lines += &format!(
            "{}: material {}: {} faces (before {}), {} samples (before {})\n",
            out.display(),
            edit.material,
            edit.face_count,
            edit.face_count_before,
            edit.sample_count,
            edit.sample_count_before
        );
    }
    let Some(transfer) = &report.transfer else { return lines };
    lines += &format!(
        "  distance: {:.4} in the mean, {:.4} at most; the source is {:.4} across\n",
        transfer.distance_rms, transfer.distance_max, transfer.source_diagonal
    );
    for channel in &transfer.channels {
        lines += &format!(
            "  {}, in {}: on the new surface {:.3} rms, {:.3} at most; at the old samples {:.3} rms, {:.3} at most\n",
            channel.slots.join(", "),
            channel.unit,
            channel.on_target_rms,
            channel.on_target_max,
            channel.on_source_rms,
            channel.on_source_max
        );
    }
    lines
}

impl Operation {
    fn common(&self) -> &Common {
        match self {
            Self::Resolution { common, .. }
            | Self::Delete { common, .. }
            | Self::Subdivide { common, .. }
            | Self::Transfer { common, .. } => common,
        }
    }
}

impl FaceFlags {
    fn selection(&self) -> Selection {
        Selection { material: self.material, faces: self.faces.as_ref().map(|list| list.0.clone()) }
    }
}

fn face_list(text: &str) -> Result<FaceList, String> {
    let number = |text: &str| text.trim().parse::<u32>().ok();
    let range = |part: &str| match part.split_once('-') {
        Some((first, last)) => Some([number(first)?, number(last)?]).filter(|[first, last]| first <= last),
        None => number(part).map(|face| [face, face]),
    };
    let ranges: Option<Vec<_>> = text.split(',').map(range).collect();
    ranges.map(FaceList).ok_or_else(|| "allowed: numbers and ranges of rising numbers, as 0,3-7".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_numbers_and_ranges() {
        assert_eq!(face_list("0,3-7, 9"), Ok(FaceList(vec![[0, 0], [3, 7], [9, 9]])));
        for wrong in ["", "a", "3-", "-3", "7-3", "1,,2", "1.5", "99999999999"] {
            assert!(face_list(wrong).unwrap_err().contains("0,3-7"), "{wrong}");
        }
    }
}
