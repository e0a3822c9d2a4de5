//! Putting a result in its place: written beside it under another name, then renamed, so that what
//! stands there is whole or what it was before.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use uuid::Uuid;

use super::outcome::UsageError;

/// The file by which an earlier bundle is known.
pub const BUNDLE_MARK: &str = "manifest.json";

/// A place beside the result; what is left there goes away with it.
pub struct Sibling {
    path: PathBuf,
}

impl Sibling {
    pub fn of(out: &Path) -> anyhow::Result<Self> {
        let name = out.file_name().and_then(|name| name.to_str()).unwrap_or("out");
        let parent = out.parent().filter(|parent| !parent.as_os_str().is_empty());
        let parent = parent.unwrap_or(Path::new("."));
        fs::create_dir_all(parent).with_context(|| format!("cannot make {}", parent.display()))?;
        let path = parent.join(format!(".{name}.{}.part", Uuid::new_v4().simple()));
        Ok(Self { path })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Puts it in place of `out`.
    pub fn rename_to(self, out: &Path) -> anyhow::Result<()> {
        let failed = || format!("cannot write {}", out.display());
        if out.is_dir() {
            // A folder can only be renamed onto an empty one, so the old one steps aside first.
            let aside = Self::of(out)?;
            fs::rename(out, aside.path()).with_context(failed)?;
            if let Err(error) = fs::rename(&self.path, out) {
                fs::rename(aside.path(), out).with_context(failed)?;
                return Err(error).with_context(failed);
            }
            return Ok(());
        }
        fs::rename(&self.path, out).with_context(failed)
    }
}

impl Drop for Sibling {
    fn drop(&mut self) {
        let _ = match fs::symlink_metadata(&self.path) {
            Ok(found) if found.is_dir() => fs::remove_dir_all(&self.path),
            Ok(_) => fs::remove_file(&self.path),
            Err(error) => Err(error),
        };
    }
}

/// Refuses a place that holds something which may not be replaced: `--force` replaces only folders that
/// hold the file `mark`.
pub fn check_free(out: &Path, is_zip: bool, is_forced: bool, mark: &str) -> anyhow::Result<()> {
    let refuse = |text: String| Err(UsageError(text).into());
    let shown = out.display();
    match fs::metadata(out) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error).with_context(|| format!("{shown}")),
        Ok(found) if found.is_dir() == is_zip => {
            let (is, wants) = if is_zip { ("a folder", "a file") } else { ("a file", "a folder") };
            refuse(format!("{shown} is {is}, and the result would be {wants}"))
        }
        Ok(_) if is_zip => {
            if is_forced {
                return Ok(());
            }
            refuse(format!("{shown} is there already; --force replaces it"))
        }
        Ok(_) => {
            let is_empty = fs::read_dir(out).with_context(|| format!("{shown}"))?.next().is_none();
            match (is_empty, is_forced, out.join(mark).is_file()) {
                (true, ..) | (_, true, true) => Ok(()),
                (_, true, false) => refuse(format!(
                    "{shown} is not empty and no earlier result (it has no {mark}); --force replaces those only"
                )),
                (_, false, _) => refuse(format!("{shown} is not empty; --force replaces an earlier result")),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_bundles_are_replaced_and_only_by_force() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path();
        let (bundle, other, zip) = (root.join("bundle"), root.join("other"), root.join("a.zip"));
        for folder in [&bundle, &other] {
            fs::create_dir(folder).unwrap();
        }
        assert!(check_free(&bundle, false, false, BUNDLE_MARK).is_ok(), "empty");
        fs::write(bundle.join("manifest.json"), "{}").unwrap();
        fs::write(other.join("thesis.tex"), "").unwrap();
        fs::write(&zip, "").unwrap();
        let free = |out: &Path, is_zip, is_forced| check_free(out, is_zip, is_forced, BUNDLE_MARK).is_ok();
        assert!(!free(&bundle, false, false) && free(&bundle, false, true));
        assert!(!free(&other, false, false) && !free(&other, false, true));
        assert!(!free(&zip, true, false) && free(&zip, true, true));
        assert!(!free(&zip, false, true) && !free(&bundle, true, true));
    }

    #[test]
    fn a_folder_takes_the_place_of_another_and_nothing_else_stays() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path();
        let out = root.join("out");
        fs::create_dir(&out).unwrap();
        fs::write(out.join("old"), "").unwrap();
        let sibling = Sibling::of(&out).unwrap();
        fs::create_dir(sibling.path()).unwrap();
        fs::write(sibling.path().join("new"), "").unwrap();
        sibling.rename_to(&out).unwrap();
        let abandoned = Sibling::of(&out).unwrap();
        fs::write(abandoned.path(), "half").unwrap();
        drop(abandoned);
        assert!(out.join("new").exists() && !out.join("old").exists());
        assert_eq!(fs::read_dir(root).unwrap().count(), 1);
    }
}
