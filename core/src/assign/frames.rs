//! The tangent frames that converted normal maps refer to.
//!
//! The source's tangents belong to the texture coordinates that go away, so the tangent is ours to choose:
//! a coordinate axis far from the face's normals, made orthogonal to each corner's normal. Neighbors with
//! one normal and one axis then have one frame and store the same values along their edge, so that they can stand in
//! one block. Faces that show what others show too have the source's tangents, by which they store the same as those.

use glam::{Mat3, Vec3, Vec4};

use crate::math::frame::Frame;
use crate::mesh::{CanvasMesh, drawn_corners, surface_point};

#[derive(Clone, Debug)]
pub struct NormalFrames {
    /// By face and corner.
    pub corners: Vec<[Frame; 4]>,
    /// The material's normal scale, which stored x and y are divided by.
    pub scale: f32,
}

/// Frames from corner normals (unit length). `given`: by face, frames that it is to have, orthonormal and all four of
/// one handedness.
pub fn choose_frames(
    canvas: &CanvasMesh,
    normals: &[[Vec3; 4]],
    given: &[Option<[Frame; 4]>],
    scale: f32,
) -> NormalFrames {
    let corners = canvas.faces.iter().zip(normals).zip(given).map(|((face, normals), given)| {
        if let Some(given) = given {
            return *given;
        }
        let axis = axis_across(normals[..face.count()].iter().sum());
        normals.map(|normal| Frame { normal, tangent: tangent(normal, axis).extend(1.0) })
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
    pub at: [f32; 2],
    pub step: [f32; 2],
}

/// Normal and tangent, not yet of unit length, along a line over one drawn triangle of a face: at its first
/// point, and the change to the next.
struct FrameRun {
    normal: [Vec3; 2],
    tangent: [Vec3; 2],
    handedness: f32,
}

impl FrameRun {
    /// `corners`: the one at `(0, 0)`, and the pairs (from, to) whose differences are the changes along s and t.
    fn new(frames: &[Frame; 4], corners: (usize, [usize; 2], [usize; 2]), line: &FrameLine) -> Self {
        let (zero, along_s, along_t) = corners;
        let run = |of: fn(&Frame) -> Vec3| {
            let change = |[from, to]: [usize; 2]| of(&frames[to]) - of(&frames[from]);
            let (by_s, by_t) = (change(along_s), change(along_t));
            let first = of(&frames[zero]) + by_s * line.at[0] + by_t * line.at[1];
            [first, by_s * line.step[0] + by_t * line.step[1]]
        };
        Self {
            normal: run(|frame| frame.normal),
            tangent: run(|frame| frame.tangent.truncate()),
            handedness: frames[0].tangent.w,
        }
    }

    /// A vector's components along tangent, bitangent and normal at a point of the line; `None` where the frame is
    /// degenerate.
    ///
    /// With `N` and `T` as they are interpolated and `B = N × T` the right-handed frame of [`Frame::blend`] is
    /// `N / |N|`, `(T |N|² - N (N · T)) / (|N| |B|)` and `B / |B|`: two square roots.
    #[inline]
    fn local(&self, number: f32, value: Vec3) -> Option<Vec3> {
        let normal = self.normal[0] + self.normal[1] * number;
        let tangent = self.tangent[0] + self.tangent[1] * number;
        let across = normal.cross(tangent);
        let (squared, across_squared) = (normal.length_squared(), across.length_squared());
        if !(squared > DEGENERATE && across_squared > DEGENERATE * squared) {
            return None;
        }
        let (per_normal, per_across) = (squared.sqrt().recip(), across_squared.sqrt().recip());
        let up = normal.dot(value);
        let along = (tangent.dot(value) * squared - up * normal.dot(tangent)) * per_normal * per_across;
        Some(Vec3::new(along, across.dot(value) * per_across * self.handedness, up * per_normal))
    }
}

/// Squared lengths (of vectors of length 1 at the corners) under which a frame is worked out with care.
const DEGENERATE: f32 = 1e-8;

impl NormalFrames {
    /// Object-space normals at the points of a line to what the face stores there, as [`Self::to_stored`]
    /// does it for one point, in 32 bits.
    pub(super) fn store(
        &self,
        canvas: &CanvasMesh,
        line: &FrameLine,
        normals: &[Vec4],
        stored: &mut Vec<Vec4>,
    ) {
        let frames = &self.corners[line.face];
        let count = canvas.faces[line.face].count();
        let place = |number: usize| {
            let at = |k: usize| line.at[k] + line.step[k] * number as f32;
            (at(0), at(1))
        };
        // The triangles that `surface_point` names: a quad is drawn over the diagonal s = t.
        let is_upper = |number: usize| count == 4 && place(number).1 > place(number).0;
        let [across, along] = self.factors();
        let factors = Vec3::new(across, across, along);
        stored.clear();
        while stored.len() < normals.len() {
            let first = stored.len();
            let upper = is_upper(first);
            let same = (first..normals.len()).take_while(|&number| is_upper(number) == upper).count();
            let corners = match (count, upper) {
                (3, _) => (0, [0, 1], [0, 2]),
                (_, false) => (0, [0, 1], [1, 2]),
                (_, true) => (0, [3, 2], [0, 3]),
            };
            let run = FrameRun::new(frames, corners, line);
            stored.extend(normals[first..first + same].iter().zip(first..).map(|(value, number)| {
                let value = value.truncate();
                let local = run.local(number as f32, value).map(|local| local * factors);
                let local = local.unwrap_or_else(|| {
                    let (s, t) = place(number);
                    self.to_stored(canvas, line.face, s, t) * value
                });
                (local + 0.5).extend(1.0)
            }));
        }
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
        let (triangle, weights) = surface_point(canvas.faces[face].count(), s, t);
        let frames = &self.corners[face];
        let frame = Frame::blend(drawn_corners(triangle).map(|corner| &frames[corner]), weights);
        let [across, along] = self.factors();
        Mat3::from_diagonal(Vec3::new(across, across, along)) * frame.transpose()
    }
}
