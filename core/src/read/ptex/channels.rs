//! Which of a file's channels are read, and their numbers as values that enter a filter.

use half::f16;

use super::super::warnings::Warnings;
use super::header::{DataType, Header};
use crate::math::transfer::{SRGB8_TO_LINEAR, srgb_to_linear};

/// The channels that become an image's components.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channels {
    /// Numbers of channels: gray or red, green, blue; then alpha.
    pub taken: Vec<usize>,
    pub has_alpha: bool,
}

/// One channel is gray, two are gray and alpha, three are RGB, four are RGB and alpha; a file may name another channel as
/// its alpha. Of more than fit the first are taken.
pub fn choose(header: &Header, place: &str, warnings: &mut Warnings) -> Channels {
    let count = header.channel_count;
    let alpha = header.alpha.or(matches!(count, 2 | 4).then(|| count - 1)).filter(|_| count > 1);
    let colors: Vec<usize> = (0..count).filter(|&channel| Some(channel) != alpha).collect();
    let color_count = if colors.len() >= 3 { 3 } else { 1 };
    if colors.len() > color_count {
        let names = if color_count == 3 { "three" } else { "one" };
        let detail =
            format!("channels beyond the first {names} of {} colors; they were left out", colors.len());
        warnings.add_many("ptex_channels", place, &detail, (colors.len() - color_count) as u64);
    }
    let taken = colors.into_iter().take(color_count).chain(alpha).collect();
    Channels { taken, has_alpha: alpha.is_some() }
}

/// Numbers of one data type to values: codes of color are sRGB and become linear light, as in any texture; halves and floats are
/// linear already.
pub struct Decoder {
    data: DataType,
    /// By 16-bit code, of color.
    light16: Vec<f32>,
}

/// Values that were brought into [0, 1], and what they reached.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    pub low: f32,
    pub high: f32,
    pub outside_count: u64,
    pub nan_count: u64,
}

impl Default for Range {
    fn default() -> Self {
        Self { low: 0.0, high: 1.0, outside_count: 0, nan_count: 0 }
    }
}

impl Range {
    fn clamped(&mut self, value: f32) -> f32 {
        if value.is_nan() {
            self.nan_count += 1;
            return 0.0;
        }
        if !(0.0..=1.0).contains(&value) {
            self.outside_count += 1;
            (self.low, self.high) = (self.low.min(value), self.high.max(value));
        }
        value.clamp(0.0, 1.0)
    }

    pub fn join(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            outside_count: self.outside_count + other.outside_count,
            nan_count: self.nan_count + other.nan_count,
        }
    }

    pub fn warn(&self, place: &str, warnings: &mut Warnings) {
        let detail = format!(
            "values outside of 0 to 1, from {} to {}; they were clamped, since textures are stored in 8 or 16 bits",
            self.low, self.high
        );
        warnings.add_many("ptex_range", place, &detail, self.outside_count);
        warnings.add_many(
            "ptex_not_a_number",
            place,
            "values that are no number; they became 0",
            self.nan_count,
        );
    }
}

impl Decoder {
    /// `is_color`: whether codes are sRGB-encoded, alpha aside.
    pub fn new(data: DataType, is_color: bool) -> Self {
        let is_light = is_color && data == DataType::U16;
        let light = |code: u16| srgb_to_linear(f32::from(code) / 65535.0);
        Self { data, light16: if is_light { (0..=u16::MAX).map(light).collect() } else { Vec::new() } }
    }

    /// The values of a plane of numbers to every `step`-th place of `to`. `is_light`: color of a color texture.
    pub fn plane(&self, bytes: &[u8], is_light: bool, range: &mut Range, to: Places<'_>) {
        match self.data {
            DataType::U8 if is_light => to.fill(bytes.iter().map(|&code| SRGB8_TO_LINEAR[usize::from(code)])),
            DataType::U8 => to.fill(bytes.iter().map(|&code| f32::from(code) / 255.0)),
            DataType::U16 => {
                let codes = bytes.as_chunks::<2>().0.iter().map(|&code| u16::from_le_bytes(code));
                if is_light && !self.light16.is_empty() {
                    to.fill(codes.map(|code| self.light16[usize::from(code)]));
                } else {
                    to.fill(codes.map(|code| f32::from(code) / 65535.0));
                }
            }
            DataType::Half => {
                let halves = bytes.as_chunks::<2>().0.iter();
                to.fill(halves.map(|&half| range.clamped(f16::from_le_bytes(half).to_f32())));
            }
            DataType::Float => {
                let floats = bytes.as_chunks::<4>().0.iter();
                to.fill(floats.map(|&float| range.clamped(f32::from_le_bytes(float))));
            }
        }
    }
}

/// Where the values of a rectangle's plane go in a face.
pub struct Places<'a> {
    /// The face's values, components interleaved.
    pub face: &'a mut [f32],
    pub components: usize,
    pub component: usize,
    /// Texels of a row of the face, and of the rectangle.
    pub widths: [usize; 2],
    /// The rectangle's first texel.
    pub first: usize,
}

impl Places<'_> {
    fn fill(self, values: impl Iterator<Item = f32>) {
        let [face_width, width] = self.widths;
        for (number, value) in values.enumerate() {
            let texel = self.first + number / width * face_width + number % width;
            self.face[texel * self.components + self.component] = value;
        }
    }
}
