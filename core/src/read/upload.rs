//! The closed set of files that one model may use.

use std::collections::BTreeMap;

use crate::error::Result;

/// Access to the files of one upload by relative path with `/`, case-exact. An implementation never
/// reaches outside its set; `read` has already refused paths with schemes, `..` or absolute roots.
pub trait Files: Send + Sync {
    /// The bytes of a file, or `None` where the upload has none of that name.
    fn read(&self, path: &str) -> Result<Option<Vec<u8>>>;

    /// Names for error messages ("the upload has: …"), sorted; may be cut short.
    fn names(&self) -> Vec<String>;
}

/// Files held in memory.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles(pub BTreeMap<String, Vec<u8>>);

impl Files for MemoryFiles {
    fn read(&self, path: &str) -> Result<Option<Vec<u8>>> {
        Ok(self.0.get(path).cloned())
    }

    fn names(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }
}

/// A model with its files. The main file's type is decided by its first bytes, not by its name; a zip
/// must hold exactly one `.glb`, `.gltf`, `.obj` or `.ply` (files in its folder are found relative to it).
pub struct Upload {
    /// Path of the main file inside `files`.
    pub main: String,
    pub files: Box<dyn Files>,
}

impl Upload {
    /// A model of a single file.
    pub fn single(name: &str, bytes: Vec<u8>) -> Self {
        let files = MemoryFiles(BTreeMap::from([(name.to_owned(), bytes)]));
        Self { main: name.to_owned(), files: Box::new(files) }
    }
}
