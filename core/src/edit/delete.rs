//! Fewer faces.

use std::collections::BTreeSet;

use crate::asset::{Asset, Mesh};
use crate::error::{Error, ErrorCode, Result};
use crate::pipeline::painted::ModelFaces;
use crate::read::Limits;
use crate::watch::Watch;

use super::carry::{Origin, Sketch};
use super::geometry::compacted;
use super::painting::{Painting, paintings};
use super::{EditReport, Edited, MaterialEdit, PrimitiveOrigins, Selection, written};

/// Takes faces out of the model, with the vertices and samples that only they had. Everything else looks as before.
///
/// # Errors
/// As [`resolution`](super::resolution()); `InvalidOptions` too where a mesh would lose all its faces, which glTF does not
/// allow.
pub fn delete(asset: &Asset, selection: &Selection, limits: &Limits, watch: &dyn Watch) -> Result<Edited> {
    let paintings = paintings(asset)?;
    let selected = selection.of(&paintings)?;
    let gone = model_faces(&paintings, &selected);
    let (edited, primitives) = without(asset, &gone)?;
    let mut report = EditReport::default();
    let mut materials = Vec::with_capacity(paintings.len());
    for painting in &paintings {
        let model_faces = ModelFaces::of(asset, painting.material);
        let origins = Origin::of_model_faces(painting, &model_faces);
        let is_kept: Vec<bool> = model_faces.places.iter().map(|place| !gone.contains(place)).collect();
        let mut next = 0;
        let number = |kept: &bool| {
            let own = next;
            next += u32::from(*kept);
            own
        };
        let numbers: Vec<u32> = is_kept.iter().map(number).collect();
        let kept = |face: &usize| is_kept[*face];
        let faces: Vec<usize> = (0..is_kept.len()).filter(kept).collect();
        let partner = |face: &usize| painting.partners[*face].map(|other| numbers[other as usize]);
        let partners = faces.iter().map(partner).collect();
        let origins: Vec<Origin> = faces.iter().map(|face| origins[*face]).collect();
        let sketch = Sketch::new(painting, &edited, (partners, &origins), |_| 0)?;
        let colors = sketch.colors(painting, limits.job_pixels, watch)?;
        report.materials.push(MaterialEdit::of(painting, &colors));
        if !colors.exponents.is_empty() {
            materials.push((painting.material, colors));
        }
    }
    Ok(Edited { glb: written(&edited, materials, false, Some(&primitives), watch)?, report })
}

/// Mesh, primitive and face.
type At = [u32; 3];

/// The faces of the model that the selected faces are.
fn model_faces(paintings: &[Painting], selected: &[Vec<bool>]) -> BTreeSet<At> {
    let mut gone = BTreeSet::new();
    for (painting, selected) in paintings.iter().zip(selected) {
        for (face, _) in painting.canvas.faces.iter().zip(selected).filter(|(_, selected)| **selected) {
            gone.extend(face.drawn.map(|drawn| [face.mesh, drawn.primitive, drawn.face]));
        }
    }
    gone
}

/// The model without some faces, and without primitives that have none left.
fn without(asset: &Asset, gone: &BTreeSet<At>) -> Result<(Asset, PrimitiveOrigins)> {
    let mut edited = asset.clone();
    let mut origins = Vec::with_capacity(asset.meshes.len());
    for (number, mesh) in (0u32..).zip(&mut edited.meshes) {
        let before = std::mem::take(mesh);
        *mesh = Mesh { name: before.name, primitives: Vec::new() };
        let mut own = Vec::new();
        for (place, mut primitive) in (0u32..).zip(before.primitives) {
            let count = primitive.faces.len();
            let faces = (0u32..).zip(&primitive.faces);
            primitive.faces = faces
                .filter(|(face, _)| !gone.contains(&[number, place, *face]))
                .map(|(_, face)| *face)
                .collect();
            if count > 0 && primitive.faces.is_empty() {
                continue;
            }
            let is_changed = primitive.faces.len() < count;
            mesh.primitives.push(if is_changed { compacted(&primitive) } else { primitive });
            own.push(place as usize);
        }
        if own.is_empty() {
            let detail =
                format!("mesh {number} would have no faces left; delete its nodes from the scene instead");
            return Err(Error::new(ErrorCode::InvalidOptions, detail).at(format!("/meshes/{number}")));
        }
        origins.push(own);
    }
    Ok((edited, origins))
}
