//! What the 16-bit codes of a level mean that does not fit into [0, 1].

use glam::Vec4;
use half::f16;
use half::slice::HalfFloatSliceExt;

use super::{Image, Pixels};

/// How the texels of a level image become the values that are filtered: linear light for color, the stored
/// number for data and normals. Levels without one hold codes of [0, 1], as glTF has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelRange {
    /// `value = code / 65535 · scale + bias`, component by component (red, green, blue, alpha; gray stands
    /// in the first three). Both are finite; the scale is above 0.
    Scaled16 { scale: Vec4, bias: Vec4 },
    /// The codes are the bits of IEEE 754 half floats, all finite.
    Float16,
}

/// The largest half float.
const HALF_MAX: f32 = 65504.0;
/// The smallest normal one above 0.
const HALF_NORMAL: f32 = 1.0 / 16384.0;

impl LevelRange {
    /// The 16-bit range that holds the values from `low` to `high`, component by component.
    pub fn spanning(low: Vec4, high: Vec4) -> Self {
        let span = high - low;
        // A constant component is its bias; any scale above 0 will do.
        let scale = Vec4::select(span.cmpgt(Vec4::splat(f32::MIN_POSITIVE)), span, Vec4::ONE);
        Self::Scaled16 { scale, bias: low }
    }

    /// As the file format and the options name it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Scaled16 { .. } => "scaled16",
            Self::Float16 => "float16",
        }
    }

    /// The nearest code of one component (0 to 3: red, green, blue, alpha).
    pub fn encode(&self, component: usize, value: f32) -> u16 {
        match self {
            Self::Scaled16 { scale, bias } => {
                let share = (value - bias[component]) / scale[component];
                (share.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16
            }
            Self::Float16 => f16::from_f32(value.clamp(-HALF_MAX, HALF_MAX)).to_bits(),
        }
    }

    /// The nearest codes of all components.
    #[inline]
    pub fn encode_all(&self, value: Vec4) -> [u16; 4] {
        match self {
            Self::Scaled16 { .. } => [0, 1, 2, 3].map(|component| self.encode(component, value[component])),
            Self::Float16 => halves(value).map(f16::to_bits),
        }
    }

    /// The nearest value that can be stored; of two equally near either.
    #[inline]
    pub fn round(&self, value: Vec4) -> Vec4 {
        match self {
            Self::Scaled16 { .. } => {
                let codes = self.encode_all(value);
                Vec4::from_array([0, 1, 2, 3].map(|component| self.decode(component, codes[component])))
            }
            Self::Float16 => {
                let value = value.clamp(Vec4::splat(-HALF_MAX), Vec4::splat(HALF_MAX));
                // T. J. Dekker, "A floating-point technique for extending the available precision", 1971: the
                // upper 11 of 24 bits. What is smaller than a normal half is a multiple of 2^-24, as are all
                // floats between 1/2 and 1.
                let scaled = value * 8193.0;
                let fine = (value + 0.75) - 0.75;
                Vec4::select(value.abs().cmplt(Vec4::splat(HALF_NORMAL)), fine, scaled - (scaled - value))
            }
        }
    }

    pub fn decode(&self, component: usize, code: u16) -> f32 {
        match self {
            Self::Scaled16 { scale, bias } => f32::from(code) / 65535.0 * scale[component] + bias[component],
            Self::Float16 => f16::from_bits(code).to_f32(),
        }
    }

    /// The code of the next larger or smaller value; the same code where there is none.
    pub fn next(&self, code: u16, is_up: bool) -> u16 {
        match self {
            Self::Scaled16 { .. } if is_up => code.saturating_add(1),
            Self::Scaled16 { .. } => code.saturating_sub(1),
            Self::Float16 => {
                // Sign and magnitude to a number in the order of the values, and back.
                let magnitude = i32::from(code & 0x7fff);
                let order = if code >> 15 == 1 { -magnitude } else { magnitude };
                let largest = i32::from(f16::MAX.to_bits());
                let next = (order + if is_up { 1 } else { -1 }).clamp(-largest, largest);
                next.unsigned_abs() as u16 | if next < 0 { 0x8000 } else { 0 }
            }
        }
    }

    /// The value of one texel as it enters a filter: gray in red, green and blue, alpha 1 where there is
    /// none. `x < width`, `y < height`; an image of 8 bits has no range and gives its codes over 255.
    // Never called as a function: rustc 1.95 may let a vector be returned into the place of an array of the caller's, which is
    // aligned to 4 bytes and not to 16.
    #[inline(always)]
    pub fn texel(&self, image: &Image, x: u32, y: u32) -> Vec4 {
        let Pixels::U16(codes) = &image.pixels else { return Vec4::from(image.normalized(x, y)) };
        let count = usize::from(image.components);
        let at = (y as usize * image.width as usize + x as usize) * count;
        let of = |component: usize, stored: usize| self.decode(component, codes[at + stored]);
        match count {
            1 | 2 => {
                let alpha = if count == 2 { of(3, 1) } else { 1.0 };
                Vec4::new(of(0, 0), of(1, 0), of(2, 0), alpha)
            }
            3 => Vec4::new(of(0, 0), of(1, 1), of(2, 2), 1.0),
            _ => Vec4::new(of(0, 0), of(1, 1), of(2, 2), of(3, 3)),
        }
    }
}

