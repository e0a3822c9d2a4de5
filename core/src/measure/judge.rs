//! What two sides of an edge, or two versions of a point, differ by: decoded and filtered as a GPU does
//! it, then compared in codes, or in degrees between object-space normals.

use glam::{Vec2, Vec3, Vec4};

use super::coarse_weights::Weights;
use super::figures::{self, FEW_LIMIT, FEW_POSITIONS, Jumps, SAMPLES};
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
    let [right, up, out] = axes(frame);
    let [x, y, z] = decoded_normal(Vec4::from(texel), scale).to_array();
    (right * x + up * y + out * z).normalize_or(out)
}

/// Of a filtered texel, what it adds to the surface's own normal, in the axes of its frame.
pub fn tilt(texel: Vec4, scale: f32) -> Vec3 {
    decoded_normal(texel, scale).normalize_or(Vec3::Z) - Vec3::Z
}

fn decoded_normal(texel: Vec4, scale: f32) -> Vec3 {
    (texel.truncate() * 2.0 - 1.0) * Vec3::new(scale, scale, 1.0)
}

/// The right-angled axes of an interpolated frame: tangent, bitangent, normal; unit length.
pub fn axes(frame: &Frame) -> [Vec3; 3] {
    let normal = frame.normal.normalize_or(Vec3::Z);
    let tangent = frame.tangent.truncate();
    let tangent = (tangent - normal * normal.dot(tangent))
        .try_normalize()
        .unwrap_or_else(|| normal.any_orthonormal_vector());
    let bitangent = normal.cross(tangent) * if frame.tangent.w < 0.0 { -1.0 } else { 1.0 };
    [tangent, bitangent, normal]
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

/// One side of an edge: the image that it reads, and where its points stand there, `(from + (to - from) t) · scale +
/// shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    /// Which of [`Judge::images`].
    pub image: usize,
    pub from: Vec2,
    pub to: Vec2,
    pub scale: Vec2,
    pub shift: Vec2,
    /// At both ends, for normals.
    pub frames: Option<[Frame; 2]>,
    /// At both ends, what multiplies the image.
    pub tints: Option<[Vec4; 2]>,
}

impl Track {
    fn at(&self, t: f32) -> Vec2 {
        // The far end exactly: no rounding of the step to it.
        let here = if t == 1.0 { self.to } else { self.from + (self.to - self.from) * t };
        here * self.scale + self.shift
    }

    fn tinted(&self, value: Vec4, t: f32) -> Vec4 {
        self.tints.map_or(value, |[from, to]| value * from.lerp(to, t))
    }

    /// The one cell that the side stays in, borders included.
    fn cell(&self) -> Option<[i32; 2]> {
        let (from, to) = (self.at(0.0), self.at(1.0));
        let (cell, _) = cell_of(from.min(to));
        let part = from.max(to) - middle_of(cell);
        (part.max_element() <= 1.0).then_some(cell)
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

/// The center of a cell's first texel.
fn middle_of([x, y]: [i32; 2]) -> Vec2 {
    Vec2::new(x as f32, y as f32) + 0.5
}

/// One level of a channel.
pub struct Judge<'a> {
    /// The level's image of each part of the material.
    pub images: Vec<Texels<'a>>,
    pub meaning: Meaning,
    /// How many components the images store.
    pub components: u8,
}

impl Judge<'_> {
    /// The difference of two sides along an edge, largest over the components: with exact weights, and with
    /// those of 8 bits where `has_coarse`.
    pub fn jumps(&self, a: &Track, b: &Track, has_coarse: bool) -> [Option<Jumps>; 2] {
        if a == b || self.is_one_row(a, b) {
            return [Some(Jumps::Nothing), has_coarse.then_some(Jumps::Nothing)];
        }
        let kinds = [(Weights::Exact, true), (Weights::EightBits, has_coarse)];
        if let (Some(cell_a), Some(cell_b)) = (a.cell(), b.cell()) {
            // Weights of 8 bits reach no further than the cell's border: the same four texels.
            let (corners_a, corners_b) =
                (self.images[a.image].corners(cell_a), self.images[b.image].corners(cell_b));
            let (first_a, first_b) = (middle_of(cell_a), middle_of(cell_b));
            return kinds.map(|(weights, is_wanted)| {
                let at = |t: f32| {
                    let left = mixed(&corners_a, weights.place(a.at(t)) - first_a);
                    let right = mixed(&corners_b, weights.place(b.at(t)) - first_b);
                    self.jump((a, left), (b, right), t)
                };
                is_wanted.then(|| {
                    let few = FEW_POSITIONS.map(at);
                    if few.iter().all(|&jump| jump < FEW_LIMIT) {
                        Jumps::Few(few)
                    } else {
                        Jumps::All(std::array::from_fn(|sample| at(figures::position(sample))))
                    }
                })
            });
        }
        kinds.map(|(weights, is_wanted)| {
            is_wanted.then(|| {
                let (left, right) = (self.along(a, weights), self.along(b, weights));
                Jumps::All(std::array::from_fn(|sample| {
                    self.jump((a, left[sample]), (b, right[sample]), figures::position(sample))
                }))
            })
        })
    }

