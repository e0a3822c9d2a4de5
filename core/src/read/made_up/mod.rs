//! What formats without a glTF document have in common: polygons with corners to meshes, image files to slots, and a
//! document made up for them.

mod build;
mod coordinates;
mod document;
mod image_files;
mod polygon;
mod soup;

use glam::{Affine3A, Vec4};

use super::Context;
use crate::asset::{Asset, Document, Instance, Material, Mesh};
use crate::error::Result;

pub(super) use build::meshes;
pub(super) use coordinates::Coordinates;
pub(super) use image_files::ImageFiles;
pub(super) use soup::{Corner, NONE, Polygon, Soup};

/// A white material without textures, neither metal nor shiny.
pub(super) fn plain(name: &[u8]) -> Material {
    Material {
        name: String::from_utf8_lossy(name).into_owned(),
        base_color_factor: Vec4::ONE,
        metallic_factor: 0.0,
        roughness_factor: 1.0,
        normal_scale: 1.0,
        occlusion_strength: 1.0,
        ..Material::default()
    }
}

/// The asset of these meshes, each at a node of its own. Slots of `materials` name images by their number in `files`.
pub(super) fn asset(
    meshes: Vec<Mesh>,
    mut materials: Vec<Material>,
    files: ImageFiles,
    context: &mut Context,
) -> Result<Asset> {
    let loaded = files.decode(&mut materials, context)?;
    let json = document::make(&meshes, &materials, &loaded.encoded, &loaded.names);
    let instances = (0..meshes.len()).map(|mesh| Instance { mesh, transform: Affine3A::IDENTITY }).collect();
    Ok(Asset {
        document: Document { json, buffers: Vec::new(), encoded_images: loaded.encoded },
        images: loaded.images,
        materials,
        meshes,
        instances,
        warnings: Vec::new(),
    })
}
