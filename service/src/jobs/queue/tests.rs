use std::sync::atomic::Ordering;

use super::*;
use crate::jobs::model::{JobInput, JobKind, StoredFile};
use crate::jobs::sqlite::SqliteStore;
use crate::jobs::testing::{Scratch, Scripted};

struct Bench {
    scratch: Scratch,
    runner: Arc<Scripted>,
    store: Arc<SqliteStore>,
    queue: Arc<Queue>,
}

async fn start(scratch: Scratch, worker_count: usize) -> Bench {
    let runner = Arc::new(Scripted::default());
    let folder = Arc::new(DataFolder::open(scratch.path()).unwrap());
    let store = Arc::new(SqliteStore::open(&folder.database()).await.unwrap());
    let parts = QueueParts {
        store: store.clone(),
        folder,
        runner: runner.clone(),
        limits: meshcolor::read::Limits::default(),
        queue_max: 1000,
        worker_count,
    };
    Bench { scratch, runner, store, queue: Queue::start(parts).await.unwrap() }
}

impl Bench {
    async fn submit(&self, model: &str) -> JobId {
        let id = JobId::new();
        let input = self.queue.folder.begin_input(id).unwrap();
        std::fs::write(input.path().join("m"), model).unwrap();
        let file = StoredFile { path: "m.glb".into(), stored: "m".into(), bytes: 1, sha256: "0".into() };
        let job = NewJob {
            id,
            kind: JobKind::Convert,
            input: JobInput { files: vec![file] },
            options: JobOptions::default(),
        };
        self.queue.submit(job, input).await.unwrap();
        id
    }

    async fn record(&self, id: JobId) -> JobRecord {
        self.queue.store.get(id).await.unwrap().unwrap()
    }

    async fn until(&self, id: JobId, state: JobState) -> JobRecord {
        loop {
            let record = self.record(id).await;
            if record.state == state {
                return record;
            }
            assert!(!record.state.is_terminal(), "{:?} instead of {state:?}", record.state);
            sleep(Duration::from_millis(2)).await;
        }
    }

    /// Lets go of everything without stopping anything, as a crash would.
    async fn crash(self) -> Scratch {
        self.queue.begin_close();
        self.runner.gate.store(true, Ordering::SeqCst);
        let workers = std::mem::take(&mut *self.queue.workers.lock().unwrap());
        for worker in workers {
            worker.abort();
            let _ = worker.await;
        }
        while Arc::strong_count(&self.queue.folder) > 1 || Arc::strong_count(&self.queue) > 1 {
            sleep(Duration::from_millis(2)).await;
        }
        // A statement whose caller is gone is still carried out; a dead process has none of these.
        self.store.close().await;
        self.scratch
    }
}

#[tokio::test]
async fn jobs_end_as_their_runs_do() {
    let bench = start(Scratch::new(), 2).await;
    let good = bench.submit("ok").await;
    let record = bench.until(good, JobState::Succeeded).await;
    assert_eq!(record.result.unwrap().warning_count, 2);
    let errors = [
        ("panic", "internal", "the conversion ended unexpectedly"),
        ("broken", "internal", "the result could not be produced"),
        ("invalid", "invalid_model", "index 9 of 3"),
        ("image", "image_too_large", "a.png is large. Raise it with MESHCOLOR_MAX_IMAGE_PIXELS."),
    ];
    for (model, code, detail) in errors {
        let id = bench.submit(model).await;
        let error = bench.until(id, JobState::Failed).await.error.unwrap();
        assert_eq!((error.code.as_str(), error.detail.as_str()), (code, detail));
        assert_eq!(error.fault == Fault::Service, code == "internal");
    }
}

#[tokio::test]
async fn files_of_ended_jobs_are_results_alone() {
    let bench = start(Scratch::new(), 1).await;
    let good = bench.submit("ok").await;
    let bad = bench.submit("panic").await;
    bench.until(good, JobState::Succeeded).await;
    bench.until(bad, JobState::Failed).await;
    while bench.queue.follow(bad).is_some() {
        sleep(Duration::from_millis(2)).await;
    }
    let files: Vec<_> = bench.scratch.job_files();
    let expected: Vec<_> =
        ["", "/result", "/result/bundle.zip", "/result/preview.png", "/result/report.json"]
            .iter()
            .map(|file| format!("{good}{file}"))
            .collect();
    assert_eq!(files, expected);
}