    /// The difference of two filtered values at one place of an edge.
    #[inline]
    fn jump(&self, (a, left): (&Track, Vec4), (b, right): (&Track, Vec4), t: f32) -> f32 {
        let (Meaning::Normal { scale }, Some(of_a), Some(of_b)) = (self.meaning, &a.frames, &b.frames) else {
            return self.difference_codes(a.tinted(left, t).to_array(), b.tinted(right, t).to_array());
        };
        let (frame_a, frame_b) = (mixed_frame(&of_a[0], &of_a[1], t), mixed_frame(&of_b[0], &of_b[1], t));
        if left == right && frame_a == frame_b {
            return 0.0;
        }
        degrees_between(
            object_normal(left.to_array(), scale, &frame_a),
            object_normal(right.to_array(), scale, &frame_b),
        )
    }

    /// The filtered values at the samples of one side; the texels of a cell are decoded once.
    fn along(&self, track: &Track, weights: Weights) -> [Vec4; SAMPLES] {
        let mut values = [Vec4::ZERO; SAMPLES];
        let texels = &self.images[track.image];
        let (mut known, part) = cell_of(weights.place(track.at(0.0)));
        let mut corners = texels.corners(known);
        values[0] = mixed(&corners, part);
        for (sample, value) in values.iter_mut().enumerate().skip(1) {
            let (cell, part) = cell_of(weights.place(track.at(figures::position(sample))));
            if cell != known {
                known = cell;
                corners = texels.corners(cell);
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
                    && a.tints == b.tints
                    && count_a == count_b
                    && self.images[a.image].equal_runs(
                        &self.images[b.image],
                        [(from_a, step_a), (from_b, step_b)],
                        count_a,
                    )
            }
            _ => false,
        }
    }

    fn difference_codes(&self, left: [f32; 4], right: [f32; 4]) -> f32 {
        if left == right {
            return 0.0;
        }
        let difference = |i: usize| {
            if left[i] == right[i] {
                0.0
            } else if i < 3 && self.meaning == Meaning::Color {
                (encode_codes(left[i]) - encode_codes(right[i])).abs()
            } else {
                (left[i] * 255.0 - right[i] * 255.0).abs()
            }
        };
        stored_components(self.components).iter().map(|&i| difference(i)).fold(0.0, f32::max)
    }
}

#[cfg(test)]
mod tests {
    use super::super::texels::CLAMPED;
    use super::*;
    use crate::image::{Image, Pixels};

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
    fn an_edge_within_one_cell_is_judged_at_few_places_where_it_shows_little() {
        // The first row of texels is a ramp, and the others are the same but for `step`.
        let jumps = |step: u8| {
            let codes = (0..16u8).map(|i| 10 * (i % 4) + if i < 4 { 0 } else { step }).collect();
            let image = Image { width: 4, height: 4, components: 1, pixels: Pixels::U8(codes) };
            let texels = Texels::new(&image, Transfer::Linear, CLAMPED);
            let judge = Judge { images: vec![texels], meaning: Meaning::Data, components: 1 };
            let track = |from, to| Track {
                image: 0,
                from,
                to,
                scale: Vec2::ONE,
                shift: Vec2::ZERO,
                frames: None,
                tints: None,
            };
            // Both stay in one cell, and the second ends on texel centers.
            let a = track(Vec2::new(1.5, 0.7), Vec2::new(2.5, 0.9));
            let b = track(Vec2::new(1.5, 1.5), Vec2::new(2.5, 1.5));
            (judge.jumps(&a, &b, true), judge.jumps(&a, &track(b.from, Vec2::new(2.6, 1.7)), false))
        };
        let (small, large) = (jumps(0), jumps(100));
        assert!(matches!(small.0, [Some(Jumps::Few(_)), Some(Jumps::Few(_))]), "{small:?}");
        let ([Some(Jumps::All(exact)), Some(Jumps::All(coarse))], [Some(Jumps::All(_)), None]) = large else {
            panic!("{large:?}")
        };
        for (sample, (exact, coarse)) in exact.into_iter().zip(coarse).enumerate() {
            // The first stands at 0.2 to 0.4 of the way down the step.
            let t = figures::position(sample);
            assert!((exact - 100.0 * (0.8 - 0.2 * t)).abs() < 1e-2, "{t}: {exact}");
            assert!((coarse - exact).abs() < 100.0 / 512.0 + 10.0 / 512.0 + 1e-2, "{t}: {coarse}");
        }
    }

    #[test]
    fn small_angles_are_exact() {
        for degrees in [0.0f32, 0.001, 0.5, 90.0, 179.0] {
            let turned = Vec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
            assert!((degrees_between(Vec3::X, turned) - degrees).abs() < 1e-4 * degrees.max(1.0));
        }
    }
}
