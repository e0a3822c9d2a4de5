//! The model files of cases against what their script writes.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// All files below a folder's folders, by `CASE/FILE`, but what conversions recorded.
///
/// # Panics
/// Where a file cannot be read.
pub fn files_of_cases(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for case in super::names_in(folder) {
        for file in std::fs::read_dir(folder.join(&case)).expect("a case's folder") {
            let file = file.expect("an entry");
            let name = format!("{case}/{}", file.file_name().display());
            if !name.ends_with("/expected.json") {
                files.insert(name, std::fs::read(file.path()).expect("a file"));
            }
        }
    }
    files
}

/// What a script writes today; `None`, and a line that says so, without Python.
///
/// # Panics
/// Where the script fails.
pub fn made_by(script: &Path) -> Option<BTreeMap<String, Vec<u8>>> {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let Ok(status) = Command::new("python3").arg(script).arg(folder.path()).status() else {
        println!("skipped: make.py (no python3)");
        return None;
    };
    assert!(status.success(), "{}: {status}", script.display());
    Some(files_of_cases(folder.path()))
}
