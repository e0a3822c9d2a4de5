//! What reading ends in: one strict type whose guarantees later stages never check again.

mod mesh_colors;
mod types;
mod vertex_colors;

pub use mesh_colors::{EXPONENT_MAX, MESH_COLORS_EXTENSION, MeshColorChannel, MeshColors};
pub use types::{
    AlphaMode, Asset, Attribute, Document, EncodedImage, Face, Instance, Material, Mesh, MorphTarget,
    NGON_EXTENSION, Primitive, Slot, TextureRef, UvTransform,
};
pub use vertex_colors::VERTEX_COLORS;
