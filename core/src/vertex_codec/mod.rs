//! Elements packed by meshoptimizer's codecs, as glTF's `EXT_meshopt_compression` has them. All of the core's `unsafe` code
//! stands here.

mod decode;
mod encode;

pub use decode::Checked;
pub use encode::{packed_attributes, packed_indices, rounded};

/// The glTF extension.
pub const EXTENSION: &str = "EXT_meshopt_compression";

/// How the elements are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// What unpacked attributes go through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
}

/// What a file says of a packed view.
#[derive(Clone, Copy, Debug)]
pub struct Form {
    pub mode: Mode,
    pub filter: Filter,
    pub count: usize,
    /// Bytes of an element.
    pub stride: usize,
}

impl Mode {
    /// As the extension names it.
    pub const NAMED: [(&str, Self); 3] =
        [("ATTRIBUTES", Self::Attributes), ("TRIANGLES", Self::Triangles), ("INDICES", Self::Indices)];
}

impl Filter {
    /// As the extension names it.
    pub const NAMED: [(&str, Self); 4] = [
        ("NONE", Self::None),
        ("OCTAHEDRAL", Self::Octahedral),
        ("QUATERNION", Self::Quaternion),
        ("EXPONENTIAL", Self::Exponential),
    ];
}
