//! What operators and machines ask: alive, ready, which version, which API.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use meshcolor::pipeline::ENGINE_VERSION;
use serde::Serialize;
use utoipa::ToSchema;

use super::openapi::document;
use super::{App, Problem};
use crate::bundle::BUNDLE_VERSION;

/// Says that the process lives; touches nothing.
#[utoipa::path(get, path = "/livez", tag = "operation", responses((status = 200, description = "Alive", body = String, content_type = "text/plain")))]
pub async fn livez() -> &'static str {
    "alive\n"
}

/// Whether jobs can be taken.
#[derive(Serialize, ToSchema)]
pub struct Readiness {
    ready: bool,
    /// The job store answers.
    queue: bool,
    /// The data folder takes writes.
    storage: bool,
    /// The service is not stopping.
    accepting: bool,
}

/// Says whether jobs can be taken.
#[utoipa::path(
    get, path = "/readyz", tag = "operation",
    responses((status = 200, description = "Ready", body = Readiness), (status = 503, description = "Not ready", body = Readiness)),
)]
pub async fn readyz(State(app): State<Arc<App>>) -> Response {
    let queue = app.queue.store.queued_count(None).await.is_ok();
    let folder = app.queue.folder.clone();
    let storage = tokio::task::spawn_blocking(move || folder.probe()).await.is_ok_and(|probe| probe.is_ok());
    let accepting = !app.queue.is_closing();
    let ready = queue && storage && accepting;
    let status = if ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    (status, Json(Readiness { ready, queue, storage, accepting })).into_response()
}

/// What runs here.
#[derive(Serialize, ToSchema)]
pub struct Version {
    name: &'static str,
    version: &'static str,
    engine_version: &'static str,
    /// Of the bundles that it writes.
    bundle_version: u32,
}

impl Version {
    pub fn current() -> Self {
        Self {
            name: "meshcolor",
            version: env!("CARGO_PKG_VERSION"),
            engine_version: ENGINE_VERSION,
            bundle_version: BUNDLE_VERSION,
        }
    }

    pub fn text(&self) -> String {
        format!(
            "{} {} (engine {}, bundle {})",
            self.name, self.version, self.engine_version, self.bundle_version
        )
    }
}

/// Says what runs here.
#[utoipa::path(get, path = "/version", tag = "operation", responses((status = 200, description = "The versions", body = Version)))]
pub async fn version() -> Json<Version> {
    Json(Version::current())
}

/// This document.
#[utoipa::path(
    get, path = "/openapi.yaml", tag = "operation",
    responses(
        (status = 200, description = "The API", body = String, content_type = "application/yaml"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn openapi() -> Result<Response, Problem> {
    let text = document().map_err(Problem::internal)?;
    let kind = HeaderValue::from_static("application/yaml");
    Ok(([(header::CONTENT_TYPE, kind)], text).into_response())
}
