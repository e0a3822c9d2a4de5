//! Finished conversions to files: GLB, PNG, the bundle's manifest.

/// One file of a bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BundleFile {
    /// Relative path with `/`.
    pub path: String,
    pub bytes: Vec<u8>,
}
