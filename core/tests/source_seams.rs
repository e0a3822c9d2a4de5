//! The seams of real models with ordinary mip maps, held against figures that were measured by another
//! program in another language.

use std::collections::BTreeMap;
use std::path::PathBuf;

use meshcolor::measure::{self, ChannelReport, Measured};
use meshcolor::read::{Limits, MemoryFiles, Upload, read};
use meshcolor::watch::Unwatched;

/// The model's seams, or `None` without the folder of models.
fn seams_of(path: &str) -> Option<Measured> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets");
    let folder = std::env::var_os("MESHCOLOR_ASSETS").map_or_else(|| PathBuf::from(beside), PathBuf::from);
    let main = folder.join(path);
    if !main.is_file() {
        println!("skipped: {path} (no model folder)");
        return None;
    }
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(main.parent().unwrap()).unwrap() {
        let entry = entry.unwrap();
        if entry.file_type().unwrap().is_file() {
            files.insert(entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap());
        }
    }
    let main = main.file_name().unwrap().to_str().unwrap().to_owned();
    let upload = Upload { main, files: Box::new(MemoryFiles(files)) };
    let asset = read(&upload, &Limits::default(), &Unwatched).unwrap();
    Some(measure::source(&asset, &Unwatched).unwrap())
}

fn assert_means(channel: &ChannelReport, means: &[f64], tolerance: f64) {
    for (level, mean) in channel.levels.iter().zip(means) {
        let found = level.seams.unwrap().mean;
        assert!(
            (found - mean).abs() <= tolerance,
            "{:?} level {}: {found}, not {mean}",
            channel.slots,
            level.level
        );
    }
}

#[test]
fn the_helmet_comes_apart_as_it_did_elsewhere() {
    let Some(measured) = seams_of("DamagedHelmet.glb") else { return };
    let slots: Vec<_> = measured.channels.iter().map(|channel| channel.slots.join(" ")).collect();
    let expected = ["baseColor", "metallicRoughness", "normal", "occlusion", "emissive"];
    assert_eq!(slots, expected.map(|name| format!("{name}Texture")));
    let [base, metal_rough, normal, occlusion, _] = &measured.channels[..] else { panic!() };
    // 3494 edges of two faces, and seven of more.
    assert_eq!(base.cuts.seam_edge_count, 3501);
    assert!((base.cuts.seam_share - 0.133).abs() < 0.001);
    // The other program filtered stored values: data agrees at every level, color at the finest.
    assert_means(base, &[58.7], 0.1);
    assert_means(metal_rough, &[100.6, 99.9, 98.8, 97.2, 91.7, 82.8, 73.4], 0.06);
    assert_means(occlusion, &[38.1, 37.2, 36.4, 36.2, 36.3, 35.0, 31.9], 0.06);
    for (channel, agreeing) in [(base, 4.0), (metal_rough, 4.0), (occlusion, 4.0), (normal, 2.0)] {
        assert!(channel.levels[0].drift.unwrap() <= agreeing);
    }
    assert!(base.levels[5].drift.unwrap() > 12.0 && occlusion.levels[5].drift.unwrap() > 10.0);
}

#[test]
fn the_cow_agrees_with_itself_at_full_resolution_alone() {
    let Some(measured) = seams_of("spot/spot_fine.obj") else { return };
    let [base] = &measured.channels[..] else { panic!() };
    assert_eq!(base.cuts.seam_edge_count, 288);
    assert_means(base, &[0.04, 0.14], 0.015);
    assert!((base.cuts.seam_share - 0.031).abs() < 0.001);
    let drift: Vec<f64> = base.levels.iter().map(|level| level.drift.unwrap()).collect();
    assert!(drift[0] < 0.1 && drift[3] > 1.0 && drift[5] > 5.0, "{drift:?}");
}
