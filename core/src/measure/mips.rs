//! The ordinary mip chain of a source image, as drivers and tools make it: each level from the one before
//! by a box filter in linear light, stored again in the image's own codes; alpha does not weigh.
//!
//! Sizes halve, rounded down, to 1 x 1. An odd size is covered exactly: each texel is the mean over its
//! share of the finer level, three taps wide (2w + 1 texels become w).

use rayon::prelude::*;

use super::texels::{encode_codes, tables_of};
use crate::image::{Image, Pixels, Transfer, Values};
use crate::math::transfer::linear_to_srgb;

/// How many levels an image's chain has, with level 0.
pub fn level_count(image: &Image) -> usize {
    image.width.max(image.height).max(1).ilog2() as usize + 1
}

/// The next coarser level; `None` under 1 x 1.
pub fn halved(image: &Image, transfer: Transfer) -> Option<Image> {
    if image.width <= 1 && image.height <= 1 {
        return None;
    }
    let components = image.components as usize;
    let is_color =
        |component: usize| transfer == Transfer::Srgb && !(image.has_alpha() && component == components - 1);
    let tables = tables_of(image);
    let decode: [&[f32]; 4] =
        std::array::from_fn(|i| if is_color(i) { &tables.srgb[..] } else { &tables.plain[..] });
    let shrink = Shrink {
        columns: taps(image.width),
        rows: taps(image.height),
        row_codes: image.width as usize * components,
        components,
    };
    let is_even = image.width.is_multiple_of(2) && image.height.is_multiple_of(2);
    let pixels = match &image.pixels {
        Pixels::U8(codes) if is_even && transfer == Transfer::Linear => {
            Pixels::U8(quartered(codes, shrink.row_codes, components, |_, [a, b, c, d]| {
                ((u32::from(a) + u32::from(b) + u32::from(c) + u32::from(d) + 2) >> 2) as u8
            }))
        }
        Pixels::U8(codes) if is_even => {
            Pixels::U8(quartered(codes, shrink.row_codes, components, |component, four| {
                let [a, b, c, d] = four;
                let table = decode[component];
                let value = |code: u8| table[usize::from(code)];
                let mean = 0.25 * (value(a) + value(b) + value(c) + value(d));
                ((if is_color(component) { encode_codes(mean) } else { mean * 255.0 }) + 0.5) as u8
            }))
        }
        Pixels::U8(codes) => {
            let encoded = |component: usize, value: f32| {
                let code = if is_color(component) { encode_codes(value) } else { value * 255.0 };
                (code + 0.5) as u8
            };
            Pixels::U8(shrink.filtered(
                codes,
                |component, code| decode[component][usize::from(code)],
                encoded,
            ))
        }
        Pixels::U16(codes) => {
            let encoded = |component: usize, value: f32| {
                let share = if is_color(component) { linear_to_srgb(value) } else { value };
                (share * 65535.0 + 0.5) as u16
            };
            Pixels::U16(shrink.filtered(
                codes,
                |component, code| decode[component][usize::from(code)],
                encoded,
            ))
        }
        Pixels::F32(of) => {
            let values = shrink.filtered(&of.values, |_, value| value, |_, value| value);
            Pixels::F32(Values { values, ..*of })
        }
    };
    let (width, height) = (shrink.columns.len() as u32, shrink.rows.len() as u32);
    Some(Image { width, height, components: image.components, pixels })
}

/// The usual case: every texel is the mean of four, of which `mean` makes a code.
fn quartered(
    codes: &[u8],
    row_codes: usize,
    components: usize,
    mean: impl Fn(usize, [u8; 4]) -> u8 + Sync,
) -> Vec<u8> {
    match components {
        1 => quartered_of::<1>(codes, row_codes, mean),
        2 => quartered_of::<2>(codes, row_codes, mean),
        3 => quartered_of::<3>(codes, row_codes, mean),
        _ => quartered_of::<4>(codes, row_codes, mean),
    }
}

fn quartered_of<const N: usize>(
    codes: &[u8],
    row_codes: usize,
    mean: impl Fn(usize, [u8; 4]) -> u8 + Sync,
) -> Vec<u8> {
    let mut coarse = vec![0; codes.len() / 4];
    coarse.par_chunks_mut(row_codes / 2).zip(codes.par_chunks(2 * row_codes)).for_each(|(out, rows)| {
        let (upper, lower) = rows.split_at(row_codes);
        let (upper, lower) = (upper.as_chunks::<N>().0, lower.as_chunks::<N>().0);
        let pairs = upper.as_chunks::<2>().0.iter().zip(lower.as_chunks::<2>().0);
        for (texel, ([a, b], [c, d])) in out.as_chunks_mut::<N>().0.iter_mut().zip(pairs) {
            for (i, code) in texel.iter_mut().enumerate() {
                *code = mean(i, [a[i], b[i], c[i], d[i]]);
            }
        }
    });
    coarse
}

