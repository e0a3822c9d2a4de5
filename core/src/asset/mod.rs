//! What reading ends in: one strict type whose guarantees later stages never check again.

mod types;

pub use types::{
    AlphaMode, Asset, Attribute, Document, EncodedImage, Face, Instance, Material, Mesh, MorphTarget,
    Primitive, Slot, TextureRef, UvTransform,
};
