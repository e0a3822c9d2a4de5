//! A model on disk for the command line: the file and those beside and below it, and nothing else.
//! Symbolic links that leave the model's folder are refused, and names must match to the case, so that
//! a model that works here works in an upload.

use std::fs;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use meshcolor::read::{Files, Upload};
use meshcolor::{Error, ErrorCode, Result};

/// How many names an error message may list.
const LISTED_NAMES_COUNT: usize = 64;

/// Opens a model by its path; `-` is standard input, a model of a single file.
///
/// # Errors
/// `MissingResource` where there is no such file.
pub fn open(path: &Path) -> Result<Upload> {
    if path == Path::new("-") {
        let mut bytes = Vec::new();
        std::io::stdin()
            .lock()
            .read_to_end(&mut bytes)
            .map_err(|error| Error::internal(format!("standard input: {error}")))?;
        return Ok(Upload::single("stdin", bytes));
    }
    let missing =
        |detail: String| Error::new(ErrorCode::MissingResource, detail).at(path.display().to_string());
    // The model itself may be a link; its own folder is where its files are.
    let real = fs::canonicalize(path).map_err(|error| missing(error.to_string()))?;
    if !real.is_file() {
        return Err(missing("it is not a file".into()));
    }
    let (Some(folder), Some(name)) = (real.parent(), real.file_name().and_then(|name| name.to_str())) else {
        return Err(missing("the name is not UTF-8".into()));
    };
    Ok(Upload { main: name.to_owned(), files: Box::new(FolderFiles { root: folder.to_owned() }) })
}

/// The files of one folder.
struct FolderFiles {
    /// Canonical.
    root: PathBuf,
}

impl Files for FolderFiles {
    fn read(&self, path: &str) -> Result<Option<Vec<u8>>> {
        let relative = Path::new(path);
        let is_inside = relative.components().all(|part| matches!(part, Component::Normal(_)));
        if path.is_empty() || path.contains('\0') || !is_inside {
            return Err(Error::new(ErrorCode::UnsafeUri, format!("{path:?} leaves the model's folder")));
        }
        let Ok(real) = fs::canonicalize(self.root.join(relative)) else { return Ok(None) };
        let Ok(inside) = real.strip_prefix(&self.root) else {
            return Err(Error::new(
                ErrorCode::UnsafeUri,
                format!("{path:?} is a link that leaves the model's folder"),
            ));
        };
        // On file systems that fold case the canonical name tells; a link inside the folder is fine.
        let is_same_name =
            inside == relative || !inside.as_os_str().eq_ignore_ascii_case(relative.as_os_str());
        if !is_same_name || !real.is_file() {
            return Ok(None);
        }
        fs::read(&real).map(Some).map_err(|error| Error::internal(format!("{path}: {error}")))
    }

    fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        collect_names(&self.root, "", &mut names);
        names.sort();
        names
    }
}

/// Names of files below a folder, two levels deep and cut short: they serve error messages alone.
fn collect_names(folder: &Path, prefix: &str, names: &mut Vec<String>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let Ok(name) = entry.file_name().into_string() else { continue };
        let Ok(kind) = entry.file_type() else { continue };
        if names.len() >= LISTED_NAMES_COUNT || name.starts_with('.') {
            continue;
        }
        if kind.is_dir() && prefix.is_empty() {
            collect_names(&entry.path(), &format!("{name}/"), names);
        } else if kind.is_file() {
            names.push(format!("{prefix}{name}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;

    fn folder() -> TempDir {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        fs::create_dir_all(path.join("model/tex")).unwrap();
        fs::write(path.join("model/a.gltf"), "{}").unwrap();
        fs::write(path.join("model/tex/a.png"), "png").unwrap();
        fs::write(path.join("secret"), "secret").unwrap();
        std::os::unix::fs::symlink("../secret", path.join("model/link")).unwrap();
        std::os::unix::fs::symlink("tex/a.png", path.join("model/inner")).unwrap();
        folder
    }

    #[test]
    fn files_beside_and_below_are_found_by_their_exact_name() {
        let folder = folder();
        let upload = open(&folder.path().join("model/a.gltf")).unwrap();
        assert_eq!(upload.main, "a.gltf");
        let read = |path: &str| upload.files.read(path).unwrap();
        assert_eq!(read("tex/a.png").as_deref(), Some(&b"png"[..]));
        assert_eq!(read("inner").as_deref(), Some(&b"png"[..]));
        assert_eq!(read("tex/A.png"), None);
        assert_eq!(read("tex"), None);
        assert_eq!(upload.files.names(), ["a.gltf", "tex/a.png"]);
    }

    #[test]
    fn nothing_outside_is_reached() {
        let folder = folder();
        let upload = open(&folder.path().join("model/a.gltf")).unwrap();
        for path in ["../secret", "/etc/passwd", "link", "tex/../../secret", "a\0b", ""] {
            let error = upload.files.read(path).unwrap_err();
            assert_eq!(error.code, ErrorCode::UnsafeUri, "{path:?}");
        }
    }

    #[test]
    fn a_missing_model_is_the_callers_mistake() {
        let Err(error) = open(Path::new("/nonexistent/chair.glb")) else { panic!("opened") };
        assert_eq!(error.code, ErrorCode::MissingResource);
        assert_eq!(error.pointer.as_deref(), Some("/nonexistent/chair.glb"));
    }
}
