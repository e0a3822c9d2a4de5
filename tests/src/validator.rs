//! The Khronos glTF validator, which runs under Node (`tests/validator`).

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use serde::Deserialize;

/// One finding of the validator.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Issue {
    pub severity: u8,
    pub code: String,
    pub message: String,
    /// JSON pointer; issues of the container have a byte offset instead.
    #[serde(default)]
    pub pointer: Option<String>,
}

impl Issue {
    pub const ERROR: u8 = 0;
    pub const WARNING: u8 = 1;
}

#[derive(Deserialize)]
struct Report {
    issues: Vec<Issue>,
}

/// The validator's findings about a GLB, or `None` where Node or the package is missing.
///
/// # Panics
/// Where the validator does not run to its end, and where it is missing although `tests/run` installed
/// it.
pub fn issues(glb: &[u8]) -> Option<Vec<Issue>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("validator");
    let start = || {
        let mut node = Command::new("node");
        node.args(["validate.mjs", "-"]).current_dir(&folder);
        node.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit()).spawn().ok()
    };
    let is_installed = folder.join("node_modules/gltf-validator").is_dir();
    let Some(mut node) = is_installed.then(start).flatten() else {
        assert!(!crate::requires_tools(), "the glTF validator is missing: run npm ci in tests/validator");
        return None;
    };
    node.stdin.take().expect("stdin is piped").write_all(glb).expect("node reads the file");
    let output = node.wait_with_output().expect("node ends");
    assert!(output.status.success(), "the glTF validator failed: {}", output.status);
    let report: Report = serde_json::from_slice(&output.stdout).expect("the validator prints JSON");
    Some(report.issues)
}

/// Fails with the list when there is an error or, where `warnings_too`, a warning. Prints that the test
/// was skipped where there is no validator.
pub fn expect_valid(name: &str, glb: &[u8], warnings_too: bool) {
    let Some(issues) = issues(glb) else {
        println!("skipped: {name} (no glTF validator; tests/run installs it)");
        return;
    };
    let worst = if warnings_too { Issue::WARNING } else { Issue::ERROR };
    let bad: Vec<&Issue> = issues.iter().filter(|issue| issue.severity <= worst).collect();
    assert!(bad.is_empty(), "{name}: {bad:#?}");
}
