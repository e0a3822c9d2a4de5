//! Triangles to pixels the way a GPU does it: positions snapped to 1/256 pixel, the top-left rule, four
//! samples a pixel, one shading for each triangle and pixel at the centroid.

use glam::{DVec2, DVec3, Mat4, Vec3};

/// Sample positions inside a pixel: the standard pattern for four.
pub const SAMPLES: [DVec2; 4] =
    [DVec2::new(0.375, 0.125), DVec2::new(0.875, 0.375), DVec2::new(0.125, 0.625), DVec2::new(0.625, 0.875)];

/// A function of the picture that is linear in pixels: `at.x * x + at.y * y + constant`.
#[derive(Clone, Copy, Debug)]
struct Plane {
    slope: DVec2,
    constant: f64,
}

impl Plane {
    fn at(&self, pixel: DVec2) -> f64 {
        self.slope.dot(pixel) + self.constant
    }
}

/// A triangle set up for drawing.
#[derive(Clone, Debug)]
pub struct Triangle {
    /// The weight of each corner on the picture, times the double area: positive inside.
    edges: [Plane; 3],
    /// Whether points exactly on the edge opposite of each corner belong to the triangle.
    owns_edge: [bool; 3],
    double_area: f64,
    /// 1/w at the corners.
    inverse_w: [f64; 3],
    depth: Plane,
    /// Corners in the order of `edges`, as numbers 0 to 2 of the record.
    pub corners: [usize; 3],
    pub is_front: bool,
    /// First and last pixel, inclusive.
    pub columns: [u32; 2],
    pub rows: [u32; 2],
}

/// Perspective-correct weights of the corners at a point, and how they change from pixel to pixel.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    pub at: Vec3,
    pub dx: Vec3,
    pub dy: Vec3,
}

impl Triangle {
    /// `None` for what cannot be seen: off the picture, without area, or behind the camera.
    pub fn new(positions: [Vec3; 3], projection: &Mat4, size: [u32; 2]) -> Option<Self> {
        let clip = positions.map(|position| (*projection * position.extend(1.0)).as_dvec4());
        if clip.iter().any(|c| c.w <= 1e-9 || !c.is_finite()) {
            return None;
        }
        let picture = DVec2::new(f64::from(size[0]), f64::from(size[1]));
        let screen = clip.map(|c| {
            let unit = DVec2::new(0.5 + 0.5 * c.x / c.w, 0.5 - 0.5 * c.y / c.w);
            (unit * picture * 256.0).round() / 256.0
        });
        let double_area = (screen[1] - screen[0]).perp_dot(screen[2] - screen[0]);
        // The picture's y runs down, so counterclockwise fronts have a negative area there.
        let is_front = double_area < 0.0;
        let corners = if is_front { [0, 2, 1] } else { [0, 1, 2] };
        let screen = corners.map(|corner| screen[corner]);
        let double_area = double_area.abs();
        let low = screen[0].min(screen[1]).min(screen[2]).max(DVec2::ZERO);
        let high = screen[0].max(screen[1]).max(screen[2]).min(picture);
        if !(double_area > 0.0 && low.x < high.x && low.y < high.y) {
            return None;
        }
        let edges = std::array::from_fn(|k| edge(screen[(k + 1) % 3], screen[(k + 2) % 3]));
        let owns_edge = std::array::from_fn(|k| {
            let along = screen[(k + 2) % 3] - screen[(k + 1) % 3];
            along.y < 0.0 || (along.y == 0.0 && along.x > 0.0)
        });
        let depths = corners.map(|corner| clip[corner].z / clip[corner].w);
        let blend = |values: [f64; 3]| Plane {
            slope: (0..3).map(|k| edges[k].slope * (values[k] / double_area)).sum(),
            constant: (0..3).map(|k| edges[k].constant * (values[k] / double_area)).sum(),
        };
        Some(Self {
            depth: blend(depths),
            edges,
            owns_edge,
            double_area,
            inverse_w: corners.map(|corner| 1.0 / clip[corner].w),
            corners,
            is_front,
            columns: [low.x as u32, (high.x as u32).min(size[0] - 1)],
            rows: [low.y as u32, (high.y as u32).min(size[1] - 1)],
        })
    }

