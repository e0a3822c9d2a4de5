//! `/v1/convert` and `/v1/check`: a job in one request. What takes longer than the wait goes on as a
//! job, and the answer says where.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;

use super::extract::Parameters;
use super::jobs::{accepted, location, wait_until};
use super::openapi::UploadForm;
use super::representation::Job;
use super::results::{bundle_response, report_response};
use super::{App, Problem, upload};
use crate::jobs::model::{JobId, JobKind, JobState};

/// Converts a model and answers with the bundle.
#[utoipa::path(
    post, path = "/v1/convert", tag = "one request",
    request_body(content((UploadForm = "multipart/form-data"), (Vec<u8> = "model/gltf-binary"), (Vec<u8> = "model/gltf+json"), (Vec<u8> = "model/obj"), (Vec<u8> = "model/ply"), (Vec<u8> = "application/zip"), (Vec<u8> = "application/octet-stream"))),
    responses(
        (status = 200, description = "The bundle", body = Vec<u8>, content_type = "application/zip"),
        (status = 202, description = "It goes on; `Location` is the job", body = Job),
        (status = "4XX", description = "Refused, or the model is at fault", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn convert(
    State(app): State<Arc<App>>,
    parameters: Parameters,
    headers: HeaderMap,
    body: Body,
) -> Result<Response, Problem> {
    match run(&app, JobKind::Convert, parameters, &headers, body).await? {
        Run::Done(id) => located(bundle_response(&app, id, &HeaderMap::new()).await?, id),
        Run::GoesOn(response) => Ok(response),
    }
}

/// Measures a model's seams and answers with the report.
#[utoipa::path(
    post, path = "/v1/check", tag = "one request",
    request_body(content((UploadForm = "multipart/form-data"), (Vec<u8> = "model/gltf-binary"), (Vec<u8> = "model/gltf+json"), (Vec<u8> = "model/obj"), (Vec<u8> = "model/ply"), (Vec<u8> = "application/zip"), (Vec<u8> = "application/octet-stream"))),
    responses(
        (status = 200, description = "The report; its verdict may be `fail`", body = Object, content_type = "application/json"),
        (status = 202, description = "It goes on; `Location` is the job", body = Job),
        (status = "4XX", description = "Refused, or the model is at fault", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn check(
    State(app): State<Arc<App>>,
    parameters: Parameters,
    headers: HeaderMap,
    body: Body,
) -> Result<Response, Problem> {
    match run(&app, JobKind::Check, parameters, &headers, body).await? {
        Run::Done(id) => located(report_response(&app, id, &HeaderMap::new()).await?, id),
        Run::GoesOn(response) => Ok(response),
    }
}

enum Run {
    Done(JobId),
    GoesOn(Response),
}

async fn run(
    app: &App,
    kind: JobKind,
    parameters: Parameters,
    headers: &HeaderMap,
    body: Body,
) -> Result<Run, Problem> {
    let id = upload::accept(app, kind, parameters, headers, body).await?;
    let job = wait_until(app, id, app.settings.sync_timeout_seconds, |_| false).await?;
    match job.state() {
        JobState::Succeeded => Ok(Run::Done(id)),
        JobState::Failed => {
            let error = app.queue.store.get(id).await?.and_then(|record| record.error);
            Err(error.map_or_else(|| Problem::internal("a failed job without an error"), Problem::from))
        }
        JobState::Canceled => Err(Problem::new("canceled", format!("job {id} was canceled meanwhile"))),
        JobState::Queued | JobState::Running => Ok(Run::GoesOn(located(accepted(&job)?, id)?)),
    }
}

fn located(mut response: Response, id: JobId) -> Result<Response, Problem> {
    response.headers_mut().insert(header::LOCATION, location(id));
    response.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    Ok(response)
}
