use super::*;
use crate::jobs::model::{Fault, JobError, JobInput, JobOptions, JobResult, StoredFile};
use crate::jobs::testing::Scratch;
use meshcolor::measure::Verdict;

async fn store() -> (Scratch, SqliteStore) {
    let scratch = Scratch::new();
    let store = SqliteStore::open(&scratch.path().join("x.db")).await.unwrap();
    (scratch, store)
}

fn new_job() -> NewJob {
    let file = StoredFile { path: "a.glb".into(), stored: "x".into(), bytes: 3, sha256: "0".into() };
    NewJob {
        id: JobId::new(),
        kind: JobKind::Convert,
        input: JobInput { files: vec![file] },
        options: JobOptions::default(),
    }
}

async fn add(store: &SqliteStore) -> JobId {
    let job = new_job();
    store.insert(&job, 100).await.unwrap();
    job.id
}

fn success() -> Ending {
    Ending::Succeeded(JobResult {
        verdict: Verdict::Pass,
        error_count: 0,
        warning_count: 0,
        max_seam_delta_codes: 0.5,
        bundle: None,
        preview: None,
        preview_failure: None,
    })
}

#[tokio::test]
async fn a_job_reads_back_as_it_was_given_and_as_it_ended() {
    let (_scratch, store) = store().await;
    let job = new_job();
    store.insert(&job, 100).await.unwrap();
    let read = store.get(job.id).await.unwrap().unwrap();
    assert_eq!((read.state, read.attempt, read.revision), (JobState::Queued, 0, 1));
    assert_eq!(read.input, job.input);
    assert_eq!(read.options, job.options.to_json());
    let claimed = store.claim().await.unwrap().unwrap();
    assert_eq!((claimed.id, claimed.attempt, claimed.revision), (job.id, 1, 2));
    let error = JobError { pointer: Some("/x".into()), fault: Fault::Input, ..JobError::internal("d") };
    assert!(store.finish(job.id, 2, &Ending::Failed(error.clone())).await.unwrap());
    let read = store.get(job.id).await.unwrap().unwrap();
    assert_eq!((read.state, read.error), (JobState::Failed, Some(error)));
    assert!(read.finished_at >= read.started_at && read.started_at >= Some(read.created_at));
}

#[tokio::test]
async fn jobs_are_claimed_once_and_in_order() {
    let (_scratch, store) = store().await;
    let store = std::sync::Arc::new(store);
    let mut ids = Vec::new();
    for _ in 0..20 {
        ids.push(add(&store).await);
    }
    assert_eq!(store.queued_count(Some(ids[4])).await.unwrap(), 5);
    let claims = (0..8).map(|_| {
        let store = store.clone();
        tokio::spawn(async move {
            let mut mine = Vec::new();
            while let Some(job) = store.claim().await.unwrap() {
                mine.push(job.id);
            }
            mine
        })
    });
    let mut all = Vec::new();
    for claim in claims.collect::<Vec<_>>() {
        let mine = claim.await.unwrap();
        assert!(mine.is_sorted());
        all.extend(mine);
    }
    all.sort();
    assert_eq!(all, ids);
}

#[tokio::test]
async fn the_end_is_written_once_and_never_changes() {
    let (_scratch, store) = store().await;
    let id = add(&store).await;
    store.claim().await.unwrap();
    assert!(!store.finish(id, 1, &success()).await.unwrap(), "an older revision");
    assert!(store.finish(id, 2, &success()).await.unwrap());
    assert!(!store.finish(id, 2, &Ending::Canceled).await.unwrap());
    assert!(!store.finish(id, 3, &Ending::Canceled).await.unwrap());
    assert_eq!(store.cancel(id).await.unwrap(), CancelOutcome::Nothing);
    assert!(!store.release(id, 3).await.unwrap());
    assert_eq!(store.release_all().await.unwrap(), 0);
    let forced = query("UPDATE jobs SET state = 'queued'").execute(&store.pool).await;
    assert!(forced.is_err(), "the database itself refuses");
    assert_eq!(store.get(id).await.unwrap().unwrap().state, JobState::Succeeded);
}

