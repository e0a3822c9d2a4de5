//! The durable queue: workers take jobs from the store, run them and write down how they ended.
//!
//! What a client is told is in the store first. A process that dies leaves rows that say `running`; the
//! next start puts them back, clears half-written results and runs them again, so each job ends once.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use meshcolor::ErrorCode;
use tokio::sync::{Notify, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep, timeout, timeout_at};
use tracing::{error, info, warn};

use super::folder::{DataFolder, InputFolder};
use super::model::{Ending, Fault, JobError, JobId, JobOptions, JobRecord, JobResult, JobState, NewJob};
use super::runner::{RunError, Runner, StoredFiles, Task};
use super::store::{CancelOutcome, JobStore, StoreError};
use crate::settings::raising_hint;
use crate::watch::{JobWatch, Progress, Stop, StopReason};

/// How often idle workers look even without a call.
const POLL: Duration = Duration::from_secs(1);

pub struct Queue {
    pub store: Arc<dyn JobStore>,
    pub folder: Arc<DataFolder>,
    runner: Arc<dyn Runner>,
    limits: meshcolor::read::Limits,
    queue_max: u64,
    /// Jobs that have not ended, with their followers.
    live: Mutex<HashMap<JobId, Live>>,
    wake: Notify,
    closing: watch::Sender<bool>,
    workers: Mutex<Vec<JoinHandle<()>>>,
}

#[derive(Clone)]
struct Live {
    stop: Arc<Stop>,
    progress: watch::Sender<Progress>,
}

/// What a run came to, before it is stored.
enum Outcome {
    Ended(Ending),
    /// The process ends; the job waits for the next one.
    PutBack,
}

pub struct QueueParts {
    pub store: Arc<dyn JobStore>,
    pub folder: Arc<DataFolder>,
    pub runner: Arc<dyn Runner>,
    pub limits: meshcolor::read::Limits,
    pub queue_max: u64,
    pub worker_count: usize,
}

impl Queue {
    /// Takes over what an earlier process left, then starts the workers.
    pub async fn start(parts: QueueParts) -> anyhow::Result<Arc<Self>> {
        let requeued = parts.store.release_all().await?;
        let stored = parts.store.ids().await?;
        parts.folder.sweep(&stored)?;
        if requeued > 0 {
            info!(requeued, "jobs that an earlier process was running wait again");
        }
        let queue = Arc::new(Self {
            store: parts.store,
            folder: parts.folder,
            runner: parts.runner,
            limits: parts.limits,
            queue_max: parts.queue_max,
            live: Mutex::default(),
            wake: Notify::new(),
            closing: watch::channel(false).0,
            workers: Mutex::default(),
        });
        for (id, state) in stored {
            if !state.is_terminal() {
                queue.make_live(id);
            }
        }
        let workers = (0..parts.worker_count).map(|_| tokio::spawn(queue.clone().work())).collect();
        *queue.workers.lock().unwrap_or_else(PoisonError::into_inner) = workers;
        Ok(queue)
    }

    /// Accepts a job: its files and its row are on disk when this returns.
    ///
    /// # Errors
    /// `QueueFull`, `Unavailable`; the input is gone then.
    pub async fn submit(&self, job: NewJob, input: InputFolder) -> Result<(), StoreError> {
        // Before the row exists, so that a fast worker finds its followers.
        self.make_live(job.id);
        if let Err(error) = self.store.insert(&job, self.queue_max).await {
            self.live().remove(&job.id);
            return Err(error);
        }
        input.keep();
        self.wake.notify_one();
        Ok(())
    }

    /// Whether a submission now would be refused; asked before a body is read.
    pub async fn is_full(&self) -> Result<bool, StoreError> {
        Ok(self.store.queued_count(None).await? >= self.queue_max)
    }

    pub fn queue_max(&self) -> u64 {
        self.queue_max
    }

    /// The progress of a job that has not ended. The channel closes when it ends, and then the store
    /// tells how; take this before reading the store.
    pub fn follow(&self, id: JobId) -> Option<watch::Receiver<Progress>> {
        self.live().get(&id).map(|live| live.progress.subscribe())
    }

