//! Alpha coverage of masked materials, looked at where it is seen: between the samples too.

use glam::{Vec2, Vec3};
use meshcolor::asset::AlphaMode;
use meshcolor::finished::Finished;
use meshcolor::image::{Image, Pixels};
use meshcolor::pipeline::{Options, Resolution, convert_asset};
use meshcolor::read::{Limits, read};
use meshcolor::watch::Unwatched;
use meshcolor_tests::patches::{Patch, Random};
use meshcolor_tests::reading::shown_alpha;

/// Share of the surface in texture space whose alpha passes the cutoff, by level.
fn coverage(finished: &Finished, cutoff: f32) -> Vec<f32> {
    const POINTS: usize = 40;
    let share = |level: &Image, number: usize| {
        let (mut passed, mut all) = (0, 0);
        let piece = &finished.primitives[0];
        for triangle in 0..piece.triangles.len() {
            for (i, j) in (0..POINTS).flat_map(|j| (0..POINTS - j).map(move |i| (i, j))) {
                let [s, t] = [i, j].map(|k| (k as f32 + 0.33) / POINTS as f32);
                let place = piece.place_at(triangle, Vec3::new(1.0 - s - t, s, t), number);
                all += 1;
                passed += usize::from(shown_alpha(level, place) >= cutoff);
            }
        }
        passed as f32 / all as f32
    };
    finished.textures[0].levels.iter().enumerate().map(|(number, level)| share(level, number)).collect()
}

/// Coverage by level of a picture with leaves on a third of its surface, which averaged are under the
/// cutoff everywhere.
fn coverage_of_leaves(mode: AlphaMode, name: &str) -> Vec<f32> {
    let mut random = Random::new(8);
    let is_leaf: Vec<bool> = (0..32 * 32).map(|_| random.below(3) == 0).collect();
    let leaf = |k: usize| is_leaf[k / 128 / 4 * 32 + k % 128 / 4];
    let codes = (0..128 * 128).flat_map(|k| [40, 120, 30, if leaf(k) { 255 } else { 0 }]).collect();
    let picture = Image { width: 128, height: 128, components: 4, pixels: Pixels::U8(codes) };
    let patch = Patch::grid(&mut random, 2, |_, _, [x, y]| Vec2::new(x as f32, y as f32) * 0.5);
    let mut asset = read(&patch.upload(&picture), &Limits::default(), &Unwatched).unwrap();
    asset.materials[0].alpha_mode = mode;
    asset.document.json["materials"][0]["alphaMode"] = name.into();
    let options = Options { resolution: Resolution::Fixed(6), ..Options::default() };
    coverage(&convert_asset(asset, &options, &Limits::default(), &Unwatched).unwrap().finished, LEAF_CUTOFF)
}

const LEAF_CUTOFF: f32 = 0.6;

#[test]
fn a_mask_keeps_most_of_what_averaging_loses() {
    let masked = coverage_of_leaves(AlphaMode::Mask(LEAF_CUTOFF), "MASK");
    let averaged = coverage_of_leaves(AlphaMode::Blend, "BLEND");
    assert_eq!(masked[0], averaged[0]);
    for level in 1..=4 {
        let (kept, left) = (masked[level] / masked[0], averaged[level] / masked[0]);
        let regained = (kept - left) / (1.0 - left);
        // Alpha of level 1 comes in few steps here, so that no factor meets the share exactly.
        assert!(regained > 0.4 && kept > 0.45, "level {level}: {masked:?}, {averaged:?}");
    }
}

#[test]
fn a_mask_keeps_its_coverage() {
    let masked = coverage_of_leaves(AlphaMode::Mask(LEAF_CUTOFF), "MASK");
    for (level, share) in masked.iter().enumerate().take(5) {
        assert!((share - masked[0]).abs() < 0.05, "level {level}: {masked:?}");
    }
}
