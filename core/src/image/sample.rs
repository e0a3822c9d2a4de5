//! Bilinear filtering as a GPU does it: decode every texel, then mix.

use std::sync::LazyLock;

use glam::{Vec2, Vec4};

use super::{Image, Pixels, Transfer, Wrap};
use crate::math::transfer::SRGB8_TO_LINEAR;

pub(super) static DATA8: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| code as f32 / 255.0));

/// The bilinear value at `at_texels` (texel centers at `.5`), in linear light for color. Finite for every
/// finite `at_texels` within ±1e9.
pub fn bilinear(image: &Image, transfer: Transfer, wrap: Wrap, at_texels: Vec2) -> Vec4 {
    let corner = at_texels - 0.5;
    let floor = corner.floor();
    let fraction = corner - floor;
    let (x, y) = (floor.x as i64, floor.y as i64);
    let is_inside = x >= 0 && y >= 0 && x + 1 < i64::from(image.width) && y + 1 < i64::from(image.height);
    let (columns, rows) = if is_inside {
        ([x as u32, x as u32 + 1], [y as u32, y as u32 + 1])
    } else {
        (
            [wrap.s.apply(x, image.width), wrap.s.apply(x + 1, image.width)],
            [wrap.t.apply(y, image.height), wrap.t.apply(y + 1, image.height)],
        )
    };
    let texels = match &image.pixels {
        Pixels::U8(codes) => {
            let color = if transfer == Transfer::Srgb { &SRGB8_TO_LINEAR } else { &DATA8 };
            four_texels8(image, codes, (color, &DATA8), columns, rows)
        }
        Pixels::U16(_) | Pixels::F32(_) => {
            let texel = |i: usize, j: usize| Vec4::from(image.linear(columns[i], rows[j], transfer));
            [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)]
        }
    };
    let top = texels[0].lerp(texels[1], fraction.x);
    let bottom = texels[2].lerp(texels[3], fraction.x);
    top.lerp(bottom, fraction.y)
}

/// Decodes the texels of an 8-bit image by tables for color and alpha.
fn four_texels8(
    image: &Image,
    codes: &[u8],
    (color, alpha): (&[f32; 256], &[f32; 256]),
    columns: [u32; 2],
    rows: [u32; 2],
) -> [Vec4; 4] {
    let components = usize::from(image.components);
    [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| {
        let at = (rows[j] as usize * image.width as usize + columns[i] as usize) * components;
        let texel = &codes[at..at + components];
        match *texel {
            [r, g, b] => Vec4::new(color[r as usize], color[g as usize], color[b as usize], 1.0),
            [r, g, b, a] => {
                Vec4::new(color[r as usize], color[g as usize], color[b as usize], alpha[a as usize])
            }
            [gray, a] => Vec4::splat(color[gray as usize]).truncate().extend(alpha[a as usize]),
            [gray, ..] => Vec4::splat(color[gray as usize]).truncate().extend(1.0),
            [] => Vec4::ZERO,
        }
    })
}
