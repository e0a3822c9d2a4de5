//! Texture fetches of the CPU renderer. `bilinear` gives the same values as `meshcolor::image::bilinear`
//! (tested); it looks the transfer up in a table, since a picture takes tens of millions of texels.

use std::sync::LazyLock;

use glam::{Vec2, Vec4};
use meshcolor::image::{Image, Pixels, Transfer, Wrap};
use meshcolor::math::transfer::SRGB8_TO_LINEAR;

use crate::preview::scene::Filter;
use crate::preview::scene::texture::Texture;
use crate::twins::{CLAMP, mct_pick};

static CODE8_TO_UNIT: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| code as f32 / 255.0));

/// One texel as it enters a filter; `x` and `y` are inside.
#[inline]
fn texel(image: &Image, transfer: Transfer, x: u32, y: u32) -> Vec4 {
    let Pixels::U8(codes) = &image.pixels else { return Vec4::from(image.linear(x, y, transfer)) };
    let color: &[f32; 256] = match transfer {
        Transfer::Srgb => &SRGB8_TO_LINEAR,
        Transfer::Linear => &CODE8_TO_UNIT,
    };
    let components = image.components as usize;
    let at = (y as usize * image.width as usize + x as usize) * components;
    let codes = &codes[at..at + components];
    match *codes {
        [r, g, b] => Vec4::new(color[r as usize], color[g as usize], color[b as usize], 1.0),
        [r, g, b, a] => {
            let alpha = CODE8_TO_UNIT[a as usize];
            Vec4::new(color[r as usize], color[g as usize], color[b as usize], alpha)
        }
        [gray, a] => Vec4::from((glam::Vec3::splat(color[gray as usize]), CODE8_TO_UNIT[a as usize])),
        [gray] => glam::Vec3::splat(color[gray as usize]).extend(1.0),
        _ => Vec4::ZERO,
    }
}

/// The bilinear value at a place in texels.
pub fn bilinear(image: &Image, transfer: Transfer, wrap: Wrap, at_texels: Vec2) -> Vec4 {
    filtered(image.size(), wrap, at_texels, |x, y| texel(image, transfer, x, y))
}

/// The bilinear mix of what `texel` gives.
#[inline]
fn filtered(size: [u32; 2], wrap: Wrap, at_texels: Vec2, texel: impl Fn(u32, u32) -> Vec4) -> Vec4 {
    let corner = at_texels - 0.5;
    let floor = corner.floor();
    let fraction = corner - floor;
    let (x, y) = (floor.x as i64, floor.y as i64);
    let columns = [wrap.s.apply(x, size[0]), wrap.s.apply(x + 1, size[0])];
    let rows = [wrap.t.apply(y, size[1]), wrap.t.apply(y + 1, size[1])];
    let top = texel(columns[0], rows[0]).lerp(texel(columns[1], rows[0]), fraction.x);
    let bottom = texel(columns[0], rows[1]).lerp(texel(columns[1], rows[1]), fraction.x);
    top.lerp(bottom, fraction.y)
}

/// The value of a mip-mapped texture at `uv` for a level of detail, as filtered.
pub fn sample_mip_maps(texture: &Texture<'_>, wrap: Wrap, uv: Vec2, lambda: f32, filter: Filter) -> Vec4 {
    between_levels(texture, lambda, filter, |level| {
        let image = texture.level(level as usize);
        let size = Vec2::new(image.width as f32, image.height as f32);
        bilinear(image, texture.transfer, wrap, uv * size)
    })
}

/// The value of a mesh color texture for a level of detail, as filtered; `place` gives where in the image of
/// a level, in texels.
pub fn sample_mesh_colors(
    texture: &Texture<'_>,
    place: impl Fn(u32) -> Vec2,
    lambda: f32,
    filter: Filter,
) -> Vec4 {
    between_levels(texture, lambda, filter, |level| {
        let place = place(level);
        let image = texture.level(level as usize);
        match texture.range(level as usize) {
            None => bilinear(image, texture.transfer, CLAMP, place),
            Some(range) => filtered(image.size(), CLAMP, place, |x, y| range.texel(image, x, y)),
        }
    })
}

fn between_levels(texture: &Texture<'_>, lambda: f32, filter: Filter, fetch: impl Fn(u32) -> Vec4) -> Vec4 {
    let level_count = texture.levels.len() as u32;
    let lambda = match filter {
        Filter::Trilinear => lambda,
        Filter::Level(level) => level as f32,
    };
    let pick = mct_pick(lambda, level_count);
    let finer = fetch(pick.finer);
    if pick.fraction > 0.0 { finer.lerp(fetch(pick.coarser), pick.fraction) } else { finer }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;
    use std::collections::BTreeMap;

    use super::*;
    use meshcolor::image::{LevelRange, WrapMode};

    /// A level in a range shows its values, not its codes as color.
    #[test]
    fn ranges_are_decoded_before_filtering() {
        let value = |x: u32, y: u32| x as f32 * 0.7 - y as f32 * 0.4 - 0.5;
        for range in [
            LevelRange::spanning(Vec4::new(-3.0, -3.0, -3.0, 0.0), Vec4::new(5.0, 5.0, 5.0, 1.0)),
            LevelRange::Float16,
        ] {
            let texels = (0..3).flat_map(|y| (0..4).map(move |x| (x, y)));
            let codes = texels.map(|(x, y)| range.encode(0, value(x, y))).collect();
            let coarse = Image { width: 4, height: 3, components: 1, pixels: Pixels::U16(codes) };
            let fine = Image { width: 4, height: 3, components: 1, pixels: Pixels::U8(vec![90; 12]) };
            let texture = Texture {
                transfer: Transfer::Srgb,
                levels: vec![Cow::Owned(fine), Cow::Owned(coarse)],
                ranges: BTreeMap::from([(1, range)]),
            };
            let place = |level: u32| crate::twins::mct_place(Vec4::new(2.0, 0.0, 0.75, 1.5), level);
            let shown = sample_mesh_colors(&texture, place, 0.0, Filter::Level(1));
            assert!((shown.x - 0.7 * 1.25 + 0.4 + 0.5).abs() < 1e-3, "{range:?}: {shown}");
            let fine = sample_mesh_colors(&texture, place, 0.0, Filter::Level(0));
            assert_eq!(fine.x, SRGB8_TO_LINEAR[90]);
        }
    }

    #[test]
    fn the_table_gives_what_the_core_gives() {
        for components in 1..=4_u8 {
            let codes = (0..5 * 3 * components as usize).map(|i| (i * 37 % 256) as u8).collect();
            let image = Image { width: 5, height: 3, components, pixels: Pixels::U8(codes) };
            for transfer in [Transfer::Srgb, Transfer::Linear] {
                for (step, mode) in [WrapMode::Repeat, WrapMode::MirroredRepeat, WrapMode::ClampToEdge]
                    .into_iter()
                    .enumerate()
                {
                    let wrap = Wrap { s: mode, t: WrapMode::Repeat };
                    let at = Vec2::new(-3.3 + 4.1 * step as f32, 7.7);
                    let expected = meshcolor::image::bilinear(&image, transfer, wrap, at);
                    assert!((bilinear(&image, transfer, wrap, at) - expected).abs().max_element() < 1e-6);
                }
            }
        }
    }
}
