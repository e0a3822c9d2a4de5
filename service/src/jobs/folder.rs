//! The data folder: a lock, the database, and one folder for each job with what it was given and what
//! it left. The one place that knows paths; another store of bytes would replace this module.
//!
//! ```text
//! lock  meshcolor.db  jobs/JOB/input/UUID…  jobs/JOB/result/bundle.zip report.json preview.png
//! ```
//!
//! Results are written in `result.part`, flushed to disk and renamed, so `result` is whole or absent.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;

use super::model::{JobId, JobState};

pub const BUNDLE_FILE: &str = "bundle.zip";
pub const REPORT_FILE: &str = "report.json";
pub const PREVIEW_FILE: &str = "preview.png";

pub struct DataFolder {
    root: PathBuf,
    /// Held as long as the service lives; the system lets go of it when the process is gone.
    _lock: File,
}

impl DataFolder {
    /// Takes the folder for this process, making it where it is missing.
    ///
    /// # Errors
    /// When another process serves it.
    pub fn open(root: &Path) -> anyhow::Result<Self> {
        fs::create_dir_all(root.join("jobs")).with_context(|| format!("cannot make {}", root.display()))?;
        let path = root.join("lock");
        let lock = File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(&path)
            .with_context(|| format!("cannot open {}", path.display()))?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { root: root.to_owned(), _lock: lock }),
            Err(TryLockError::WouldBlock) => anyhow::bail!(
                "another meshcolor serves the data folder {} already; stop it, or name another folder with --data",
                root.display()
            ),
            Err(TryLockError::Error(error)) => {
                Err(error).with_context(|| format!("cannot lock {}", path.display()))
            }
        }
    }

    pub fn database(&self) -> PathBuf {
        self.root.join("meshcolor.db")
    }

    fn jobs(&self) -> PathBuf {
        self.root.join("jobs")
    }

    fn job(&self, id: JobId) -> PathBuf {
        self.jobs().join(id.to_string())
    }

    pub fn input(&self, id: JobId) -> PathBuf {
        self.job(id).join("input")
    }

    /// A finished result file.
    pub fn result(&self, id: JobId, file: &str) -> PathBuf {
        self.job(id).join("result").join(file)
    }

    /// Makes the folder for a job's input; it goes away again unless it is kept.
    pub fn begin_input(&self, id: JobId) -> io::Result<InputFolder> {
        let folder = InputFolder { job: self.job(id), is_kept: false };
        fs::create_dir_all(folder.path())?;
        Ok(folder)
    }

    /// Makes an empty folder for results that are being written.
    pub fn begin_result(&self, id: JobId) -> io::Result<PathBuf> {
        self.discard_result(id)?;
        let part = self.job(id).join("result.part");
        fs::create_dir_all(&part)?;
        Ok(part)
    }

    /// Makes what was written since `begin_result` the job's result, durable when this returns.
    pub fn commit_result(&self, id: JobId) -> io::Result<()> {
        let (job, part) = (self.job(id), self.job(id).join("result.part"));
        for entry in fs::read_dir(&part)? {
            flush(&entry?.path())?;
        }
        flush(&part)?;
        fs::rename(part, job.join("result"))?;
        flush(&job)
    }

    pub fn discard_result(&self, id: JobId) -> io::Result<()> {
        remove_tree(&self.job(id).join("result.part"))?;
        remove_tree(&self.job(id).join("result"))
    }

    pub fn discard_input(&self, id: JobId) -> io::Result<()> {
        remove_tree(&self.input(id))
    }

    /// Removes everything of a job.
    pub fn remove(&self, id: JobId) -> io::Result<()> {
        remove_tree(&self.job(id))
    }

    /// Brings the files in line with the stored jobs after a start: what belongs to no job, inputs that
    /// are no longer needed, results of jobs that have none.
    pub fn sweep(&self, stored: &[(JobId, JobState)]) -> io::Result<()> {
        for entry in fs::read_dir(self.jobs())? {
            let entry = entry?;
            let id = entry.file_name().to_str().and_then(|name| name.parse::<JobId>().ok());
            let state =
                id.and_then(|id| stored.iter().find(|(other, _)| *other == id)).map(|(_, state)| *state);
            match (id, state) {
                (Some(id), Some(JobState::Succeeded)) => self.discard_input(id)?,
                (Some(id), Some(state)) if state.is_terminal() => self.remove(id)?,
                (Some(id), Some(_)) => self.discard_result(id)?,
                _ => remove_tree(&entry.path())?,
            }
        }
        Ok(())
    }

    /// Whether the folder takes writes.
    pub fn probe(&self) -> io::Result<()> {
        let path = self.root.join("probe");
        fs::write(&path, b"ready")?;
        fs::remove_file(path)
    }
}

