//! Where jobs are kept. Every change of state is one guarded statement, so two callers can never both
//! make it; a `false` or `None` says that someone else was first.

use futures_util::future::BoxFuture;

use super::model::{Ending, JobId, JobRecord, JobState, NewJob};

/// The store cannot be reached or refuses; the cause is for the log.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error("the queue is full: {limit} jobs wait")]
    QueueFull { limit: u64 },
    #[error("the job store failed")]
    Unavailable(#[from] anyhow::Error),
}

pub type StoreFuture<'a, T> = BoxFuture<'a, Result<T, StoreError>>;

/// What a request to cancel met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelOutcome {
    /// It waited, and is canceled now.
    Canceled,
    /// It runs; the wish is stored, and whoever runs it has to be told.
    Requested,
    /// It had ended before, or there is no such job.
    Nothing,
}

/// One page of a list, newest first.
#[derive(Clone, Debug, Default)]
pub struct Page {
    pub state: Option<JobState>,
    /// Jobs older than this one.
    pub before: Option<JobId>,
    pub size: u32,
}

pub trait JobStore: Send + Sync + 'static {
    /// Adds a queued job, durable when this returns. Refuses when `queue_max` jobs wait.
    fn insert<'a>(&'a self, job: &'a NewJob, queue_max: u64) -> StoreFuture<'a, ()>;

    fn get(&self, id: JobId) -> StoreFuture<'_, Option<JobRecord>>;

    fn list(&self, page: Page) -> StoreFuture<'_, Vec<JobRecord>>;

    /// Every id that is stored, for sweeping files that belong to none.
    fn ids(&self) -> StoreFuture<'_, Vec<(JobId, JobState)>>;

    /// How many jobs wait; with an id, how many wait before it (and itself).
    fn queued_count(&self, up_to: Option<JobId>) -> StoreFuture<'_, u64>;

    /// Takes the oldest queued job; it runs from then on, with one attempt more.
    fn claim(&self) -> StoreFuture<'_, Option<JobRecord>>;

    /// Ends the job if it still runs at this revision; one that was to be canceled never succeeds.
    fn finish<'a>(&'a self, id: JobId, revision: u64, ending: &'a Ending) -> StoreFuture<'a, bool>;

    /// Puts a running job back without counting the attempt; one that is to be canceled is canceled.
    fn release(&self, id: JobId, revision: u64) -> StoreFuture<'_, bool>;

    /// Releases everything that runs: what a process that is gone had left. Returns how many there were.
    fn release_all(&self) -> StoreFuture<'_, u64>;

    fn cancel(&self, id: JobId) -> StoreFuture<'_, CancelOutcome>;

    fn delete(&self, id: JobId) -> StoreFuture<'_, bool>;
}
