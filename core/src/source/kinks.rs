//! How fine a quad of vertex colors alone has to be.
//!
//! Its color is linear on each of the two triangles that it is drawn as, with a kink along the diagonal between them. What is stored is
//! bilinear, so with one sample a corner the middle is off by `(c0 - c1 + c2 - c3) / 4`. With `n` segments a side only cells
//! on the diagonal are off, by an `n`th of that.

use glam::{Vec4, Vec4Swizzles};

use super::SurfaceSource;
use crate::math::transfer::linear_to_srgb;

/// A kink that is off by this much in the middle of its cells may stay, 8-bit codes.
const KINK_CODES: f32 = 4.0;

/// The largest difference, in codes, of the middle of a diagonal between the colors `ends` and of the mean of all four corners.
pub fn kink_codes(ends: [Vec4; 2], others: [Vec4; 2]) -> f32 {
    let diagonal = (ends[0] + ends[1]) * 0.5;
    let all = diagonal * 0.5 + (others[0] + others[1]) * 0.25;
    let code = |value: Vec4| value.xyz().map(linear_to_srgb).extend(value.w) * 255.0;
    (code(diagonal) - code(all)).abs().max_element()
}

impl SurfaceSource<'_> {
    /// The square of the segments that a face needs along a side; of a channel that is vertex colors alone. What is linear needs none.
    pub(super) fn kink_texels(&self, face: usize, is_triangle: bool) -> f32 {
        match self.tints.get(face) {
            Some([[a, b, c], [_, _, d]]) if !is_triangle => {
                (kink_codes([*a, *c], [*b, *d]) / KINK_CODES).powi(2)
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_bent_has_a_kink() {
        let [dark, light] = [Vec4::splat(0.2), Vec4::splat(0.6)];
        let middle = (dark + light) * 0.5;
        assert!(kink_codes([dark, light], [middle, middle]) < 1e-3);
        // 1 and 0.5 in linear light are the codes 255 and 187.5.
        let kink = kink_codes([Vec4::ONE; 2], [Vec4::new(0.0, 1.0, 1.0, 1.0); 2]);
        assert!((kink - 67.48).abs() < 0.01, "{kink}");
    }
}
