//! `meshcolor convert`: one model into a bundle, without a server.

use std::fs::File;
use std::io::{Cursor, Write, stdout};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use meshcolor::measure::Verdict;
use tokio::sync::watch;

use super::Outcome;
use super::arguments::{ConversionFlags, RunFlags};
use super::bars::Bar;
use super::interrupt::Interrupt;
use super::outcome::in_file;
use super::replace::{BUNDLE_MARK, Sibling, check_free};
use crate::jobs::model::JobOptions;
use crate::settings::ModelLimits;
use crate::watch::{JobWatch, Progress, Stop};
use crate::work::{self, Converted, Preview};
use crate::{bundle, input};

#[derive(clap::Args)]
pub struct Arguments {
    /// The model: .glb, .gltf, .obj, .ply or .zip; `-` is standard input
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// Where the bundle goes: a folder, or a zip file when it ends in .zip; `-` is a zip on standard output
    #[arg(short = 'o', long, env = "MESHCOLOR_OUT", value_name = "OUT")]
    out: PathBuf,
    /// Replace a bundle that is there already
    #[arg(long, env = "MESHCOLOR_FORCE")]
    force: bool,
    /// Leave the seam-check sheet out
    #[arg(long, env = "MESHCOLOR_NO_PREVIEW")]
    no_preview: bool,
    #[command(flatten)]
    conversion: ConversionFlags,
    #[command(flatten)]
    run: RunFlags,
    #[command(flatten)]
    limits: ModelLimits,
}

pub fn run(arguments: Arguments) -> anyhow::Result<Outcome> {
    let quiet = arguments.run.quiet;
    crate::logging::start(if quiet { "error" } else { "warn" });
    let options = JobOptions {
        conversion: arguments.conversion.options()?,
        preview: !arguments.no_preview,
        tradeoff: false,
    };
    let to_stdout = arguments.out == Path::new("-");
    let is_zip = arguments.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("zip"));
    if !to_stdout {
        check_free(&arguments.out, is_zip, arguments.force, BUNDLE_MARK)?;
    }
    let shown = arguments.input.display().to_string();
    let stop = Arc::new(Stop::default());
    let interrupt = Interrupt::listen(stop.clone())?;
    let upload = input::open(&arguments.input)?;
    let (sender, progress) = watch::channel(Progress::default());
    let watch = JobWatch::new(stop, sender);
    let bar = Bar::follow(shown.clone(), progress, quiet);
    let pool = work::thread_pool(arguments.run.threads)?;
    let limits = &arguments.limits.0;
    let done = pool.install(|| work::convert(&upload, &options, limits, &watch));
    drop(bar);
    let written = done.map_err(|error| in_file(&arguments.input, error).into()).and_then(|done| {
        write(&arguments.out, to_stdout, is_zip, &done)?;
        Ok(done)
    });
    match written {
        Ok(done) => {
            if !quiet {
                tell(&arguments.out, &done);
            }
            Ok(Outcome::Fine)
        }
        Err(error) => Ok(interrupt.over(Outcome::of_error(&error))),
    }
}

fn write(out: &Path, to_stdout: bool, is_zip: bool, done: &Converted) -> anyhow::Result<()> {
    if to_stdout {
        let mut zip = Cursor::new(Vec::new());
        bundle::write_zip(&done.files, &mut zip)?;
        stdout().lock().write_all(zip.get_ref()).context("standard output")?;
        return Ok(());
    }
    let sibling = Sibling::of(out)?;
    let written = if is_zip {
        let file = File::create(sibling.path()).map_err(anyhow::Error::from);
        file.and_then(|file| bundle::write_zip(&done.files, file))
    } else {
        bundle::write_folder(&done.files, sibling.path())
    };
    written.with_context(|| format!("cannot write {}", out.display()))?;
    sibling.rename_to(out)
}

fn tell(out: &Path, done: &Converted) {
    let report = &done.report;
    let verdict = match report.verdict {
        Verdict::Pass => "pass",
        Verdict::Warn => "warn",
        Verdict::Fail => "fail",
    };
    eprintln!(
        "{}: {verdict}, largest seam {:.3} codes on uncut edges",
        out.display(),
        report.max_seam_delta_codes
    );
    for error in &report.errors {
        eprintln!("  error: {error}");
    }
    for warning in &report.warnings {
        eprintln!("  warning: {} ({}, {} of them)", warning.detail, warning.pointer, warning.count);
    }
    eprint!("{}", super::text::compression(report));
    if let Preview::Failed { reason } = &done.preview {
        eprintln!("  no picture: {reason}");
    }
}