/// The input of a job that is not accepted yet.
pub struct InputFolder {
    job: PathBuf,
    is_kept: bool,
}

impl InputFolder {
    pub fn path(&self) -> PathBuf {
        self.job.join("input")
    }

    /// Makes the folders durable; the files are flushed by whoever wrote them.
    pub fn flush(&self) -> io::Result<()> {
        flush(&self.path())?;
        flush(&self.job)?;
        self.job.parent().map_or(Ok(()), flush)
    }

    pub fn keep(mut self) {
        self.is_kept = true;
    }
}

impl Drop for InputFolder {
    fn drop(&mut self) {
        if !self.is_kept
            && let Err(error) = remove_tree(&self.job)
        {
            tracing::warn!(%error, "an upload's files could not be removed; the next start does it");
        }
    }
}

/// Flushes a file or folder to disk.
fn flush(path: &Path) -> io::Result<()> {
    File::open(path)?.sync_all()
}

fn remove_tree(path: &Path) -> io::Result<()> {
    match fs::remove_dir_all(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotADirectory => fs::remove_file(path),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;

    fn folder() -> (TempDir, DataFolder) {
        let root = tempfile::tempdir().unwrap();
        let data = DataFolder::open(root.path()).unwrap();
        (root, data)
    }

    #[test]
    fn one_process_at_a_time() {
        let (root, first) = folder();
        let Err(error) = DataFolder::open(root.path()) else { panic!("locked twice") };
        assert!(error.to_string().contains("--data"), "{error}");
        drop(first);
        DataFolder::open(root.path()).unwrap();
    }

    #[test]
    fn an_upload_that_is_not_kept_leaves_nothing() {
        let (_root, data) = folder();
        let id = JobId::new();
        let input = data.begin_input(id).unwrap();
        fs::write(input.path().join("x"), "x").unwrap();
        drop(input);
        assert!(!data.job(id).exists());
        data.begin_input(id).unwrap().keep();
        assert!(data.input(id).exists());
    }

    #[test]
    fn sweeping_keeps_what_the_jobs_need_and_nothing_else() {
        let (_root, data) = folder();
        let ids: Vec<_> = (0..5).map(|_| JobId::new()).collect();
        for id in &ids {
            data.begin_input(*id).unwrap().keep();
            fs::write(data.begin_result(*id).unwrap().join(REPORT_FILE), "{}").unwrap();
            data.commit_result(*id).unwrap();
        }
        fs::write(data.jobs().join("stray"), "").unwrap();
        let stored = [
            (ids[0], JobState::Succeeded),
            (ids[1], JobState::Queued),
            (ids[2], JobState::Failed),
            (ids[3], JobState::Running),
        ];
        data.sweep(&stored).unwrap();
        let has = |id: JobId| (data.input(id).exists(), data.result(id, REPORT_FILE).exists());
        let left: Vec<_> = ids.iter().map(|id| has(*id)).collect();
        assert_eq!(left, [(false, true), (true, false), (false, false), (true, false), (false, false)]);
        assert!(!data.jobs().join("stray").exists());
    }
}
