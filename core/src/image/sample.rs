//! Bilinear filtering as a GPU does it: decode every texel, then mix.

use glam::{Vec2, Vec4};

use super::{Image, Transfer, Wrap};

/// The bilinear value at `at_texels` (texel centers at `.5`, level 0 of nothing: plain texels), in
/// linear light for color. Finite for every finite `at_texels` within ±1e9.
pub fn bilinear(image: &Image, transfer: Transfer, wrap: Wrap, at_texels: Vec2) -> Vec4 {
    let corner = at_texels - 0.5;
    let floor = corner.floor();
    let fraction = corner - floor;
    let (x, y) = (floor.x as i64, floor.y as i64);
    let columns = [wrap.s.apply(x, image.width), wrap.s.apply(x + 1, image.width)];
    let rows = [wrap.t.apply(y, image.height), wrap.t.apply(y + 1, image.height)];
    let texel = |i: usize, j: usize| Vec4::from(image.linear(columns[i], rows[j], transfer));
    let top = texel(0, 0).lerp(texel(1, 0), fraction.x);
    let bottom = texel(0, 1).lerp(texel(1, 1), fraction.x);
    top.lerp(bottom, fraction.y)
}
