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

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pixels {
    U8(Vec<u8>),
    U16(Vec<u16>),
}

/// Guarantees: `width, height >= 1`, `components` in 1..=4 (gray, gray + alpha, RGB, RGBA),
/// `pixels` holds exactly `width * height * components` codes.
#[derive(Clone, Debug, PartialEq, Eq)]
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

    /// Largest code: 255 or 65535.
    pub fn code_max(&self) -> f32 {
        match self.pixels {
            Pixels::U8(_) => 255.0,
            Pixels::U16(_) => 65535.0,
        }
    }

    pub fn has_alpha(&self) -> bool {
        matches!(self.components, 2 | 4)
    }

    /// The stored codes of one texel over `code_max`, as a sampler sees them: gray in red, green and
    /// blue, alpha 1 where there is none. `x < width`, `y < height`.
    pub fn normalized(&self, x: u32, y: u32) -> [f32; 4] {
        let n = self.components as usize;
        let at = (y as usize * self.width as usize + x as usize) * n;
        let code = |i: usize| match &self.pixels {
            Pixels::U8(codes) => f32::from(codes[at + i]) / 255.0,
            Pixels::U16(codes) => f32::from(codes[at + i]) / 65535.0,
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
            (Transfer::Linear, _) => stored,
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
