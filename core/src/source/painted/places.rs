//! From the faces of a model to those of a canvas, some of which are two of its triangles.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};

use crate::mesh::CanvasMesh;

/// Where a drawn triangle stands on a canvas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnPlace {
    /// Of the canvas.
    pub face: u32,
    /// By corner of the triangle: the place in the face's unit domain.
    pub corners: [Vec2; 3],
}

impl DrawnPlace {
    /// The place of a point, given its barycentrics.
    pub fn at(&self, weights: Vec3) -> Vec2 {
        let [a, b, c] = self.corners;
        a * weights.x + b * weights.y + c * weights.z
    }
}

/// By mesh and primitive, and there by face of the model.
pub struct DrawnPlaces(BTreeMap<[usize; 2], Vec<Option<FacePlace>>>);

/// A face of the model on the canvas: the whole face there, or one of its two triangles.
#[derive(Clone, Copy)]
struct FacePlace {
    face: u32,
    /// By corner of the model's face.
    corners: [Vec2; 4],
}

impl DrawnPlaces {
    pub fn new(canvas: &CanvasMesh) -> Self {
        let mut primitives: BTreeMap<_, Vec<Option<FacePlace>>> = BTreeMap::new();
        for (number, face) in (0u32..).zip(&canvas.faces) {
            for (drawn, own) in face.drawn.iter().zip(face.drawn_corners()) {
                let faces = primitives.entry([face.mesh as usize, drawn.primitive as usize]).or_default();
                let at = drawn.face as usize;
                if faces.len() <= at {
                    faces.resize(at + 1, None);
                }
                let place = faces[at].get_or_insert(FacePlace { face: number, corners: [Vec2::ZERO; 4] });
                for (&of_model, &of_canvas) in drawn.corners.iter().zip(own) {
                    place.corners[usize::from(of_model)] = unit_corner(face.is_triangle(), of_canvas);
                }
            }
        }
        Self(primitives)
    }

    /// See [`super::PaintedSource::place`].
    pub fn of(&self, [mesh, primitive, face]: [usize; 3], corners: [usize; 3]) -> Option<DrawnPlace> {
        let place = (*self.0.get(&[mesh, primitive])?.get(face)?)?;
        let [a, b, c] = corners.map(|corner| place.corners.get(corner).copied());
        Some(DrawnPlace { face: place.face, corners: [a?, b?, c?] })
    }
}

/// A corner of a face in its unit domain.
fn unit_corner(is_triangle: bool, corner: usize) -> Vec2 {
    match (corner, is_triangle) {
        (0, _) => Vec2::ZERO,
        (1, _) => Vec2::X,
        (2, false) => Vec2::ONE,
        _ => Vec2::Y,
    }
}

#[cfg(test)]
mod tests;