    /// Cancels a job that waits or runs.
    pub async fn cancel(&self, id: JobId) -> Result<CancelOutcome, StoreError> {
        let outcome = self.store.cancel(id).await?;
        match outcome {
            CancelOutcome::Canceled => {
                self.live().remove(&id);
                self.clear_unfinished(id);
            }
            CancelOutcome::Requested => self.stop(id),
            CancelOutcome::Nothing => {}
        }
        Ok(outcome)
    }

    /// Stops and forgets a job with all its files.
    pub async fn delete(&self, id: JobId) -> Result<bool, StoreError> {
        let was_there = self.store.delete(id).await?;
        self.stop(id);
        self.live().remove(&id);
        if was_there {
            // A worker that still runs it meets a missing row and removes what it wrote meanwhile.
            self.report(id, self.folder.remove(id));
        }
        Ok(was_there)
    }

    pub fn is_closing(&self) -> bool {
        *self.closing.borrow()
    }

    /// Changes to `true` when the service stops.
    pub fn closing(&self) -> watch::Receiver<bool> {
        self.closing.subscribe()
    }

    /// Marks the queue as closing: nothing is claimed any more.
    pub fn begin_close(&self) {
        self.closing.send_replace(true);
    }

    /// Ends the workers: running jobs may finish within the grace, then they go back into the queue.
    pub async fn close(&self, grace: Duration) {
        self.begin_close();
        let mut workers = std::mem::take(&mut *self.workers.lock().unwrap_or_else(PoisonError::into_inner));
        let deadline = Instant::now() + grace;
        for worker in &mut workers {
            let _ = timeout_at(deadline, worker).await;
        }
        for live in self.live().values() {
            live.stop.set(StopReason::Shutdown);
        }
        for worker in workers.iter_mut().filter(|worker| !worker.is_finished()) {
            if timeout(Duration::from_secs(5), worker).await.is_err() {
                warn!("a job does not stop; the next start runs it again");
            }
        }
    }

    async fn work(self: Arc<Self>) {
        let mut closing = self.closing.subscribe();
        while !*closing.borrow_and_update() {
            match self.store.claim().await {
                Ok(Some(job)) => self.run(job).await,
                Ok(None) => tokio::select! {
                    () = self.wake.notified() => {}
                    () = sleep(POLL) => {}
                    _ = closing.changed() => {}
                },
                Err(cause) => {
                    error!(error = ?cause, "no job can be claimed");
                    sleep(POLL).await;
                }
            }
        }
    }

    async fn run(self: &Arc<Self>, job: JobRecord) {
        let (id, revision) = (job.id, job.revision);
        let live = self.make_live(id);
        live.progress.send_modify(|progress| *progress = Progress { revision, ..Progress::default() });
        info!(job = %id, attempt = job.attempt, "started");
        let queue = self.clone();
        let run = tokio::task::spawn_blocking({
            let live = live.clone();
            move || queue.run_blocking(job, &live)
        });
        let outcome = run.await.unwrap_or_else(|cause| {
            error!(job = %id, error = %cause, "the job's thread ended");
            Outcome::Ended(Ending::Failed(JobError::internal("the conversion ended unexpectedly")))
        });
        self.settle(id, revision, outcome).await;
    }

    /// The job itself, on a thread of its own.
    fn run_blocking(&self, job: JobRecord, live: &Live) -> Outcome {
        let id = job.id;
        let result = catch_unwind(AssertUnwindSafe(|| self.run_and_store(job, live)));
        match result {
            Ok(Ok(result)) => Outcome::Ended(Ending::Succeeded(result)),
            Ok(Err(RunError::Conversion(cause))) if cause.code == ErrorCode::Canceled => {
                match live.stop.reason() {
                    Some(StopReason::Shutdown) => Outcome::PutBack,
                    _ => Outcome::Ended(Ending::Canceled),
                }
            }
            Ok(Err(RunError::Conversion(cause))) => {
                if cause.code == ErrorCode::Internal {
                    error!(job = %id, error = %cause, "the conversion broke a promise");
                }
                Outcome::Ended(Ending::Failed(self.job_error(cause)))
            }
            Ok(Err(RunError::Own(cause))) => {
                error!(job = %id, error = format!("{cause:#}"), "the job failed");
                Outcome::Ended(Ending::Failed(JobError::internal("the result could not be produced")))
            }
            Err(panic) => {
                error!(job = %id, panic = panic_text(panic.as_ref()), "the conversion panicked");
                Outcome::Ended(Ending::Failed(JobError::internal("the conversion ended unexpectedly")))
            }
        }
    }

