//! Errors as RFC 9457 `application/problem+json`. The message is for the client and names the figure and
//! the setting behind it; the cause of our own faults goes to the log.

use axum::Json;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

use super::identity;
use crate::jobs::model::JobError;
use crate::jobs::store::StoreError;

/// Where the codes are explained; a URI that names the kind, not a page that must exist.
const TYPE_PREFIX: &str = "urn:meshcolor:error:";

/// An error response.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Problem {
    /// URI of the kind of problem.
    #[serde(rename = "type")]
    kind: String,
    title: &'static str,
    /// HTTP status of this response.
    status: u16,
    /// What went wrong, with the figure and the setting that raises it.
    detail: String,
    /// Stable name that programs act on.
    code: String,
    /// The path that was asked.
    instance: String,
    request_id: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    limit: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    actual: Option<u64>,
    /// JSON pointer into the model or the options, or `file:line`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pointer: Option<String>,
    #[serde(skip)]
    retry_after_seconds: Option<u32>,
    #[serde(skip)]
    closes: bool,
}

/// Code, status and title of everything that this service answers itself.
const KINDS: &[(&str, u16, &str)] = &[
    ("malformed_multipart", 400, "The multipart body is malformed"),
    ("missing_part", 400, "A part is missing"),
    ("invalid_options", 400, "The options are not valid"),
    ("invalid_parameter", 400, "A parameter is not valid"),
    ("digest_mismatch", 400, "The body is not what its digest says"),
    ("incomplete_body", 400, "The body ended early"),
    ("not_found", 404, "There is nothing here"),
    ("method_not_allowed", 405, "This method is not offered here"),
    ("not_acceptable", 406, "This format is not offered"),
    ("upload_too_slow", 408, "The upload was too slow"),
    ("not_finished", 409, "The job has not finished"),
    ("not_succeeded", 409, "The job has no result"),
    ("canceled", 409, "The job was canceled"),
    ("body_too_large", 413, "The body is too large"),
    ("too_many_files", 413, "The upload has too many files"),
    ("archive_too_large", 413, "The archive is too large"),
    ("unsupported_media_type", 415, "This kind of file is not understood"),
    ("range_not_satisfiable", 416, "The range lies outside the file"),
    ("invalid_model", 422, "The model is not valid"),
    ("unsafe_uri", 422, "A URI leaves the upload"),
    ("external_uri", 422, "A URI points at the network"),
    ("missing_resource", 422, "A file is missing"),
    ("image_too_large", 422, "An image is too large"),
    ("too_many_triangles", 422, "The model has too many triangles"),
    ("model_too_large", 422, "The model is too large"),
    ("archive_ratio", 422, "The archive unpacks to suspiciously much"),
    ("unsupported_extension", 422, "A required extension is not understood"),
    ("texture_too_large", 422, "The converted texture would be too large"),
    ("nothing_to_convert", 422, "The model has nothing to convert"),
    ("queue_full", 429, "The queue is full"),
    ("too_many_uploads", 429, "Too many uploads at a time"),
    ("internal", 500, "Something broke here"),
    ("not_ready", 503, "The service is not ready"),
    ("queue_unavailable", 503, "The queue cannot be reached"),
    ("shutting_down", 503, "The service is stopping"),
    ("storage_full", 507, "The disk is full"),
];

impl Problem {
    pub fn new(code: &str, detail: impl Into<String>) -> Self {
        let (code, status, title) = KINDS.iter().find(|kind| kind.0 == code).copied().unwrap_or((
            "internal",
            500,
            "Something broke here",
        ));
        Self {
            kind: format!("{TYPE_PREFIX}{code}"),
            title,
            status,
            detail: detail.into(),
            code: code.to_owned(),
            instance: String::new(),
            request_id: String::new(),
            limit: None,
            actual: None,
            pointer: None,
            retry_after_seconds: None,
            closes: false,
        }
    }

    /// Our own fault: the cause goes to the log, the client learns the request's id.
    pub fn internal(cause: impl std::fmt::Display) -> Self {
        tracing::error!(%cause, request = %identity::current().request_id, "request failed");
        Self::new(
            "internal",
            "the request could not be completed; the log has the cause under this request id",
        )
    }

    /// A disk that does not take what it is given.
    pub fn storage(cause: &std::io::Error) -> Self {
        if matches!(cause.kind(), std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded) {
            return Self::new("storage_full", "there is no space left for this upload; try again later")
                .retry(30);
        }
        Self::internal(cause)
    }

    pub fn limit(mut self, limit: u64, actual: Option<u64>) -> Self {
        self.limit = Some(limit);
        self.actual = actual;
        self
    }

    pub fn retry(mut self, seconds: u32) -> Self {
        self.retry_after_seconds = Some(seconds);
        self
    }

    /// Says that the connection ends here, for answers that leave a body unread.
    pub fn closing(mut self) -> Self {
        self.closes = true;
        self
    }

    pub fn code(&self) -> &str {
        &self.code
    }
}

impl From<meshcolor::Error> for Problem {
    fn from(error: meshcolor::Error) -> Self {
        if error.code == meshcolor::ErrorCode::Internal {
            return Self::internal(error);
        }
        let problem = Self::new(&error.code.name(), error.detail);
        Self { limit: error.limit, actual: error.actual, pointer: error.pointer, ..problem }
    }
}

impl From<JobError> for Problem {
    fn from(error: JobError) -> Self {
        let problem = Self::new(&error.code, error.detail);
        Self { limit: error.limit, actual: error.actual, pointer: error.pointer, ..problem }
    }
}

impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::QueueFull { limit } => queue_full(limit),
            StoreError::Unavailable(cause) => {
                tracing::error!(cause = format!("{cause:#}"), "the job store failed");
                Self::new("queue_unavailable", "the job store does not answer; try again").retry(2)
            }
        }
    }
}

pub fn queue_full(limit: u64) -> Problem {
    Problem::new(
        "queue_full",
        format!("{limit} jobs wait already. The operator raises it with MESHCOLOR_QUEUE_MAX."),
    )
    .limit(limit, None)
    .retry(5)
}

impl IntoResponse for Problem {
    fn into_response(mut self) -> Response {
        let identity = identity::current();
        self.instance = identity.path;
        self.request_id = identity.request_id;
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let retry_after_seconds = self.retry_after_seconds;
        let closes = self.closes;
        let mut response = (status, Json(self)).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        if let Some(seconds) = retry_after_seconds {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        if closes {
            headers.insert(header::CONNECTION, HeaderValue::from_static("close"));
        }
        response
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meshcolor::ErrorCode;

    #[test]
    fn every_code_of_the_conversion_has_its_status() {
        use ErrorCode::*;
        let codes = [
            InvalidModel,
            UnsafeUri,
            ExternalUri,
            MissingResource,
            ImageTooLarge,
            TooManyTriangles,
            ModelTooLarge,
            ArchiveRatio,
            ArchiveTooLarge,
            TooManyFiles,
            UnsupportedExtension,
            UnsupportedMediaType,
            InvalidOptions,
            TextureTooLarge,
            NothingToConvert,
            Canceled,
        ];
        for code in codes {
            let problem = Problem::from(meshcolor::Error::new(code, "x"));
            assert_eq!(problem.code(), code.name());
            assert!((400..500).contains(&problem.status), "{code:?}");
        }
        assert_eq!(Problem::from(meshcolor::Error::internal("secret")).status, 500);
    }

    #[test]
    fn causes_of_our_own_faults_stay_here() {
        let problem = Problem::from(meshcolor::Error::internal("/secret/path"));
        assert!(!serde_json::to_string(&problem).unwrap().contains("secret"));
    }
}
