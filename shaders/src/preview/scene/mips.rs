//! Ordinary mip maps, as any engine makes them: a box filter in linear light, level by level, down to
//! one texel. This is what the source column of the sheet shows.

use glam::Vec4;
use meshcolor::image::{Image, Pixels, Transfer, Values};
use meshcolor::math::transfer::linear_to_srgb;
use rayon::prelude::*;

/// Levels 1 and up; level 0 is the image itself. Each side is half of the one before, rounded down.
pub fn mip_maps(image: &Image, transfer: Transfer) -> Vec<Image> {
    let mut levels = Vec::new();
    let mut size = image.size();
    let mut values: Vec<Vec4> = Vec::new();
    while size != [1, 1] {
        let half = [(size[0] / 2).max(1), (size[1] / 2).max(1)];
        values = if levels.is_empty() {
            reduce(size, half, |x, y| Vec4::from(image.linear(x, y, transfer)))
        } else {
            reduce(size, half, |x, y| values[y as usize * size[0] as usize + x as usize])
        };
        levels.push(encode(&values, half, image, transfer));
        size = half;
    }
    levels
}

/// The texels along one axis that output texel `to` of `to_count` covers, with their shares: two of an
/// even side, three of an odd one, where the box is a little wider than two texels.
fn taps(to: u32, from_count: u32, to_count: u32) -> [(u32, f32); 3] {
    if from_count == 1 {
        [(0, 1.0), (0, 0.0), (0, 0.0)]
    } else if from_count.is_multiple_of(2) {
        [(2 * to, 0.5), (2 * to + 1, 0.5), (2 * to, 0.0)]
    } else {
        let share = |texels: u32| texels as f32 / from_count as f32;
        [(2 * to, share(to_count - to)), (2 * to + 1, share(to_count)), (2 * to + 2, share(to + 1))]
    }
}

fn reduce(from: [u32; 2], to: [u32; 2], fetch: impl Fn(u32, u32) -> Vec4 + Sync) -> Vec<Vec4> {
    let mut out = vec![Vec4::ZERO; to[0] as usize * to[1] as usize];
    out.par_chunks_mut(to[0] as usize).enumerate().for_each(|(row, line)| {
        let rows = taps(row as u32, from[1], to[1]);
        for (column, value) in line.iter_mut().enumerate() {
            let columns = taps(column as u32, from[0], to[0]);
            for (y, y_share) in rows.into_iter().filter(|(_, share)| *share > 0.0) {
                for (x, x_share) in columns.into_iter().filter(|(_, share)| *share > 0.0) {
                    *value += fetch(x, y) * (x_share * y_share);
                }
            }
        }
    });
    out
}

/// Back to the format of `like`.
fn encode(values: &[Vec4], size: [u32; 2], like: &Image, transfer: Transfer) -> Image {
    let components = like.components as usize;
    if let Pixels::F32(of) = &like.pixels {
        let is_alpha = |c: usize| like.has_alpha() && c + 1 == components;
        let stored = |value: &Vec4, c: usize| if is_alpha(c) { value.w } else { value[c] };
        let values = values.iter().flat_map(|value| (0..components).map(move |c| stored(value, c))).collect();
        let pixels = Pixels::F32(Values { values, ..*of });
        return Image { width: size[0], height: size[1], components: like.components, pixels };
    }
    let stored = |value: Vec4, component: usize| {
        let is_alpha = like.has_alpha() && component + 1 == components;
        let linear = if is_alpha { value.w } else { value[component] };
        let encoded = match transfer {
            Transfer::Srgb if !is_alpha => linear_to_srgb(linear),
            _ => linear,
        };
        encoded.clamp(0.0, 1.0) * like.code_max() + 0.5
    };
    let codes = values.par_iter().flat_map_iter(|value| (0..components).map(|c| stored(*value, c)));
    let pixels = match like.pixels {
        Pixels::U8(_) => Pixels::U8(codes.map(|code| code as u8).collect()),
        Pixels::U16(_) | Pixels::F32(_) => Pixels::U16(codes.map(|code| code as u16).collect()),
    };
    Image { width: size[0], height: size[1], components: like.components, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(width: u32, height: u32, codes: &[u8]) -> Image {
        Image { width, height, components: 1, pixels: Pixels::U8(codes.to_vec()) }
    }

    #[test]
    fn black_and_white_average_in_linear_light() {
        let levels = mip_maps(&gray(2, 1, &[0, 255]), Transfer::Srgb);
        assert_eq!(levels, vec![gray(1, 1, &[188])]);
        let levels = mip_maps(&gray(2, 1, &[0, 255]), Transfer::Linear);
        assert_eq!(levels, vec![gray(1, 1, &[128])]);
    }

    #[test]
    fn an_odd_side_keeps_the_mean() {
        let levels = mip_maps(&gray(5, 1, &[10, 20, 30, 40, 50]), Transfer::Linear);
        let sizes: Vec<_> = levels.iter().map(Image::size).collect();
        assert_eq!(sizes, vec![[2, 1], [1, 1]]);
        assert_eq!(levels[1], gray(1, 1, &[30]));
    }

    #[test]
    fn alpha_is_linear_in_a_color_image() {
        let image = Image { width: 2, height: 1, components: 2, pixels: Pixels::U8(vec![0, 0, 255, 255]) };
        let level = &mip_maps(&image, Transfer::Srgb)[0];
        assert_eq!(level.pixels, Pixels::U8(vec![188, 128]));
    }
}
