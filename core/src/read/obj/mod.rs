//! OBJ with MTL to an asset. The parser is our own: one pass, linear time, and no file is opened but
//! through the upload.

mod build;
mod document;
mod lines;
mod materials;
mod mtl;
mod parse;
mod polygon;

use glam::Affine3A;

use super::Context;
use super::text::file_label;
use crate::asset::{Asset, Document, Instance};
use crate::error::Result;

/// `main` is the file's path in the upload, for error messages and as the name of an unnamed mesh.
pub(super) fn read(text: &[u8], main: &str, context: &mut Context) -> Result<Asset> {
    let file = file_label(main);
    let parsed = parse::parse(text, &file, context)?;
    let materials = materials::read(&parsed, &file, context)?;
    let stem = file.rsplit_once('.').map_or(file.as_str(), |(stem, _)| stem);
    let meshes = build::meshes(&parsed, stem, &file, context)?;
    let json = document::make(&meshes, &materials.materials, &materials.encoded, &materials.image_names);
    let instances = (0..meshes.len()).map(|mesh| Instance { mesh, transform: Affine3A::IDENTITY }).collect();
    Ok(Asset {
        document: Document { json, buffers: Vec::new(), encoded_images: materials.encoded },
        images: materials.images,
        materials: materials.materials,
        meshes,
        instances,
        warnings: Vec::new(),
    })
}
