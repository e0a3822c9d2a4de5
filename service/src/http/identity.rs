//! Who a request is: its id (the client's, or made here) and its path, for answers and the log; and the
//! headers that every answer carries.

use axum::extract::Request;
use axum::http::{HeaderName, HeaderValue, header};
use axum::middleware::Next;
use axum::response::Response;
use uuid::Uuid;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Longest id that is taken from a client.
const LONGEST_ID_BYTES: usize = 128;

#[derive(Clone, Debug, Default)]
pub struct Identity {
    pub request_id: String,
    pub path: String,
}

tokio::task_local! {
    static CURRENT: Identity;
}

/// The request that this task answers; empty outside one.
pub fn current() -> Identity {
    CURRENT.try_with(Clone::clone).unwrap_or_default()
}

/// Gives the request its id and the answer its common headers.
pub async fn middleware(request: Request, next: Next) -> Response {
    let given = request.headers().get(REQUEST_ID).and_then(|value| value.to_str().ok());
    let request_id = match given.filter(|id| is_plain(id)) {
        Some(id) => id.to_owned(),
        None => Uuid::now_v7().to_string(),
    };
    let path = request.uri().path().to_owned();
    let method = request.method().clone();
    let is_quiet = matches!(path.as_str(), "/livez" | "/readyz");
    let identity = Identity { request_id: request_id.clone(), path: path.clone() };
    let mut response = CURRENT.scope(identity, next.run(request)).await;
    if !is_quiet {
        let status = response.status().as_u16();
        tracing::info!(%method, %path, status, request = %request_id, "answered");
    }
    let headers = response.headers_mut();
    if let Ok(value) = HeaderValue::from_str(&request_id) {
        headers.insert(REQUEST_ID, value);
    }
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers
        .entry(header::CONTENT_SECURITY_POLICY)
        .or_insert(HeaderValue::from_static("default-src 'none'; frame-ancestors 'none'; sandbox"));
    response
}

fn is_plain(id: &str) -> bool {
    !id.is_empty() && id.len() <= LONGEST_ID_BYTES && id.bytes().all(|byte| byte.is_ascii_graphic())
}
