//! Finished conversions to files: the GLB with its images, in the form that the bundle promises.
//!
//! The glTF JSON of the source is the draft: what was converted is replaced in it, everything else
//! stays as it came, and what only the replaced parts used is swept out at the end.

mod alike;
mod compact;
mod coordinates;
mod draft;
mod extensions;
mod geometry;
mod images;
mod in_use;
mod materials;
mod mesh_colors;
mod meshes;
mod ngons;
mod packed;
mod parts;
mod primitives;
mod references;
#[cfg(test)]
mod tests;
pub mod textures;
mod united;
mod vertices;

use std::collections::BTreeMap;

use crate::asset::Asset;
use crate::error::{Error, ErrorCode, Result, Warning};
use crate::finished::{EXTENSION, Finished, FinishedPrimitive};
use crate::watch::{Stage, Watch, check};

use draft::Draft;
pub use images::png;
use materials::Materials;
pub use mesh_colors::{PaintedMaterial, mesh_colors_glb};
use meshes::MeshTarget;
pub use packed::GeometryFormat;
pub use references::shows_textures;

/// One file of a bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BundleFile {
    /// Relative path with `/`.
    pub path: String,
    pub bytes: Vec<u8>,
}

/// A written model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Glb {
    pub bytes: Vec<u8>,
    /// Over all primitives.
    pub vertex_count: u64,
}

/// The converted model as one binary glTF 2.0 file: the same bytes for any number of threads.
///
/// A converted material belongs to the converted primitives alone: a primitive that shares it without
/// having faces to convert (points, lines), and a `KHR_materials_variants` mapping of a converted
/// primitive, get a copy of the source's material at the end of `materials`, with the source's
/// textures. Parts of a material beyond the first are copies of it there, and of the primitives at the end of their
/// mesh. Materials that share their textures and differ in nothing but their names become one, and so do primitives of
/// theirs that differ in nothing but geometry. What cannot be kept is named by [`losses`].
///
/// # Errors
/// `Canceled`; `InvalidModel` where a part of the source that has to be kept lies outside of its
/// buffer; `Internal` where `asset` and `finished` contradict each other.
pub fn glb(asset: &Asset, finished: &Finished, watch: &dyn Watch) -> Result<Glb> {
    let pngs = encode(finished, watch)?;
    glb_of(asset, finished, pngs, GeometryFormat::Plain, watch)
}

/// Every level as PNG, by texture and level.
pub type Pngs = Vec<Vec<Vec<u8>>>;

/// The PNG files that [`glb_of`] puts into the model.
///
/// # Errors
/// `Canceled`; `Internal` where an image breaks its own guarantees.
pub fn encode(finished: &Finished, watch: &dyn Watch) -> Result<Pngs> {
    watch.stage(Stage::Write);
    watch.step(Some("encode"));
    let pngs = images::encode_levels(finished, watch);
    watch.step(None);
    pngs
}

/// [`glb`] with levels that are encoded already, and geometry in a format.
///
/// # Errors
/// As [`glb`].
pub fn glb_of(
    asset: &Asset,
    finished: &Finished,
    pngs: Pngs,
    geometry: GeometryFormat,
    watch: &dyn Watch,
) -> Result<Glb> {
    let mut draft = Draft::open(&asset.document)?;
    images::embed_files(&mut draft, asset);
    // Ours, not the file's.
    finished.check().map_err(|error| Error { code: ErrorCode::Internal, ..error })?;
    let converted = converted_primitives(asset, finished)?;
    let mut materials = Materials::convert(&mut draft, asset, finished, pngs)?;
    let mut vertex_count = 0;
    for mesh in 0..asset.meshes.len() {
        let pieces = converted.get(&mesh).map_or(&[][..], Vec::as_slice);
        let target = MeshTarget { asset, finished, mesh, pieces };
        vertex_count += target.write(&mut draft, &mut materials, watch)?;
    }
    united::sweep(&mut draft, &materials.united);
    compact::sweep(&mut draft, &asset.document)?;
    extensions::settle(&mut draft, if converted.is_empty() { &[] } else { &[EXTENSION] });
    check(watch)?;
    packed::pack(&mut draft, geometry, watch)?;
    Ok(Glb { bytes: draft.into_glb()?, vertex_count })
}

/// What a converted file cannot keep of its source, as warnings for the report.
pub fn losses(asset: &Asset, finished: &Finished) -> Vec<Warning> {
    primitives::losses(asset, finished)
}

/// The primitives with triangles by mesh, in order of primitive and part, checked against the asset. One without
/// triangles is written as it came, because an accessor cannot be empty.
fn converted_primitives<'a>(
    asset: &Asset,
    finished: &'a Finished,
) -> Result<BTreeMap<usize, Vec<&'a FinishedPrimitive>>> {
    let mut converted: BTreeMap<usize, Vec<&FinishedPrimitive>> = BTreeMap::new();
    for piece in &finished.primitives {
        let place = format!("/meshes/{}/primitives/{}", piece.mesh, piece.primitive);
        let source = asset
            .meshes
            .get(piece.mesh)
            .and_then(|mesh| mesh.primitives.get(piece.primitive))
            .ok_or_else(|| Error::internal("a converted primitive is not in the asset").at(&place))?;
        let vertex_count = source.positions.len();
        let corners = piece.triangles.iter().flat_map(|triangle| triangle.vertices);
        if corners.into_iter().any(|vertex| vertex as usize >= vertex_count) {
            return Err(Error::internal("a triangle has a vertex that its primitive lacks").at(place));
        }
        if !piece.frames.is_empty() && piece.frames.len() != piece.triangles.len() {
            return Err(Error::internal("frames and triangles differ in number").at(place));
        }
        if !piece.triangles.is_empty() {
            converted.entry(piece.mesh).or_default().push(piece);
        }
    }
    for pieces in converted.values_mut() {
        pieces.sort_by_key(|piece| (piece.primitive, piece.part));
    }
    Ok(converted)
}
