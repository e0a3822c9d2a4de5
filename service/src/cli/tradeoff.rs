//! `meshcolor tradeoff`: one model by every rung and by budgets of texels, as a record, tables and pictures.

use std::io::{Write, stdout};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use meshcolor::pipeline::Options;
use meshcolor::read::{Upload, read_with};
use meshcolor::watch::{Stage, Watch};
use tokio::sync::watch;

use super::Outcome;
use super::arguments::{ConversionFlags, RunFlags};
use super::bars::Bar;
use super::interrupt::Interrupt;
use super::outcome::in_file;
use super::replace::{Sibling, check_free};
use crate::settings::ModelLimits;
use crate::tradeoff::{self, Manner, RECORD_FILE, Subject, Tradeoff};
use crate::watch::{JobWatch, Progress, Stop};
use crate::{bundle, input, sample, work};

#[derive(clap::Args)]
#[command(after_help = "\
Runs the presets draft, standard and exact, and standard with each rung of each ladder in turn: 15 \
conversions, one more where rungs are named. Then 9 for the curve of texels against error: by area, and by budgets with \
point and with fitted samples; these run once. Writes tradeoff.json, tradeoff.md, tradeoff.svg and .png, curve.svg and .png. \
--cut holds for all runs, and so does --resolution where it is not the preset's. A rung that cannot be had on the model is a \
row with its reason. Times are CPU seconds of the process.")]
pub struct Arguments {
    /// The model: .glb, .gltf, .obj, .ply or .zip; `-` is standard input; without one, the demo's sample
    #[arg(value_name = "MODEL")]
    input: Option<PathBuf>,
    /// The folder that the record, the tables and the pictures go to
    #[arg(short = 'o', long, env = "MESHCOLOR_OUT", value_name = "FOLDER")]
    out: PathBuf,
    /// Replace an earlier tradeoff that is there
    #[arg(long, env = "MESHCOLOR_FORCE")]
    force: bool,
    /// Print the record as JSON on standard output
    #[arg(long, env = "MESHCOLOR_JSON")]
    json: bool,
    /// Convert this often by each rung and keep the fastest
    #[arg(long, env = "MESHCOLOR_REPEAT", value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    repeat: u32,
    #[command(flatten)]
    conversion: ConversionFlags,
    #[command(flatten)]
    run: RunFlags,
    #[command(flatten)]
    limits: ModelLimits,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let quiet = arguments.run.quiet;
    crate::logging::start(if quiet { "error" } else { "warn" });
    let options = arguments.conversion.options()?;
    check_free(&arguments.out, false, arguments.force, RECORD_FILE)?;
    let shown = arguments.input.as_ref().map_or("sample".to_owned(), |path| path.display().to_string());
    let stop = Arc::new(Stop::default());
    let interrupt = Interrupt::listen(stop.clone())?;
    let upload = match &arguments.input {
        Some(path) => input::open(path)?,
        None => Upload::single("sample.glb", sample::model()),
    };
    let (sender, progress) = watch::channel(Progress::default());
    let watch = JobWatch::new(stop, sender);
    let bar = Bar::follow(shown.clone(), progress, quiet);
    let pool = work::thread_pool(arguments.run.threads)?;
    let done = pool.install(|| convert(arguments, &options, &upload, &watch));
    drop(bar);
    let done = done.map_err(|error| in_file(Path::new(&shown), error).into());
    match done.and_then(|record| Ok((write(&arguments.out, &record)?, record))) {
        Ok((json, record)) => {
            if arguments.json {
                stdout().lock().write_all(&json).context("standard output")?;
            }
            if !quiet {
                eprintln!("{}: {}", arguments.out.display(), tradeoff::headline(&record));
            }
            Ok(Outcome::Fine)
        }
        Err(error) => Ok(interrupt.over(Outcome::of_error(&error))),
    }
}

fn convert(
    arguments: &Arguments,
    options: &Options,
    upload: &Upload,
    watch: &JobWatch,
) -> meshcolor::Result<Tradeoff> {
    let limits = &arguments.limits.0;
    watch.stage(Stage::Read);
    let asset = read_with(upload, &options.channels, limits, watch)?;
    let subject =
        Subject { model: &work::title(&upload.main), asset: &asset, read: watch.finish().into_iter().next() };
    let manner = Manner { limits, repeat_count: arguments.repeat, done: 0.02 };
    tradeoff::run(&subject, options, &manner, watch)
}

/// Writes the folder and returns the record as its file holds it.
fn write(out: &Path, record: &Tradeoff) -> anyhow::Result<Vec<u8>> {
    let files = tradeoff::files(record, "")?;
    let sibling = Sibling::of(out)?;
    let written = bundle::write_folder(&files, sibling.path());
    written.with_context(|| format!("cannot write {}", out.display()))?;
    sibling.rename_to(out)?;
    let json = files.into_iter().find(|file| file.path == RECORD_FILE);
    Ok(json.map(|file| file.bytes).unwrap_or_default())
}