#[inline]
fn halves(value: Vec4) -> [f16; 4] {
    let mut halves = [f16::ZERO; 4];
    halves.convert_from_f32_slice(&value.clamp(Vec4::splat(-HALF_MAX), Vec4::splat(HALF_MAX)).to_array());
    halves
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_reaches_both_its_ends() {
        let (low, high) = (Vec4::new(-3.0, 0.25, 0.0, 1.0), Vec4::new(5.0, 0.25, 1.0, 1.0));
        let range = LevelRange::spanning(low, high);
        for k in 0..4 {
            assert_eq!(range.decode(k, range.encode(k, low[k])), low[k]);
            assert_eq!(range.decode(k, range.encode(k, high[k])), high[k]);
        }
        for step in 0..=1000 {
            let value = -3.0 + 8.0 * step as f32 / 1000.0;
            let back = range.decode(0, range.encode(0, value));
            assert!((back - value).abs() <= 0.501 * 8.0 / 65535.0, "{value} came back as {back}");
        }
        assert_eq!((range.encode(0, -9.0), range.encode(0, 9.0)), (0, 65535));
    }

    #[test]
    fn half_floats_keep_eleven_bits_and_stay_finite() {
        let range = LevelRange::Float16;
        for value in [-70.0, -0.3, 0.0, 1.0 / 3.0, 1.0, 1234.5] {
            let back = range.decode(1, range.encode(1, value));
            assert!((back - value).abs() <= value.abs() / 2048.0, "{value} came back as {back}");
        }
        for value in [-70.0, -1.0 / 1024.0, 0.0, 0.5, 1.0, HALF_MAX] {
            let code = range.encode(0, value);
            let [down, up] = [false, true].map(|is_up| range.decode(0, range.next(code, is_up)));
            assert!(down < value && (up > value || value == HALF_MAX), "{down} {value} {up}");
            assert_eq!(range.decode(0, range.next(range.next(code, false), true)), value);
        }
        assert_eq!(range.decode(2, range.encode(2, 1e9)), HALF_MAX);
        assert_eq!(range.decode(2, range.encode(2, -1e9)), -HALF_MAX);
    }

    #[test]
    fn four_components_are_rounded_as_each_is() {
        let scale = Vec4::new(4.0, 1.0, 1e-3, 70.0);
        for range in [LevelRange::Scaled16 { scale, bias: Vec4::splat(-0.3) }, LevelRange::Float16] {
            for step in 0..2000 {
                let share = step as f32 / 999.0 - 0.5;
                let value = Vec4::new(share, share.powi(9), share * 1e-6, share * 1e5);
                let each = [0, 1, 2, 3].map(|k| range.encode(k, value[k]));
                assert_eq!(range.encode_all(value), each, "{value}");
                let decoded = Vec4::from_array([0, 1, 2, 3].map(|k| range.decode(k, each[k])));
                let rounded = range.round(value);
                assert_eq!((rounded - value).abs(), (decoded - value).abs(), "{value}");
                assert_eq!(range.round(rounded), rounded, "{value}");
            }
        }
    }

    #[test]
    fn texels_know_gray_and_alpha() {
        let range = LevelRange::Scaled16 { scale: Vec4::splat(2.0), bias: Vec4::new(-1.0, -1.0, -1.0, 3.0) };
        let image = |components: u8, codes: &[u16]| Image {
            width: 1,
            height: 1,
            components,
            pixels: Pixels::U16(codes.to_vec()),
        };
        assert_eq!(range.texel(&image(1, &[65535]), 0, 0), Vec4::ONE);
        assert_eq!(range.texel(&image(2, &[65535, 0]), 0, 0), Vec4::new(1.0, 1.0, 1.0, 3.0));
        assert_eq!(range.texel(&image(3, &[0, 65535, 0]), 0, 0), Vec4::new(-1.0, 1.0, -1.0, 1.0));
        assert_eq!(range.texel(&image(4, &[0, 0, 65535, 65535]), 0, 0), Vec4::new(-1.0, -1.0, 1.0, 5.0));
    }
}
