//! What two sides of an edge, or two versions of a point, differ by: decoded and filtered as a GPU does
//! it, then compared in codes, or in degrees between object-space normals.

use glam::{Vec2, Vec3};

use super::coarse_weights::Weights;
use super::figures::{self, SAMPLES};
use super::report::Unit;
use super::texels::{Texels, encode_codes, stored_components};
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
    let tangent = (tangent - normal * normal.dot(tangent)).normalize_or(normal.any_orthonormal_vector());
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
    pub fn jumps(&self, a: &Track, b: &Track) -> [f32; SAMPLES] {
        if a == b {
            // The same texels with the same weights: nothing to fetch.
            return [0.0; SAMPLES];
        }
        std::array::from_fn(|sample| {
            let t = figures::position(sample);
            let [left, right] = [a, b].map(|side| self.texels.bilinear(self.weights.place(side.at(t))));
            match (self.meaning, &a.frames, &b.frames) {
                (Meaning::Normal { scale }, Some(of_a), Some(of_b)) => degrees_between(
                    object_normal(left, scale, &mixed_frame(&of_a[0], &of_a[1], t)),
                    object_normal(right, scale, &mixed_frame(&of_b[0], &of_b[1], t)),
                ),
                _ => self.difference_codes(left, right),
            }
        })
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
