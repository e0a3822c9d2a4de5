//! The drawn triangles of one material over all its meshes, with the pairs of sides that meet: of a
//! source by its faces, of a conversion by the triangles that it wrote.

use glam::{Vec2, Vec3};

use super::edges::{self, EdgePair, Side};
use crate::asset::{Asset, Primitive};
use crate::error::{Error, Result};
use crate::finished::{Anchor, Coordinates, Finished, FinishedPrimitive, FinishedTriangle, Frame, faces_of};

/// No image is as large: converted coordinates beyond are refused.
const FAR_TEXELS: f32 = 1e9;

/// The triangles of one primitive that stand in one part of its material.
pub struct Part<'a> {
    pub mesh: usize,
    pub primitive: usize,
    pub geometry: &'a Primitive,
    /// Vertices of `geometry`.
    pub triangles: Vec<[u32; 3]>,
    /// One for each triangle; empty for a plain source.
    pub placed: &'a [FinishedTriangle],
    /// Of `placed`.
    pub coordinates: &'a Coordinates,
    pub finished: Option<&'a FinishedPrimitive>,
}

impl Part<'_> {
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|vertex| self.geometry.positions[vertex as usize])
    }

    /// The place of barycentrics `at` in the image of `level`, in texels.
    pub fn place_at(&self, triangle: usize, at: Vec3, level: usize) -> Vec2 {
        self.coordinates.place_at(&self.placed[triangle], at, level)
    }

    /// The face of each triangle.
    ///
    /// # Errors
    /// `InvalidModel` where the triangles are not some of those that the faces are drawn as, in their order.
    pub fn faces(&self) -> Result<Vec<u32>> {
        faces_of(self.geometry, self.triangles.iter().copied()).ok_or_else(|| {
            Error::invalid("the drawn triangles are not those of the asset's faces")
                .at(format!("/meshes/{}/primitives/{}", self.mesh, self.primitive))
        })
    }

    /// Of its material.
    pub fn part(&self) -> usize {
        self.finished.map_or(0, |finished| finished.part)
    }

    /// The frames a conversion gave; empty where it has none.
    pub fn frames(&self) -> &[[Frame; 3]] {
        self.finished.map_or(&[], |finished| &finished.frames)
    }
}

pub struct Surface<'a> {
    pub material: usize,
    /// In order of mesh, primitive and part.
    pub parts: Vec<Part<'a>>,
    pub pairs: Vec<EdgePair>,
}

impl<'a> Surface<'a> {
    /// `primitives` are the material's, see [`of_source`].
    pub fn of_source(primitives: Vec<(usize, usize, &'a Primitive)>, material: usize) -> Self {
        let part = |(mesh, primitive, geometry)| {
            let triangles = fan(geometry).map(|(_, triangle)| triangle).collect();
            Part {
                mesh,
                primitive,
                geometry,
                triangles,
                placed: &[],
                coordinates: &Coordinates::Scaled,
                finished: None,
            }
        };
        Self::joined(material, primitives.into_iter().map(part).collect())
    }

    /// `primitives` are the material's, see [`by_material`].
    ///
    /// # Errors
    /// `InvalidModel` where the conversion does not fit the asset it is about.
    pub fn of_finished(
        asset: &'a Asset,
        primitives: &[&'a FinishedPrimitive],
        material: usize,
    ) -> Result<Self> {
        let mut parts = Vec::with_capacity(primitives.len());
        for &written in primitives {
            let at = format!("/meshes/{}/primitives/{}", written.mesh, written.primitive);
            let geometry = asset
                .meshes
                .get(written.mesh)
                .and_then(|mesh| mesh.primitives.get(written.primitive))
                .ok_or_else(|| {
                    Error::invalid("converted coordinates of a primitive that is not there").at(&at)
                })?;
            check_fit(geometry, written).map_err(|error| error.at(&at))?;
            parts.push(Part {
                mesh: written.mesh,
                primitive: written.primitive,
                geometry,
                triangles: written.triangles.iter().map(|triangle| triangle.vertices).collect(),
                placed: &written.triangles,
                coordinates: &written.coordinates,
                finished: Some(written),
            });
        }
        parts.sort_by_key(|part| (part.mesh, part.primitive, part.part()));
        Ok(Self::joined(material, parts))
    }

    fn joined(material: usize, parts: Vec<Part<'a>>) -> Self {
        let pairs = edges::pairs(&parts);
        Self { material, parts, pairs }
    }

    pub fn part(&self, side: &Side) -> &Part<'a> {
        &self.parts[side.part as usize]
    }

    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.triangles.len()).sum()
    }

    /// For each pair, whether either side's triangle says that its texture does not join it, one of `textures`.
    pub fn cut_flags(&self, textures: &[usize]) -> Vec<bool> {
        let bits: Vec<&[u8]> = self
            .parts
            .iter()
            .map(|part| {
                let cuts = part.finished.map_or(&[][..], |finished| &finished.cuts);
                cuts.iter().find(|cuts| textures.contains(&cuts.texture)).map_or(&[][..], |cuts| &cuts.bits)
            })
            .collect();
        let marked = |side: &Side| {
            let bits = bits[side.part as usize].get(side.triangle as usize).copied().unwrap_or(0);
            bits >> side.corner & 1 == 1
        };
        self.pairs.iter().map(|pair| marked(&pair.a) || marked(&pair.b)).collect()
    }
}

