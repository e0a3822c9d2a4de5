//! Where the pictures are taken from. View space has the camera at the origin, looking along -z, and is
//! scaled so that what it frames is about one unit large: f32 is enough there for any model.

use glam::{DAffine3, DMat3, DMat4, DVec3, Mat4};

/// A camera: world (or mesh) space to view space, and view space to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    pub to_view: DAffine3,
    pub projection: Mat4,
}

/// Half the vertical angle of view.
const HALF_ANGLE: f64 = 13.0 * std::f64::consts::PI / 180.0;
/// Share of the picture that the framed thing fills.
const FILL: f64 = 0.9;

/// The directions of a three-quarter view from the front (glTF's front is +z), to the right or the left.
pub fn three_quarter(right: bool) -> DMat3 {
    let yaw = if right { 32.0_f64 } else { -32.0 }.to_radians();
    let pitch = 16.0_f64.to_radians();
    let toward_eye = DVec3::new(yaw.sin() * pitch.cos(), pitch.sin(), yaw.cos() * pitch.cos());
    basis(toward_eye, DVec3::Y)
}

/// Rows: right, up, toward the eye.
fn basis(toward_eye: DVec3, up: DVec3) -> DMat3 {
    let right = up.cross(toward_eye).try_normalize().unwrap_or_else(|| toward_eye.any_orthonormal_vector());
    let up = toward_eye.cross(right);
    DMat3::from_cols(right, up, toward_eye).transpose()
}

/// Calls its argument with every point that a picture frames.
pub type EachPoint<'a> = &'a dyn Fn(&mut dyn FnMut(DVec3));

/// The box around the points, seen along `turn`: low and high corner; `None` without points.
pub fn extent(turn: DMat3, each_point: EachPoint<'_>) -> Option<[DVec3; 2]> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    each_point(&mut |point| {
        low = low.min(turn * point);
        high = high.max(turn * point);
    });
    (low.x <= high.x).then_some([low, high])
}

/// The nearest perspective camera that sees every point, for a picture of `aspect` (width over height).
pub fn fit(turn: DMat3, each_point: EachPoint<'_>, aspect: f64) -> Camera {
    let Some([low, high]) = extent(turn, each_point) else {
        return Camera { to_view: DAffine3::IDENTITY, projection: Mat4::IDENTITY };
    };
    let middle = (low + high) / 2.0;
    let slope_y = HALF_ANGLE.tan() * FILL;
    let slope_x = slope_y * aspect;
    // The four sides of the view pyramid, each moved out until it holds every point.
    let mut sides = [f64::NEG_INFINITY; 4];
    each_point(&mut |point| {
        let p = turn * point - middle;
        let reach = [p.x + p.z * slope_x, -p.x + p.z * slope_x, p.y + p.z * slope_y, -p.y + p.z * slope_y];
        sides = std::array::from_fn(|side| sides[side].max(reach[side]));
    });
    let [right, left, above, below] = sides;
    let half_depth = (high.z - low.z) / 2.0;
    let size = ((high - low) / 2.0).max_element().max(middle.abs().max_element() * 1e-9).max(1e-30);
    let distance = ((right + left) / (2.0 * slope_x))
        .max((above + below) / (2.0 * slope_y))
        .max(half_depth + size * 0.05);
    let eye = middle + DVec3::new((right - left) / 2.0, (above - below) / 2.0, distance);
    let scale = 1.0 / size;
    let near = (distance - half_depth) * scale * 0.9;
    let far = (distance + half_depth) * scale * 1.1;
    let projection = DMat4::perspective_rh(2.0 * HALF_ANGLE, aspect, near, far);
    Camera {
        to_view: DAffine3::from_mat3_translation(turn * scale, -eye * scale),
        projection: projection.as_mat4(),
    }
}

/// A look straight at a surface, without perspective. The frame is 2 units high in view space.
#[derive(Clone, Copy, Debug)]
pub struct CloseUp {
    pub position: DVec3,
    pub normal: DVec3,
    /// Runs upwards in the picture.
    pub seam: DVec3,
    pub half_height: f64,
    pub aspect: f64,
}

/// What of the scene a close-up shows in depth, in half heights before and behind the surface: enough for
/// curved surfaces, and nothing that hangs before them.
const DEPTH: [f64; 2] = [1.5, 6.0];

impl CloseUp {
    pub fn camera(&self) -> Camera {
        let normal = self.normal.try_normalize().unwrap_or(DVec3::Z);
        let turn = basis(normal, self.seam);
        let scale = 1.0 / self.half_height;
        let to_view = DAffine3::from_mat3_translation(turn * scale, -(turn * self.position) * scale);
        let projection = DMat4::orthographic_rh(-self.aspect, self.aspect, -1.0, 1.0, -DEPTH[0], DEPTH[1]);
        Camera { to_view, projection: projection.as_mat4() }
    }

    /// The box in view space that the picture shows.
    pub fn keep(&self) -> [DVec3; 2] {
        [DVec3::new(-self.aspect, -1.0, -DEPTH[1]), DVec3::new(self.aspect, 1.0, DEPTH[0])]
    }
}
