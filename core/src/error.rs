//! The one error type of the conversion: what went wrong, where, what is allowed, how to mend it.
//!
//! `code` is the meaning that programs act on (the HTTP API sends it as it stands); `detail` is for
//! a person and always names the file or element, the figure and the setting that would change it.

use std::fmt;

use serde::Serialize;

pub type Result<T> = std::result::Result<T, Error>;

/// What kind of trouble it is. The names are part of the HTTP API (snake case).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorCode {
    /// The file breaks its own format's rules.
    InvalidModel,
    /// A URI that leaves the upload: scheme, absolute path, drive letter, `..`, NUL.
    UnsafeUri,
    /// A URI that points at the network.
    ExternalUri,
    /// A file that the model names is not in the upload.
    MissingResource,
    ImageTooLarge,
    TooManyTriangles,
    /// Any other element count over its limit (vertices, nodes, JSON bytes, JSON depth).
    ModelTooLarge,
    ArchiveRatio,
    ArchiveTooLarge,
    TooManyFiles,
    /// `extensionsRequired` names something that is not understood.
    UnsupportedExtension,
    /// None of the known formats, by its first bytes.
    UnsupportedMediaType,
    InvalidOptions,
    /// The layout would not fit the largest texture that is allowed.
    TextureTooLarge,
    /// The model has nothing that could be converted.
    NothingToConvert,
    Canceled,
    /// A promise of this program is broken: our fault, never the file's.
    Internal,
}

impl ErrorCode {
    /// The wire name, such as `image_too_large`.
    pub fn name(self) -> String {
        match serde_json::to_value(self) {
            Ok(serde_json::Value::String(name)) => name,
            _ => "internal".to_owned(),
        }
    }
}

/// An error with its place and its rule.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
pub struct Error {
    pub code: ErrorCode,
    pub detail: String,
    /// JSON pointer into the model (`/images/0`), or `file:line` for text formats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actual: Option<u64>,
}

impl Error {
    pub fn new(code: ErrorCode, detail: impl Into<String>) -> Self {
        Self { code, detail: detail.into(), pointer: None, limit: None, actual: None }
    }

    pub fn at(mut self, pointer: impl Into<String>) -> Self {
        self.pointer = Some(pointer.into());
        self
    }

    pub fn limit(mut self, limit: u64, actual: u64) -> Self {
        self.limit = Some(limit);
        self.actual = Some(actual);
        self
    }

    pub fn invalid(detail: impl Into<String>) -> Self {
        Self::new(ErrorCode::InvalidModel, detail)
    }

    pub fn internal(detail: impl Into<String>) -> Self {
        Self::new(ErrorCode::Internal, detail)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.pointer {
            Some(pointer) => write!(f, "{pointer}: {}", self.detail),
            None => f.write_str(&self.detail),
        }
    }
}

/// Recoverable trouble, reported with the element that it is about; nothing was lost because of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct Warning {
    /// Snake-case name of the rule, such as `degenerate_face`.
    pub code: String,
    /// What happened and what was done about it.
    pub detail: String,
    /// The element: a JSON pointer, or `file:line`.
    pub pointer: String,
    /// How many elements this warning stands for (the first one is `pointer`).
    pub count: u64,
}
