//! Values to stored codes and back.

use std::sync::LazyLock;

use glam::Vec4;

use crate::image::Transfer;
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

/// The linear value from which on an 8-bit sRGB code is the nearest.
static SRGB8_THRESHOLDS: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| srgb_to_linear((code as f32 - 0.5) / 255.0)));

/// First guess of the code of a linear value, by its 4096th part.
static SRGB8_GUESS: LazyLock<[u8; 4097]> = LazyLock::new(|| {
    std::array::from_fn(|part| (linear_to_srgb(part as f32 / 4096.0) * 255.0).round() as u8)
});

impl Codec {
    pub fn code_max(&self) -> f32 {
        if self.bits == 8 { 255.0 } else { 65535.0 }
    }

    fn is_srgb(&self, component: usize) -> bool {
        let is_alpha = matches!((self.components, component), (2, 1) | (4, 3));
        self.transfer == Transfer::Srgb && !is_alpha
    }

    /// The nearest code of a value; values outside [0, 1] are clamped.
    fn encode_one(&self, component: usize, value: f32) -> u16 {
        let value = value.clamp(0.0, 1.0);
        if !self.is_srgb(component) {
            return (value * self.code_max() + 0.5) as u16;
        }
        if self.bits == 16 {
            return (linear_to_srgb(value) * 65535.0 + 0.5) as u16;
        }
        let mut code = usize::from(SRGB8_GUESS[(value * 4096.0) as usize]);
        while code < 255 && value >= SRGB8_THRESHOLDS[code + 1] {
            code += 1;
        }
        while code > 0 && value < SRGB8_THRESHOLDS[code] {
            code -= 1;
        }
        code as u16
    }

    fn decode_one(&self, component: usize, code: u16) -> f32 {
        let srgb = self.is_srgb(component);
        match (srgb, self.bits) {
            (true, 8) => SRGB8_TO_LINEAR[usize::from(code)],
            (true, _) => srgb_to_linear(f32::from(code) / 65535.0),
            (false, _) => f32::from(code) / self.code_max(),
        }
    }

    /// Codes of a value `(r, g, b, a)`; the first `components` of the result count.
    pub fn encode(&self, value: Vec4) -> [u16; 4] {
        let order: [f32; 4] =
            if self.components == 2 { [value.x, value.w, 0.0, 0.0] } else { value.to_array() };
        let mut codes = [0; 4];
        for (component, code) in codes.iter_mut().enumerate().take(usize::from(self.components)) {
            *code = self.encode_one(component, order[component]);
        }
        codes
    }

    /// The value that codes stand for, as a sampler returns it.
    pub fn decode(&self, codes: [u16; 4]) -> Vec4 {
        let of = |component: usize| self.decode_one(component, codes[component]);
        match self.components {
            1 => Vec4::new(of(0), of(0), of(0), 1.0),
            2 => Vec4::new(of(0), of(0), of(0), of(1)),
            3 => Vec4::new(of(0), of(1), of(2), 1.0),
            _ => Vec4::new(of(0), of(1), of(2), of(3)),
        }
    }

    /// The nearest value that can be stored.
    pub fn round(&self, value: Vec4) -> Vec4 {
        self.decode(self.encode(value))
    }
}
