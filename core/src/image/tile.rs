//! A rectangle of decoded texels. Transfer and wrap modes are dealt with once, when it is filled, so that a
//! fetch is four loads and three mixes.

use glam::{Vec2, Vec4};

use super::sample::DATA8;
use super::{Image, Pixels, Transfer, Wrap};
use crate::math::transfer::SRGB8_TO_LINEAR;

/// Texels around what was asked for, so that rounding cannot leave the tile.
const MARGIN: i64 = 1;

/// Reused from fill to fill.
#[derive(Clone, Debug, Default)]
pub struct Tile {
    origin: [i64; 2],
    width: usize,
    height: usize,
    texels: Vec<Vec4>,
}

impl Tile {
    /// Texels that [`fill`](Self::fill) would decode; what is not finite needs more than there can be.
    pub fn needed_texels(least: Vec2, most: Vec2) -> f32 {
        let sides = most - least + (2.0 + 2.0 * MARGIN as f32);
        let count = sides.x * sides.y;
        if count.is_finite() { count } else { f32::INFINITY }
    }

    /// Decodes everything that bilinear fetches at places from `least` to `most` (texels, texel centers at
    /// `.5`, finite) read.
    pub fn fill(&mut self, image: &Image, transfer: Transfer, wrap: Wrap, least: Vec2, most: Vec2) {
        let first = |place: f32| (place - 0.5).floor() as i64 - MARGIN;
        let last = |place: f32| (place - 0.5).floor() as i64 + 1 + MARGIN;
        self.origin = [first(least.x), first(least.y)];
        self.width = (last(most.x) - self.origin[0]) as usize + 1;
        self.height = (last(most.y) - self.origin[1]) as usize + 1;
        self.texels.resize(self.width * self.height, Vec4::ZERO);
        let is_inside = self.origin[0] >= 0 && last(most.x) < i64::from(image.width);
        let columns: Vec<u32> = if is_inside {
            Vec::new()
        } else {
            (0..self.width as i64).map(|k| wrap.s.apply(self.origin[0] + k, image.width)).collect()
        };
        let components = usize::from(image.components);
        for (number, row) in self.texels.chunks_exact_mut(self.width).enumerate() {
            let y = wrap.t.apply(self.origin[1] + number as i64, image.height);
            match &image.pixels {
                Pixels::U8(codes) => {
                    let color = if transfer == Transfer::Srgb { &SRGB8_TO_LINEAR } else { &DATA8 };
                    let start = y as usize * image.width as usize * components;
                    let line = &codes[start..start + image.width as usize * components];
                    if is_inside {
                        decode8(&line[self.origin[0] as usize * components..], components, color, row);
                    } else {
                        for (texel, &x) in row.chunks_exact_mut(1).zip(&columns) {
                            decode8(&line[x as usize * components..], components, color, texel);
                        }
                    }
                }
                Pixels::U16(_) | Pixels::F32(_) => {
                    for (k, texel) in row.iter_mut().enumerate() {
                        let x = columns.get(k).copied().unwrap_or_else(|| (self.origin[0] + k as i64) as u32);
                        *texel = image.linear(x, y, transfer).into();
                    }
                }
            }
        }
    }

    /// What to take from a place in texels for [`bilinear`](Self::bilinear).
    pub fn offset(&self) -> Vec2 {
        Vec2::new(self.origin[0] as f32 + 0.5, self.origin[1] as f32 + 0.5)
    }

    /// The bilinear value at `at` texels from the center of the tile's first texel.
    #[inline(always)]
    pub fn bilinear(&self, at: Vec2) -> Vec4 {
        let i = (at.x as i32).clamp(0, self.width as i32 - 2);
        let j = (at.y as i32).clamp(0, self.height as i32 - 2);
        let (x, y) = (at.x - i as f32, at.y - j as f32);
        let first = j as usize * self.width + i as usize;
        let top = &self.texels[first..first + 2];
        let bottom = &self.texels[first + self.width..first + self.width + 2];
        let low = top[0] + (top[1] - top[0]) * x;
        let high = bottom[0] + (bottom[1] - bottom[0]) * x;
        low + (high - low) * y
    }
}

/// Decodes as many texels as `row` holds.
fn decode8(codes: &[u8], components: usize, color: &[f32; 256], row: &mut [Vec4]) {
    let alpha = &*DATA8;
    let c = |code: u8| color[usize::from(code)];
    match components {
        1 => {
            for (texel, &gray) in row.iter_mut().zip(codes) {
                *texel = Vec4::splat(c(gray)).with_w(1.0);
            }
        }
        2 => {
            for (texel, [gray, a]) in row.iter_mut().zip(codes.as_chunks().0) {
                *texel = Vec4::splat(c(*gray)).with_w(alpha[usize::from(*a)]);
            }
        }
        3 => {
            for (texel, [r, g, b]) in row.iter_mut().zip(codes.as_chunks().0) {
                *texel = Vec4::new(c(*r), c(*g), c(*b), 1.0);
            }
        }
        _ => {
            for (texel, [r, g, b, a]) in row.iter_mut().zip(codes.as_chunks().0) {
                *texel = Vec4::new(c(*r), c(*g), c(*b), alpha[usize::from(*a)]);
            }
        }
    }
}

#[cfg(test)]
mod tests;
