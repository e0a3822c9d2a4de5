//! Values to stored codes and back.

use std::sync::LazyLock;

use glam::Vec4;

use crate::image::{LevelRange, Transfer};
use crate::math::transfer::{SRGB8_TO_LINEAR, linear_to_srgb, srgb_to_linear};

/// What one texel stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Codec {
    pub transfer: Transfer,
    /// 1 gray, 2 gray and alpha, 3 RGB, 4 RGBA.
    pub components: u8,
    /// 8 or 16.
    pub bits: u8,
}

const ALPHA: usize = 3;

impl Codec {
    /// The components of `(r, g, b, a)` that are stored, in their order.
    pub fn stored(&self) -> &'static [usize] {
        match self.components {
            1 => &[0],
            2 => &[0, ALPHA],
            3 => &[0, 1, 2],
            _ => &[0, 1, 2, ALPHA],
        }
    }

    /// Whether alpha is among them.
    pub fn has_alpha(&self) -> bool {
        self.stored().contains(&ALPHA)
    }

    /// Codes of a value `(r, g, b, a)`, the nearest in range: of each component that is stored.
    pub fn codes(&self, value: Vec4) -> impl Iterator<Item = u16> {
        self.stored().iter().map(move |&component| self.encode_one(component, value[component]))
    }

    fn encode_one(&self, component: usize, value: f32) -> u16 {
        match (self.transfer == Transfer::Srgb && component != ALPHA, self.bits) {
            (true, 8) => u16::from(srgb8(value)),
            (true, _) => srgb16(value),
            (false, 8) => u16::from(unorm8(value)),
            (false, _) => unorm16(value),
        }
    }

    fn decode_one(&self, component: usize, code: u16) -> f32 {
        match (self.transfer == Transfer::Srgb && component != ALPHA, self.bits) {
            (true, 8) => SRGB8_TO_LINEAR[usize::from(code)],
            (true, _) => srgb_to_linear(f32::from(code) / 65535.0),
            (false, 8) => f32::from(code) / 255.0,
            (false, _) => f32::from(code) / 65535.0,
        }
    }
}

/// A codec, or the range that stands for it at a level that does not fit into [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LevelCodec {
    pub plain: Codec,
    pub range: Option<LevelRange>,
}

impl LevelCodec {
    /// Codes of a value `(r, g, b, a)`, the nearest in range; the first `components` of the result count.
    pub fn encode(&self, value: Vec4) -> [u16; 4] {
        let mut codes = [0; 4];
        for (code, &component) in codes.iter_mut().zip(self.plain.stored()) {
            *code = self.encode_one(component, value[component]);
        }
        codes
    }

    /// The value that codes stand for, as a sampler returns it.
    pub fn decode(&self, codes: [u16; 4]) -> Vec4 {
        let mut value = Vec4::W;
        for (&code, &component) in codes.iter().zip(self.plain.stored()) {
            value[component] = self.decode_one(component, code);
        }
        if self.plain.components <= 2 {
            (value.y, value.z) = (value.x, value.x);
        }
        value
    }

    /// The nearest value that can be stored.
    pub fn round(&self, value: Vec4) -> Vec4 {
        self.decode(self.encode(value))
    }

    /// The nearest code of one component (0 to 3: red, green, blue, alpha).
    pub fn encode_one(&self, component: usize, value: f32) -> u16 {
        match &self.range {
            None => self.plain.encode_one(component, value),
            Some(range) => range.encode(component, value),
        }
    }

    pub fn decode_one(&self, component: usize, code: u16) -> f32 {
        match &self.range {
            None => self.plain.decode_one(component, code),
            Some(range) => range.decode(component, code),
        }
    }

    /// The codes on both sides of a value; twice the nearest where there is no other.
    pub fn around(&self, component: usize, value: f32) -> [u16; 2] {
        let nearest = self.encode_one(component, value);
        let found = self.decode_one(component, nearest);
        if found == value {
            return [nearest; 2];
        }
        let is_up = found < value;
        let next = match &self.range {
            Some(range) => range.next(nearest, is_up),
            None if is_up => nearest.saturating_add(1).min(if self.plain.bits == 8 { 255 } else { u16::MAX }),
            None => nearest.saturating_sub(1),
        };
        [nearest, next]
    }
}

