//! The sRGB transfer function (IEC 61966-2-1), scalar, and tables for 8-bit codes.

use std::sync::LazyLock;

/// sRGB-encoded value in [0, 1] to linear light in [0, 1]. Values outside are extended, not clamped.
pub fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Linear light to the sRGB-encoded value; the inverse of [`srgb_to_linear`].
pub fn linear_to_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The derivative of [`linear_to_srgb`].
pub fn srgb_slope(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 } else { 1.055 / 2.4 * linear.powf(1.0 / 2.4 - 1.0) }
}

/// `SRGB8_TO_LINEAR[code]` is the linear light of an 8-bit sRGB code.
pub static SRGB8_TO_LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| srgb_to_linear(code as f32 / 255.0)));
