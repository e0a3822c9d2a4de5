//! A runner for tests that does what the model's bytes say, and a data folder that goes away.

use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use image::ImageFormat;
use meshcolor::measure::Verdict;
use meshcolor::watch::{Stage, Watch};
use meshcolor::write::BundleFile;
use meshcolor::{Error, ErrorCode};
use tempfile::TempDir;

use super::folder::{BUNDLE_FILE, PREVIEW_FILE, REPORT_FILE};
use super::model::{JobKind, JobResult};
use super::runner::{RunError, Runner, Task, describe};
use crate::bundle::write_zip;

/// What it does by the model's text:
/// `ok…` succeeds; `wait…` runs until it is stopped or the gate opens; `stubborn…` too, and then
/// succeeds although it was stopped; `panic`, `invalid`, `image`, `broken` fail.
#[derive(Default)]
pub struct Scripted {
    pub gate: AtomicBool,
    /// The model of every run, in order of their starts.
    pub runs: Mutex<Vec<String>>,
}

impl Runner for Scripted {
    fn run(&self, task: &Task<'_>) -> Result<JobResult, RunError> {
        let bytes = task.upload.files.read(&task.upload.main)?;
        let text = String::from_utf8(bytes.unwrap_or_default()).unwrap_or_default();
        self.runs.lock().unwrap().push(text.clone());
        task.watch.stage(Stage::Read);
        task.watch.progress(0.25);
        if text.starts_with("wait") || text.starts_with("stubborn") {
            fs::write(task.out.join(REPORT_FILE), "half")?;
            while !self.gate.load(Ordering::SeqCst) && !task.watch.canceled() {
                std::thread::sleep(Duration::from_millis(2));
            }
            if text.starts_with("wait") {
                meshcolor::watch::check(task.watch)?;
            }
        }
        match text.as_str() {
            "panic" => panic!("a secret in a panic"),
            "broken" => Err(anyhow::anyhow!("a secret path").into()),
            "invalid" => Err(Error::invalid("index 9 of 3").at("/accessors/0").into()),
            "image" => Err(Error::new(ErrorCode::ImageTooLarge, "a.png is large.")
                .limit(67_108_864, 9e8 as u64)
                .into()),
            _ => succeed(task),
        }
    }
}

fn succeed(task: &Task<'_>) -> Result<JobResult, RunError> {
    fs::write(task.out.join(REPORT_FILE), r#"{"verdict":"warn"}"#)?;
    let mut result = JobResult {
        verdict: Verdict::Warn,
        error_count: 0,
        warning_count: 2,
        max_seam_delta_codes: 0.75,
        bundle: None,
        preview: None,
        preview_failure: None,
    };
    if task.kind == JobKind::Convert {
        let path = task.out.join(BUNDLE_FILE);
        let file = BundleFile { path: "asset.glb".into(), bytes: (0..=255).collect() };
        write_zip(&[file], fs::File::create(&path)?)?;
        result.bundle = Some(describe(&path)?);
        if task.options.preview {
            let mut png = Cursor::new(Vec::new());
            image::RgbImage::new(300, 150)
                .write_to(&mut png, ImageFormat::Png)
                .map_err(anyhow::Error::from)?;
            fs::write(task.out.join(PREVIEW_FILE), png.into_inner())?;
            result.preview = Some(describe(&task.out.join(PREVIEW_FILE))?);
        }
    }
    Ok(result)
}

/// A folder of its own for each test.
pub struct Scratch(TempDir);

impl Scratch {
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Relative paths of all files and empty folders below `jobs`.
    pub fn job_files(&self) -> Vec<String> {
        let mut found = Vec::new();
        let jobs = self.path().join("jobs");
        let mut folders = vec![jobs.clone()];
        while let Some(folder) = folders.pop() {
            // A job may be done with a folder in the meantime.
            let Ok(entries) = fs::read_dir(folder) else { continue };
            for entry in entries {
                let path = entry.unwrap().path();
                found.push(path.strip_prefix(&jobs).unwrap().display().to_string());
                if path.is_dir() {
                    folders.push(path);
                }
            }
        }
        found.sort();
        found
    }
}
