//! Who does the work of one job. `InProcess` converts on this process's thread pool; a runner with a
//! child process for each job would stand beside it.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read};
use std::path::{Path, PathBuf};

use meshcolor::read::{Files, Limits, Upload};
use sha2::{Digest, Sha256};

use super::folder::{BUNDLE_FILE, PREVIEW_FILE, REPORT_FILE};
use super::model::{JobInput, JobKind, JobOptions, JobResult, ResultFile};
use crate::watch::JobWatch;
use crate::work::{self, Preview};
use crate::{bundle, work::Converted};

/// One job as a runner gets it.
pub struct Task<'a> {
    pub kind: JobKind,
    pub upload: Upload,
    pub options: JobOptions,
    /// An empty folder for the result files.
    pub out: &'a Path,
    pub watch: &'a JobWatch,
}

/// Why a run ended without a result.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The model's fault or the client's wish; the client reads it as it stands.
    #[error(transparent)]
    Conversion(#[from] meshcolor::Error),
    /// Ours; the cause is for the log.
    #[error(transparent)]
    Own(#[from] anyhow::Error),
}

impl From<io::Error> for RunError {
    fn from(error: io::Error) -> Self {
        Self::Own(error.into())
    }
}

/// Runs one job at a time for each caller, on the caller's thread; it may panic, and the queue copes.
pub trait Runner: Send + Sync + 'static {
    /// # Errors
    /// See [`RunError`].
    fn run(&self, task: &Task<'_>) -> Result<JobResult, RunError>;
}

/// Converts in this process, all jobs on one pool.
pub struct InProcess {
    pub pool: rayon::ThreadPool,
    pub limits: Limits,
}

impl Runner for InProcess {
    fn run(&self, task: &Task<'_>) -> Result<JobResult, RunError> {
        let (upload, options, limits) = (&task.upload, &task.options, &self.limits);
        match task.kind {
            JobKind::Convert => {
                let done = self.pool.install(|| work::convert(upload, options, limits, task.watch))?;
                store_conversion(done, task.out)
            }
            JobKind::Check => {
                let report = self.pool.install(|| work::check(upload, options, limits, task.watch))?;
                fs::write(task.out.join(REPORT_FILE), work::report_bytes(&report)?)?;
                Ok(JobResult::of_report(&report))
            }
        }
    }
}

fn store_conversion(done: Converted, out: &Path) -> Result<JobResult, RunError> {
    let mut result = JobResult::of_report(&done.report);
    // The bundle's own file where it has one, so that both are the same to the byte.
    let report = match done.files.iter().find(|file| file.path == REPORT_FILE) {
        Some(file) => file.bytes.clone(),
        None => work::report_bytes(&done.report)?,
    };
    fs::write(out.join(REPORT_FILE), report)?;
    let path = out.join(BUNDLE_FILE);
    bundle::write_zip(&done.files, BufWriter::new(File::create(&path)?))?;
    result.bundle = Some(describe(&path)?);
    match done.preview {
        Preview::Skipped => {}
        Preview::Failed { reason } => {
            tracing::warn!(%reason, "no preview");
            result.preview_failure = Some(reason);
        }
        Preview::Drawn { png } => {
            let path = out.join(PREVIEW_FILE);
            fs::write(&path, png)?;
            result.preview = Some(describe(&path)?);
        }
    }
    Ok(result)
}

/// Size and hash of a file, read back in pieces.
pub fn describe(path: &Path) -> io::Result<ResultFile> {
    let mut file = File::open(path)?;
    let (mut hash, mut bytes) = (Sha256::new(), 0);
    let mut buffer = vec![0; 1 << 16];
    loop {
        let count = file.read(&mut buffer)?;
        if count == 0 {
            return Ok(ResultFile { bytes, sha256: hex(&hash.finalize()) });
        }
        bytes += count as u64;
        hash.update(&buffer[..count]);
    }
}

pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The stored files of one upload under the names that the client gave them.
pub struct StoredFiles {
    pub folder: PathBuf,
    pub input: JobInput,
}

impl StoredFiles {
    /// The model is the first file.
    pub fn into_upload(self) -> anyhow::Result<Upload> {
        let main = self.input.files.first().map(|file| file.path.clone());
        let main = main.ok_or_else(|| anyhow::anyhow!("a job without a model"))?;
        Ok(Upload { main, files: Box::new(self) })
    }
}

impl Files for StoredFiles {
    fn read(&self, path: &str) -> meshcolor::Result<Option<Vec<u8>>> {
        let Some(file) = self.input.files.iter().find(|file| file.path == path) else { return Ok(None) };
        fs::read(self.folder.join(&file.stored)).map(Some).map_err(|error| {
            tracing::error!(%error, path, "a stored file cannot be read");
            meshcolor::Error::internal("a stored file of the upload cannot be read")
        })
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = self.input.files.iter().map(|file| file.path.clone()).collect();
        names.sort();
        names.truncate(64);
        names
    }
}
