//! Four faces for each.

use serde::Serialize;

use crate::asset::Asset;
use crate::error::{Error, ErrorCode, Result};
use crate::pipeline::painted::ModelFaces;
use crate::read::Limits;
use crate::watch::Watch;

use super::carry::{Origin, Sketch};
use super::painting::{Painting, paintings};
use super::smooth::smooth;
use super::split::{Center, MIDDLE, PARTS, origins, split};
use super::{EditReport, Edited, MaterialEdit, written};

/// Where the vertices of a subdivided mesh lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Scheme {
    /// On the faces that they come from: the shape stays.
    Midpoint,
    /// On Loop's surface: triangles only.
    Loop,
    /// On Catmull and Clark's surface. Triangles among the quads are split in four triangles (Stam and Loop).
    CatmullClark,
}

/// Splits every face of the model in four. Each part has half the segments of its face along both axes, so that samples
/// are where they were on the face and nothing is resampled; of a face of one segment the new corners get what was shown
/// there. Positions are the scheme's; other attributes are means, their vectors of unit length.
///
/// # Errors
/// As [`resolution`](super::resolution()); `InvalidOptions` too where the scheme cannot be had: `Loop` with quads, any with
/// skins, and any but `Midpoint` with morph targets; `TooManyTriangles` and `ModelTooLarge` beyond `limits`.
pub fn subdivide(asset: &Asset, scheme: Scheme, limits: &Limits, watch: &dyn Watch) -> Result<Edited> {
    let paintings = paintings(asset)?;
    check(asset, scheme, limits)?;
    let center = if scheme == Scheme::Midpoint { Center::Diagonal } else { Center::Mean };
    let mut edited = asset.clone();
    for mesh in &mut edited.meshes {
        for primitive in mesh.primitives.iter_mut().filter(|primitive| !primitive.faces.is_empty()) {
            crate::watch::check(watch)?;
            *primitive = split(primitive, center);
        }
        if scheme != Scheme::Midpoint {
            smooth(mesh);
        }
    }
    let primitives = asset.meshes.iter().map(|mesh| (0..mesh.primitives.len()).collect()).collect();
    let mut report = EditReport::default();
    let mut materials = Vec::with_capacity(paintings.len());
    for painting in &paintings {
        let model_faces = ModelFaces::of(asset, painting.material);
        let before = Origin::of_model_faces(painting, &model_faces);
        let parts = before.iter().zip(&model_faces.places).flat_map(|(origin, &[mesh, primitive, face])| {
            let face = asset.meshes[mesh as usize].primitives[primitive as usize].faces[face as usize];
            origins(*origin, face.count == 3)
        });
        let parts: Vec<Origin> = parts.collect();
        let sketch = Sketch::new(painting, &edited, (partners(painting, &model_faces), &parts), |_| 0)?;
        let colors = sketch.colors(painting, limits.job_pixels, watch)?;
        report.materials.push(MaterialEdit::of(painting, &colors));
        materials.push((painting.material, colors));
    }
    Ok(Edited { glb: written(&edited, materials, false, Some(&primitives), watch)?, report })
}

fn check(asset: &Asset, scheme: Scheme, limits: &Limits) -> Result<()> {
    let mut triangles = 0;
    let mut vertices = 0;
    for (mesh, own) in asset.meshes.iter().enumerate() {
        for (number, primitive) in own.primitives.iter().enumerate().filter(|(_, own)| !own.faces.is_empty())
        {
            let refuse = |detail: &str| {
                let place = format!("/meshes/{mesh}/primitives/{number}");
                Err(Error::new(ErrorCode::InvalidOptions, detail).at(place))
            };
            if primitive.attributes.iter().any(|own| own.semantic.starts_with("JOINTS_")) {
                return refuse(
                    "the primitive is skinned, and joints of new vertices are not worked out; subdivide the model before it is skinned",
                );
            }
            if scheme != Scheme::Midpoint && !primitive.targets.is_empty() {
                return refuse(
                    "the primitive has morph targets, which only `midpoint` keeps; take that scheme",
                );
            }
            if scheme == Scheme::Loop && primitive.faces.iter().any(|face| face.count == 4) {
                return refuse(
                    "`loop` splits triangles, and the primitive has quads; take `catmull-clark` or `midpoint`",
                );
            }
            triangles += primitive.faces.iter().map(|face| 4 * face.triangles().len() as u64).sum::<u64>();
            // At most three middles or centers for each face.
            vertices += (primitive.positions.len() + 5 * primitive.faces.len()) as u64;
        }
    }
    let over = |code, what: &str, limit: u64, count: u64| {
        Err(Error::new(code, format!("the model would have {count} {what}, and {limit} are allowed"))
            .limit(limit, count))
    };
    if triangles > limits.triangles {
        return over(ErrorCode::TooManyTriangles, "triangles", limits.triangles, triangles);
    }
    if vertices > limits.vertices {
        return over(ErrorCode::ModelTooLarge, "vertices", limits.vertices, vertices);
    }
    Ok(())
}

/// By part of the model's faces: where two triangles were a quad, their parts are four.
fn partners(painting: &Painting, model_faces: &ModelFaces) -> Vec<Option<u32>> {
    let mut partners = vec![None; model_faces.places.len() * PARTS as usize];
    for face in painting.canvas.faces.iter().filter(|face| face.is_pair()) {
        let [a, b] = model_faces.drawn(face).map(|number| number * PARTS);
        // Corners 0, 1, 2 of the quad on the one, and 0, 2, 3 on the other.
        let [a0, a1, a2] = face.drawn[0].corners.map(|corner| a + u32::from(corner));
        let [b0, b2, b3] = face.drawn[1].corners.map(|corner| b + u32::from(corner));
        for [one, other] in [[a0, b0], [a1, a + MIDDLE], [a2, b2], [b3, b + MIDDLE]] {
            partners[one as usize] = Some(other);
            partners[other as usize] = Some(one);
        }
    }
    partners
}