#[tokio::test]
async fn a_cancel_reaches_the_run_and_is_final() {
    let bench = start(Scratch::new(), 1).await;
    let running = bench.submit("wait").await;
    let waiting = bench.submit("ok").await;
    bench.until(running, JobState::Running).await;
    assert_eq!(bench.queue.cancel(waiting).await.unwrap(), CancelOutcome::Canceled);
    assert_eq!(bench.queue.cancel(running).await.unwrap(), CancelOutcome::Requested);
    bench.until(running, JobState::Canceled).await;
    let stubborn = bench.submit("stubborn").await;
    bench.until(stubborn, JobState::Running).await;
    bench.queue.cancel(stubborn).await.unwrap();
    bench.until(stubborn, JobState::Canceled).await;
    while bench.queue.follow(stubborn).is_some() {
        sleep(Duration::from_millis(2)).await;
    }
    assert_eq!(bench.scratch.job_files(), Vec::<String>::new());
    assert_eq!(*bench.runner.runs.lock().unwrap(), ["wait", "stubborn"]);
}

#[tokio::test]
async fn a_deleted_job_leaves_nothing_even_while_it_runs() {
    let bench = start(Scratch::new(), 1).await;
    let id = bench.submit("stubborn").await;
    bench.until(id, JobState::Running).await;
    assert!(bench.queue.delete(id).await.unwrap());
    assert!(!bench.queue.delete(id).await.unwrap());
    let next = bench.submit("ok").await;
    bench.until(next, JobState::Succeeded).await;
    assert!(bench.queue.store.get(id).await.unwrap().is_none());
    assert!(bench.scratch.job_files().iter().all(|file| file.starts_with(&next.to_string())));
}

#[tokio::test]
async fn a_crash_loses_nothing_and_no_job_ends_twice() {
    let mut bench = start(Scratch::new(), 2).await;
    let mut ids = Vec::new();
    for index in 0..6 {
        ids.push(bench.submit(if index % 2 == 0 { "wait" } else { "ok" }).await);
    }
    bench.until(ids[0], JobState::Running).await;
    let mut ended: HashMap<JobId, JobRecord> = HashMap::new();
    for _ in 0..4 {
        for id in &ids {
            let record = bench.record(*id).await;
            if record.state.is_terminal() {
                let before = ended.entry(*id).or_insert_with(|| record.clone());
                assert_eq!(*before, record, "an end changed");
            }
        }
        bench = start(bench.crash().await, 2).await;
    }
    bench.runner.gate.store(true, Ordering::SeqCst);
    for id in &ids {
        let record = bench.until(*id, JobState::Succeeded).await;
        assert_eq!(record.attempt, 1, "interrupted runs count no attempt");
        assert!(bench.queue.folder.result(*id, "bundle.zip").is_file());
    }
}

#[tokio::test]
async fn a_stopping_service_puts_its_jobs_back() {
    let bench = start(Scratch::new(), 1).await;
    let id = bench.submit("wait").await;
    let next = bench.submit("ok").await;
    bench.until(id, JobState::Running).await;
    bench.queue.close(Duration::from_millis(20)).await;
    assert_eq!(bench.record(id).await.state, JobState::Queued);
    assert_eq!(bench.record(next).await.state, JobState::Queued);
    assert_eq!(bench.record(id).await.attempt, 0);
}

#[tokio::test]
async fn followers_see_progress_and_are_let_go_at_the_end() {
    let bench = start(Scratch::new(), 1).await;
    let id = bench.submit("wait").await;
    let mut follower = bench.queue.follow(id).unwrap();
    while follower.borrow_and_update().percent == 0 {
        follower.changed().await.unwrap();
    }
    let progress = *follower.borrow();
    assert_eq!((progress.revision, progress.percent, progress.stage), (2, 23, Some("read")));
    bench.runner.gate.store(true, Ordering::SeqCst);
    while follower.changed().await.is_ok() {}
    assert_eq!(bench.record(id).await.state, JobState::Succeeded);
    assert!(bench.queue.follow(id).is_none());
}