    pub fn covers(&self, point: DVec2) -> bool {
        self.edges.iter().zip(self.owns_edge).all(|(edge, owned)| {
            let value = edge.at(point);
            value > 0.0 || (value == 0.0 && owned)
        })
    }

    /// Depth at a point of the picture, 0 near to 1 far inside the view.
    pub fn depth(&self, point: DVec2) -> f32 {
        self.depth.at(point) as f32
    }

    /// Weights in the order of the record's corners.
    pub fn weights(&self, point: DVec2) -> Weights {
        let share = |k: usize| self.inverse_w[k] / self.double_area;
        let q = DVec3::from_array(std::array::from_fn(|k| self.edges[k].at(point) * share(k)));
        let q_dx = DVec3::from_array(std::array::from_fn(|k| self.edges[k].slope.x * share(k)));
        let q_dy = DVec3::from_array(std::array::from_fn(|k| self.edges[k].slope.y * share(k)));
        let sum = q.element_sum();
        let at = q / sum;
        let dx = (q_dx - at * q_dx.element_sum()) / sum;
        let dy = (q_dy - at * q_dy.element_sum()) / sum;
        Weights { at: self.reorder(at), dx: self.reorder(dx), dy: self.reorder(dy) }
    }

    fn reorder(&self, weights: DVec3) -> Vec3 {
        let mut out = [0.0; 3];
        for (k, corner) in self.corners.into_iter().enumerate() {
            out[corner] = weights[k] as f32;
        }
        Vec3::from_array(out)
    }
}

/// Positive to the right of the way from `a` to `b` as the picture is seen (its y runs down).
fn edge(a: DVec2, b: DVec2) -> Plane {
    let along = b - a;
    let slope = DVec2::new(-along.y, along.x);
    Plane { slope, constant: -slope.dot(a) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_of_a_square_share_every_sample_once() {
        let corners =
            [(-0.63, -0.71), (0.82, -0.6), (0.77, 0.9), (-0.8, 0.68)].map(|(x, y)| Vec3::new(x, y, 0.5));
        let pieces = [[0, 1, 2], [0, 2, 3]].map(|piece| {
            Triangle::new(piece.map(|c| corners[c]), &Mat4::IDENTITY, [32, 32]).expect("it is in view")
        });
        let whole = |point: DVec2| {
            let at = DVec2::new(point.x / 16.0 - 1.0, 1.0 - point.y / 16.0);
            (0..4).all(|k| {
                let [a, b] = [corners[k], corners[(k + 1) % 4]].map(|c| c.truncate().as_dvec2());
                (b - a).perp_dot(at - a) > 0.02
            })
        };
        for y in 0..32 {
            for x in 0..32 {
                for sample in SAMPLES {
                    let point = DVec2::new(f64::from(x), f64::from(y)) + sample;
                    let count = pieces.iter().filter(|piece| piece.covers(point)).count();
                    assert!(count <= 1, "({x}, {y}) is drawn {count} times");
                    assert!(count == 1 || !whole(point), "({x}, {y}) is left out");
                }
            }
        }
    }

    #[test]
    fn weights_are_perspective_correct() {
        let projection = Mat4::perspective_rh(1.0, 1.0, 0.1, 100.0);
        let positions = [Vec3::new(-1.0, -1.0, -2.0), Vec3::new(3.0, -1.0, -6.0), Vec3::new(0.0, 2.0, -4.0)];
        let triangle = Triangle::new(positions, &projection, [256, 256]).expect("it is in view");
        let middle = (positions[0] + positions[1] + positions[2]) / 3.0;
        let clip = projection * middle.extend(1.0);
        let point = DVec2::new(
            f64::from(128.0 + 128.0 * clip.x / clip.w),
            f64::from(128.0 - 128.0 * clip.y / clip.w),
        );
        let weights = triangle.weights(point);
        assert!((weights.at - 1.0 / 3.0).abs().max_element() < 0.01, "{weights:?}");
        let step = triangle.weights(point + DVec2::X).at - weights.at;
        assert!((step - weights.dx).abs().max_element() < 1e-3);
    }
}
