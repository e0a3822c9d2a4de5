//! The tangent frames that converted normal maps refer to.
//!
//! The source's tangents belong to the texture coordinates that go away, so the tangent is ours to choose:
//! a coordinate axis far from the face's normals, made orthogonal to each corner's normal. Neighbors with
//! one normal and one axis then have one frame, so that most edges store the same values on both sides.

use glam::{Mat3, Vec3};

use crate::math::frame::Frame;
use crate::mesh::{CanvasMesh, surface_point};

#[derive(Clone, Debug)]
pub struct NormalFrames {
    /// By face and corner.
    pub corners: Vec<[Frame; 4]>,
    /// The material's normal scale, which stored x and y are divided by.
    pub scale: f32,
}

/// Frames from corner normals (unit length). Faces in one merged pair (`partner`) use one axis.
pub fn choose_frames(
    canvas: &CanvasMesh,
    normals: &[[Vec3; 4]],
    partner: impl Fn(usize) -> Option<usize>,
    scale: f32,
) -> NormalFrames {
    let sum = |face: usize| normals[face][..canvas.faces[face].count()].iter().sum::<Vec3>();
    let corners = (0..canvas.faces.len()).map(|face| {
        let mean = sum(face) + partner(face).map_or(Vec3::ZERO, sum);
        let axis = axis_across(mean);
        normals[face].map(|normal| Frame { normal, tangent: tangent(normal, axis).extend(1.0) })
    });
    NormalFrames { corners: corners.collect(), scale }
}

/// The coordinate axis that is most nearly at right angles.
fn axis_across(normal: Vec3) -> Vec3 {
    let size = normal.abs();
    if size.x <= size.y && size.x <= size.z {
        Vec3::X
    } else if size.y <= size.z {
        Vec3::Y
    } else {
        Vec3::Z
    }
}

fn tangent(normal: Vec3, axis: Vec3) -> Vec3 {
    let across = axis - normal * normal.dot(axis);
    across.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector())
}

impl NormalFrames {
    /// The linear map from an object-space normal to the stored value less 1/2, at a point of a face.
    /// A scale below 1 shortens the stored vector, since x and y would leave the range; a viewer normalizes.
    pub fn to_stored(&self, canvas: &CanvasMesh, face: usize, s: f32, t: f32) -> Mat3 {
        let (corners, weights) = surface_point(canvas.faces[face].count(), s, t);
        let frames = &self.corners[face];
        let frame = Frame::blend(corners.map(|corner| &frames[corner]), weights);
        let scale = if self.scale.abs() < 1e-3 { 1.0 } else { self.scale };
        let flat = scale.abs().min(1.0);
        Mat3::from_diagonal(Vec3::new(flat / scale, flat / scale, flat) * 0.5) * frame.transpose()
    }
}
