//! The source of one channel where it is mesh colors: what the reference filter (MC 4.1) gives at a point of the surface.

use glam::{Vec3, Vec4};

use super::judge::Meaning;
use super::origin::meaning;
use super::surface::{Part, Surface};
use crate::asset::{Asset, Face, Slot};
use crate::error::{Error, Result};
use crate::finished::Frame;
use crate::source::painted::{DrawnPlace, PaintedChannel, PaintedSource};
use crate::source::tangents::corner_normals;

/// A channel's mesh colors over one surface.
pub struct PaintedOrigin<'a> {
    pub channel: &'a PaintedChannel<'a>,
    pub meaning: Meaning,
    /// Part by part, where its triangles stand.
    places: Vec<Vec<DrawnPlace>>,
    /// Part by part, the mesh's own normals at the corners of its triangles; empty but for normals.
    frames: Vec<Vec<[Frame; 3]>>,
}

impl<'a> PaintedOrigin<'a> {
    /// `None` where the material has no mesh colors for that slot.
    ///
    /// # Errors
    /// `Internal` where the surface's triangles are not those of the faces that have the mesh colors.
    pub fn new(
        asset: &Asset,
        surface: &Surface<'_>,
        slot: Slot,
        sources: &'a [PaintedSource<'a>],
    ) -> Result<Option<Self>> {
        let own = sources.iter().find(|source| source.material == surface.material);
        let Some((source, channel)) = own.and_then(|source| Some((source, source.channel(slot)?))) else {
            return Ok(None);
        };
        let meaning = meaning(asset, surface.material, slot);
        let places = surface.parts.iter().map(|part| part_places(part, source)).collect::<Result<_>>()?;
        let frames = if matches!(meaning, Meaning::Normal { .. }) {
            surface.parts.iter().map(part_frames).collect::<Result<_>>()?
        } else {
            Vec::new()
        };
        Ok(Some(Self { channel, meaning, places, frames }))
    }

    /// Where a triangle stands.
    pub fn place(&self, part: usize, triangle: usize) -> &DrawnPlace {
        &self.places[part][triangle]
    }

    /// What the source shows at barycentrics `at` of a triangle: linear light, data, or a normal in the mesh's space whose length
    /// says nothing.
    pub fn shown(&self, part: usize, triangle: usize, at: Vec3) -> Vec4 {
        let place = self.place(part, triangle);
        self.channel.colors.linear(place.face as usize, place.at(at), 0)
    }

    /// The mesh's own normals, where the channel holds normals; their tangents say nothing.
    pub fn corner_frames(&self, part: usize, triangle: usize) -> Option<&[Frame; 3]> {
        self.frames.get(part).map(|frames| &frames[triangle])
    }
}

/// Each triangle of a part with the face that it is drawn for, and which of its corners it has.
fn drawn<'p>(part: &'p Part<'_>) -> Result<impl Iterator<Item = (u32, Option<[usize; 3]>)> + 'p> {
    let faces = part.faces()?;
    let of_face = |(triangle, face): (&[u32; 3], u32)| {
        (face, drawn_corners(&part.geometry.faces[face as usize], triangle))
    };
    Ok(part.triangles.iter().zip(faces).map(of_face))
}

/// Which corners of a face a triangle has: those of one of the triangles that the face is drawn as.
fn drawn_corners(face: &Face, triangle: &[u32; 3]) -> Option<[usize; 3]> {
    face.triangles().iter().find_map(|own| {
        let corner = |&vertex: &u32| own.iter().copied().find(|&corner| face.corners[corner] == vertex);
        let [a, b, c] = triangle.each_ref().map(corner);
        Some([a?, b?, c?])
    })
}

fn part_places(part: &Part<'_>, source: &PaintedSource<'_>) -> Result<Vec<DrawnPlace>> {
    let place = |(face, corners): (u32, Option<[usize; 3]>)| {
        let place = corners.and_then(|own| source.place([part.mesh, part.primitive, face as usize], own));
        place.ok_or_else(|| {
            Error::internal("a drawn triangle has no place among the mesh colors")
                .at(format!("/meshes/{}/primitives/{}", part.mesh, part.primitive))
        })
    };
    drawn(part)?.map(place).collect()
}

fn part_frames(part: &Part<'_>) -> Result<Vec<[Frame; 3]>> {
    let frames = |(face, corners): (u32, Option<[usize; 3]>)| {
        let normals = corner_normals(part.geometry, &part.geometry.faces[face as usize]);
        corners.unwrap_or([0, 1, 2]).map(|corner| Frame { normal: normals[corner], tangent: Vec4::W })
    };
    Ok(drawn(part)?.map(frames).collect())
}