/// Encodes a line of values into 8-bit codes: texel `first`, then every `step` texels.
pub(super) fn write_line8(codec: &Codec, codes: &mut [u8], line: Line<'_>) {
    if codec.transfer == Transfer::Srgb {
        let table = &*SRGB8;
        by_components(codec, codes, line, |component, value| {
            if component == ALPHA { unorm8(value) } else { srgb8_by(table, value) }
        });
    } else {
        by_components(codec, codes, line, |_, value| unorm8(value));
    }
}

/// The same with 16-bit codes, of a range where there is one.
pub(super) fn write_line16(codec: &LevelCodec, codes: &mut [u16], line: Line<'_>) {
    match (&codec.range, codec.plain.transfer) {
        (Some(range), _) => {
            let all = |value: Vec4| range.encode_all(value);
            match codec.plain.components {
                1 => write(codes, line, |v| [all(v)[0]]),
                2 => write(codes, line, |v| [all(v)[0], all(v)[ALPHA]]),
                3 => write(codes, line, |v| {
                    let [red, green, blue, _] = all(v);
                    [red, green, blue]
                }),
                _ => write(codes, line, all),
            }
        }
        (None, Transfer::Srgb) => by_components(&codec.plain, codes, line, |component, value| {
            if component == ALPHA { unorm16(value) } else { srgb16(value) }
        }),
        (None, Transfer::Linear) => by_components(&codec.plain, codes, line, |_, value| unorm16(value)),
    }
}

/// Values for texels in a row, in any direction.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    /// Number of the first texel.
    pub first: usize,
    /// Texels from one to the next.
    pub step: isize,
    pub values: &'a [Vec4],
}

fn by_components<C: Copy>(
    codec: &Codec,
    codes: &mut [C],
    line: Line<'_>,
    encode: impl Fn(usize, f32) -> C + Copy,
) {
    match codec.components {
        1 => write(codes, line, |v| [encode(0, v.x)]),
        2 => write(codes, line, |v| [encode(0, v.x), encode(ALPHA, v.w)]),
        3 => write(codes, line, |v| [encode(0, v.x), encode(1, v.y), encode(2, v.z)]),
        _ => write(codes, line, |v| [encode(0, v.x), encode(1, v.y), encode(2, v.z), encode(ALPHA, v.w)]),
    }
}

#[inline(always)]
fn write<C: Copy, const N: usize>(codes: &mut [C], line: Line<'_>, encode: impl Fn(Vec4) -> [C; N]) {
    let Line { first, step, values } = line;
    let mut at = first * N;
    if step == 1 {
        let texels = codes[at..].chunks_exact_mut(N);
        texels.zip(values).for_each(|(texel, value)| texel.copy_from_slice(&encode(*value)));
        return;
    }
    let step = step * N as isize;
    for value in values {
        codes[at..at + N].copy_from_slice(&encode(*value));
        at = at.wrapping_add_signed(step);
    }
}

