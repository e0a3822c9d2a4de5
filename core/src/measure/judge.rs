//! What two sides of an edge, or two versions of a point, differ by: decoded and filtered as a GPU does
//! it, then compared in codes, or in degrees between object-space normals.

use glam::{Vec2, Vec3, Vec4};

use super::coarse_weights::Weights;
use super::figures::{self, SAMPLES};
use super::report::Unit;
use super::texels::{Texels, cell_of, encode_codes, mixed, stored_components};
use crate::finished::Frame;
use crate::image::Transfer;

/// What the texels of a channel stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meaning {
    Color,
    Data,
    /// Tangent-space normals with the material's scale.
    Normal {
        scale: f32,
    },
}

impl Meaning {
    pub fn transfer(self) -> Transfer {
        if self == Meaning::Color { Transfer::Srgb } else { Transfer::Linear }
    }

    pub fn unit(self) -> Unit {
        if matches!(self, Meaning::Normal { .. }) { Unit::Degrees } else { Unit::Codes }
    }

    /// A filtered texel in codes; not for normals, which need a frame.
    pub fn codes(self, texel: [f32; 4]) -> [f32; 4] {
        let [red, green, blue, alpha] = texel;
        if self == Meaning::Color {
            [encode_codes(red), encode_codes(green), encode_codes(blue), alpha * 255.0]
        } else {
            texel.map(|value| value * 255.0)
        }
    }
}

/// The object-space normal of a filtered texel, unit length, in an interpolated frame.
pub fn object_normal(texel: [f32; 4], scale: f32, frame: &Frame) -> Vec3 {
    let [x, y, z, _] = texel.map(|value| 2.0 * value - 1.0);
    let normal = frame.normal.normalize_or(Vec3::Z);
    let tangent = frame.tangent.truncate();
    let tangent = (tangent - normal * normal.dot(tangent))
        .try_normalize()
        .unwrap_or_else(|| normal.any_orthonormal_vector());
    let bitangent = normal.cross(tangent) * if frame.tangent.w < 0.0 { -1.0 } else { 1.0 };
    (tangent * (x * scale) + bitangent * (y * scale) + normal * z).normalize_or(normal)
}

/// The angle between unit vectors, exact for small ones too.
pub fn degrees_between(a: Vec3, b: Vec3) -> f32 {
    2.0 * (0.5 * a.distance(b)).min(1.0).asin().to_degrees()
}

pub fn mixed_frame(a: &Frame, b: &Frame, t: f32) -> Frame {
    Frame { normal: a.normal.lerp(b.normal, t), tangent: a.tangent.lerp(b.tangent, t) }
}

/// The frame at barycentrics of a triangle.
pub fn interpolated(frames: &[Frame; 3], at: Vec3) -> Frame {
    let [a, b, c] = frames;
    Frame {
        normal: a.normal * at.x + b.normal * at.y + c.normal * at.z,
        tangent: a.tangent * at.x + b.tangent * at.y + c.tangent * at.z,
    }
}

/// One side of an edge: where its points stand in an image, `(from + (to - from) t) · scale + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    pub from: Vec2,
    pub to: Vec2,
    pub scale: Vec2,
    pub shift: Vec2,
    /// At both ends, for normals.
    pub frames: Option<[Frame; 2]>,
}

impl Track {
    fn at(&self, t: f32) -> Vec2 {
        // The far end exactly: no rounding of the step to it.
        let here = if t == 1.0 { self.to } else { self.from + (self.to - self.from) * t };
        here * self.scale + self.shift
    }

    /// The texels that the side reads, as the first one, the step and their count: where both ends are
    /// texel centers of one row or column.
    fn run(&self) -> Option<([i32; 2], [i32; 2], i32)> {
        let ([from, to], parts): ([[i32; 2]; 2], Vec2) = {
            let ((from, part_from), (to, part_to)) = (cell_of(self.at(0.0)), cell_of(self.at(1.0)));
            ([from, to], part_from.max(part_to))
        };
        let [right, down] = [i64::from(to[0]) - i64::from(from[0]), i64::from(to[1]) - i64::from(from[1])];
        let is_straight = parts == Vec2::ZERO && (right == 0) != (down == 0);
        let count = i32::try_from(right.abs().max(down.abs()) + 1).ok()?;
        is_straight.then(|| (from, [right.signum() as i32, down.signum() as i32], count))
    }
}

/// One level image of a channel.
pub struct Judge<'a> {
    pub texels: Texels<'a>,
    pub meaning: Meaning,
    /// How many components the image stores.
    pub components: u8,
    pub weights: Weights,
}