/// The primitives with faces of each of a plain model's materials, as mesh, primitive and geometry.
pub fn of_source(asset: &Asset) -> Vec<Vec<(usize, usize, &Primitive)>> {
    let mut groups = vec![Vec::new(); asset.materials.len()];
    for (mesh, content) in asset.meshes.iter().enumerate() {
        for (number, primitive) in content.primitives.iter().enumerate() {
            let group = primitive.material.and_then(|material| groups.get_mut(material));
            if let Some(group) = group.filter(|_| !primitive.faces.is_empty()) {
                group.push((mesh, number, primitive));
            }
        }
    }
    groups
}

/// The converted primitives of each of the model's materials.
pub fn by_material<'f>(asset: &Asset, finished: &'f Finished) -> Vec<Vec<&'f FinishedPrimitive>> {
    let mut groups = vec![Vec::new(); asset.materials.len()];
    for written in &finished.primitives {
        if let Some(group) = groups.get_mut(written.material) {
            group.push(written);
        }
    }
    groups
}

/// The triangles that a primitive's faces are drawn as, each with its face.
pub fn fan(primitive: &Primitive) -> impl Iterator<Item = (usize, [u32; 3])> {
    primitive.faces.iter().enumerate().flat_map(|(number, face)| {
        face.triangles().iter().map(move |corners| (number, corners.map(|corner| face.corners[corner])))
    })
}

fn check_fit(geometry: &Primitive, written: &FinishedPrimitive) -> Result<()> {
    let vertex_count = geometry.positions.len();
    for (number, triangle) in written.triangles.iter().enumerate() {
        if triangle.vertices.iter().any(|&vertex| vertex as usize >= vertex_count) {
            return Err(Error::invalid(format!(
                "triangle {number} names vertices {:?}, and there are {vertex_count}",
                triangle.vertices
            )));
        }
        // Not a number is not within either.
        let is_near = |place: Vec2| place.abs().cmplt(Vec2::splat(FAR_TEXELS)).all();
        let is_offset_near = match triangle.anchor {
            Anchor::Offset(offset) => is_near(offset),
            // Blocks are checked with their table.
            Anchor::Block { .. } => true,
        };
        if !(triangle.corners.into_iter().all(is_near) && is_offset_near) {
            return Err(Error::invalid(format!(
                "triangle {number} has a coordinate beyond {FAR_TEXELS} texels"
            )));
        }
    }
    if !written.frames.is_empty() && written.frames.len() != written.triangles.len() {
        return Err(Error::invalid("frames and triangles differ in number"));
    }
    Ok(())
}
