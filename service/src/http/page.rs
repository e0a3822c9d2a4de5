//! `/`: a page that explains the service to whoever opens it in a browser. No scripts, no pictures,
//! nothing from elsewhere; the style's hash stands in the content security policy.

use std::sync::LazyLock;

use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use meshcolor::pipeline::OPTIONS;
use sha2::{Digest, Sha256};

use super::representation::header_value;
use crate::jobs::model::SWITCHES;

const STYLE: &str = include_str!("page.css");
const BODY: &str = include_str!("page.html");

/// The page and its policy, the same for every request.
static PAGE: LazyLock<(String, HeaderValue)> = LazyLock::new(|| {
    let rows: String = OPTIONS
        .iter()
        .map(|spec| {
            let cells = [spec.name, spec.default, spec.doc, spec.allowed].map(escape);
            let [name, default, doc, allowed] = cells;
            format!("<tr><td><code>{name}</code></td><td><code>{default}</code></td><td>{doc}. <small>{allowed}</small></td></tr>\n")
        })
        .collect();
    let switches: String = SWITCHES
        .iter()
        .map(|switch| {
            let [name, default, doc] = [switch.name, &switch.default.to_string(), switch.doc].map(escape);
            format!("<tr><td><code>{name}</code></td><td><code>{default}</code></td><td>{doc}</td></tr>\n")
        })
        .collect();
    let html = BODY
        .replace("{{style}}", STYLE)
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
        .replace("{{options}}", &rows)
        .replace("{{switches}}", &switches);
    let hash = STANDARD.encode(Sha256::digest(STYLE));
    let policy = format!(
        "default-src 'none'; style-src 'sha256-{hash}'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; sandbox"
    );
    (html, header_value(&policy))
});

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Explains the service.
#[utoipa::path(get, path = "/", tag = "operation", responses((status = 200, description = "A page", body = String, content_type = "text/html")))]
pub async fn page() -> Response {
    let (html, policy) = &*PAGE;
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8")),
        (header::CONTENT_SECURITY_POLICY, policy.clone()),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
    ];
    (headers, html.as_str()).into_response()
}
