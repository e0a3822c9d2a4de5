//! The tangent frames that converted normal maps refer to.
//!
//! The source's tangents belong to the texture coordinates that go away, so the tangent is ours to choose:
//! a coordinate axis far from the face's normals, made orthogonal to each corner's normal. Neighbors with
//! one normal and one axis then have one frame, so that most edges store the same values on both sides.

use glam::{Mat3, Vec3, Vec4};

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

/// Points of a face in a row: `(s, t)` of the first one, and the step to the next.
pub(super) struct FrameLine {
    pub face: usize,
    pub is_triangle: bool,
    pub at: [f32; 2],
    pub step: [f32; 2],
}

/// Normal and tangent over one drawn triangle of a face: at `(0, 0)`, and their changes along s and t.
struct FramePlane {
    normal: [Vec3; 3],
    tangent: [Vec3; 3],
}

impl FramePlane {
    /// `corners`: at `(0, 0)`, and the two pairs (from, to) whose differences are the changes.
    fn new(frames: &[Frame; 4], at: usize, along_s: [usize; 2], along_t: [usize; 2]) -> Self {
        let plane = |of: fn(&Frame) -> Vec3| {
            let change = |[from, to]: [usize; 2]| of(&frames[to]) - of(&frames[from]);
            [of(&frames[at]), change(along_s), change(along_t)]
        };
        Self { normal: plane(|frame| frame.normal), tangent: plane(|frame| frame.tangent.truncate()) }
    }

    /// Normal, tangent and the bitangent of a right-handed frame, all of unit length, as [`Frame::blend`]
    /// gives them.
    #[inline]
    fn frame(&self, s: f32, t: f32) -> [Vec3; 3] {
        let at = |[at, along_s, along_t]: &[Vec3; 3]| *at + *along_s * s + *along_t * t;
        let normal = at(&self.normal).try_normalize().unwrap_or(self.normal[0]);
        let tangent = at(&self.tangent);
        let across = tangent - normal * normal.dot(tangent);
        let tangent = across.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        [normal, tangent, normal.cross(tangent)]
    }
}

impl NormalFrames {
    /// Object-space normals at the points of a line to what the face stores there, as [`Self::to_stored`]
    /// does it for one point, in 32 bits.
    pub(super) fn store(&self, line: &FrameLine, normals: &[Vec4], stored: &mut Vec<Vec4>) {
        let frames = &self.corners[line.face];
        // The triangles that `surface_point` names: a quad is drawn over the diagonal s = t.
        let planes = if line.is_triangle {
            [(); 2].map(|()| FramePlane::new(frames, 0, [0, 1], [0, 2]))
        } else {
            [FramePlane::new(frames, 0, [0, 1], [1, 2]), FramePlane::new(frames, 0, [3, 2], [0, 3])]
        };
        let [across, along] = self.factors();
        let bitangent_factor = across * frames[0].tangent.w;
        let ([s, t], [ds, dt]) = (line.at, line.step);
        stored.clear();
        stored.extend(normals.iter().enumerate().map(|(number, value)| {
            let (s, t) = (s + ds * number as f32, t + dt * number as f32);
            let [normal, tangent, bitangent] = planes[usize::from(t > s)].frame(s, t);
            let value = value.truncate();
            let local = Vec3::new(
                tangent.dot(value) * across,
                bitangent.dot(value) * bitangent_factor,
                normal.dot(value) * along,
            );
            (local + 0.5).extend(1.0)
        }));
    }

    /// What the stored x and y, and z, are shorter by than the normal. A scale below 1 shortens the stored
    /// vector, since x and y would leave the range; a viewer normalizes.
    fn factors(&self) -> [f32; 2] {
        let scale = if self.scale.abs() < 1e-3 { 1.0 } else { self.scale };
        let flat = scale.abs().min(1.0);
        [0.5 * flat / scale, 0.5 * flat]
    }

    /// The linear map from an object-space normal to the stored value less 1/2, at a point of a face.
    pub fn to_stored(&self, canvas: &CanvasMesh, face: usize, s: f32, t: f32) -> Mat3 {
        let (corners, weights) = surface_point(canvas.faces[face].count(), s, t);
        let frames = &self.corners[face];
        let frame = Frame::blend(corners.map(|corner| &frames[corner]), weights);
        let [across, along] = self.factors();
        Mat3::from_diagonal(Vec3::new(across, across, along)) * frame.transpose()
    }
}
