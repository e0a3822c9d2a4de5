//! Golden cases: a folder each in `tests/cases`, with a model, `case.json` (main file, options, and what
//! must hold whatever was recorded) and `expected.json` (the recorded key figures).
//!
//! `UPDATE_CASES=1` records anew. A case that fails leaves both sides under `target/cases/NAME`.

mod figures;
mod script;

pub use script::{files_of_cases, made_by};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use meshcolor::pipeline::{Conversion, Options, check, convert};
use meshcolor::read::{Limits, MemoryFiles, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor::{Error, finished};
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::validator;

/// `case.json`.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// For people.
    pub purpose: String,
    main: String,
    pub options: Map<String, Value>,
    limits: CaseLimits,
    /// JSON pointers into the figures with their values; `null` where nothing may stand.
    expect: BTreeMap<String, Value>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CaseLimits {
    texture_side: Option<u32>,
}

/// Part of the expectations that is no pointer: words of an error's detail.
const DETAIL_CONTAINS: &str = "detail_contains";

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cases")
}

/// Names of all cases, sorted.
///
/// # Panics
/// Where the folder cannot be read.
pub fn names() -> Vec<String> {
    names_in(&folder())
}

/// Names of the cases in a folder, sorted.
///
/// # Panics
/// Where the folder cannot be read.
pub fn names_in(folder: &Path) -> Vec<String> {
    let entries =
        std::fs::read_dir(folder).expect("the folder of cases").map(|entry| entry.expect("an entry"));
    let folders = entries.filter(|entry| entry.path().is_dir() && entry.file_name() != "__pycache__");
    let mut names: Vec<String> =
        folders.map(|entry| entry.file_name().into_string().expect("UTF-8")).collect();
    names.sort();
    names
}

/// Runs one case.
///
/// # Panics
/// Where a figure is not what it has to be, with both.
pub fn run(name: &str) {
    let folder = folder().join(name);
    let case = Case::load(&folder);
    let (figures, detail) = case.figures(name, &folder);
    case.judge_figures(&folder, &figures, &detail, &(figures::text(&figures, 0) + "\n"));
}

fn equal(found: &Value, wanted: &Value) -> bool {
    match (found.as_f64(), wanted.as_f64()) {
        (Some(found), Some(wanted)) => found == wanted,
        _ => found == wanted,
    }
}

/// Leaves both sides of a failing case and says where.
fn leave(name: &str, expected: &str, actual: &str) -> PathBuf {
    let folder = target().join("cases").join(name);
    std::fs::create_dir_all(&folder).expect("the target folder");
    std::fs::write(folder.join("expected.json"), expected).expect("expected.json");
    std::fs::write(folder.join("actual.json"), actual).expect("actual.json");
    folder
}

impl Case {
    /// # Panics
    /// Where `case.json` is missing or not what it has to be.
    pub fn load(folder: &Path) -> Self {
        let path = folder.join("case.json");
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    /// Holds figures against what the case expects, then against what was recorded as `actual`; records
    /// instead with `UPDATE_CASES=1`.
    ///
    /// # Panics
    /// Where a figure is not what it has to be, with both.
    pub fn judge_figures(&self, folder: &Path, figures: &Value, detail: &str, actual: &str) {
        let name = folder.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        for (pointer, wanted) in &self.expect {
            if pointer == DETAIL_CONTAINS {
                let wanted = wanted.as_str().expect("a text");
                assert!(detail.contains(wanted), "{name}: the detail lacks {wanted:?}: {detail}");
                continue;
            }
            let found = figures.pointer(pointer).unwrap_or(&Value::Null);
            assert!(equal(found, wanted), "{name}: {pointer} is {found}, not {wanted}, in\n{actual}");
        }
        let path = folder.join("expected.json");
        if std::env::var_os("UPDATE_CASES").is_some_and(|value| value == "1") {
            std::fs::write(path, actual).expect("expected.json");
            return;
        }
        let expected = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        if actual != expected {
            let left = leave(name, &expected, actual);
            panic!(
                "{name}: not the recorded figures; both are in {}\nexpected {expected}\nactual {actual}",
                left.display()
            );
        }
    }

    pub fn upload(&self, folder: &Path) -> Upload {
        let mut files = MemoryFiles::default();
        for entry in std::fs::read_dir(folder).expect("the case's folder") {
            let path = entry.expect("an entry").path();
            let name = path.file_name().and_then(|name| name.to_str()).expect("UTF-8").to_owned();
            if !["case.json", "expected.json"].contains(&name.as_str()) {
                files.0.insert(name, std::fs::read(&path).expect("a file"));
            }
        }
        Upload { main: self.main.clone(), files: Box::new(files) }
    }

    pub fn limits(&self) -> Limits {
        let mut limits = Limits::default();
        limits.texture_side = self.limits.texture_side.unwrap_or(limits.texture_side);
        limits
    }

    /// The key figures, and an error's detail.
    fn figures(&self, name: &str, folder: &Path) -> (Value, String) {
        let options = Options::from_json(&self.options).unwrap_or_else(|e| panic!("{name}: {e}"));
        match convert(&self.upload(folder), &options, &self.limits(), &Unwatched) {
            Ok(conversion) => {
                judge(name, &conversion, &options);
                (figures::of(&conversion), String::new())
            }
            Err(Error { code, detail, pointer, limit, actual }) => {
                let error = serde_json::json!({
                    "code": code.name(), "pointer": pointer, "limit": limit, "actual": actual
                });
                (serde_json::json!({ "error": error }), detail)
            }
        }
    }
}

/// What holds for every conversion: the file is valid, comes back as it was, and keeps its promises when
/// it is measured from the file alone.
fn judge(name: &str, conversion: &Conversion, options: &Options) {
    let glb = &conversion.files[0].bytes;
    validator::expect_valid(name, glb, false);
    let upload = || Upload::single("asset.glb", glb.clone());
    let back =
        read(&upload(), &Limits::default(), &Unwatched).unwrap_or_else(|e| panic!("{name}, written: {e}"));
    let found =
        finished::extract(&back).unwrap_or_else(|e| panic!("{name}, written: {e}")).expect("a conversion");
    assert!(found.textures == conversion.finished.textures, "{name}: other textures come back");
    let report =
        check(&upload(), options, &Limits::default(), &Unwatched).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(report.errors, Vec::<String>::new(), "{name}");
    let seams = |report: &meshcolor::measure::Report| -> Vec<_> {
        let levels = report.channels.iter().flat_map(|channel| &channel.levels);
        levels.map(|level| level.seams.map(|seams| (seams.max, seams.sample_count))).collect()
    };
    assert_eq!(seams(&report), seams(&conversion.report), "{name}: the file's seams are not the report's");
}

/// Cargo's target folder, three levels above the test's binary.
fn target() -> PathBuf {
    let binary = std::env::current_exe().expect("the test's own path");
    binary.ancestors().nth(3).expect("target/PROFILE/deps").to_owned()
}
