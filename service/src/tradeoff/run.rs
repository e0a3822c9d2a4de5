//! Runs a plan: one model, one conversion after another, without pictures.

use std::collections::BTreeSet;

use meshcolor::asset::Asset;
use meshcolor::measure::{Report, Verdict};
use meshcolor::pipeline::{self, ENGINE_VERSION, OPTIONS, Options};
use meshcolor::read::Limits;
use meshcolor::watch::{Stage, Watch};
use meshcolor::{Error, ErrorCode, Result};
use serde_json::{Map, Value};

use super::curve;
use super::errors::{errors_of, output_of};
use super::front::front;
use super::plan::{Plan, PlannedRun};
use super::record::{Cost, Done, End, Machine, RECORD_VERSION, Run, StageCost, Tradeoff};
use crate::clock::Timestamp;
use crate::watch::{JobWatch, Part, StageFigures, TRADEOFF_STAGE};
use crate::work::processor_count;

/// The stages that rungs decide about. Reading, measuring and writing cost every rung about the same.
pub const CONVERTING: [Stage; 5] = [Stage::Resample, Stage::Mip, Stage::Layout, Stage::Assign, Stage::Solve];

/// What the runs are made on.
pub struct Subject<'a> {
    pub model: &'a str,
    pub asset: &'a Asset,
    /// What reading it cost, once for all runs.
    pub read: Option<StageFigures>,
}

/// How to run.
pub struct Manner<'a> {
    pub limits: &'a Limits,
    /// Each conversion runs this often; the fastest counts.
    pub repeat_count: u32,
    /// The share of the job's progress that is there already; the runs have the rest.
    pub done: f32,
}

/// Runs every rung with the cuts of `base`, and with its resolution where that is not its preset's, and then the curve of
/// texels against error, on the threads of the pool that calls it.
///
/// # Errors
/// What keeps `standard` from converting, `Canceled`, and errors of our own; a rung that refuses the
/// asset is a result.
pub fn run(subject: &Subject<'_>, base: &Options, manner: &Manner<'_>, watch: &JobWatch) -> Result<Tradeoff> {
    // Only reports are kept.
    let base = &Options { textures: BTreeSet::new(), compress: BTreeSet::new(), ..base.clone() };
    let plan = Plan::new(base)?;
    let started_at = Timestamp::now();
    watch.enter(TRADEOFF_STAGE);
    let mut ends: Vec<Option<End>> = vec![None; plan.runs.len()];
    let mut runner = Runner::new(subject, manner, watch);
    runner.total = plan.runs.len() * manner.repeat_count as usize + curve::RUN_COUNT;
    let matched = curve::area_matched(base, 1.0)?;
    let mut matched_figures = None;
    // Repeats go round all runs, so that a busy minute of the machine does not fall on one of them.
    for _ in 0..manner.repeat_count {
        for (planned, end) in plan.runs.iter().zip(&mut ends) {
            let (report, stages) = runner.convert(&planned.options);
            if let Some(report) = report.as_ref().ok().filter(|_| planned.options == matched) {
                matched_figures = Some(curve::figures_of(report));
            }
            faster(end, end_of(planned, report, stages, &subject.read)?);
        }
    }
    let curve = curve::run(&mut runner, base, matched_figures)?;
    let runs = plan.runs.into_iter().zip(ends).filter_map(|(planned, end)| {
        Some(Run { name: planned.name, options: planned.options.to_json(), end: end? })
    });
    let mut record = Tradeoff {
        record_version: RECORD_VERSION,
        engine_version: ENGINE_VERSION.to_owned(),
        model: subject.model.to_owned(),
        face_count: faces(subject.asset),
        options: common(base),
        started_at: started_at.to_string(),
        machine: Machine::here(),
        repeat_count: manner.repeat_count,
        presets: plan.presets,
        ladders: plan.ladders,
        asked: plan.asked,
        runs: runs.collect(),
        curve: Some(curve),
    };
    mark_fronts(&mut record.runs);
    Ok(record)
}

impl Machine {
    /// This machine, and the pool that calls.
    pub fn here() -> Self {
        Self {
            os: std::env::consts::OS.to_owned(),
            architecture: std::env::consts::ARCH.to_owned(),
            processor_count: processor_count(),
            thread_count: rayon::current_num_threads(),
        }
    }
}

/// Converts one subject again and again, and moves the job's progress on.
pub(super) struct Runner<'a> {
    subject: &'a Subject<'a>,
    manner: &'a Manner<'a>,
    watch: &'a JobWatch,
    /// Conversions that there will be.
    total: usize,
    done: usize,
}

impl<'a> Runner<'a> {
    fn new(subject: &'a Subject<'a>, manner: &'a Manner<'a>, watch: &'a JobWatch) -> Self {
        Self { subject, manner, watch, total: 1, done: 0 }
    }

