use super::*;
use crate::asset::{Asset, Slot};
use crate::image::Image;
use crate::measure::hand_made::{finished, image, square, surface_of};
use crate::measure::points::scatter;
use glam::Vec3;

fn measured(asset: &Asset, value: impl Fn(Vec3) -> [u8; 3], extent: Extent) -> Fidelity {
    let conversion = finished(Slot::Occlusion, value);
    let surface = surface_of(asset, &conversion);
    let origin = Origin::new(asset, &surface, Slot::Occlusion, false).unwrap().unwrap();
    let converted = Converted::new(&surface, vec![&conversion.textures[0]], Meaning::Data).unwrap();
    fidelity(
        &origin,
        &converted,
        &scatter(&surface, 4096),
        (extent, conversion.textures[0].levels[0].texel_count()),
    )
    .unwrap()
}

#[test]
fn a_constant_error_is_its_own_root_mean_square() {
    let asset = square(Slot::Occlusion, image([32, 32], |_, _| [100; 3]));
    let found = measured(&asset, |_| [103, 100, 100], Extent::Faces);
    assert!((found.rms - (9.0f64 / 3.0).sqrt()).abs() < 1e-4, "{found:?}");
    assert!((found.psnr_db - 10.0 * (255.0f64 * 255.0 / 3.0).log10()).abs() < 1e-3);
    assert_eq!((found.yardstick_psnr_db, found.point_count), (Some(99.0), 4096));
}

/// The image over its charts, whose value on the surface is `50 + 100 x + 50 y`.
fn smooth(gray: impl Fn(Vec3) -> f32) -> Image {
    image([256, 256], |x, y| {
        let (u, v) = ((x as f32 + 0.5) / 256.0, (y as f32 + 0.5) / 256.0);
        let chart = if u < 0.5 { 0.1 } else { 0.6 };
        [gray(Vec3::new((u - chart) / 0.3, (v - 0.2) / 0.6, 0.0)).round().clamp(0.0, 255.0) as u8; 3]
    })
}

#[test]
fn a_plane_survives_both() {
    let plane = |at: Vec3| 50.0 + 100.0 * at.x + 50.0 * at.y;
    let found = measured(&square(Slot::Occlusion, smooth(plane)), |at| [plane(at) as u8; 3], Extent::Faces);
    assert!(found.psnr_db > 50.0 && found.yardstick_psnr_db.unwrap() > 50.0, "{found:?}");
}

#[test]
fn the_yardstick_rises_with_its_texels_and_falls_with_detail() {
    let wave = |per_unit: f32| move |at: Vec3| 128.0 + 100.0 * (per_unit * (at.x + at.y)).sin();
    let with = |per_unit: f32, extent| {
        measured(&square(Slot::Occlusion, smooth(wave(per_unit))), |_| [0; 3], extent)
            .yardstick_psnr_db
            .unwrap()
    };
    assert!(with(2.0, Extent::Faces) > with(8.0, Extent::Faces) + 6.0);
    // The charts cover 18 % of the image: as many texels for all of it are fewer for them.
    assert!(with(2.0, Extent::Faces) > with(2.0, Extent::Image) + 6.0);
}

#[test]
fn points_follow_the_texels_within_bounds() {
    assert_eq!([0, 2048, 1 << 24].map(point_count), [1024, 2048, 65_536]);
}
