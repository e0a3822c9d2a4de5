//! `/v1/jobs/{id}/events`: a job as it goes, as server-sent events.
//!
//! An event's id is made of the job's revision (it counts state changes, over restarts too) and the
//! percent, so ids only rise and a client that comes back with `Last-Event-ID` misses nothing new.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::http::{HeaderMap, HeaderName};
use axum::response::Sse;
use axum::response::sse::{Event, KeepAlive};
use futures_util::Stream;
use tokio::sync::mpsc::{Sender, channel};
use tokio_stream::wrappers::ReceiverStream;

use super::extract::{JobPath, no_such_job, text};
use super::representation::{Job, ProgressView};
use super::{App, Problem};
use crate::jobs::model::JobId;

/// Ids of one revision: the state at 0, progress at 1 to 101, the end behind it.
const IDS_PER_REVISION: u64 = 1000;
const DONE_OFFSET: u64 = IDS_PER_REVISION - 1;

const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// Follows a job.
///
/// Events `state` (a Job), `progress` (its progress) and `done` (the Job at its end); the stream closes
/// behind `done`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events", tag = "jobs",
    params(
        ("id" = String, Path, description = "The job"),
        ("Last-Event-ID" = Option<String>, Header, description = "The last event that the client has"),
    ),
    responses(
        (status = 200, description = "The events", body = String, content_type = "text/event-stream"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn follow(
    State(app): State<Arc<App>>,
    JobPath(id): JobPath,
    headers: HeaderMap,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, Problem> {
    app.queue.store.get(id).await?.ok_or_else(no_such_job)?;
    let seen = text(&headers, HeaderName::from_static("last-event-id")).and_then(|id| id.parse().ok());
    let (sender, receiver) = channel(4);
    tokio::spawn(Teller { app, id, sender, seen }.tell());
    let keep_alive = KeepAlive::new().interval(KEEP_ALIVE).text("still here");
    Ok(Sse::new(ReceiverStream::new(receiver)).keep_alive(keep_alive))
}

struct Teller {
    app: Arc<App>,
    id: JobId,
    sender: Sender<Result<Event, Infallible>>,
    /// The newest id that the client has.
    seen: Option<u64>,
}

impl Teller {
    /// Sends events until the job has ended, the client is gone or the service stops (a client then
    /// comes back with its last id).
    async fn tell(mut self) {
        let mut closing = self.app.queue.closing();
        loop {
            let mut follower = self.app.queue.follow(self.id);
            let progress = follower.as_mut().map(|follower| *follower.borrow_and_update());
            let record = match self.app.queue.store.get(self.id).await {
                Ok(Some(record)) => record,
                Ok(None) => return,
                Err(cause) => {
                    tracing::error!(error = ?cause, "events end early");
                    return;
                }
            };
            let base = record.revision * IDS_PER_REVISION;
            let view = ProgressView::of(&record, progress);
            let Ok(job) = Job::of(&self.app, record, progress).await else { return };
            let is_done = job.state().is_terminal();
            self.send(base, "state", &job).await;
            if is_done {
                self.send(base + DONE_OFFSET, "done", &job).await;
                return;
            }
            self.send(base + 1 + u64::from(view.percent()), "progress", &view).await;
            let sender = self.sender.clone();
            let change = async {
                match &mut follower {
                    Some(follower) => drop(follower.changed().await),
                    None => tokio::time::sleep(Duration::from_millis(50)).await,
                }
            };
            tokio::select! {
                () = change => {}
                () = sender.closed() => return,
                _ = closing.changed() => return,
            }
        }
    }

    /// Sends an event that the client does not have yet.
    async fn send(&mut self, id: u64, name: &str, data: &impl serde::Serialize) {
        if self.seen.is_some_and(|seen| seen >= id) {
            return;
        }
        let Ok(event) = Event::default().id(id.to_string()).event(name).json_data(data) else { return };
        self.seen = Some(id);
        let _ = self.sender.send(Ok(event)).await;
    }
}
