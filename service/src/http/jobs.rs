//! `/v1/jobs`: submit, look, list, cancel, delete.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use tokio::time::{Instant, sleep, timeout_at};
use utoipa::ToSchema;

use super::extract::{JobPath, Parameters, matches_tag, no_such_job, preferred_wait};
use super::openapi::UploadForm;
use super::representation::{Job, header_value, json_headers};
use super::{App, Problem, upload};
use crate::jobs::model::{JobId, JobKind, JobState};
use crate::jobs::store::{CancelOutcome, Page};

const DEFAULT_PAGE_SIZE: u32 = 50;
const LARGEST_PAGE_SIZE: u32 = 200;

/// Submits a conversion.
///
/// Sends the model as `multipart/form-data`, or alone as the body with the options in the query. When
/// this answers, the job is on disk and survives a crash.
#[utoipa::path(
    post, path = "/v1/jobs", tag = "jobs",
    params(("Prefer" = Option<String>, Header, description = "`wait=N`: answer when the job has ended, after N seconds at most")),
    request_body(content((UploadForm = "multipart/form-data"), (Vec<u8> = "model/gltf-binary"), (Vec<u8> = "model/gltf+json"), (Vec<u8> = "model/obj"), (Vec<u8> = "model/ply"), (Vec<u8> = "application/zip"), (Vec<u8> = "application/octet-stream"))),
    responses(
        (status = 200, description = "Ended within the preferred wait", body = Job),
        (status = 202, description = "Accepted; `Location` is the job", body = Job),
        (status = "4XX", description = "Refused", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn submit(
    State(app): State<Arc<App>>,
    parameters: Parameters,
    headers: HeaderMap,
    body: Body,
) -> Result<Response, Problem> {
    let id = upload::accept(&app, JobKind::Convert, parameters, &headers, body).await?;
    let wait = preferred_wait(&headers, app.settings.max_wait_seconds);
    let job = wait_until(&app, id, wait.unwrap_or(0), |_| false).await?;
    let mut response = if job.state().is_terminal() {
        let (body, tag) = job.tagged()?;
        (StatusCode::OK, json_headers(&tag), body).into_response()
    } else {
        accepted(&job)?
    };
    response.headers_mut().insert(header::LOCATION, location(id));
    apply_preference(&mut response, wait);
    Ok(response)
}

/// The answer for work that goes on.
pub fn accepted(job: &Job) -> Result<Response, Problem> {
    let (body, tag) = job.tagged()?;
    let mut response = (StatusCode::ACCEPTED, json_headers(&tag), body).into_response();
    response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from_static("1"));
    Ok(response)
}

pub fn location(id: JobId) -> HeaderValue {
    header_value(&format!("/v1/jobs/{id}"))
}

fn apply_preference(response: &mut Response, wait: Option<u64>) {
    if let Some(seconds) = wait {
        response.headers_mut().insert("preference-applied", header_value(&format!("wait={seconds}")));
    }
}

/// Waits until a job has ended, `enough` holds or the time is over, and returns it as it is then.
pub async fn wait_until(
    app: &App,
    id: JobId,
    seconds: u64,
    enough: impl Fn(&Job) -> bool,
) -> Result<Job, Problem> {
    let deadline = Instant::now() + Duration::from_secs(seconds);
    let mut closing = app.queue.closing();
    loop {
        let mut follower = app.queue.follow(id);
        let progress = follower.as_mut().map(|follower| *follower.borrow_and_update());
        let record = app.queue.store.get(id).await?.ok_or_else(no_such_job)?;
        let job = Job::of(app, record, progress).await?;
        let is_over = Instant::now() >= deadline || *closing.borrow_and_update();
        if is_over || job.state().is_terminal() || enough(&job) {
            return Ok(job);
        }
        let change = async {
            match &mut follower {
                // An error says that the job has ended; the store tells how.
                Some(follower) => drop(follower.changed().await),
                None => sleep(Duration::from_millis(50)).await,
            }
        };
        tokio::select! {
            _ = timeout_at(deadline, change) => {}
            _ = closing.changed() => {}
        }
    }
}

/// Looks at a job.
///
/// With `Prefer: wait=N` it answers when the job has ended; with `If-None-Match` too, as soon as it
/// differs from what the client has.
#[utoipa::path(
    get, path = "/v1/jobs/{id}", tag = "jobs",
    params(
        ("id" = String, Path, description = "The job"),
        ("Prefer" = Option<String>, Header, description = "`wait=N`: seconds to wait"),
        ("If-None-Match" = Option<String>, Header, description = "The `ETag` that the client has"),
    ),
    responses(
        (status = 200, description = "The job", body = Job),
        (status = 304, description = "As the client has it"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn get(
    State(app): State<Arc<App>>,
    JobPath(id): JobPath,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wait = preferred_wait(&headers, app.settings.max_wait_seconds);
    let is_conditional = headers.contains_key(header::IF_NONE_MATCH);
    let differs =
        |job: &Job| is_conditional && job.tagged().is_ok_and(|(_, tag)| !matches_tag(&headers, &tag));
    let job = wait_until(&app, id, wait.unwrap_or(0), differs).await?;
    let (body, tag) = job.tagged()?;
    let mut response = if matches_tag(&headers, &tag) {
        (StatusCode::NOT_MODIFIED, json_headers(&tag)).into_response()
    } else {
        (json_headers(&tag), body).into_response()
    };
    apply_preference(&mut response, wait);
    Ok(response)
}

/// A page of jobs.
#[derive(Serialize, ToSchema)]
pub struct JobList {
    jobs: Vec<Job>,
    /// The `page_token` of the next page; null on the last one.
    next_page_token: Option<String>,
}

/// Lists jobs, newest first.
#[utoipa::path(
    get, path = "/v1/jobs", tag = "jobs",
    params(
        ("state" = Option<JobState>, Query, description = "Only jobs in this state"),
        ("page_size" = Option<u32>, Query, description = "1 to 200, otherwise 50"),
        ("page_token" = Option<String>, Query, description = "From the page before"),
    ),
    responses(
        (status = 200, description = "A page", body = JobList),
        (status = 400, description = "A parameter is not valid", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn list(State(app): State<Arc<App>>, mut parameters: Parameters) -> Result<Response, Problem> {
    let refuse = |name: &str, allowed: &str| {
        Problem::new("invalid_parameter", format!("{name} is not valid; allowed: {allowed}"))
    };
    let names: Vec<_> = JobState::ALL.iter().map(|state| state.name()).collect();
    let state = match parameters.take("state") {
        None => None,
        Some(name) => Some(JobState::from_name(&name).ok_or_else(|| refuse("state", &names.join(", ")))?),
    };
    let size = match parameters.take("page_size") {
        None => DEFAULT_PAGE_SIZE,
        Some(text) => text
            .parse()
            .ok()
            .filter(|size| (1..=LARGEST_PAGE_SIZE).contains(size))
            .ok_or_else(|| refuse("page_size", "1 to 200"))?,
    };
    let before = match parameters.take("page_token") {
        None => None,
        Some(token) => {
            Some(token.parse().map_err(|_| refuse("page_token", "a next_page_token of this list"))?)
        }
    };
    parameters.finish("state, page_size, page_token")?;
    // One more than asked for tells whether there is another page.
    let mut records = app.queue.store.list(Page { state, before, size: size + 1 }).await?;
    let has_more = records.len() > size as usize;
    records.truncate(size as usize);
    let next_page_token = records.last().filter(|_| has_more).map(|record| record.id.to_string());
    let mut jobs = Vec::with_capacity(records.len());
    for record in records {
        let progress = app.queue.follow(record.id).map(|follower| *follower.borrow());
        jobs.push(Job::of(&app, record, progress).await?);
    }
    Ok(Json(JobList { jobs, next_page_token }).into_response())
}

/// Cancels a job.
///
/// A job that has ended stays as it is; asking again changes nothing.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/cancel", tag = "jobs",
    params(("id" = String, Path, description = "The job")),
    responses(
        (status = 200, description = "It has ended", body = Job),
        (status = 202, description = "It is stopping", body = Job),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn cancel(State(app): State<Arc<App>>, JobPath(id): JobPath) -> Result<Response, Problem> {
    let outcome = app.queue.cancel(id).await?;
    let job = wait_until(&app, id, 0, |_| true).await?;
    if outcome == CancelOutcome::Requested && !job.state().is_terminal() {
        return accepted(&job);
    }
    let (body, tag) = job.tagged()?;
    Ok((json_headers(&tag), body).into_response())
}

/// Deletes a job with its files; one that has not ended is canceled first.
#[utoipa::path(
    delete, path = "/v1/jobs/{id}", tag = "jobs",
    params(("id" = String, Path, description = "The job")),
    responses(
        (status = 204, description = "Gone"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn delete(State(app): State<Arc<App>>, JobPath(id): JobPath) -> Result<StatusCode, Problem> {
    if app.queue.delete(id).await? { Ok(StatusCode::NO_CONTENT) } else { Err(no_such_job()) }
}