impl Judge<'_> {
    /// The difference of two sides at each sample of an edge, largest over the components.
    /// `None` stands for no difference at any of them.
    pub fn jumps(&self, a: &Track, b: &Track) -> Option<[f32; SAMPLES]> {
        if a == b || self.is_one_row(a, b) {
            return None;
        }
        let (left, right) = (self.along(a), self.along(b));
        let mut jumps = [0.0; SAMPLES];
        if let (Meaning::Normal { scale }, Some(of_a), Some(of_b)) = (self.meaning, &a.frames, &b.frames) {
            for (sample, jump) in jumps.iter_mut().enumerate() {
                let t = figures::position(sample);
                let frames = (mixed_frame(&of_a[0], &of_a[1], t), mixed_frame(&of_b[0], &of_b[1], t));
                let (left, right) = (left[sample].to_array(), right[sample].to_array());
                if left != right || frames.0 != frames.1 {
                    let normals =
                        (object_normal(left, scale, &frames.0), object_normal(right, scale, &frames.1));
                    *jump = degrees_between(normals.0, normals.1);
                }
            }
        } else {
            for ((left, right), jump) in left.iter().zip(&right).zip(&mut jumps) {
                *jump = self.difference_codes(left.to_array(), right.to_array());
            }
        }
        Some(jumps)
    }

    /// The filtered values at the samples of one side; the texels of a cell are decoded once.
    fn along(&self, track: &Track) -> [Vec4; SAMPLES] {
        let mut values = [Vec4::ZERO; SAMPLES];
        let (mut known, part) = cell_of(self.weights.place(track.at(0.0)));
        let mut corners = self.texels.corners(known);
        values[0] = mixed(&corners, part);
        for (sample, value) in values.iter_mut().enumerate().skip(1) {
            let (cell, part) = cell_of(self.weights.place(track.at(figures::position(sample))));
            if cell != known {
                known = cell;
                corners = self.texels.corners(cell);
            }
            *value = mixed(&corners, part);
        }
        values
    }

    /// Whether both sides run from texel center to texel center along rows or columns that hold the same
    /// codes: filtering reads nothing else there, with the same weights on both sides.
    fn is_one_row(&self, a: &Track, b: &Track) -> bool {
        match (a.run(), b.run()) {
            (Some((from_a, step_a, count_a)), Some((from_b, step_b, count_b))) => {
                a.frames == b.frames
                    && count_a == count_b
                    && self.texels.equal_runs((from_a, step_a), (from_b, step_b), count_a)
            }
            _ => false,
        }
    }

    fn difference_codes(&self, left: [f32; 4], right: [f32; 4]) -> f32 {
        if left == right {
            return 0.0;
        }
        let (left, right) = (self.meaning.codes(left), self.meaning.codes(right));
        stored_components(self.components).iter().map(|&i| (left[i] - right[i]).abs()).fold(0.0, f32::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    const UPRIGHT: Frame = Frame { normal: Vec3::Z, tangent: Vec4::new(1.0, 0.0, 0.0, 1.0) };

    #[test]
    fn the_frame_turns_the_stored_normal() {
        assert_eq!(object_normal([0.5, 0.5, 1.0, 1.0], 1.0, &UPRIGHT), Vec3::Z);
        assert!(object_normal([0.5, 1.0, 0.5, 1.0], 1.0, &UPRIGHT).distance(Vec3::Y) < 1e-6);
        let mirrored = Frame { tangent: Vec4::new(1.0, 0.0, 0.0, -1.0), ..UPRIGHT };
        assert!(object_normal([0.5, 1.0, 0.5, 1.0], 1.0, &mirrored).distance(-Vec3::Y) < 1e-6);
        let slope = object_normal([1.0, 0.5, 1.0, 1.0], 0.5, &UPRIGHT);
        assert!((slope.x / slope.z - 0.5).abs() < 1e-6);
    }

    #[test]
    fn lost_normals_are_the_surface() {
        assert_eq!(object_normal([0.5, 0.5, 0.5, 1.0], 1.0, &UPRIGHT), Vec3::Z);
        let lost = Frame { normal: Vec3::ZERO, tangent: Vec4::ZERO };
        assert!(object_normal([0.2, 0.7, 0.9, 1.0], 1.0, &lost).is_normalized());
    }

    #[test]
    fn small_angles_are_exact() {
        for degrees in [0.0f32, 0.001, 0.5, 90.0, 179.0] {
            let turned = Vec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
            assert!((degrees_between(Vec3::X, turned) - degrees).abs() < 1e-4 * degrees.max(1.0));
        }
    }
}
