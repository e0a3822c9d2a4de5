//! `meshcolor check`: measures models and says so by text, JSON and exit code.

use std::fs;
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::ValueEnum;
use meshcolor::measure::{Report, SubjectKind, Verdict};
use serde_json::{Value, json};
use tokio::sync::watch;

use super::Outcome;
use super::arguments::{ConversionFlags, RunFlags};
use super::bars::Bar;
use super::interrupt::Interrupt;
use super::outcome::{UsageError, in_file};
use super::text::table;
use crate::input;
use crate::jobs::model::JobOptions;
use crate::settings::ModelLimits;
use crate::watch::{JobWatch, Progress, Stop};
use crate::work;

/// The bundle's promise for 8-bit channels; a source that exceeds it has seams.
const LARGEST_SEAM_CODES: f64 = 1.5;

/// File endings that are models when a folder is given.
const MODEL_ENDINGS: [&str; 5] = ["glb", "gltf", "obj", "ply", "zip"];

#[derive(clap::Args)]
pub struct Arguments {
    /// Models, or folders with models in them; `-` is standard input
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,
    /// What makes the exit code 1; otherwise a broken guarantee of a converted model does
    #[arg(long, env = "MESHCOLOR_FAIL_ON", value_name = "SEVERITY")]
    fail_on: Option<FailOn>,
    /// What goes to standard output
    #[arg(long, env = "MESHCOLOR_FORMAT", default_value = "text")]
    format: Format,
    #[command(flatten)]
    conversion: ConversionFlags,
    #[command(flatten)]
    run: RunFlags,
    #[command(flatten)]
    limits: ModelLimits,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FailOn {
    /// A broken guarantee; a source's seam
    Error,
    /// These, and warnings
    Warning,
    Never,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Text,
    Json,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    crate::logging::start(if arguments.run.quiet { "error" } else { "warn" });
    let conversion = arguments.conversion.options()?;
    let options = JobOptions { conversion, preview: false, tradeoff: false };
    let paths = models(&arguments.inputs)?;
    let stop = Arc::new(Stop::default());
    let interrupt = Interrupt::listen(stop.clone())?;
    let pool = work::thread_pool(arguments.run.threads)?;
    let mut outcome = Outcome::Fine;
    let mut entries = Vec::new();
    for path in &paths {
        let checked = check(path, arguments, &options, &pool, &stop);
        let is_canceled = checked.as_ref().is_err_and(|e| e.code == meshcolor::ErrorCode::Canceled);
        if is_canceled {
            return Ok(interrupt.over(Outcome::Failed));
        }
        outcome = outcome.max(match &checked {
            Ok(report) if has_findings(report, arguments.fail_on) => Outcome::Findings,
            Ok(_) => Outcome::Fine,
            Err(error) => Outcome::of_code(error.code),
        });
        match arguments.format {
            Format::Text => say(path, &checked, arguments.run.quiet)?,
            Format::Json => entries.push(entry(path, &checked)),
        }
    }
    if arguments.format == Format::Json {
        writeln!(stdout(), "{:#}", json!({ "files": entries }))?;
    }
    Ok(interrupt.over(outcome))
}

fn check(
    path: &Path,
    arguments: &Arguments,
    options: &JobOptions,
    pool: &rayon::ThreadPool,
    stop: &Arc<Stop>,
) -> meshcolor::Result<Report> {
    let upload = input::open(path)?;
    let (sender, progress) = watch::channel(Progress::default());
    let watch = JobWatch::new(stop.clone(), sender);
    let _bar = Bar::follow(path.display().to_string(), progress, arguments.run.quiet);
    pool.install(|| work::check(&upload, options, &arguments.limits.0, &watch))
}

/// The heaviest finding of a report decides, in the words of `--fail-on`.
fn has_findings(report: &Report, fail_on: Option<FailOn>) -> bool {
    let is_source = report.kind == SubjectKind::Source;
    let fail_on = fail_on.unwrap_or(if is_source { FailOn::Never } else { FailOn::Error });
    let has_seams = is_source && report.max_seam_delta_codes > LARGEST_SEAM_CODES;
    match fail_on {
        FailOn::Never => false,
        FailOn::Error => has_seams || report.verdict == Verdict::Fail,
        FailOn::Warning => has_seams || report.verdict != Verdict::Pass || !report.warnings.is_empty(),
    }
}

fn say(path: &Path, checked: &meshcolor::Result<Report>, quiet: bool) -> anyhow::Result<()> {
    match checked {
        Ok(_) if quiet => {}
        Ok(report) => write!(stdout(), "{}", table(&path.display().to_string(), report))?,
        Err(error) => eprintln!("meshcolor: {} [{}]", in_file(path, error.clone()), error.code.name()),
    }
    Ok(())
}

fn entry(path: &Path, checked: &meshcolor::Result<Report>) -> Value {
    let path = path.display().to_string();
    match checked {
        Ok(report) => json!({ "path": path, "report": report }),
        Err(error) => json!({ "path": path, "error": error }),
    }
}

/// The models that the arguments name; folders are searched to their bottom, in order of names.
fn models(inputs: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for input in inputs {
        if input.is_dir() {
            search(input, &mut paths)?;
        } else {
            paths.push(input.clone());
        }
    }
    if paths.is_empty() {
        return Err(UsageError("there is no model in these folders".to_owned()).into());
    }
    Ok(paths)
}

fn search(folder: &Path, paths: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    let mut entries: Vec<_> = fs::read_dir(folder)?.collect::<Result<_, _>>()?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        // Links to folders are left: they may run in a circle.
        if entry.file_type()?.is_dir() {
            search(&path, paths)?;
        } else if ending.is_some_and(|ending| MODEL_ENDINGS.contains(&ending.as_str())) {
            paths.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::text::sample_report;

    #[test]
    fn sources_fail_only_when_asked_and_converted_models_by_themselves() {
        let mut report = sample_report();
        report.kind = SubjectKind::Source;
        report.max_seam_delta_codes = 40.0;
        report.verdict = Verdict::Pass;
        assert!(!has_findings(&report, None));
        assert!(has_findings(&report, Some(FailOn::Error)));
        assert!(has_findings(&report, Some(FailOn::Warning)));
        assert!(!has_findings(&report, Some(FailOn::Never)));
        report.kind = SubjectKind::Converted;
        assert!(!has_findings(&report, None));
        report.verdict = Verdict::Fail;
        assert!(has_findings(&report, None));
        assert!(!has_findings(&report, Some(FailOn::Never)));
        report.verdict = Verdict::Warn;
        assert!(!has_findings(&report, Some(FailOn::Error)));
        assert!(has_findings(&report, Some(FailOn::Warning)));
    }
}
