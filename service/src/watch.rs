//! The `Watch` of a real run: clocks and memory by stage and step, a way to stop, and progress that
//! anyone may follow.
//!
//! CPU time and memory are the process's: with several jobs at once each one's figures hold the others'
//! too (`run.json` says so). Peak memory is the kernel's high-water mark, set back at each stage where
//! `/proc/self/clear_refs` may be written; elsewhere it is the running maximum since the start.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use meshcolor::watch::{Stage, Watch};
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;
use tokio::sync::watch;

/// The stage that the service adds behind the conversion's own.
pub const PREVIEW_STAGE: &str = "preview";

/// The stage of a job's further conversions, one for each rung.
pub const TRADEOFF_STAGE: &str = "tradeoff";

/// Share of the whole job that conversions are; the rest is the preview and the bundle.
const CONVERSION_SHARE: f32 = 0.92;

/// Names of all stages that a job reports, in order.
pub fn stage_names() -> Vec<&'static str> {
    Stage::ALL.iter().map(|stage| stage.name()).chain([PREVIEW_STAGE, TRADEOFF_STAGE]).collect()
}

/// How far a job is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// State changes of the job so far; zero outside the service.
    pub revision: u64,
    pub percent: u8,
    pub stage: Option<&'static str>,
}

/// Why a run has to end early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// Someone asked for it; the job ends as canceled.
    Canceled,
    /// The process ends; the job goes back into the queue.
    Shutdown,
}

/// A flag that is set once; a cancel outranks a shutdown.
#[derive(Debug, Default)]
pub struct Stop(AtomicU8);

impl Stop {
    pub fn set(&self, reason: StopReason) {
        self.0.fetch_max(if reason == StopReason::Canceled { 2 } else { 1 }, Ordering::SeqCst);
    }

    pub fn reason(&self) -> Option<StopReason> {
        match self.0.load(Ordering::SeqCst) {
            0 => None,
            1 => Some(StopReason::Shutdown),
            _ => Some(StopReason::Canceled),
        }
    }
}

/// Watches one job.
pub struct JobWatch {
    clocks: Mutex<Clocks>,
    stop: Arc<Stop>,
    progress: watch::Sender<Progress>,
}

impl JobWatch {
    pub fn new(stop: Arc<Stop>, progress: watch::Sender<Progress>) -> Self {
        Self { clocks: Mutex::new(Clocks::start()), stop, progress }
    }

    /// A watch nobody follows or stops, for callers that want the clocks alone.
    pub fn alone() -> Self {
        Self::new(Arc::default(), watch::channel(Progress::default()).0)
    }

    /// Enters a stage that the conversion does not know.
    pub fn enter(&self, stage: &'static str) {
        self.clocks().enter(stage);
        self.progress.send_if_modified(|progress| {
            let changed = progress.stage != Some(stage);
            progress.stage = Some(stage);
            changed
        });
    }

    /// A part of the job: its progress runs from `start` over `share` of the whole.
    pub fn part(&self, start: f32, share: f32) -> Part<'_> {
        Part { watch: self, start, share }
    }

    /// Counts the memory's high-water mark for the running stage, before other clocks set the mark back.
    pub fn note_peak_memory(&self) {
        let mut clocks = self.clocks();
        if let Some((index, _)) = clocks.running {
            let stage = &mut clocks.stages[index];
            stage.peak_memory_bytes = stage.peak_memory_bytes.max(peak_memory_bytes());
        }
    }

    /// Ends the clocks and returns what they measured.
    pub fn finish(&self) -> Vec<StageFigures> {
        let mut clocks = self.clocks();
        clocks.leave();
        clocks.stages.clone()
    }

    fn clocks(&self) -> MutexGuard<'_, Clocks> {
        self.clocks.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Watch for JobWatch {
    fn stage(&self, stage: Stage) {
        self.enter(stage.name());
    }

    fn step(&self, name: Option<&'static str>) {
        self.clocks().step(name);
    }

    fn progress(&self, done: f32) {
        // `as` saturates and sends NaN to 0, so no value can break the promise of 0 to 99.
        let percent = ((done.clamp(0.0, 1.0) * CONVERSION_SHARE * 100.0) as u8).min(99);
        self.progress.send_if_modified(|progress| {
            let rises = percent > progress.percent;
            progress.percent = progress.percent.max(percent);
            rises
        });
    }

    fn canceled(&self) -> bool {
        self.stop.reason().is_some()
    }
}

