//! Editing a model after it was painted (MC 3.3): other resolutions, fewer faces, more faces, another mesh.
//!
//! Samples belong to vertices, edges and faces, so what changes these carries its samples along: a sample that is at a
//! place before and after keeps its value to the last bit, and what is new between samples is what was shown there. Only
//! [`transfer`] resamples, and says by how much the result differs.

mod carry;
mod coarsen;
mod compare;
mod delete;
mod geometry;
mod nearest;
mod painting;
mod resolution;
mod selection;
mod side;
mod smooth;
mod split;
mod subdivide;
#[cfg(test)]
mod tests;
mod transfer;

pub use delete::delete;
pub use resolution::{ResolutionChange, resolution};
pub use selection::Selection;
pub use subdivide::{Scheme, subdivide};
pub use transfer::{TransferError, TransferReport, transfer};

use painting::Painting;
use serde::Serialize;

use crate::asset::{Asset, MeshColorChannel, MeshColors};
use crate::error::Result;
use crate::watch::Watch;
use crate::write::{PaintedMaterial, mesh_colors_glb};

/// An edited model, as a file with `MCT_mesh_colors`.
#[derive(Clone, Debug)]
pub struct Edited {
    pub glb: Vec<u8>,
    pub report: EditReport,
}

/// What an edit did.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EditReport {
    pub materials: Vec<MaterialEdit>,
    /// Of a transfer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transfer: Option<TransferReport>,
}

/// One painted material before and after. Two triangles that are one quad count once.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MaterialEdit {
    /// Index into the model's materials.
    pub material: usize,
    pub face_count_before: u64,
    pub face_count: u64,
    /// Over all channels.
    pub sample_count_before: u64,
    pub sample_count: u64,
}

impl MaterialEdit {
    fn of(before: &Painting, after: &MeshColors) -> Self {
        let count =
            |channel: &MeshColorChannel| (channel.samples.len() / usize::from(channel.components)) as u64;
        Self {
            material: before.material,
            face_count_before: before.canvas.faces.len() as u64,
            face_count: after.exponents.len() as u64,
            sample_count_before: before.sample_count(),
            sample_count: after.channels.iter().map(count).sum(),
        }
    }
}

/// Where the primitives of an edited model come from: by mesh, which of the document's each one is.
type PrimitiveOrigins = Vec<Vec<usize>>;

/// Writes the painted materials of a model. `remodeled`: where its faces are not the document's any more; `takes_colors`:
/// whether painted faces lose their vertex colors, which would count beside the paint.
fn written(
    asset: &Asset,
    materials: Vec<(usize, MeshColors)>,
    takes_colors: bool,
    remodeled: Option<&PrimitiveOrigins>,
    watch: &dyn Watch,
) -> Result<Vec<u8>> {
    let painted =
        |(material, colors)| PaintedMaterial { material, colors, stand_ins: Vec::new(), takes_colors };
    let painted: Vec<PaintedMaterial> = materials.into_iter().map(painted).collect();
    mesh_colors_glb(asset, &painted, remodeled.map(Vec::as_slice), watch)
}