#[inline(always)]
fn unorm8(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[inline(always)]
fn unorm16(value: f32) -> u16 {
    (value.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16
}

fn srgb16(value: f32) -> u16 {
    (linear_to_srgb(value.clamp(0.0, 1.0)) * 65535.0 + 0.5) as u16
}

fn srgb8(value: f32) -> u8 {
    srgb8_by(&SRGB8, value)
}

/// Values under this are code 0, whose half ends at 1.5e-4.
const SRGB8_LOW: f32 = 1.0 / 8192.0;
/// The largest number under 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;
/// The lower bits of a float that tell values in one entry of the table apart; 7 bits of its fraction and
/// its exponent choose the entry.
const ENTRY_BITS: u32 = 16;
const SRGB8_ENTRIES: usize = 13 << 7;

/// By the upper bits of a linear value: its 8-bit sRGB code in the upper half, and in the lower half what
/// carries into it from the next code's threshold on. No entry holds two thresholds.
static SRGB8: LazyLock<Box<[u32; SRGB8_ENTRIES]>> = LazyLock::new(|| {
    let threshold = |code: u32| srgb_to_linear((code as f32 - 0.5) / 255.0);
    let mut code = 0;
    let entry = |number: usize| {
        let first = SRGB8_LOW.to_bits() + ((number as u32) << ENTRY_BITS);
        while code < 255 && f32::from_bits(first) >= threshold(code + 1) {
            code += 1;
        }
        let size = 1 << ENTRY_BITS;
        let to_next = if code < 255 { threshold(code + 1).to_bits() - first } else { size };
        (code << ENTRY_BITS) + size.saturating_sub(to_next)
    };
    let entries: Vec<u32> = (0..SRGB8_ENTRIES).map(entry).collect();
    Box::new(std::array::from_fn(|number| entries[number]))
});

#[inline(always)]
fn srgb8_by(table: &[u32; SRGB8_ENTRIES], value: f32) -> u8 {
    // In this order what is not a number is 0.
    #[expect(clippy::manual_clamp, reason = "clamp keeps NaN; in this order it becomes a number")]
    let bits = value.max(SRGB8_LOW).min(BELOW_ONE).to_bits() - SRGB8_LOW.to_bits();
    let entry = table[(bits >> ENTRY_BITS) as usize];
    ((entry + (bits & 0xffff)) >> ENTRY_BITS) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn plain(transfer: Transfer, components: u8, bits: u8) -> LevelCodec {
        LevelCodec { plain: Codec { transfer, components, bits }, range: None }
    }

    #[test]
    fn codes_survive_decoding_and_encoding() {
        for transfer in [Transfer::Srgb, Transfer::Linear] {
            let codec = plain(transfer, 4, 8);
            for code in 0..=255u16 {
                let codes = [code, 255 - code, code, code];
                assert_eq!(codec.encode(codec.decode(codes)), codes);
            }
            let deep = plain(transfer, 2, 16);
            for code in (0..=65535u16).step_by(97) {
                let codes = [code, 65535 - code, 0, 0];
                assert_eq!(deep.encode(deep.decode(codes)), codes);
            }
        }
    }

    /// Encoding takes the nearest code in the encoded scale, and clamps what is out of range.
    #[test]
    fn encoding_is_nearest() {
        let codec = plain(Transfer::Srgb, 1, 8);
        for step in 0..=20_000 {
            let value = (step as f32 / 20_000.0).powi(3);
            let code = codec.encode(Vec4::splat(value))[0];
            let exact = linear_to_srgb(value) * 255.0;
            assert!((f32::from(code) - exact).abs() <= 0.501, "{value} became {code}, not {exact}");
        }
        assert_eq!(codec.encode(Vec4::splat(-3.0))[0], 0);
        assert_eq!(codec.encode(Vec4::splat(7.0))[0], 255);
        assert_eq!(codec.encode(Vec4::splat(f32::NAN))[0], 0);
        assert!((srgb_to_linear(0.5) - codec.decode([128, 0, 0, 0]).x).abs() < 0.005);
    }

    /// From its threshold on, and not one float before it.
    #[test]
    fn the_table_turns_exactly_at_every_threshold() {
        for code in 1..=255u8 {
            let threshold = srgb_to_linear((f32::from(code) - 0.5) / 255.0);
            assert_eq!((srgb8(threshold), srgb8(threshold.next_down())), (code, code - 1));
        }
    }

    #[test]
    fn lines_run_in_any_direction() {
        let codec = Codec { transfer: Transfer::Linear, components: 2, bits: 8 };
        let values = [1, 2, 3].map(|code| Vec4::new(code as f32, 0.0, 0.0, 255.0) / 255.0);
        let written = |first: usize, step: isize| {
            let mut codes = vec![0; 12];
            write_line8(&codec, &mut codes, Line { first, step, values: &values });
            codes
        };
        assert_eq!(written(1, 1), [0, 0, 1, 255, 2, 255, 3, 255, 0, 0, 0, 0]);
        assert_eq!(written(4, -2), [3, 255, 0, 0, 2, 255, 0, 0, 1, 255, 0, 0]);
    }
}
