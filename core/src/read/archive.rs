//! A zip archive, unpacked into memory entry by entry, and the one model in it.
//!
//! Sizes that the archive declares are never believed: unpacking counts what comes out and stops at the
//! first byte too many.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use zip::ZipArchive;
use zip::result::ZipError;

use super::text::quoted;
use super::uri::check_entry_name;
use super::{Limits, MemoryFiles, Upload};
use crate::error::{Error, ErrorCode, Result};
use crate::watch::{self, Watch};

/// An archive may unpack to this much whatever its ratio.
const RATIO_FREE_BYTES: u64 = 1 << 20;

/// Signature of an entry in the central directory.
const ENTRY_SIGNATURE: &[u8] = b"PK\x01\x02";

/// Bytes unpacked between two looks at the limits.
const STEP_BYTES: usize = 64 << 10;

/// Unpacks an archive; the result's main file is its only model.
pub(super) fn unpack(bytes: &[u8], limits: &Limits, watch: &dyn Watch) -> Result<Upload> {
    check_entry_count(bytes, limits)?;
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| broken(&error))?;
    if archive.has_duplicate_names() {
        return Err(Error::invalid("the archive has two entries of one name"));
    }
    if archive.has_overlapping_entries().map_err(|error| broken(&error))? {
        return Err(Error::invalid("entries of the archive overlap"));
    }
    let mut unpacked = Unpacked { limits, packed_bytes: bytes.len() as u64, total_bytes: 0 };
    let mut files = BTreeMap::new();
    for index in 0..archive.len() {
        watch::check(watch)?;
        let mut entry = archive.by_index_raw(index).map_err(|error| broken(&error))?;
        let name = entry.name().map_err(|error| broken(&error))?.into_owned();
        let at = |error: Error| error.at(format!("zip entry {}", quoted(&name)));
        let path = check_entry_name(&name).map_err(at)?;
        if entry.is_symlink() {
            let detail = "the archive holds a symbolic link; put the file itself there";
            return Err(at(Error::new(ErrorCode::UnsafeUri, detail)));
        }
        if entry.encrypted() {
            return Err(at(Error::invalid("the archive is encrypted")));
        }
        if entry.is_dir() || path.starts_with("__MACOSX/") {
            continue;
        }
        drop(entry);
        entry = archive.by_index(index).map_err(|error| at(broken(&error)))?;
        let content = unpacked.read(&mut entry, watch).map_err(at)?;
        if files.insert(path, content).is_some() {
            return Err(at(Error::invalid("the archive has two entries of one name")));
        }
    }
    let main = the_only_model(&files)?;
    Ok(Upload { main, files: Box::new(MemoryFiles(files)) })
}

/// Refuses before the directory is parsed. Each entry begins with its signature wherever the directory
/// may stand, so their number bounds what any reading of the archive can find.
fn check_entry_count(bytes: &[u8], limits: &Limits) -> Result<()> {
    let limit = limits.archive_entries;
    let count = bytes.windows(4).filter(|four| *four == ENTRY_SIGNATURE).count() as u64;
    if count > limit {
        let detail = format!("the archive has more than {limit} entries (limit `archive_entries`)");
        return Err(Error::new(ErrorCode::TooManyFiles, detail).limit(limit, count));
    }
    Ok(())
}

/// Running total of what came out.
struct Unpacked<'a> {
    limits: &'a Limits,
    packed_bytes: u64,
    total_bytes: u64,
}

impl Unpacked<'_> {
    fn read(&mut self, entry: &mut impl Read, watch: &dyn Watch) -> Result<Vec<u8>> {
        let mut content = Vec::new();
        let mut step = vec![0; STEP_BYTES];
        loop {
            let read = entry.read(&mut step).map_err(|error| {
                Error::invalid(format!("the archive's entry cannot be unpacked: {error}"))
            })?;
            if read == 0 {
                return Ok(content);
            }
            self.count(read as u64)?;
            content.extend_from_slice(&step[..read]);
            watch::check(watch)?;
        }
    }

    fn count(&mut self, bytes: u64) -> Result<()> {
        self.total_bytes = self.total_bytes.saturating_add(bytes);
        let limit = self.limits.archive_bytes;
        if self.total_bytes > limit {
            let detail = format!("the archive unpacks to more than {limit} bytes (limit `archive_bytes`)");
            return Err(Error::new(ErrorCode::ArchiveTooLarge, detail).limit(limit, self.total_bytes));
        }
        let ratio = self.limits.archive_ratio;
        let allowed = self.packed_bytes.saturating_mul(ratio).max(RATIO_FREE_BYTES);
        if self.total_bytes > allowed {
            let detail = format!(
                "the archive's {} bytes unpack to more than {ratio} times as many (limit `archive_ratio`)",
                self.packed_bytes
            );
            let actual = self.total_bytes / self.packed_bytes.max(1);
            return Err(Error::new(ErrorCode::ArchiveRatio, detail).limit(ratio, actual));
        }
        Ok(())
    }
}

fn the_only_model(files: &BTreeMap<String, Vec<u8>>) -> Result<String> {
    let is_model = |name: &str| {
        let name = name.to_ascii_lowercase();
        [".glb", ".gltf", ".obj", ".ply"].iter().any(|extension| name.ends_with(extension))
    };
    let models: Vec<&String> = files.keys().filter(|name| is_model(name)).collect();
    match models[..] {
        [one] => Ok(one.clone()),
        [] => Err(Error::invalid("the archive holds no model; it must hold one .glb, .gltf, .obj or .ply")),
        _ => {
            let listed: Vec<String> = models.iter().take(5).map(|name| quoted(name)).collect();
            let more = if models.len() > 5 { ", …" } else { "" };
            let detail = format!(
                "the archive holds {} models and must hold one: {}{more}",
                models.len(),
                listed.join(", ")
            );
            Err(Error::invalid(detail))
        }
    }
}

fn broken(error: &ZipError) -> Error {
    Error::invalid(format!("the zip archive cannot be read: {error}"))
}