    /// A conversion's report, and what its stages took.
    pub(super) fn convert(&mut self, options: &Options) -> (Result<Report>, Vec<StageFigures>) {
        let share = (1.0 - self.manner.done) / self.total as f32;
        let part = self.watch.part(self.manner.done + share * self.done as f32, share);
        let clocks = JobWatch::alone();
        let watched = Watched { clocks: &clocks, job: self.watch, progress: &part };
        let product = pipeline::convert_read(self.subject.asset, options, self.manner.limits, &watched);
        self.done += 1;
        (product.map(|product| product.report), clocks.finish())
    }
}

/// Clocks of its own for each run, and the job's progress and stop.
struct Watched<'a> {
    clocks: &'a JobWatch,
    job: &'a JobWatch,
    progress: &'a Part<'a>,
}

impl Watch for Watched<'_> {
    fn stage(&self, stage: Stage) {
        self.job.note_peak_memory();
        self.clocks.stage(stage);
    }

    fn step(&self, name: Option<&'static str>) {
        self.clocks.step(name);
    }

    fn progress(&self, done: f32) {
        self.progress.progress(done);
    }

    fn canceled(&self) -> bool {
        self.progress.canceled()
    }
}

/// Whether an error is none of the subject's, so that the others would not fare better.
pub(super) fn ends_all(error: &Error) -> bool {
    matches!(error.code, ErrorCode::Canceled | ErrorCode::Internal)
}

fn end_of(
    planned: &PlannedRun,
    report: Result<Report>,
    stages: Vec<StageFigures>,
    read: &Option<StageFigures>,
) -> Result<End> {
    let is_fatal = |error: &Error| planned.name == super::plan::HOME || ends_all(error);
    match report {
        Err(error) if is_fatal(&error) => Err(error),
        Err(error) => Ok(End::Refused { code: error.code.name(), reason: error.to_string() }),
        Ok(report) => {
            let stages: Vec<_> = read.iter().cloned().chain(stages).collect();
            Ok(End::Done(Box::new(Done {
                cost: cost_of(&stages),
                errors: errors_of(&report),
                output: output_of(&report),
                is_seamless: report.verdict != Verdict::Fail,
                is_on_front: false,
                is_on_mip_front: false,
            })))
        }
    }
}

/// What a run's stages come to.
pub fn cost_of(stages: &[StageFigures]) -> Cost {
    let is_converting = |figures: &&StageFigures| CONVERTING.iter().any(|s| s.name() == figures.stage);
    Cost {
        converting_cpu_seconds: stages.iter().filter(is_converting).map(|s| s.cpu_seconds).sum(),
        cpu_seconds: stages.iter().map(|stage| stage.cpu_seconds).sum(),
        seconds: stages.iter().map(|stage| stage.seconds).sum(),
        peak_memory_bytes: stages.iter().filter_map(|stage| stage.peak_memory_bytes).max(),
        stages: stages
            .iter()
            .map(|figures| StageCost {
                stage: figures.stage.to_owned(),
                seconds: figures.seconds,
                cpu_seconds: figures.cpu_seconds,
                peak_memory_bytes: figures.peak_memory_bytes,
            })
            .collect(),
    }
}

/// Keeps the faster of two ends.
fn faster(kept: &mut Option<End>, new: End) {
    let is_slower = match (&*kept, &new) {
        (Some(End::Done(kept)), End::Done(new)) => {
            new.cost.converting_cpu_seconds >= kept.cost.converting_cpu_seconds
        }
        _ => false,
    };
    if !is_slower {
        *kept = Some(new);
    }
}

/// Marks both fronts over all runs that have no seams: near and fast is easy for those that keep them.
fn mark_fronts(runs: &mut [Run]) {
    let points = |error: fn(&Done) -> Option<f64>| -> Vec<_> {
        let point = move |done: &Done| Some((done.cost.converting_cpu_seconds, error(done)?));
        let seamless = |run: &Run| run.done().filter(|done| done.is_seamless).and_then(point);
        runs.iter().map(seamless).collect()
    };
    let (fine, coarse) = (front(&points(Done::level_0_error)), front(&points(Done::mip_error)));
    for (run, (fine, coarse)) in runs.iter_mut().zip(fine.into_iter().zip(coarse)) {
        if let End::Done(done) = &mut run.end {
            (done.is_on_front, done.is_on_mip_front) = (fine, coarse);
        }
    }
}

/// The options that no ladder has.
fn common(base: &Options) -> Map<String, Value> {
    let is_common = |name: &str| OPTIONS.iter().any(|spec| spec.name == name && spec.rungs.is_empty());
    base.to_json().into_iter().filter(|(name, _)| is_common(name)).collect()
}

/// Faces of all meshes.
fn faces(asset: &Asset) -> u64 {
    let primitives = asset.meshes.iter().flat_map(|mesh| &mesh.primitives);
    primitives.map(|primitive| primitive.faces.len() as u64).sum()
}