#[tokio::test]
async fn a_job_that_was_to_be_canceled_never_succeeds() {
    let (_scratch, store) = store().await;
    let (running, queued) = (add(&store).await, add(&store).await);
    store.claim().await.unwrap();
    assert_eq!(store.cancel(running).await.unwrap(), CancelOutcome::Requested);
    assert_eq!(store.cancel(queued).await.unwrap(), CancelOutcome::Canceled);
    assert_eq!(store.cancel(queued).await.unwrap(), CancelOutcome::Nothing);
    assert_eq!(store.cancel(JobId::new()).await.unwrap(), CancelOutcome::Nothing);
    assert!(!store.finish(running, 2, &success()).await.unwrap());
    assert!(store.finish(running, 2, &Ending::Canceled).await.unwrap());
}

#[tokio::test]
async fn what_ran_waits_again_without_an_attempt_and_canceled_wishes_are_kept() {
    let (_scratch, store) = store().await;
    let (kept, canceled) = (add(&store).await, add(&store).await);
    store.claim().await.unwrap();
    store.claim().await.unwrap();
    store.cancel(canceled).await.unwrap();
    assert_eq!(store.release_all().await.unwrap(), 2);
    let read = store.get(kept).await.unwrap().unwrap();
    assert_eq!((read.state, read.attempt, read.started_at), (JobState::Queued, 0, None));
    let read = store.get(canceled).await.unwrap().unwrap();
    assert_eq!(read.state, JobState::Canceled);
    assert!(read.finished_at.is_some());
    // The run that was interrupted is fenced out by its revision.
    assert!(!store.finish(kept, 2, &success()).await.unwrap());
    let again = store.claim().await.unwrap().unwrap();
    assert_eq!((again.id, again.attempt, again.revision), (kept, 1, 4));
}

#[tokio::test]
async fn the_queue_has_an_end() {
    let (_scratch, store) = store().await;
    for _ in 0..3 {
        store.insert(&new_job(), 3).await.unwrap();
    }
    let refused = store.insert(&new_job(), 3).await;
    assert!(matches!(refused, Err(StoreError::QueueFull { limit: 3 })));
    store.claim().await.unwrap();
    store.insert(&new_job(), 3).await.unwrap();
}

#[tokio::test]
async fn pages_hold_every_job_once_newest_first() {
    let (_scratch, store) = store().await;
    let mut ids = Vec::new();
    for _ in 0..7 {
        ids.push(add(&store).await);
    }
    ids.reverse();
    let (mut seen, mut before) = (Vec::new(), None);
    loop {
        let page = store.list(Page { state: None, before, size: 3 }).await.unwrap();
        before = page.last().map(|job| job.id);
        if page.is_empty() {
            break;
        }
        seen.extend(page.into_iter().map(|job| job.id));
    }
    assert_eq!(seen, ids);
    store.claim().await.unwrap();
    let running = store.list(Page { state: Some(JobState::Running), before: None, size: 9 }).await.unwrap();
    assert_eq!(running.len(), 1);
}

#[tokio::test]
async fn the_file_survives_and_commits_are_flushed() {
    let scratch = Scratch::new();
    let path = scratch.path().join("x.db");
    let store = SqliteStore::open(&path).await.unwrap();
    let id = add(&store).await;
    store.close().await;
    let store = SqliteStore::open(&path).await.unwrap();
    assert!(store.get(id).await.unwrap().is_some());
    let row = query("PRAGMA synchronous").fetch_one(&store.pool).await.unwrap();
    assert_eq!(row.get::<i64, _>(0), 2, "FULL");
    let row = query("PRAGMA journal_mode").fetch_one(&store.pool).await.unwrap();
    assert_eq!(row.get::<String, _>(0), "wal");
}
