//! Extractors whose refusals are problems, and small readers of headers.

use axum::extract::{FromRequestParts, Path, Query};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderName, header};

use super::Problem;
use crate::jobs::model::JobId;

/// The `{id}` of a job's path. What is no id is a job that does not exist.
pub struct JobPath(pub JobId);

impl<S: Send + Sync> FromRequestParts<S> for JobPath {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let path = Path::<String>::from_request_parts(parts, state).await.map_err(|_| no_such_job())?;
        path.0.parse().map(Self).map_err(|_| no_such_job())
    }
}

pub fn no_such_job() -> Problem {
    Problem::new("not_found", "there is no such job; it may have been deleted")
}

/// The query as names and values, each name once.
pub struct Parameters(Vec<(String, String)>);

impl<S: Send + Sync> FromRequestParts<S> for Parameters {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let refuse = || Problem::new("invalid_parameter", "the query is not name=value&name=value");
        let Query(pairs) =
            Query::<Vec<(String, String)>>::from_request_parts(parts, state).await.map_err(|_| refuse())?;
        for (index, (name, _)) in pairs.iter().enumerate() {
            if pairs[..index].iter().any(|(other, _)| other == name) {
                return Err(Problem::new("invalid_parameter", format!("\"{name}\" is given twice")));
            }
        }
        Ok(Self(pairs))
    }
}

impl Parameters {
    /// Takes a parameter out.
    pub fn take(&mut self, name: &str) -> Option<String> {
        let index = self.0.iter().position(|(other, _)| other == name)?;
        Some(self.0.remove(index).1)
    }

    /// Those that nobody took.
    pub fn rest(&self) -> &[(String, String)] {
        &self.0
    }

    /// Refuses what nobody took.
    pub fn finish(self, allowed: &str) -> Result<(), Problem> {
        match self.0.first() {
            None => Ok(()),
            Some((name, _)) => Err(Problem::new(
                "invalid_parameter",
                format!("there is no parameter \"{name}\" here; there are: {allowed}"),
            )),
        }
    }
}

/// A header as text.
pub fn text(headers: &HeaderMap, name: impl Into<HeaderName>) -> Option<&str> {
    headers.get(name.into())?.to_str().ok()
}

/// The seconds of `Prefer: wait=N` (RFC 7240), at most `most`.
pub fn preferred_wait(headers: &HeaderMap, most: u64) -> Option<u64> {
    let preferences = headers.get_all("prefer").iter().filter_map(|value| value.to_str().ok());
    let seconds = preferences.flat_map(|value| value.split([',', ';'])).find_map(|preference| {
        let (name, value) = preference.split_once('=')?;
        if !name.trim().eq_ignore_ascii_case("wait") {
            return None;
        }
        value.trim().trim_matches('"').parse::<u64>().ok()
    })?;
    Some(seconds.min(most))
}

/// Whether `If-None-Match` holds this tag (weak comparison, RFC 9110 13.1.2).
pub fn matches_tag(headers: &HeaderMap, tag: &str) -> bool {
    headers
        .get_all(header::IF_NONE_MATCH)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .map(|value| value.trim().trim_start_matches("W/"))
        .any(|value| value == tag || value == "*")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(name: &'static str, value: &str) -> HeaderMap {
        HeaderMap::from_iter([(HeaderName::from_static(name), value.parse().unwrap())])
    }

    #[test]
    fn waits_are_read_as_the_rfc_writes_them() {
        let wait = |value: &str| preferred_wait(&headers("prefer", value), 60);
        assert_eq!(wait("wait=5"), Some(5));
        assert_eq!(wait("respond-async, wait=100"), Some(60));
        assert_eq!(wait("Wait = \"7\""), Some(7));
        assert_eq!(wait("wait=-1"), None);
        assert_eq!(wait("waiting=1"), None);
        assert_eq!(preferred_wait(&HeaderMap::new(), 60), None);
    }

    #[test]
    fn tags_match_in_lists_and_weakly() {
        let matches = |value: &str| matches_tag(&headers("if-none-match", value), "\"a\"");
        assert!(matches("\"b\", W/\"a\""));
        assert!(matches("*"));
        assert!(!matches("\"b\""));
        assert!(!matches("a"));
    }
}
