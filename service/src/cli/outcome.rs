//! How a command ended, as its exit code, and how errors are said on standard error.

use std::io;
use std::path::Path;
use std::process::ExitCode;

use meshcolor::ErrorCode;
use meshcolor::read::Limits;

use crate::settings::raising_hint;

/// In rising order of weight: of many files the heaviest counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    Fine,
    /// Something at or above `--fail-on`.
    Findings,
    Usage,
    /// The input breaks its format's rules or a limit.
    Refused,
    /// Disk, network, ourselves.
    Failed,
    /// A signal ended it; its number.
    Signal(u8),
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        ExitCode::from(match outcome {
            Outcome::Fine => 0,
            Outcome::Findings => 1,
            Outcome::Usage => 2,
            Outcome::Refused => 3,
            Outcome::Failed => 4,
            Outcome::Signal(number) => 128 + number,
        })
    }
}

/// The caller asked for something that cannot be.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// Of options, which name themselves in the text.
impl From<meshcolor::Error> for UsageError {
    fn from(error: meshcolor::Error) -> Self {
        Self(error.detail)
    }
}

/// A model's error with the path that was asked for in front of its place, so that of several models the right one is
/// named, and named once.
pub fn in_file(path: &Path, mut error: meshcolor::Error) -> meshcolor::Error {
    let shown = path.display().to_string();
    let name = path.file_name().map(|name| name.display().to_string());
    let place = error.pointer.take().unwrap_or_default();
    let behind =
        |file: &str| place.strip_prefix(file).filter(|rest| rest.is_empty() || rest.starts_with([':', ',']));
    let named = match behind(&shown).or_else(|| behind(name.as_deref()?)) {
        Some(rest) => format!("{shown}{rest}"),
        None if place.is_empty() => shown,
        None => format!("{shown}: {place}"),
    };
    error.at(named)
}

impl Outcome {
    /// Says the error and returns what it means.
    pub fn of_error(error: &anyhow::Error) -> Self {
        let is_closed_pipe = |cause: &io::Error| cause.kind() == io::ErrorKind::BrokenPipe;
        if error.chain().filter_map(|cause| cause.downcast_ref()).any(is_closed_pipe) {
            return Self::Fine; // whoever reads has seen enough
        }
        eprintln!("meshcolor: {error:#}");
        let cause = error.downcast_ref::<meshcolor::Error>();
        // Who has changed a limit knows its name; the others are told.
        let hint = cause.and_then(|cause| raising_hint(&Limits::default(), cause.code, cause.limit?));
        if let Some(hint) = hint {
            eprintln!("{hint}");
        }
        if error.is::<UsageError>() {
            return Self::Usage;
        }
        cause.map_or(Self::Failed, |cause| Self::of_code(cause.code))
    }

    pub fn of_code(code: ErrorCode) -> Self {
        match code {
            ErrorCode::Internal | ErrorCode::Canceled => Self::Failed,
            ErrorCode::InvalidOptions => Self::Usage,
            _ => Self::Refused,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_heaviest_counts() {
        assert_eq!(Outcome::Findings.max(Outcome::Refused), Outcome::Refused);
        assert_eq!(Outcome::Refused.max(Outcome::Failed), Outcome::Failed);
        assert_eq!(Outcome::Fine.max(Outcome::Findings), Outcome::Findings);
    }

    #[test]
    fn errors_keep_their_meaning_through_context() {
        use anyhow::Context;
        let error = Err::<(), _>(meshcolor::Error::invalid("x")).context("chair.glb").unwrap_err();
        assert_eq!(Outcome::of_error(&error), Outcome::Refused);
        assert_eq!(Outcome::of_error(&UsageError("x".into()).into()), Outcome::Usage);
        assert_eq!(Outcome::of_error(&anyhow::anyhow!("x")), Outcome::Failed);
    }

    #[test]
    fn files_are_named_once() {
        let said = |place: Option<&str>| {
            let error = meshcolor::Error::invalid("why");
            let error = place.into_iter().fold(error, meshcolor::Error::at);
            in_file(Path::new("models/a.obj"), error).to_string()
        };
        assert_eq!(said(None), "models/a.obj: why");
        assert_eq!(said(Some("a.obj")), "models/a.obj: why");
        assert_eq!(said(Some("models/a.obj")), "models/a.obj: why");
        assert_eq!(said(Some("a.obj:7")), "models/a.obj:7: why");
        assert_eq!(said(Some("a.obj, face 7")), "models/a.obj, face 7: why");
        assert_eq!(said(Some("a.obj.mtl:7")), "models/a.obj: a.obj.mtl:7: why");
        assert_eq!(said(Some("/images/0")), "models/a.obj: /images/0: why");
    }
}
