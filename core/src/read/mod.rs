//! Bytes to [`Asset`]: glTF 2.0 (`.glb`, `.gltf` with its files, zip), OBJ with MTL and Ptex, and PLY; further images as
//! attributes of materials.
//!
//! Every URI is resolved here, inside the upload alone; sizes are checked before anything is allocated.

mod archive;
mod attributes;
mod bare;
mod basis;
mod budget;
mod container;
mod data_uri;
mod geometry;
mod glb;
mod gltf;
mod image_header;
mod images;
mod json;
mod limits;
mod made_up;
mod obj;
mod openexr;
mod ply;
mod ptex;
mod resources;
mod text;
mod upload;
mod uri;
mod warnings;
mod webp_header;

#[cfg(test)]
mod tests;

pub use attributes::AttributeSource;
pub use gltf::TEXCOORD_SETS_MAX;
pub use limits::Limits;
pub use upload::{Files, MemoryFiles, Upload};

use budget::Budget;
use container::Container;
use resources::Resources;
use warnings::Warnings;

use crate::asset::Asset;
use crate::error::{Error, ErrorCode, Result};
use crate::watch::{self, Stage, Watch};

/// What the readers of all formats work with besides the main file.
struct Context<'a> {
    resources: Resources<'a>,
    budget: Budget<'a>,
    warnings: Warnings,
    watch: &'a dyn Watch,
}

/// Reads the upload's main file.
///
/// # Errors
/// Every code of [`crate::ErrorCode`] that is about the input, with the place (`pointer`) and the rule.
pub fn read(upload: &Upload, limits: &Limits, watch: &dyn Watch) -> Result<Asset> {
    read_with(upload, &[], limits, watch)
}

/// Reads the upload's main file, and images of it as attributes of its materials.
///
/// # Errors
/// As [`read`]; `InvalidOptions` where an attribute finds no material, or faces without coordinates.
pub fn read_with(
    upload: &Upload,
    attributes: &[AttributeSource],
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<Asset> {
    watch.stage(Stage::Read);
    watch::check(watch)?;
    let bytes = main_file(upload)?;
    match container::detect(&bytes)? {
        Container::Zip => {
            let inner = archive::unpack(&bytes, limits, watch)?;
            drop(bytes);
            let bytes = main_file(&inner)?;
            match container::detect(&bytes)? {
                Container::Zip => Err(Error::invalid("the archive's model is itself an archive")),
                container => {
                    Model { container, bytes: &bytes, upload: &inner, attributes }.read(limits, watch)
                }
            }
        }
        container => Model { container, bytes: &bytes, upload, attributes }.read(limits, watch),
    }
}

fn main_file(upload: &Upload) -> Result<Vec<u8>> {
    upload.files.read(&upload.main)?.ok_or_else(|| {
        let detail = format!("the model {} is not in the upload", text::quoted(&upload.main));
        Error::new(ErrorCode::MissingResource, detail)
    })
}

/// A main file with what may be read beside it.
struct Model<'a> {
    container: Container,
    bytes: &'a [u8],
    upload: &'a Upload,
    attributes: &'a [AttributeSource],
}

impl Model<'_> {
    fn read(&self, limits: &Limits, watch: &dyn Watch) -> Result<Asset> {
        let Self { container, bytes, upload, attributes } = *self;
        let mut context = Context {
            resources: Resources::new(upload.files.as_ref(), &upload.main),
            budget: Budget::new(limits),
            warnings: Warnings::default(),
            watch,
        };
        let mut asset = match container {
            Container::Glb => {
                let glb = glb::split(bytes)?;
                gltf::read(json::parse(glb.json, limits)?, glb.bin, &mut context)?
            }
            Container::GltfJson => gltf::read(json::parse(bytes, limits)?, None, &mut context)?,
            Container::Obj => obj::read(bytes, &upload.main, &mut context)?,
            Container::Ply => ply::read(bytes, &upload.main, &mut context)?,
            Container::Zip => return Err(Error::internal("an archive reached the model readers")),
        };
        attributes::add(&mut asset, attributes, &mut context)?;
        asset.warnings = context.warnings.into_list();
        Ok(asset)
    }
}
