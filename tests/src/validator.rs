//! Foreign readers, which run under Node (`tests/validator`): the Khronos glTF validator, and ktx-parse.

use std::collections::BTreeMap;
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
    let printed = node(&["validate.mjs", "-"], "gltf-validator", glb)?;
    let report: Report = serde_json::from_slice(&printed).expect("the validator prints JSON");
    Some(report.issues)
}

/// What ktx-parse reads in a KTX2 file; lists are as `validator/ktx.mjs` makes them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Ktx {
    pub format: u32,
    pub type_size: u32,
    pub size: [u32; 2],
    pub depth_layers_faces: [u32; 3],
    pub supercompression: u32,
    /// Stored and unpacked bytes of each level.
    pub levels: Vec<[u64; 2]>,
    pub keys: BTreeMap<String, String>,
    pub model: u8,
    pub primaries: u8,
    pub transfer: u8,
    /// Sides of a block of texels, less one.
    pub block: Vec<u32>,
    pub plane_bytes: u64,
    /// First bit and, less one, number of bits of each sample.
    pub samples: Vec<[u32; 2]>,
}

/// KTX2 files as ktx-parse reads them, or `None` where Node or the package is missing.
///
/// # Panics
/// As [`issues`], and where a file is none that the package reads.
pub fn ktx(files: &[&[u8]]) -> Option<Vec<Ktx>> {
    let lengths = files.iter().map(|file| (file.len() as u32).to_le_bytes());
    let input: Vec<u8> = lengths.zip(files).flat_map(|(length, file)| [&length[..], file].concat()).collect();
    let printed = node(&["ktx.mjs"], "ktx-parse", &input)?;
    let lines = printed.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
    Some(lines.map(|line| serde_json::from_slice(line).expect("a line of JSON")).collect())
}

/// Runs a script of `validator/` that needs a package; returns what it prints.
fn node(arguments: &[&str], package: &str, input: &[u8]) -> Option<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("validator");
    let start = || {
        let mut node = Command::new("node");
        node.args(arguments).current_dir(&folder);
        node.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit()).spawn().ok()
    };
    let is_installed = folder.join("node_modules").join(package).is_dir();
    let Some(mut node) = is_installed.then(start).flatten() else {
        assert!(!crate::requires_tools(), "{package} is missing: run npm ci in tests/validator");
        return None;
    };
    node.stdin.take().expect("stdin is piped").write_all(input).expect("node reads its input");
    let output = node.wait_with_output().expect("node ends");
    assert!(output.status.success(), "{package} failed: {}", output.status);
    Some(output.stdout)
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
