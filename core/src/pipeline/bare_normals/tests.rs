use glam::Vec3;

use crate::asset::Slot;
use crate::image::Pixels;
use crate::pipeline::tests::noise_asset;
use crate::pipeline::{Options, Sampling, Solver, convert_asset};
use crate::read::Limits;
use crate::watch::Unwatched;

/// A normal map that says nothing keeps saying nothing at every level, however the mesh bends.
#[test]
fn a_flat_map_stays_flat_down_to_the_last_level() {
    let mut asset = noise_asset(3, 6, Slot::Normal);
    asset.images[0].pixels = Pixels::U16([32_768, 32_768, 65_535].repeat(64 * 64));
    // As it is filtered, before any texel has to be brought into range.
    let options = Options { sampling: Sampling::Point, solver: Solver::Clamp, ..Options::default() };
    let conversion = convert_asset(asset, &options, &Limits::default(), &Unwatched).unwrap();
    let levels = &conversion.finished.textures[0].levels;
    assert!(levels.len() > 5);
    for (level, image) in levels.iter().enumerate() {
        let Pixels::U16(codes) = &image.pixels else { panic!("level {level} has 8 bits") };
        // Between two samples of a coarse edge a normal is shorter, not turned.
        let turned = codes.chunks(3).filter(|texel| **texel != [0; 3]).map(|texel| {
            let stored = Vec3::from_array([0, 1, 2].map(|k| f32::from(texel[k]) / 32_767.5 - 1.0));
            stored.angle_between(Vec3::Z).to_degrees()
        });
        let worst = turned.fold(0.0, f32::max);
        assert!(worst < 3.0, "level {level}: {worst} degrees");
    }
}