    fn run_and_store(&self, job: JobRecord, live: &Live) -> Result<JobResult, RunError> {
        let out = self.folder.begin_result(job.id)?;
        let files = StoredFiles { folder: self.folder.input(job.id), input: job.input };
        let watch = JobWatch::new(live.stop.clone(), live.progress.clone());
        let task = Task {
            kind: job.kind,
            upload: files.into_upload()?,
            options: JobOptions::from_json(&job.options)?,
            out: &out,
            watch: &watch,
        };
        let result = self.runner.run(&task)?;
        self.folder.commit_result(job.id)?;
        Ok(result)
    }

    fn job_error(&self, cause: meshcolor::Error) -> JobError {
        let hint = cause.limit.and_then(|limit| raising_hint(&self.limits, cause.code, limit));
        let detail = match hint {
            Some(hint) if !cause.detail.contains("MESHCOLOR_") => format!("{} {hint}", cause.detail),
            _ => cause.detail,
        };
        let is_ours = cause.code == ErrorCode::Internal;
        JobError {
            code: cause.code.name(),
            detail: if is_ours { "the conversion broke a promise of its own".to_owned() } else { detail },
            fault: if is_ours { Fault::Service } else { Fault::Input },
            pointer: cause.pointer.filter(|_| !is_ours),
            limit: cause.limit.filter(|_| !is_ours),
            actual: cause.actual.filter(|_| !is_ours),
        }
    }

    /// Writes down how a run ended, as often as it takes, then clears up behind it.
    async fn settle(&self, id: JobId, revision: u64, mut outcome: Outcome) {
        loop {
            let stored = match &outcome {
                Outcome::Ended(ending) => self.store.finish(id, revision, ending).await,
                Outcome::PutBack => self.store.release(id, revision).await,
            };
            let record = match stored {
                Ok(_) => self.store.get(id).await,
                Err(cause) => Err(cause),
            };
            match record {
                Ok(Some(job)) if job.state == JobState::Running && job.revision == revision => {
                    // Refused although it runs: someone canceled it at the last moment.
                    outcome = Outcome::Ended(Ending::Canceled);
                    continue;
                }
                Ok(record) => {
                    self.clear(id, record.map(|job| job.state));
                    return;
                }
                Err(cause) => error!(job = %id, error = ?cause, "the end of a job cannot be stored yet"),
            }
            sleep(POLL).await;
        }
    }

    /// Removes what a job in this state does not need, and lets its followers go.
    fn clear(&self, id: JobId, state: Option<JobState>) {
        match state {
            None => self.report(id, self.folder.remove(id)),
            Some(JobState::Succeeded) => self.report(id, self.folder.discard_input(id)),
            Some(state) if state.is_terminal() => self.clear_unfinished(id),
            Some(_) => self.report(id, self.folder.discard_result(id)),
        }
        if state.is_none_or(JobState::is_terminal) {
            self.live().remove(&id);
        }
        info!(job = %id, state = state.map_or("deleted", JobState::name), "ended");
    }

    fn clear_unfinished(&self, id: JobId) {
        self.report(id, self.folder.remove(id));
    }

    /// Files that could not be removed are swept at the next start.
    fn report(&self, id: JobId, result: std::io::Result<()>) {
        if let Err(cause) = result {
            warn!(job = %id, error = %cause, "files could not be removed");
        }
    }

    fn stop(&self, id: JobId) {
        if let Some(live) = self.live().get(&id) {
            live.stop.set(StopReason::Canceled);
        }
    }

    fn make_live(&self, id: JobId) -> Live {
        self.live()
            .entry(id)
            .or_insert_with(|| Live {
                stop: Arc::default(),
                progress: watch::channel(Progress { revision: 1, ..Progress::default() }).0,
            })
            .clone()
    }

    fn live(&self) -> MutexGuard<'_, HashMap<JobId, Live>> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
}

#[cfg(test)]
mod tests;
