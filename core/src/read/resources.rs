//! The files beside the main one, loaded by URI or by name, counted and within the budget.

use std::collections::BTreeSet;

use super::Files;
use super::budget::Budget;
use super::data_uri;
use super::text::{quoted, quoted_bytes};
use super::uri;
use crate::error::{Error, ErrorCode, Result};

/// How many file names "the upload has: …" lists.
const LISTED_NAMES: usize = 8;

/// Bytes that a URI led to; the media type is known of `data:` URIs alone.
#[derive(Debug)]
pub(super) struct Loaded {
    pub bytes: Vec<u8>,
    pub media_type: Option<String>,
}

pub(super) struct Resources<'a> {
    files: &'a dyn Files,
    /// Folder of the main file: empty, or ending in `/`.
    folder: String,
    used: BTreeSet<String>,
}

impl<'a> Resources<'a> {
    pub fn new(files: &'a dyn Files, main: &str) -> Self {
        Self { files, folder: uri::folder_of(main).to_owned(), used: BTreeSet::new() }
    }

    /// What a glTF URI names.
    pub fn load_uri(&mut self, uri: &str, pointer: &str, budget: &mut Budget) -> Result<Loaded> {
        if data_uri::is_data_uri(uri) {
            budget.take_bytes(uri.len() as u64, pointer)?;
            let decoded = data_uri::decode(uri, pointer)?;
            return Ok(Loaded { bytes: decoded.bytes, media_type: Some(decoded.media_type) });
        }
        let path = uri::resolve(uri, &self.folder, pointer)?;
        match self.load(&path, pointer, budget)? {
            Some(bytes) => Ok(Loaded { bytes, media_type: None }),
            None => Err(self.missing(&quoted(uri), &self.folder, pointer)),
        }
    }

    /// Folder of the main file: empty, or ending in `/`.
    pub fn folder(&self) -> &str {
        &self.folder
    }

    /// What a file name of an OBJ or MTL file names, with its path.
    pub fn load_name(
        &mut self,
        name: &[u8],
        folder: &str,
        pointer: &str,
        budget: &mut Budget,
    ) -> Result<(String, Vec<u8>)> {
        match self.find_name(name, folder, pointer, budget)? {
            Some(found) => Ok(found),
            None => Err(self.missing(&quoted_bytes(name), folder, pointer)),
        }
    }

    pub fn find_name(
        &mut self,
        name: &[u8],
        folder: &str,
        pointer: &str,
        budget: &mut Budget,
    ) -> Result<Option<(String, Vec<u8>)>> {
        for path in uri::resolve_name(name, folder, pointer)? {
            if let Some(bytes) = self.load(&path, pointer, budget)? {
                return Ok(Some((path, bytes)));
            }
        }
        Ok(None)
    }

    /// The rules alone, for names that are not needed.
    pub fn check_name(&self, name: &[u8], folder: &str, pointer: &str) -> Result<()> {
        uri::resolve_name(name, folder, pointer).map(drop)
    }

    fn load(&mut self, path: &str, pointer: &str, budget: &mut Budget) -> Result<Option<Vec<u8>>> {
        let Some(bytes) = self.files.read(path)? else { return Ok(None) };
        budget.take_bytes(bytes.len() as u64, pointer)?;
        self.used.insert(path.to_owned());
        let (limit, actual) = (budget.limits.files, self.used.len() as u64);
        if actual > limit {
            let detail = format!("the model uses more than {limit} files (limit `files`)");
            return Err(Error::new(ErrorCode::TooManyFiles, detail).at(pointer).limit(limit, actual));
        }
        Ok(Some(bytes))
    }

    fn missing(&self, shown: &str, folder: &str, pointer: &str) -> Error {
        let names = self.files.names();
        let listed: Vec<String> = names.iter().take(LISTED_NAMES).map(|name| quoted(name)).collect();
        let more = if names.len() > LISTED_NAMES { ", …" } else { "" };
        let within =
            if folder.is_empty() { String::new() } else { format!(" in the folder {}", quoted(folder)) };
        let detail = format!(
            "the file {shown} is not in the upload{within}; add it (the upload has: {}{more})",
            listed.join(", ")
        );
        Error::new(ErrorCode::MissingResource, detail).at(pointer)
    }
}
