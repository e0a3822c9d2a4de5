//! Vertex attributes of whole numbers: what glTF 2.0 allows of them (section 3.7.2.1), what `KHR_mesh_quantization` adds,
//! and the numbers that the codes stand for (section 3.6.2.2).

use ::gltf::accessor::{DataType, Dimensions};

use super::super::json::At;
use super::accessors::{Accessor, unsigned};
use crate::error::Result;

const EXTENSION: &str = "KHR_mesh_quantization";

/// Whether the file says that it may have what the extension allows.
pub(super) fn is_named(root: &At) -> Result<bool> {
    let lists = [root.list("extensionsRequired")?, root.list("extensionsUsed")?];
    Ok(lists.into_iter().flatten().any(|name| name.as_str() == Some(EXTENSION)))
}

/// An attribute that the conversion computes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Semantic {
    Position,
    Normal,
    Tangent,
    Texcoord,
}

impl Semantic {
    pub fn dimensions(self) -> Dimensions {
        match self {
            Semantic::Position | Semantic::Normal => Dimensions::Vec3,
            Semantic::Tangent => Dimensions::Vec4,
            Semantic::Texcoord => Dimensions::Vec2,
        }
    }

    /// Whether an accessor has a type of the semantic's; `named`: the types of the extension too.
    pub fn allows(self, accessor: &Accessor, named: bool) -> bool {
        use DataType::{F32, I8, I16, U8, U16};
        if accessor.dimensions != self.dimensions() {
            return false;
        }
        match (self, accessor.component, accessor.normalized) {
            (_, F32, false) | (Semantic::Texcoord, U8 | U16, true) => true,
            (Semantic::Position | Semantic::Texcoord, I8 | U8 | I16 | U16, _) => named,
            (Semantic::Normal | Semantic::Tangent, I8 | I16, true) => named,
            _ => false,
        }
    }

    /// What [`Self::allows`], in words.
    pub fn allowed(self, named: bool) -> String {
        let dimensions = self.dimensions();
        let (core, more) = match self {
            Semantic::Position => ("F32", "I8, U8, I16 or U16, normalized or not"),
            Semantic::Normal | Semantic::Tangent => ("F32", "I8 or I16 normalized"),
            Semantic::Texcoord => ("F32, or U8 or U16 normalized", "I8, U8, I16 or U16, normalized or not"),
        };
        if named {
            format!("{dimensions:?} of F32, or {more}")
        } else {
            format!("{dimensions:?} of {core} ({more} are only for files that name {EXTENSION})")
        }
    }
}

/// Packed elements of any of these types as floats: codes that are normalized over their largest, those of signed types
/// no less than -1.
pub(super) fn numbers<const N: usize>(packed: &[u8], accessor: &Accessor) -> Vec<[f32; N]> {
    let size = accessor.component.size();
    let number: fn(&[u8]) -> f32 = match (accessor.component, accessor.normalized) {
        (DataType::I8, false) => |bytes| f32::from(unsigned(bytes) as u8 as i8),
        (DataType::I8, true) => |bytes| (f32::from(unsigned(bytes) as u8 as i8) / 127.0).max(-1.0),
        (DataType::U8, false) | (DataType::U16, false) => |bytes| unsigned(bytes) as f32,
        (DataType::U8, true) => |bytes| unsigned(bytes) as f32 / 255.0,
        (DataType::I16, false) => |bytes| f32::from(unsigned(bytes) as u16 as i16),
        (DataType::I16, true) => |bytes| (f32::from(unsigned(bytes) as u16 as i16) / 32767.0).max(-1.0),
        (DataType::U16, true) => |bytes| unsigned(bytes) as f32 / 65535.0,
        (DataType::U32, _) => |bytes| unsigned(bytes) as f32,
        (DataType::F32, _) => |bytes| f32::from_bits(unsigned(bytes)),
    };
    let vector = |element: &[u8]| {
        let mut vector = [0.0; N];
        for (component, bytes) in vector.iter_mut().zip(element.chunks_exact(size)) {
            *component = number(bytes);
        }
        vector
    };
    packed.chunks_exact(size * N).map(vector).collect()
}
