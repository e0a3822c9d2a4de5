//! A material's mesh colors, as `MCT_mesh_colors` has them (docs/mesh_colors.md).

use super::Slot;

/// The glTF extension that holds mesh colors.
pub const MESH_COLORS_EXTENSION: &str = "MCT_mesh_colors";

/// The largest exponent of a face: a side of it has 4096 segments.
pub const EXPONENT_MAX: u8 = 12;

/// What a value of 1 may stand for in attributes of numbers of any size: 2^-100 to 2^100.
pub const VALUE_SCALES: [f32; 2] = [f32::from_bits(27 << 23), f32::from_bits(227 << 23)];

/// Samples on the faces of one material, over all meshes that show it.
///
/// A *face of the model* is a triangle or a quad of a primitive that has this material, in the order of meshes, of their
/// primitives and of the primitive's faces. A *face* is one of these, or two triangles that have become a quad; it stands where
/// the first of its two stood.
///
/// Guarantees of a file that was read: partners name each other, both of them triangles; there are as many exponents, none above
/// [`EXPONENT_MAX`], as faces; cuts and tangents have as many entries as there are faces, or none; all numbers are finite;
/// no slot is in two channels. Whether there are as many samples as the faces ask for is not known here.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshColors {
    /// By face of the model: the triangle that it is a quad with.
    pub partners: Vec<Option<u32>>,
    /// By face: along edges 0 and 2, and along edges 1 and 3; a triangle's are equal.
    pub exponents: Vec<[u8; 2]>,
    pub channels: Vec<MeshColorChannel>,
}

/// One channel's samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshColorChannel {
    /// In order; at least one.
    pub slots: Vec<Slot>,
    /// What a sample has: 1 gray, 2 gray and alpha, 3 RGB or a normal, 4 RGB and alpha.
    pub components: u8,
    /// Of each component where it is stored in a texture: 8 or 16.
    pub bits: u8,
    /// By face: bit `k` says that edge `k` is a cut. Empty where there are none.
    pub cuts: Vec<u8>,
    /// Components of all samples one after the other: linear light, data, or unit normals in the mesh's space.
    pub samples: Vec<f32>,
    /// Of attributes whose numbers may be of any size: what a sample of 1 stands for, one of [`VALUE_SCALES`]; samples are then
    /// within [-1, 1].
    pub value_scale: Option<f32>,
    /// Of normals, by face and corner: the tangent, unit length, and the handedness (+1 or -1) of the frame that a texture is
    /// to store them in; zero where any will do. Empty where that is so everywhere.
    pub tangents: Vec<[[f32; 4]; 4]>,
}
