//! What reading ends in: one strict type whose guarantees later stages never check again.

mod mesh_colors;
mod slot;
mod types;
mod vertex_colors;

pub use mesh_colors::{EXPONENT_MAX, MESH_COLORS_EXTENSION, MeshColorChannel, MeshColors, VALUE_SCALES};
pub use slot::{AttributeName, Slot, TEXTURE_EXTENSION};
pub use types::{
    AlphaMode, Asset, Attribute, Document, EncodedImage, Face, Instance, Material, Mesh, MorphTarget,
    NGON_EXTENSION, Primitive, TextureRef, UvTransform,
};
pub use vertex_colors::VERTEX_COLORS;
