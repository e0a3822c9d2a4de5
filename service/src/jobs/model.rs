//! What a job is: its identity, its states, what it was given, what it left.

use std::fmt;
use std::str::FromStr;

use meshcolor::measure::{Report, Verdict};
use meshcolor::pipeline::Options;
use meshcolor::{Error, ErrorCode};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::clock::Timestamp;

/// `job_` and 32 hexadecimal digits; ordered by creation within one process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JobId(Uuid);

impl JobId {
    pub fn new() -> Self {
        Self(Uuid::now_v7())
    }
}

impl Default for JobId {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "job_{}", self.0.simple())
    }
}

/// The text is no job id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a job id")]
pub struct NotAJobId;

impl FromStr for JobId {
    type Err = NotAJobId;

    fn from_str(text: &str) -> Result<Self, NotAJobId> {
        let digits = text.strip_prefix("job_").ok_or(NotAJobId)?;
        let is_canonical =
            digits.len() == 32 && digits.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        let id = Uuid::try_parse(digits).map_err(|_| NotAJobId)?;
        if is_canonical { Ok(Self(id)) } else { Err(NotAJobId) }
    }
}

/// A closed set of names, as the database and the API both write them.
macro_rules! names {
    ($(#[$doc:meta])* $type:ident { $($variant:ident = $name:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $type { $($variant),+ }

        impl $type {
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }

            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|value| value.name() == name)
            }
        }
    };
}

names!(
    /// Where a job stands. The last three are final.
    JobState {
        Queued = "queued",
        Running = "running",
        Succeeded = "succeeded",
        Failed = "failed",
        Canceled = "canceled",
    }
);

names!(
    /// What a job does: convert a model, or measure one.
    JobKind { Convert = "convert", Check = "check" }
);

impl JobState {
    pub fn is_terminal(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Canceled)
    }
}

/// What a client may choose: the conversion's options, and what comes along.
#[derive(Clone, Debug, PartialEq)]
pub struct JobOptions {
    pub conversion: Options,
    /// Whether to draw the seam-check sheet.
    pub preview: bool,
    /// Whether to run every rung too, and show what each costs.
    pub tradeoff: bool,
}

/// The yes-or-no options of the service itself.
pub struct SwitchSpec {
    pub name: &'static str,
    pub default: bool,
    pub doc: &'static str,
    field: fn(&mut JobOptions) -> &mut bool,
}

pub const SWITCHES: [SwitchSpec; 2] = [
    SwitchSpec {
        name: "preview",
        default: true,
        doc: "Whether to draw the seam-check sheet.",
        field: |options| &mut options.preview,
    },
    SwitchSpec {
        name: "tradeoff",
        default: false,
        doc: "Whether to convert by every rung of every ladder too, and by budgets of texels, and add `tradeoff/` with tables \
              and pictures of error against time and against texels. That is 24 conversions more: send it as a job.",
        field: |options| &mut options.tradeoff,
    },
];

impl Default for JobOptions {
    fn default() -> Self {
        let mut options = Self { conversion: Options::default(), preview: false, tradeoff: false };
        for switch in &SWITCHES {
            *(switch.field)(&mut options) = switch.default;
        }
        options
    }
}

impl JobOptions {
    /// # Errors
    /// `InvalidOptions`, naming the option and what is allowed.
    pub fn from_json(object: &Map<String, Value>) -> meshcolor::Result<Self> {
        let mut rest = object.clone();
        let mut options = Self::default();
        for switch in &SWITCHES {
            match rest.shift_remove(switch.name) {
                None => {}
                Some(Value::Bool(value)) => *(switch.field)(&mut options) = value,
                Some(other) => return Err(refused(switch.name, &other.to_string())),
            }
        }
        options.conversion = Options::from_json(&rest).map_err(with_switches_named)?;
        Ok(options)
    }

    /// Sets one option from its text form.
    ///
    /// # Errors
    /// As [`JobOptions::from_json`].
    pub fn set(&mut self, name: &str, value: &str) -> meshcolor::Result<()> {
        if let Some(switch) = SWITCHES.iter().find(|switch| switch.name == name) {
            *(switch.field)(self) = value.parse().map_err(|_| refused(name, value))?;
            return Ok(());
        }
        self.conversion.set(name, value).map_err(with_switches_named)
    }

    /// Every option with its value.
    pub fn to_json(&self) -> Map<String, Value> {
        let mut object = self.conversion.to_json();
        object.insert("preview".to_owned(), self.preview.into());
        object.insert("tradeoff".to_owned(), self.tradeoff.into());
        object
    }
}

fn refused(name: &str, value: &str) -> Error {
    Error::new(ErrorCode::InvalidOptions, format!("{name} = {value} is not allowed; allowed: true, false"))
        .at(format!("/{name}"))
}

