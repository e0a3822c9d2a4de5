//! The Job object as every route and event shows it.

use axum::http::{HeaderMap, HeaderValue, header};
use meshcolor::measure::Verdict;
use serde::Serialize;
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::{App, Problem};
use crate::jobs::model::{JobError, JobKind, JobOptions, JobRecord, JobState};
use crate::watch::{Progress, stage_names};

/// Characters of a client's file name that are shown.
const SHOWN_NAME_CHARS: usize = 256;

/// A conversion or check, from its submission to its result.
#[derive(Debug, Serialize, ToSchema)]
pub struct Job {
    id: String,
    kind: JobKind,
    state: JobState,
    /// `pass`, `warn` or `fail` once it has succeeded; a job whose result fails its check has succeeded.
    #[schema(value_type = Option<VerdictName>)]
    verdict: Option<Verdict>,
    #[schema(format = DateTime)]
    created_at: String,
    #[schema(format = DateTime)]
    started_at: Option<String>,
    #[schema(format = DateTime)]
    finished_at: Option<String>,
    /// When the result goes away; null: it stays until it is deleted.
    #[schema(format = DateTime)]
    expires_at: Option<String>,
    /// Times it was started, without those that a stopped service took back.
    attempt: u32,
    /// 1 is next; null once it runs.
    queue_position: Option<u64>,
    progress: ProgressView,
    input: InputView,
    /// Every option as resolved.
    #[schema(value_type = JobOptions)]
    options: Map<String, Value>,
    engine_version: String,
    /// Whether an earlier, equal submission answered this one.
    deduplicated: bool,
    report: Option<ReportView>,
    /// Null for checks.
    bundle: Option<FileView>,
    /// Null where none was asked for.
    preview: Option<PreviewView>,
    /// Why it failed.
    error: Option<JobError>,
}

/// `pass`: every guarantee holds. `warn`: it holds, and something deserves a look. `fail`: one is broken.
#[derive(ToSchema, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(dead_code)]
enum VerdictName {
    Pass,
    Warn,
    Fail,
}

#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct ProgressView {
    /// 0 to 100, never falling within one attempt.
    percent: u8,
    /// The stage that runs; stages up to `solve` run once for each texture channel.
    stage: Option<&'static str>,
    /// All stages in order.
    stages: Vec<&'static str>,
}

#[derive(Debug, Serialize, ToSchema)]
struct InputView {
    /// The model's name as it was sent, at most 256 characters of it.
    name: String,
    bytes: u64,
    sha256: String,
}

#[derive(Debug, Serialize, ToSchema)]
struct ReportView {
    #[schema(value_type = VerdictName)]
    verdict: Verdict,
    errors: u64,
    warnings: u64,
    /// Largest jump across an uncut edge, 8-bit codes.
    max_seam_delta: f64,
    url: String,
}

#[derive(Debug, Serialize, ToSchema)]
struct FileView {
    url: String,
    bytes: u64,
    sha256: String,
}

#[derive(Debug, Serialize, ToSchema)]
struct PreviewView {
    /// Null where the picture could not be drawn.
    url: Option<String>,
    /// Why it could not be drawn.
    failure: Option<String>,
}

impl ProgressView {
    pub fn of(record: &JobRecord, progress: Option<Progress>) -> Self {
        let progress = progress.filter(|progress| progress.revision == record.revision).unwrap_or_default();
        let percent = if record.state == JobState::Succeeded { 100 } else { progress.percent };
        Self { percent, stage: progress.stage, stages: stage_names() }
    }

    pub fn percent(&self) -> u8 {
        self.percent
    }
}

impl Job {
    /// The object of a stored job; progress is what its worker last said.
    pub async fn of(app: &App, record: JobRecord, progress: Option<Progress>) -> Result<Self, Problem> {
        let queue_position = match record.state {
            JobState::Queued => Some(app.queue.store.queued_count(Some(record.id)).await?),
            _ => None,
        };
        Ok(Self::with_position(record, progress, queue_position))
    }

    fn with_position(record: JobRecord, progress: Option<Progress>, queue_position: Option<u64>) -> Self {
        let url = |file: &str| format!("/v1/jobs/{}/{file}", record.id);
        let result = record.result.as_ref();
        let model = record.input.files.first();
        Self {
            verdict: result.map(|result| result.verdict),
            progress: ProgressView::of(&record, progress),
            input: InputView {
                name: model
                    .map(|file| file.path.chars().take(SHOWN_NAME_CHARS).collect())
                    .unwrap_or_default(),
                bytes: record.input.files.iter().map(|file| file.bytes).sum(),
                sha256: model.map(|file| file.sha256.clone()).unwrap_or_default(),
            },
            report: result.map(|result| ReportView {
                verdict: result.verdict,
                errors: result.error_count,
                warnings: result.warning_count,
                max_seam_delta: result.max_seam_delta_codes,
                url: url("report"),
            }),
            bundle: result.and_then(|result| result.bundle.as_ref()).map(|file| FileView {
                url: url("bundle"),
                bytes: file.bytes,
                sha256: file.sha256.clone(),
            }),
            preview: result.and_then(|result| match (&result.preview, &result.preview_failure) {
                (Some(_), _) => Some(PreviewView { url: Some(url("preview.png")), failure: None }),
                (None, Some(failure)) => Some(PreviewView { url: None, failure: Some(failure.clone()) }),
                (None, None) => None,
            }),
            id: record.id.to_string(),
            kind: record.kind,
            state: record.state,
            created_at: record.created_at.to_string(),
            started_at: record.started_at.map(|time| time.to_string()),
            finished_at: record.finished_at.map(|time| time.to_string()),
            expires_at: None,
            attempt: record.attempt,
            queue_position,
            options: record.options,
            engine_version: record.engine_version,
            deduplicated: false,
            error: record.error,
        }
    }

    pub fn state(&self) -> JobState {
        self.state
    }

    /// The object as bytes with its entity tag.
    pub fn tagged(&self) -> Result<(Vec<u8>, String), Problem> {
        let body = serde_json::to_vec(self).map_err(Problem::internal)?;
        let tag = format!("\"{}\"", &blake3::hash(&body).to_hex()[..32]);
        Ok((body, tag))
    }
}

/// A header value of text that this program made; what cannot be one is left empty.
pub fn header_value(text: &str) -> HeaderValue {
    HeaderValue::from_str(text).unwrap_or(HeaderValue::from_static(""))
}

/// Headers of a JSON answer with its tag.
pub fn json_headers(tag: &str) -> HeaderMap {
    HeaderMap::from_iter([
        (header::CONTENT_TYPE, HeaderValue::from_static("application/json")),
        (header::ETAG, header_value(tag)),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
    ])
}
