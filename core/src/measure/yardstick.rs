//! The honest yardstick of fidelity: what any conversion to as many texels could be expected to keep. The
//! source is resampled once, bilinearly, onto a square grid turned by 27° (so that no texel centers
//! coincide), stored in 8 bits, and read back bilinearly in linear light.
//!
//! The grid's spacing is `h = sqrt(A / N)` source texels: `N` texels for an area `A`, see [`Extent`].

use glam::Vec2;

use super::judge::Meaning;
use super::origin::Origin;
use super::surface::Surface;
use super::texels::{Texels, encode_codes, of_8_bits};

/// Turn of the grid, radians.
const TURN: f32 = 27.0 * std::f32::consts::PI / 180.0;

/// Spacings outside are as good as these: a grid of every position, and of none.
const SPACING_RANGE_TEXELS: (f64, f64) = (1e-3, 1e6);

/// What area the yardstick's texels are spread over, in texels of the source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extent {
    /// The whole image, used or not.
    Image,
    /// What the faces cover, overlaps counted each time: a conversion gives every face texels of its own.
    #[default]
    Faces,
}

impl Extent {
    pub(super) fn area_texels(self, origin: &Origin<'_>, surface: &Surface<'_>) -> f64 {
        let image = origin.image.texel_count() as f64;
        match self {
            Extent::Image => image,
            Extent::Faces => {
                let parts = surface.parts.iter().enumerate();
                let triangles =
                    parts.flat_map(|(number, part)| part.triangles.iter().map(move |t| (number, *t)));
                let areas = triangles.map(|(number, triangle)| {
                    let [a, b, c] = origin.corner_uvs(number, triangle).map(|uv| uv.as_dvec2());
                    0.5 * (b - a).perp_dot(c - a).abs()
                });
                areas.sum::<f64>() * image
            }
        }
    }
}

/// The resampled source.
pub struct Yardstick<'a> {
    source: Texels<'a>,
    meaning: Meaning,
    /// Linear light of 8-bit sRGB codes.
    decode: &'static [f32],
    /// Texels of the source.
    spacing: f32,
    /// The grid's first axis, unit length.
    axis: Vec2,
    /// Whether nodes are rounded to 8-bit codes.
    is_rounded: bool,
}

impl<'a> Yardstick<'a> {
    /// A grid of `texel_count` texels of `bits` bits over `area_texels` of the source.
    pub fn new(origin: &Origin<'a>, area_texels: f64, texel_count: usize, bits: u32) -> Self {
        let (low, high) = SPACING_RANGE_TEXELS;
        Self {
            source: origin.texels(origin.image),
            decode: &of_8_bits().srgb,
            meaning: origin.meaning,
            spacing: (area_texels / texel_count.max(1) as f64).sqrt().clamp(low, high) as f32,
            axis: Vec2::from_angle(TURN),
            is_rounded: bits <= 8,
        }
    }

    /// The resampled value at a place of the source, in texels.
    pub fn bilinear(&self, at_texels: Vec2) -> [f32; 4] {
        let on_grid = Vec2::new(self.axis.dot(at_texels), self.axis.perp().dot(at_texels)) / self.spacing;
        let node = on_grid.floor();
        let part = on_grid - node;
        let weights = [
            (1.0 - part.x) * (1.0 - part.y),
            part.x * (1.0 - part.y),
            (1.0 - part.x) * part.y,
            part.x * part.y,
        ];
        let steps = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
        let mut mixed = [0.0; 4];
        for (weight, step) in weights.into_iter().zip(steps) {
            let value = self.node(node + step);
            mixed.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
        }
        mixed
    }

    fn node(&self, node: Vec2) -> [f32; 4] {
        let place = (self.axis * node.x + self.axis.perp() * node.y) * self.spacing;
        let value = self.source.bilinear(place);
        if !self.is_rounded {
            return value;
        }
        let plain = |value: f32| rounded(value * 255.0) as f32 / 255.0;
        let color = |value: f32| self.decode[rounded(encode_codes(value))];
        let [red, green, blue, alpha] = value;
        match self.meaning {
            Meaning::Color => [color(red), color(green), color(blue), plain(alpha)],
            _ => value.map(plain),
        }
    }
}

/// To the nearest whole number, of one that is not negative.
fn rounded(value: f32) -> usize {
    (value + 0.5) as usize
}