/// The conversion's list of known options lacks the service's own.
fn with_switches_named(mut error: Error) -> Error {
    if error.detail.contains("there are: ") {
        for switch in &SWITCHES {
            error.detail.push_str(", ");
            error.detail.push_str(switch.name);
        }
    }
    error
}

/// One file of an upload, by the client's name and by ours.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredFile {
    pub path: String,
    /// Name inside the job's input folder; never made from `path`.
    pub stored: String,
    pub bytes: u64,
    pub sha256: String,
}

/// What a job was given; the model comes first.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JobInput {
    pub files: Vec<StoredFile>,
}

/// A result file that can be fetched.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ResultFile {
    pub bytes: u64,
    pub sha256: String,
}

/// What a job left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JobResult {
    pub verdict: Verdict,
    pub error_count: u64,
    pub warning_count: u64,
    pub max_seam_delta_codes: f64,
    pub bundle: Option<ResultFile>,
    pub preview: Option<ResultFile>,
    /// Why there is no picture although one was asked for.
    pub preview_failure: Option<String>,
}

impl JobResult {
    /// The figures of a report, before any file is known.
    pub fn of_report(report: &Report) -> Self {
        Self {
            verdict: report.verdict,
            error_count: report.errors.len() as u64,
            warning_count: report.warnings.iter().map(|warning| warning.count).sum(),
            max_seam_delta_codes: report.max_seam_delta_codes,
            bundle: None,
            preview: None,
            preview_failure: None,
        }
    }
}

/// Why a job failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobError {
    /// As in problem responses, such as `image_too_large`.
    pub code: String,
    /// What went wrong, where, and what is allowed.
    pub detail: String,
    /// Whose fault it is.
    pub fault: Fault,
    /// JSON pointer into the model, or `file:line`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pointer: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub limit: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub actual: Option<u64>,
}

names!(
    /// `input`: the file must change. `service`: the same file may succeed later.
    Fault { Input = "input", Service = "service" }
);

impl JobError {
    /// Our own fault. The cause has gone to the log; the client learns the job's id alone.
    pub fn internal(detail: &str) -> Self {
        Self {
            code: ErrorCode::Internal.name(),
            detail: detail.to_owned(),
            fault: Fault::Service,
            pointer: None,
            limit: None,
            actual: None,
        }
    }
}

/// How a job ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    Succeeded(JobResult),
    Failed(JobError),
    Canceled,
}

impl Ending {
    pub fn state(&self) -> JobState {
        match self {
            Self::Succeeded(_) => JobState::Succeeded,
            Self::Failed(_) => JobState::Failed,
            Self::Canceled => JobState::Canceled,
        }
    }
}

/// A job as it is stored.
#[derive(Clone, Debug, PartialEq)]
pub struct JobRecord {
    pub id: JobId,
    pub kind: JobKind,
    pub state: JobState,
    pub created_at: Timestamp,
    pub started_at: Option<Timestamp>,
    pub finished_at: Option<Timestamp>,
    pub attempt: u32,
    /// Counts state changes, from 1.
    pub revision: u64,
    pub cancel_requested: bool,
    pub engine_version: String,
    pub input: JobInput,
    pub options: Map<String, Value>,
    pub result: Option<JobResult>,
    pub error: Option<JobError>,
}

/// A job that is about to be accepted.
#[derive(Clone, Debug)]
pub struct NewJob {
    pub id: JobId,
    pub kind: JobKind,
    pub input: JobInput,
    pub options: JobOptions,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_read_back_and_nothing_else_does() {
        let id = JobId::new();
        assert_eq!(id.to_string().parse(), Ok(id));
        assert!(JobId::new() > id);
        let upper = id.to_string().replace("job_", "").to_uppercase();
        for text in ["", "job_", "job_../../etc", &format!("job_{upper}x"), "x"] {
            assert_eq!(text.parse::<JobId>(), Err(NotAJobId), "{text}");
        }
    }

    #[test]
    fn options_read_back_from_their_own_json() {
        let mut options = JobOptions::default();
        options.set("resolution", "fixed:3").unwrap();
        options.set("preview", "false").unwrap();
        options.set("tradeoff", "true").unwrap();
        assert_eq!(JobOptions::from_json(&options.to_json()).unwrap(), options);
    }

    #[test]
    fn wrong_options_name_what_is_allowed() {
        let read = |text: &str| {
            let Value::Object(object) = serde_json::from_str(text).unwrap() else { panic!() };
            JobOptions::from_json(&object).unwrap_err()
        };
        assert_eq!(read(r#"{"preview": "yes"}"#).pointer.as_deref(), Some("/preview"));
        assert!(read(r#"{"colour": 1}"#).detail.ends_with(", preview, tradeoff"));
        assert_eq!(read(r#"{"cut": 400}"#).code, ErrorCode::InvalidOptions);
    }
}