/// The finer texels that one texel covers along an axis: `weights[..count]` from `first` on, sum 1.
struct Taps {
    first: usize,
    count: usize,
    weights: [f32; 3],
}

fn taps(size: u32) -> Vec<Taps> {
    let coarse = (size / 2).max(1);
    (0..coarse)
        .map(|i| {
            let first = 2 * i as usize;
            let share = |numerator: u32| numerator as f32 / size as f32;
            match size {
                1 => Taps { first: 0, count: 1, weights: [1.0, 0.0, 0.0] },
                even if even % 2 == 0 => Taps { first, count: 2, weights: [0.5, 0.5, 0.0] },
                // The interval from i·size/coarse on, size/coarse wide.
                _ => Taps { first, count: 3, weights: [share(coarse - i), share(coarse), share(i + 1)] },
            }
        })
        .collect()
}

struct Shrink {
    columns: Vec<Taps>,
    rows: Vec<Taps>,
    row_codes: usize,
    components: usize,
}

impl Shrink {
    /// `decode` and `encode` get a component's number with what is stored of it, or with its value.
    fn filtered<T>(
        &self,
        codes: &[T],
        decode: impl Fn(usize, T) -> f32 + Sync,
        encode: impl Fn(usize, f32) -> T + Sync,
    ) -> Vec<T>
    where
        T: Copy + Default + Send + Sync,
    {
        let stride = self.columns.len() * self.components;
        let mut coarse = vec![T::default(); stride * self.rows.len()];
        coarse.par_chunks_mut(stride).zip(&self.rows).for_each(|(out, row)| {
            for (texel, column) in out.chunks_mut(self.components).zip(&self.columns) {
                let mut sums = [0.0f32; 4];
                for j in 0..row.count {
                    let line = &codes[(row.first + j) * self.row_codes..][..self.row_codes];
                    let stored = &line[column.first * self.components..];
                    for i in 0..column.count {
                        let weight = row.weights[j] * column.weights[i];
                        for component in 0..self.components {
                            sums[component] +=
                                weight * decode(component, stored[i * self.components + component]);
                        }
                    }
                }
                for (component, code) in texel.iter_mut().enumerate() {
                    *code = encode(component, sums[component]);
                }
            }
        });
        coarse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(width: u32, height: u32, codes: Vec<u8>) -> Image {
        Image { width, height, components: 1, pixels: Pixels::U8(codes) }
    }

    #[test]
    fn halves_in_linear_light() {
        let checker = gray(2, 2, vec![0, 255, 255, 0]);
        assert_eq!(halved(&checker, Transfer::Srgb), Some(gray(1, 1, vec![188])));
        assert_eq!(halved(&checker, Transfer::Linear), Some(gray(1, 1, vec![128])));
        assert_eq!(halved(&gray(1, 1, vec![7]), Transfer::Linear), None);
    }

    #[test]
    fn every_constant_keeps_its_code_down_to_one_texel() {
        for (width, height) in [(8, 8), (7, 5), (1, 9), (3, 1)] {
            for code in 0..=255u8 {
                let mut level = gray(width, height, vec![code; (width * height) as usize]);
                let mut count = 1;
                while let Some(next) = halved(&level, Transfer::Srgb) {
                    assert!(matches!(&next.pixels, Pixels::U8(codes) if codes.iter().all(|c| *c == code)));
                    level = next;
                    count += 1;
                }
                assert_eq!((level.size(), count), ([1, 1], level_count(&gray(width, height, vec![]))));
            }
        }
    }

    #[test]
    fn odd_sizes_keep_the_mean() {
        // 5 texels become 2 of 2.5 each: (10 + 20 + 15) / 2.5 and (15 + 40 + 50) / 2.5.
        let level = halved(&gray(5, 1, vec![10, 20, 30, 40, 50]), Transfer::Linear);
        assert_eq!(level, Some(gray(2, 1, vec![18, 42])));
    }

    #[test]
    fn alpha_and_deep_codes_are_averaged_as_they_are() {
        let pixels = Pixels::U16(vec![0, 0, 65535, 65535]);
        let image = Image { width: 2, height: 1, components: 2, pixels };
        let Some(level) = halved(&image, Transfer::Srgb) else { panic!("two texels have a half") };
        let Pixels::U16(codes) = level.pixels else { panic!("the depth stays") };
        assert!(codes[0].abs_diff(48193) < 20, "{codes:?}");
        assert_eq!(codes[1], 32768);
    }
}
