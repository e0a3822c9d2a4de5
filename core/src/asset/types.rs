//! The asset: geometry and materials decoded, everything else kept as it came.

use std::collections::BTreeMap;

use glam::{Affine3A, Vec2, Vec3, Vec4};

use crate::error::Warning;
use crate::image::{Image, Wrap};

use super::{MeshColors, Slot};

/// A model, read and checked.
///
/// Guarantees (by construction in `read`; tested there):
/// * every index (image, material, vertex, node) is in range;
/// * every position, normal, tangent and texture coordinate is finite; normals and tangents have unit
///   length (a zero normal was replaced by its face's); texture coordinates lie within ±1e6, positions
///   within ±1e9, components of texture transforms within ±1e6;
/// * every attribute of a primitive has as many elements as `positions`;
/// * faces have 3 or 4 corners; polygons with more were cut into triangles, strips and fans unrolled,
///   with the winding of the source; degenerate faces are kept (and warned of);
/// * `instances` come from an acyclic node graph, and their transforms are finite;
/// * images are decoded once each, within the limits asked for: `images[i]` is image `i` of the document.
///   Decoded are the images that a slot of a material reads, and the levels of a converted texture; any
///   other image is one black texel here (its file is in `Document::encoded_images`). Where several
///   images of the document are the same file, `TextureRef::image` is the first of them, and the others
///   are one texel too unless they are levels. Behind those of the document stand the images of attributes that
///   were asked for beside it.
#[derive(Clone, Debug, Default)]
pub struct Asset {
    pub document: Document,
    pub images: Vec<Image>,
    pub materials: Vec<Material>,
    pub meshes: Vec<Mesh>,
    /// Where meshes stand in the default scene, in node order.
    pub instances: Vec<Instance>,
    pub warnings: Vec<Warning>,
}

/// Everything of a glTF file that the conversion does not touch; for other formats a document that
/// `read` made up, with the same nodes, meshes and materials as the asset.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// The glTF JSON. `meshes[m].primitives[p]` here is `Asset::meshes[m].primitives[p]`, and the same
    /// for materials and images (of a made-up document, primitives have no accessors yet).
    /// Buffer views that came packed are plain ones of further buffers.
    pub json: serde_json::Value,
    /// The bytes of each buffer of `json`, resolved.
    pub buffers: Vec<Vec<u8>>,
    /// The encoded bytes of each image with its media type: what passes through unchanged where an
    /// image is not converted.
    pub encoded_images: Vec<EncodedImage>,
}

/// An image file as it came.
#[derive(Clone, Debug, Default)]
pub struct EncodedImage {
    pub media_type: String,
    pub bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum AlphaMode {
    #[default]
    Opaque,
    /// Alpha test against the cutoff.
    Mask(f32),
    Blend,
}

/// A material. It has those slots where the source has a texture with an image, and attributes that were asked for.
#[derive(Clone, Debug, Default)]
pub struct Material {
    pub name: String,
    pub slots: BTreeMap<Slot, TextureRef>,
    /// Linear.
    pub base_color_factor: Vec4,
    pub metallic_factor: f32,
    pub roughness_factor: f32,
    /// Linear.
    pub emissive_factor: Vec3,
    pub normal_scale: f32,
    pub occlusion_strength: f32,
    pub alpha_mode: AlphaMode,
    pub double_sided: bool,
    /// Instead of textures in the slots of its channels.
    pub mesh_colors: Option<MeshColors>,
}

impl Material {
    pub fn slot(&self, slot: Slot) -> Option<&TextureRef> {
        self.slots.get(&slot)
    }
}

/// How a slot reads an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into `Asset::images`.
    pub image: usize,
    pub wrap: Wrap,
    /// Index into `Primitive::texcoords`. A primitive that lacks the set reads (0, 0) everywhere.
    pub texcoord: usize,
    pub transform: UvTransform,
}

/// KHR_texture_transform: `uv' = offset + R(rotation) · (scale · uv)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    pub offset: Vec2,
    /// Radians, as the extension defines it.
    pub rotation: f32,
    pub scale: Vec2,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation: 0.0, scale: Vec2::ONE }
    }
}

impl UvTransform {
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        let (sin, cos) = self.rotation.sin_cos();
        let scaled = uv * self.scale;
        // The extension's matrix turns clockwise in a v-down image.
        Vec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x) + self.offset
    }
}

#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub name: String,
    pub primitives: Vec<Primitive>,
}

/// Faces of one material. Points and lines are kept as passed-through primitives with no faces.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    pub material: Option<usize>,
    pub positions: Vec<Vec3>,
    /// Empty where the source has none.
    pub normals: Vec<Vec3>,
    /// `w` is the handedness, +1 or -1. Empty where the source has none.
    pub tangents: Vec<Vec4>,
    /// One vector per texture coordinate set; glTF's convention (v down, row 0 at v = 0).
    pub texcoords: Vec<Vec<Vec2>>,
    /// Every further vertex attribute (COLOR_n, JOINTS_n, WEIGHTS_n, custom ones), bytes unchanged.
    pub attributes: Vec<Attribute>,
    pub targets: Vec<MorphTarget>,
    pub faces: Vec<Face>,
}

/// A vertex attribute as tightly packed bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    pub semantic: String,
    /// glTF component type (5120 to 5126).
    pub component_type: u32,
    /// glTF accessor type, such as `VEC4`.
    pub kind: String,
    pub normalized: bool,
    /// Bytes of one element; `bytes.len() == element_bytes * positions.len()`.
    pub element_bytes: usize,
    pub bytes: Vec<u8>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    pub attributes: Vec<Attribute>,
}

/// The glTF extension whose primitives have their triangles in the order of polygons.
pub const NGON_EXTENSION: &str = "FB_ngon_encoding";

/// A triangle or a quad: `corners[..count]`, vertex indices of its primitive. A quad is drawn as the
/// triangles (0, 1, 2) and (0, 2, 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    pub corners: [u32; 4],
    pub count: u8,
}

impl Face {
    pub fn triangle(corners: [u32; 3]) -> Self {
        Self { corners: [corners[0], corners[1], corners[2], corners[2]], count: 3 }
    }

    pub fn quad(corners: [u32; 4]) -> Self {
        Self { corners, count: 4 }
    }

    pub fn corners(&self) -> &[u32] {
        &self.corners[..self.count as usize]
    }

    /// The triangles that the face is drawn as, as corner numbers of the face.
    pub fn triangles(&self) -> &'static [[usize; 3]] {
        if self.count == 3 { &[[0, 1, 2]] } else { &[[0, 1, 2], [0, 2, 3]] }
    }
}

/// One mesh at one node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    pub mesh: usize,
    /// Mesh to world.
    pub transform: Affine3A,
}
