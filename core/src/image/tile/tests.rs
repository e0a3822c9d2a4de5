use glam::{Vec2, Vec4};

use super::Tile;
use crate::image::{Image, Pixels, Transfer, Wrap, WrapMode, bilinear};

/// A tile shows what single fetches show, for every kind of image, inside and outside of it.
#[test]
fn a_tile_agrees_with_single_fetches() {
    let modes = [WrapMode::Repeat, WrapMode::MirroredRepeat, WrapMode::ClampToEdge];
    let kinds = (1u8..=4).flat_map(|components| [(components, false), (components, true)]);
    for (number, (components, is_wide)) in kinds.enumerate() {
        let codes = (0..7 * 5 * usize::from(components)).map(|k| (k * 89 + number * 31) % 251);
        let pixels = if is_wide {
            Pixels::U16(codes.map(|code| code as u16 * 257).collect())
        } else {
            Pixels::U8(codes.map(|code| code as u8).collect())
        };
        let image = Image { width: 7, height: 5, components, pixels };
        let wrap = Wrap { s: modes[number % 3], t: modes[number / 3 % 3] };
        let transfer = if number % 2 == 0 { Transfer::Srgb } else { Transfer::Linear };
        for (least, most) in [([-9.0, 3.2], [-2.5, 14.0]), ([2.5, 2.5], [4.5, 3.0]), ([0.0, 0.0], [7.0, 5.0])]
        {
            let (least, most) = (Vec2::from(least), Vec2::from(most));
            let mut tile = Tile::default();
            tile.fill(&image, transfer, wrap, least, most);
            for k in 0..=20 {
                let share = Vec2::new(k as f32 / 20.0, (k * 7 % 21) as f32 / 20.0);
                let place = least + (most - least) * share;
                let (found, wanted) =
                    (tile.bilinear(place - tile.offset()), bilinear(&image, transfer, wrap, place));
                let difference = (found - wanted).abs();
                assert!(difference.cmplt(Vec4::splat(1e-5)).all(), "{components} {place}: {found}, {wanted}");
            }
        }
    }
}
