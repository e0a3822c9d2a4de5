//! Foreign readers and writers that run under Python (`tests/openimageio`): OpenImageIO, with the libraries that
//! Ptex and OpenEXR were published with.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

/// Part of an image file: of a Ptex file a face.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Part {
    pub size: [usize; 2],
    pub channels: usize,
    /// By row, column and channel; codes as shares of 1. `None` is no finite number.
    pub values: Vec<Option<f32>>,
}

/// The parts of files of a format, by file, or `None` where Python or the package is missing.
///
/// # Panics
/// Where a file is not read, and where the package is missing although `tests/run` installed it.
pub fn read(extension: &str, files: &[Vec<u8>]) -> Option<Vec<Vec<Part>>> {
    let folder = temporary_folder();
    let paths = (0..files.len()).map(|number| folder.path().join(format!("{number}.{extension}")));
    let paths: Vec<PathBuf> = paths.collect();
    for (path, bytes) in paths.iter().zip(files) {
        fs::write(path, bytes).expect("a temporary file");
    }
    let parts: Vec<Vec<Part>> = serde_json::from_slice(&python("texels.py", &paths)?).expect("JSON");
    assert_eq!(parts.len(), files.len());
    Some(parts)
}

/// The files that a script of `openimageio/` writes, by name, or `None` as in [`read`].
///
/// # Panics
/// Where the script fails, and as [`read`].
pub fn written_by(script: &str) -> Option<BTreeMap<String, Vec<u8>>> {
    let folder = temporary_folder();
    python(script, &[folder.path().to_owned()])?;
    let entries =
        fs::read_dir(folder.path()).expect("the folder that was made").map(|entry| entry.expect("an entry"));
    let named = |entry: fs::DirEntry| (entry.file_name().display().to_string(), fs::read(entry.path()));
    Some(entries.map(named).map(|(name, bytes)| (name, bytes.expect("a file"))).collect())
}

fn temporary_folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder for temporary files")
}

/// Runs a script of `openimageio/`; returns what it prints.
fn python(script: &str, arguments: &[PathBuf]) -> Option<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("openimageio");
    let packages = folder.join("packages");
    let start = || {
        let mut python = Command::new("python3");
        python.arg(folder.join(script)).args(arguments).env("PYTHONPATH", &packages).output().ok()
    };
    let Some(output) = packages.is_dir().then(start).flatten() else {
        assert!(!crate::requires_tools(), "OpenImageIO is missing: tests/run installs it");
        return None;
    };
    assert!(output.status.success(), "{script}: {}", String::from_utf8_lossy(&output.stderr));
    Some(output.stdout)
}
