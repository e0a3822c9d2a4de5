//! A glTF document with its resources to an asset.
//!
//! The order is that of trust: extensions and references first, then buffers, then what is made of them.

mod accessors;
mod buffers;
mod draco;
mod extensions;
mod faces;
mod materials;
mod mesh_colors;
mod meshopt;
mod ngons;
mod primitives;
mod quantized;
mod references;
mod scene;
mod typed;
mod views;

use serde_json::Value;

pub(super) use materials::blank as blank_material;
pub use primitives::TEXCOORD_SETS_MAX;

use super::images;
use super::json::{At, check_version};
use super::{Context, bare};
use crate::asset::{Asset, Document, Primitive};
use crate::error::Result;
use crate::watch;

/// `bin` is the binary chunk of a GLB.
pub(super) fn read(mut json: Value, bin: Option<&[u8]>, context: &mut Context) -> Result<Asset> {
    let root = At::root(&json);
    if !json.is_object() {
        return Err(root.error("the document must be an object"));
    }
    check_version(&root)?;
    extensions::check_required(&root)?;
    references::check(&root)?;
    watch::check(context.watch)?;

    let mut buffers = buffers::load(&root, bin, context)?;
    let unpacked = meshopt::unpack(&root, &buffers, context)?;
    drop(root);
    meshopt::replace(&mut json, &mut buffers, unpacked);
    let root = At::root(&json);
    let unpacked = draco::unpack(&root, &buffers, context)?;
    drop(root);
    draco::replace(&mut json, &mut buffers, unpacked);
    let root = At::root(&json);

    let store = accessors::Store::new(&root, &buffers, &mut context.warnings)?;
    let encoded_images = buffers::load_images(&root, &store, context)?;
    let mut materials = materials::read(&root, &mut context.warnings)?;
    let instances = scene::read(&root, context.budget.limits)?;
    let mut meshes = primitives::read(&root, &store, context)?;
    mesh_colors::read(&root, &store, &meshes, &mut materials, context)?;

    let wanted = materials::wanted_images(&root, &materials, encoded_images.len());
    let decoded = images::decode_all(&encoded_images, &wanted, |index| format!("/images/{index}"), context)?;
    for reference in materials.iter_mut().flat_map(|material| material.slots.values_mut()) {
        reference.image = decoded.canonical[reference.image];
    }
    drop(root);
    bare::give_material(&mut json, &mut meshes, &mut materials, Primitive::has_vertex_colors)?;
    Ok(Asset {
        images: decoded.images,
        materials,
        meshes,
        instances,
        document: Document { json, buffers, encoded_images },
        warnings: Vec::new(),
    })
}
