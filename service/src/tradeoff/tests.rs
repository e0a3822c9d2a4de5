//! The runs on the sample, made small by its resolution.

use std::sync::Arc;

use meshcolor::ErrorCode;
use meshcolor::pipeline::Options;
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use tokio::sync::watch;

use super::*;
use crate::jobs::model::{JobOptions, SWITCHES};
use crate::watch::{JobWatch, Progress, Stop, StopReason};
use crate::{sample, work};

fn options() -> Options {
    let mut options = Options::default();
    options.set("resolution", "area:0.01").unwrap();
    options
}

fn upload() -> Upload {
    Upload::single("sample.glb", sample::model())
}

fn run_with(limits: &Limits, watch: &JobWatch) -> Result<Tradeoff> {
    let asset = read(&upload(), &Limits::default(), &Unwatched).unwrap();
    let subject = Subject { model: "sample", asset: &asset, read: None };
    run(&subject, &options(), &Manner { limits, repeat_count: 1, done: 0.0 }, watch)
}

#[test]
fn every_run_has_its_figures_and_the_record_reads_back() {
    let (sender, progress) = watch::channel(Progress::default());
    let record = run_with(&Limits::default(), &JobWatch::new(Arc::default(), sender)).unwrap();
    assert_eq!(progress.borrow().stage, Some("tradeoff"));
    assert!(progress.borrow().percent > 80, "{:?}", progress.borrow());
    for run in &record.runs {
        let done = run.done().unwrap();
        let stages: f64 = done.cost.stages.iter().map(|stage| stage.cpu_seconds).sum();
        assert!((stages - done.cost.cpu_seconds).abs() < 1e-9 && done.cost.converting_cpu_seconds <= stages);
        let codes = done.errors.codes.as_ref().unwrap();
        assert!(codes.level_0.rms > 0.0 && done.errors.degrees.is_some(), "{}", run.name);
        assert!(done.output.texels > 0);
    }
    assert!(record.runs.iter().filter_map(Run::done).any(|done| done.is_on_front));
    hold_curve(&record);
    let files = files(&record, "x/").unwrap();
    let names: Vec<_> = files.iter().map(|file| file.path.as_str()).collect();
    let wanted = ["tradeoff.json", "tradeoff.md", "tradeoff.svg", "tradeoff.png", "curve.svg", "curve.png"];
    assert_eq!(names, wanted.map(|name| format!("x/{name}")));
    let back: Tradeoff = serde_json::from_slice(&files[0].bytes).unwrap();
    assert_eq!(back, record);
    assert_eq!(svg(&back).as_bytes(), files[2].bytes);
    let table = String::from_utf8(files[1].bytes.clone()).unwrap();
    assert!(record.runs.iter().all(|run| table.contains(&format!("| {} |", run.name))));
    assert!(table.contains("| budget, fitted, 1/4 of the area |"), "{table}");
}

/// Budgets are kept and are shares of the area-matched run, which is `standard`'s own.
fn hold_curve(record: &Tradeoff) {
    let curve = record.curve.as_ref().unwrap();
    let names: Vec<_> = curve.lines.iter().map(|line| line.name.as_str()).collect();
    assert_eq!(names, ["budget, fitted", "budget, point", "area-matched"]);
    let area = curve.lines[2].points.last().unwrap();
    let home = record.preset(HOME).unwrap();
    assert_eq!(area.options, home.options);
    let PointEnd::Done(matched) = &area.end else { panic!("{area:?}") };
    assert_eq!(matched.maps.len() as u64 * matched.texels, home.done().unwrap().output.texels);
    for point in curve.lines[..2].iter().flat_map(|line| &line.points) {
        let PointEnd::Done(figures) = &point.end else { continue };
        assert!(figures.texels as f64 <= point.share * matched.texels as f64 + 0.5, "{point:?}");
    }
    assert!(curve.best().unwrap().done().count() > 0 && curve.cpu_seconds > 0.0);
}

#[test]
fn the_option_tells_how_many_conversions_there_are() {
    let count = Plan::new(&Options::default()).unwrap().runs.len() + curve::RUN_COUNT - 1;
    let told = format!("That is {count} conversions more");
    assert!(SWITCHES.iter().any(|switch| switch.doc.contains(&told)), "{told}");
}

#[test]
fn a_rung_that_refuses_is_a_row_and_the_home_of_all_is_an_error() {
    let mut record = run_with(&Limits::default(), &JobWatch::alone()).unwrap();
    let last = record.ladders.last().unwrap().rungs.iter().find(|rung| !rung.is_home).unwrap().run;
    record.runs[last].end = End::Refused { code: "x".into(), reason: "too | large".into() };
    let table = markdown(&record);
    assert!(table.contains("refused: too \\| large"), "{table}");
    assert!(svg(&record).contains("refused: too | large"));
    let back: Tradeoff = serde_json::from_str(&serde_json::to_string(&record).unwrap()).unwrap();
    assert_eq!(back, record);
    let limits = Limits { texture_side: 4, ..Limits::default() };
    let error = run_with(&limits, &JobWatch::alone()).unwrap_err();
    assert_eq!(error.code, ErrorCode::TextureTooLarge);
}

#[test]
fn a_stop_ends_it() {
    let stop = Arc::new(Stop::default());
    stop.set(StopReason::Canceled);
    let watch = JobWatch::new(stop, watch::channel(Progress::default()).0);
    assert_eq!(run_with(&Limits::default(), &watch).unwrap_err().code, ErrorCode::Canceled);
}

#[test]
fn a_job_brings_it_along() {
    let options = JobOptions { conversion: options(), preview: false, tradeoff: true };
    let (sender, progress) = watch::channel(Progress::default());
    let watch = JobWatch::new(Arc::default(), sender);
    let done = work::convert(&upload(), &options, &Limits::default(), &watch).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&done.files[0].bytes).unwrap();
    assert_eq!(manifest["options"]["tradeoff"], true);
    let file = |path: &str| done.files.iter().find(|file| file.path == path).unwrap();
    let record: Tradeoff = serde_json::from_slice(&file("tradeoff/tradeoff.json").bytes).unwrap();
    assert_eq!((record.model.as_str(), record.runs[record.asked].name.as_str()), ("sample", "standard"));
    assert!(record.runs.iter().all(|run| run.done().unwrap().cost.stages[0].stage == "read"));
    image::load_from_memory(&file("tradeoff/tradeoff.png").bytes).unwrap();
    let run: serde_json::Value = serde_json::from_slice(&file("run.json").bytes).unwrap();
    let stages = run["stages"].as_array().unwrap();
    assert!(stages.iter().any(|stage| stage["stage"] == "tradeoff" && stage["peak_memory_bytes"].is_u64()));
    assert!((85..=99).contains(&progress.borrow().percent), "{:?}", progress.borrow());
}
