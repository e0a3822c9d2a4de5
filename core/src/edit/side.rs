//! One of two models that stand in one world.

use glam::{DAffine3, DVec3, Mat3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::asset::Asset;
use crate::colors::LevelNumbering;
use crate::error::{Error, Result};
use crate::mesh::{CanvasMesh, surface_point};
use crate::watch::{self, Watch};

use super::nearest::{Place, Surface};

/// Places that are looked for between two looks at whether to go on.
const BATCH: usize = 1 << 16;

/// A canvas in the world.
pub struct Side<'a> {
    pub canvas: &'a CanvasMesh,
    /// By vertex.
    pub positions: Vec<DVec3>,
    /// By mesh: mesh space to the world's.
    transforms: Vec<Mat3>,
}

/// A point of a face, in segments of its grid.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    pub face: u32,
    /// `(s, t)` of the unit domain.
    pub at: [f32; 2],
}

/// Where the samples of a level are, by number; each as the first face sees it that has it.
pub fn spots(numbering: &LevelNumbering<'_>) -> Vec<Spot> {
    let mut spots = vec![Spot { face: u32::MAX, at: [0.0; 2] }; numbering.sample_count()];
    for face in 0..numbering.canvas.faces.len() {
        let shape = numbering.shape(face);
        for (i, j) in (0..=shape.segments[1]).flat_map(|j| (0..shape.point_count(j)).map(move |i| (i, j))) {
            let tap = numbering.tap(face, i, j);
            let spot = &mut spots[tap.samples[0] as usize];
            if tap.second == 0.0 && spot.face == u32::MAX {
                *spot = Spot { face: face as u32, at: shape.unit(i, j) };
            }
        }
    }
    spots
}

impl<'a> Side<'a> {
    /// Each mesh where its first instance stands; in its own space where it has none.
    pub fn new(asset: &Asset, canvas: &'a CanvasMesh) -> Self {
        let of_mesh = |mesh: usize| {
            let instance = asset.instances.iter().find(|instance| instance.mesh == mesh);
            instance.map_or(DAffine3::IDENTITY, |instance| {
                DAffine3::from_mat3_translation(
                    glam::Mat3::from(instance.transform.matrix3).as_dmat3(),
                    glam::Vec3::from(instance.transform.translation).as_dvec3(),
                )
            })
        };
        let transforms: Vec<DAffine3> = (0..asset.meshes.len()).map(of_mesh).collect();
        let mut positions = vec![DVec3::ZERO; canvas.positions.len()];
        for face in &canvas.faces {
            for &vertex in &face.vertices[..face.count()] {
                let own = canvas.positions[vertex as usize].as_dvec3();
                positions[vertex as usize] = transforms[face.mesh as usize].transform_point3(own);
            }
        }
        let transforms = transforms.iter().map(|transform| transform.matrix3.as_mat3()).collect();
        Self { canvas, positions, transforms }
    }

    pub fn area(&self) -> f64 {
        let of_face = |face: &crate::mesh::CanvasFace| {
            let of_drawn = |corners: &[usize; 3]| {
                let [a, b, c] = corners.map(|k| self.positions[face.vertices[k] as usize]);
                0.5 * (b - a).cross(c - a).length()
            };
            face.drawn_corners().iter().map(of_drawn).sum::<f64>()
        };
        self.canvas.faces.iter().map(of_face).sum()
    }

    /// Diagonal of the box around the vertices.
    pub fn diagonal(&self) -> f64 {
        let least = self.positions.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let most = self.positions.iter().copied().reduce(DVec3::max).unwrap_or_default();
        (most - least).length()
    }

    pub fn point(&self, spot: &Spot) -> DVec3 {
        let face = &self.canvas.faces[spot.face as usize];
        let (drawn, weights) = surface_point(face.count(), spot.at[0], spot.at[1]);
        let corners = face.drawn_corners()[drawn].map(|k| self.positions[face.vertices[k] as usize]);
        let weights = weights.as_dvec3();
        corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z
    }

    /// The places of this side that are nearest to spots of another. `surface`: this one's.
    ///
    /// # Errors
    /// `Canceled`.
    pub fn nearest_to(
        &self,
        surface: &Surface,
        other: &Side<'_>,
        spots: &[Spot],
        watch: &dyn Watch,
    ) -> Result<Vec<Place>> {
        let mut places = Vec::with_capacity(spots.len());
        for batch in spots.chunks(BATCH) {
            watch::check(watch)?;
            let nearest = |spot| {
                let place = surface.nearest(self.canvas, other.point(spot));
                place.ok_or_else(|| Error::internal("a surface without faces was searched"))
            };
            places.extend(batch.par_iter().map(nearest).collect::<Result<Vec<_>>>()?);
        }
        Ok(places)
    }

    /// A normal in the space of a face's mesh as one in the space of another side's face.
    pub fn turned(&self, normal: Vec4, face: u32, other: &Side<'_>, other_face: u32) -> Vec4 {
        let to_world = self.transforms[self.canvas.faces[face as usize].mesh as usize];
        let other_to_world = other.transforms[other.canvas.faces[other_face as usize].mesh as usize];
        // Normals go by the inverse transposed; back from the world that is the transposed.
        let world = to_world.inverse().transpose() * normal.xyz();
        let turned = (other_to_world.transpose() * world).try_normalize();
        turned.filter(|turned| turned.is_finite()).map_or(Vec4::Z, |turned| turned.extend(1.0))
    }
}