/// One of several conversions that a job makes.
pub struct Part<'a> {
    watch: &'a JobWatch,
    start: f32,
    share: f32,
}

impl Watch for Part<'_> {
    fn stage(&self, stage: Stage) {
        self.watch.stage(stage);
    }

    fn step(&self, name: Option<&'static str>) {
        self.watch.step(name);
    }

    fn progress(&self, done: f32) {
        self.watch.progress(self.start + done.clamp(0.0, 1.0) * self.share);
    }

    fn canceled(&self) -> bool {
        self.watch.canceled()
    }
}

/// What one stage cost, over all its visits.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageFigures {
    pub stage: &'static str,
    pub visit_count: u32,
    pub seconds: f64,
    pub cpu_seconds: f64,
    pub peak_memory_bytes: Option<u64>,
    pub steps: Vec<StepFigures>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepFigures {
    pub step: &'static str,
    pub visit_count: u32,
    pub seconds: f64,
    pub cpu_seconds: f64,
}

#[derive(Clone, Copy)]
struct Mark {
    wall: Instant,
    cpu_seconds: f64,
}

impl Mark {
    fn now() -> Self {
        Self { wall: Instant::now(), cpu_seconds: cpu_seconds() }
    }

    /// Wall and CPU seconds since then.
    fn elapsed(self) -> (f64, f64) {
        (self.wall.elapsed().as_secs_f64(), (cpu_seconds() - self.cpu_seconds).max(0.0))
    }
}

struct Clocks {
    stages: Vec<StageFigures>,
    /// The stage that runs, an index into `stages`.
    running: Option<(usize, Mark)>,
    step: Option<(&'static str, Mark)>,
}

impl Clocks {
    fn start() -> Self {
        Self { stages: Vec::new(), running: None, step: None }
    }

    fn enter(&mut self, stage: &'static str) {
        self.leave();
        let index = self.stages.iter().position(|s| s.stage == stage).unwrap_or_else(|| {
            self.stages.push(StageFigures {
                stage,
                visit_count: 0,
                seconds: 0.0,
                cpu_seconds: 0.0,
                peak_memory_bytes: None,
                steps: Vec::new(),
            });
            self.stages.len() - 1
        });
        reset_peak_memory();
        self.stages[index].visit_count += 1;
        self.running = Some((index, Mark::now()));
    }

    fn leave(&mut self) {
        self.step(None);
        if let Some((index, mark)) = self.running.take() {
            let (seconds, cpu_seconds) = mark.elapsed();
            let stage = &mut self.stages[index];
            stage.seconds += seconds;
            stage.cpu_seconds += cpu_seconds;
            stage.peak_memory_bytes = stage.peak_memory_bytes.max(peak_memory_bytes());
        }
    }

    fn step(&mut self, name: Option<&'static str>) {
        if let (Some((step, mark)), Some((index, _))) = (self.step.take(), self.running) {
            let (seconds, cpu_seconds) = mark.elapsed();
            let steps = &mut self.stages[index].steps;
            match steps.iter_mut().find(|s| s.step == step) {
                Some(figures) => {
                    figures.visit_count += 1;
                    figures.seconds += seconds;
                    figures.cpu_seconds += cpu_seconds;
                }
                None => steps.push(StepFigures { step, visit_count: 1, seconds, cpu_seconds }),
            }
        }
        self.step = name.map(|name| (name, Mark::now()));
    }
}

/// CPU seconds of all threads of the process.
pub fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// The high-water mark of resident memory, where the system tells.
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

fn reset_peak_memory() {
    // "5" sets the high-water mark back to the present size. Where it is refused the mark keeps
    // rising, as the module's header says.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

#[cfg(test)]
mod tests;
