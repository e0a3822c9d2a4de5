//! An image as it is stored: integer codes, row 0 at the top, components interleaved.

use glam::Vec4;

use super::LevelRange;
use crate::math::transfer::{SRGB8_TO_LINEAR, srgb_to_linear};

/// How a stored code in [0, 1] relates to the value that is filtered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Transfer {
    /// Color: red, green, blue are sRGB-encoded, alpha (a 2nd or 4th component) is linear.
    Srgb,
    /// Data: the code is the value.
    Linear,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    U8(Vec<u8>),
    U16(Vec<u16>),
    /// Of sources alone: nothing is ever stored so.
    F32(Values),
}

/// Texels as they enter a filter, of a source that no image file holds: linear light for color, the number for
/// data, whatever the transfer says.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// All finite; components interleaved.
    pub values: Vec<f32>,
    /// What the painted texels had, and what is stored of them: 8 or 16.
    pub bits: u8,
    /// How many texels stand here along the side of a painted one; at least 1.
    pub texels_per_painted: u8,
    /// Where the numbers may be of any size: what 1 stands for here, a power of two. Otherwise they are codes' of [0, 1].
    pub scale: Option<f32>,
}

/// Guarantees: `width, height >= 1`, `components` in 1..=4 (gray, gray + alpha, RGB, RGBA),
/// `pixels` holds exactly `width * height * components` codes.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    pub width: u32,
    pub height: u32,
    pub components: u8,
    pub pixels: Pixels,
}

impl Image {
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    pub fn texel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Of a code, 8 or 16; of values, what codes made of them are to have.
    pub fn bits(&self) -> u8 {
        match &self.pixels {
            Pixels::U8(_) => 8,
            Pixels::U16(_) => 16,
            Pixels::F32(values) => values.bits,
        }
    }

    /// Largest code: 255 or 65535.
    pub fn code_max(&self) -> f32 {
        if self.bits() == 8 { 255.0 } else { 65535.0 }
    }

    /// Texels along the side of what somebody painted as one.
    pub fn texels_per_painted(&self) -> u8 {
        match &self.pixels {
            Pixels::U8(_) | Pixels::U16(_) => 1,
            Pixels::F32(values) => values.texels_per_painted,
        }
    }

    /// What a value of 1 stands for where values are numbers of any size: those of [-1, 1] times this.
    pub fn value_scale(&self) -> Option<f32> {
        match &self.pixels {
            Pixels::U8(_) | Pixels::U16(_) => None,
            Pixels::F32(values) => values.scale,
        }
    }

    pub fn has_alpha(&self) -> bool {
        matches!(self.components, 2 | 4)
    }

    /// The stored codes of one texel over `code_max` (values as they are), as a sampler sees them: gray in red,
    /// green and blue, alpha 1 where there is none. `x < width`, `y < height`.
    pub fn normalized(&self, x: u32, y: u32) -> [f32; 4] {
        let n = self.components as usize;
        let at = (y as usize * self.width as usize + x as usize) * n;
        let code = |i: usize| match &self.pixels {
            Pixels::U8(codes) => f32::from(codes[at + i]) / 255.0,
            Pixels::U16(codes) => f32::from(codes[at + i]) / 65535.0,
            Pixels::F32(values) => values.values[at + i],
        };
        match n {
            1 => [code(0), code(0), code(0), 1.0],
            2 => [code(0), code(0), code(0), code(1)],
            3 => [code(0), code(1), code(2), 1.0],
            _ => [code(0), code(1), code(2), code(3)],
        }
    }

    /// The value of one texel as it enters a filter, of a level that may be stored in a range.
    pub fn value(&self, x: u32, y: u32, transfer: Transfer, range: Option<&LevelRange>) -> Vec4 {
        match range {
            Some(range) => range.texel(self, x, y),
            None => Vec4::from(self.linear(x, y, transfer)),
        }
    }

    /// The value of one texel as it enters a filter: linear light for color, the code for data.
    pub fn linear(&self, x: u32, y: u32, transfer: Transfer) -> [f32; 4] {
        let stored = self.normalized(x, y);
        match (transfer, &self.pixels) {
            (Transfer::Linear, _) | (_, Pixels::F32(_)) => stored,
            (Transfer::Srgb, Pixels::U8(_)) => {
                let decode = |v: f32| SRGB8_TO_LINEAR[(v * 255.0 + 0.5) as usize];
                [decode(stored[0]), decode(stored[1]), decode(stored[2]), stored[3]]
            }
            (Transfer::Srgb, Pixels::U16(_)) => {
                [srgb_to_linear(stored[0]), srgb_to_linear(stored[1]), srgb_to_linear(stored[2]), stored[3]]
            }
        }
    }
}
