//! One conversion or check as the command line and the service both do it: the conversion, the picture,
//! the clocks, the bundle.

use std::path::Path;
use std::thread::available_parallelism;

use meshcolor::measure::Report;
use meshcolor::pipeline::{self, ENGINE_VERSION};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Stage;
use meshcolor::write::BundleFile;
use meshcolor::{Error, Result};
use serde_json::{Value, json};

use crate::bundle;
use crate::clock::Timestamp;
use crate::jobs::model::JobOptions;
use crate::sheet::{self, Sheet};
use crate::tradeoff;
use crate::watch::{JobWatch, PREVIEW_STAGE};

/// What a conversion leaves.
pub struct Converted {
    /// Every file of the bundle, the manifest first.
    pub files: Vec<BundleFile>,
    pub report: Report,
    pub preview: Preview,
}

/// What became of the picture.
pub enum Preview {
    /// Nobody asked for it.
    Skipped,
    Drawn {
        png: Vec<u8>,
    },
    /// The conversion stands; the picture could not be drawn, for this reason.
    Failed {
        reason: String,
    },
}

/// The processors that this process may use.
pub fn processor_count() -> usize {
    available_parallelism().map_or(1, usize::from)
}

/// A pool for conversions. Its threads get the stack that a main thread has, since models nest.
pub fn thread_pool(threads: usize) -> anyhow::Result<rayon::ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(8 << 20)
        .thread_name(|index| format!("convert-{index}"))
        .build()?;
    Ok(pool)
}

/// Converts on the threads of the pool that calls it.
///
/// # Errors
/// Those of [`pipeline::convert`].
pub fn convert(
    upload: &Upload,
    options: &JobOptions,
    limits: &Limits,
    watch: &JobWatch,
) -> Result<Converted> {
    let started_at = Timestamp::now();
    let mut conversion = {
        // With the rungs to come, the conversion is one of many.
        let share = if options.tradeoff { FIRST_OF_MANY } else { 1.0 };
        pipeline::convert(upload, &options.conversion, limits, &watch.part(0.0, share))?
    };
    let mut files = std::mem::take(&mut conversion.files);
    let title = title(&upload.main);
    let sheet = if options.preview {
        watch.enter(PREVIEW_STAGE);
        Some(sheet::draw(&conversion, &title).map_err(|error| format!("{error:#}")))
    } else {
        None
    };
    files.extend(sheet::shaders(&conversion.finished));
    if options.tradeoff {
        drop(conversion.finished);
        let read = watch.finish().into_iter().find(|figures| figures.stage == Stage::Read.name());
        let subject = tradeoff::Subject { model: &title, asset: &conversion.asset, read };
        let manner = tradeoff::Manner { limits, repeat_count: 1, done: FIRST_OF_MANY };
        let record = tradeoff::run(&subject, &options.conversion, &manner, watch)?;
        files.extend(tradeoff::files(&record, "tradeoff/")?);
    }
    let run = run_json(watch, started_at, sheet.as_ref());
    files.push(bundle::json_file("run.json", &run));
    let preview = match sheet {
        None => Preview::Skipped,
        Some(Err(reason)) => Preview::Failed { reason },
        Some(Ok(sheet)) => {
            files.push(BundleFile { path: "preview.png".to_owned(), bytes: sheet.png.clone() });
            Preview::Drawn { png: sheet.png }
        }
    };
    let files = bundle::with_manifest(files, &options.to_json());
    Ok(Converted { files, report: conversion.report, preview })
}

/// Share of a job with `tradeoff` that its own conversion is.
const FIRST_OF_MANY: f32 = 0.08;

/// What stands over pictures: the model's file name without its ending, cut where it would leave the page.
pub fn title(main: &str) -> String {
    const TITLE_CHARS: usize = 64;
    let name = Path::new(main).file_stem().unwrap_or_default().to_string_lossy();
    name.chars().filter(|c| !c.is_control()).take(TITLE_CHARS).collect()
}

/// Measures on the threads of the pool that calls it.
///
/// # Errors
/// Those of [`pipeline::check`].
pub fn check(upload: &Upload, options: &JobOptions, limits: &Limits, watch: &JobWatch) -> Result<Report> {
    pipeline::check(upload, &options.conversion, limits, watch)
}

/// The report as its file holds it.
pub fn report_bytes(report: &Report) -> Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec_pretty(report)
        .map_err(|error| Error::internal(format!("the report cannot be written: {error}")))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// What is not a function of the input.
fn run_json(
    watch: &JobWatch,
    started_at: Timestamp,
    sheet: Option<&std::result::Result<Sheet, String>>,
) -> Value {
    let stages = watch.finish();
    let seconds: f64 = stages.iter().map(|stage| stage.seconds).sum();
    let cpu_seconds: f64 = stages.iter().map(|stage| stage.cpu_seconds).sum();
    let peak_memory_bytes = stages.iter().filter_map(|stage| stage.peak_memory_bytes).max();
    let preview = match sheet {
        None => json!({ "state": "skipped" }),
        Some(Ok(sheet)) => json!({ "state": "drawn", "renderer": sheet.renderer }),
        Some(Err(reason)) => json!({ "state": "failed", "reason": reason }),
    };
    json!({
        "engine_version": ENGINE_VERSION,
        "started_at": started_at.to_string(),
        "finished_at": Timestamp::now().to_string(),
        "machine": {
            "os": std::env::consts::OS,
            "architecture": std::env::consts::ARCH,
            "processor_count": processor_count(),
        },
        "thread_count": rayon::current_num_threads(),
        // CPU time and memory hold whatever else the process did meanwhile.
        "scope": "process",
        "seconds": seconds,
        "cpu_seconds": cpu_seconds,
        "peak_memory_bytes": peak_memory_bytes,
        "stages": stages,
        "preview": preview,
    })
}
