//! The HTTP API: one file for each resource with its routes, types and handlers. The OpenAPI document is
//! made of the same declarations.

#![allow(clippy::result_large_err, reason = "a problem is made once for a refused request")]

mod convert;
mod events;
mod extract;
mod identity;
mod jobs;
mod openapi;
mod ops;
mod page;
mod problem;
mod representation;
mod results;
mod upload;
mod upload_body;

use std::sync::Arc;

use axum::extract::DefaultBodyLimit;
use axum::response::IntoResponse;
use axum::{Router, middleware};
use tokio::sync::Semaphore;
use tower_http::catch_panic::CatchPanicLayer;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::jobs::queue::Queue;
use crate::settings::Settings;

pub use openapi::document;
pub use ops::Version;
pub use problem::Problem;

/// What every handler may use.
pub struct App {
    pub queue: Arc<Queue>,
    pub settings: Settings,
    /// One permit for each upload that is being received.
    pub uploads: Semaphore,
}

impl App {
    pub fn new(queue: Arc<Queue>, settings: Settings) -> Arc<Self> {
        let permits = usize::try_from(settings.max_concurrent_uploads).unwrap_or(usize::MAX);
        let uploads = Semaphore::new(permits.min(Semaphore::MAX_PERMITS));
        Arc::new(Self { queue, settings, uploads })
    }
}

fn api() -> OpenApiRouter<Arc<App>> {
    OpenApiRouter::with_openapi(openapi::base())
        .routes(routes!(jobs::submit, jobs::list))
        .routes(routes!(jobs::get, jobs::delete))
        .routes(routes!(jobs::cancel))
        .routes(routes!(events::follow))
        .routes(routes!(results::bundle))
        .routes(routes!(results::report))
        .routes(routes!(results::preview))
        .routes(routes!(convert::convert))
        .routes(routes!(convert::check))
        .routes(routes!(ops::livez))
        .routes(routes!(ops::readyz))
        .routes(routes!(ops::version))
        .routes(routes!(ops::openapi))
        .routes(routes!(page::page))
}

/// The whole service as one router.
pub fn router(app: Arc<App>) -> Router {
    let (router, _) = api().split_for_parts();
    router
        .fallback(not_found)
        .method_not_allowed_fallback(method_not_allowed)
        // Uploads count their own bytes; nothing else reads a body.
        .layer(DefaultBodyLimit::disable())
        .layer(CatchPanicLayer::custom(|_: Box<dyn std::any::Any + Send>| {
            Problem::internal("a handler panicked").into_response()
        }))
        .layer(middleware::from_fn(identity::middleware))
        .with_state(app)
}

async fn not_found() -> Problem {
    Problem::new("not_found", "there is no such path; GET /openapi.yaml lists all of them")
}

async fn method_not_allowed() -> Problem {
    Problem::new("method_not_allowed", "this path has other methods; the Allow header names them")
}

#[cfg(test)]
mod tests;
