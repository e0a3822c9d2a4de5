mod parts;

use glam::{Vec2, Vec3, Vec4};

use super::*;
use crate::error::ErrorCode;
use crate::finished::{Anchor, Frame, hand_made};
use crate::image::Pixels;
use crate::measure::hand_made::{EXPONENT, UPRIGHT, code_mut, finished, finished_by_triangle, image, square};
use crate::measure::report::{CoordinatesKind, SubjectKind, TableReport, Verdict};
use crate::measure::verdict::judge;
use crate::watch::Unwatched;

/// Whole codes at every sample of every level.
fn ramp(at: Vec3) -> [u8; 3] {
    [(40.0 * at.x + 80.0 * at.y) as u8, 100, (200.0 - 60.0 * at.x) as u8]
}

fn measured(asset: &Asset, finished: &Finished) -> Measured {
    converted(asset, finished, &[], &Extras::default(), &Unwatched).unwrap()
}

fn flat(code: u8) -> Image {
    image([64, 64], |_, _| [code; 3])
}

#[test]
fn a_seamless_pair_has_no_seams() {
    let asset = square(Slot::Occlusion, flat(9));
    let result = measured(&asset, &finished(Slot::Occlusion, ramp));
    let [channel] = &result.channels[..] else { panic!() };
    assert_eq!(channel.levels.len(), EXPONENT + 1);
    for level in &channel.levels {
        let seams = level.seams.unwrap();
        assert!(seams.max < 1e-3, "level {}: {seams:?}", level.level);
        assert_eq!(seams.sample_count, 19);
    }
    assert_eq!(judge(SubjectKind::Converted, &result.channels).verdict, Verdict::Pass);
    assert_eq!((channel.cuts.seam_edge_count, channel.cuts.welded_share), (1, 1.0));
}

#[test]
fn a_broken_texel_is_found_with_its_size_at_its_level() {
    let asset = square(Slot::Occlusion, flat(9));
    for (level, texel) in [(0, [2, 2]), (1, [1, 1]), (2, [1, 0]), (0, [4, 0])] {
        let mut broken = finished(Slot::Occlusion, ramp);
        *code_mut(&mut broken, level, texel, 2) += 10;
        let result = measured(&asset, &broken);
        for found in &result.channels[0].levels {
            let max = found.seams.unwrap().max;
            let expected = if found.level == level as u32 { 10.0 } else { 0.0 };
            assert!((max - expected).abs() < 1e-3, "level {} of {level}: {max}", found.level);
        }
        let judgement = judge(SubjectKind::Converted, &result.channels);
        assert_eq!(judgement.verdict, Verdict::Fail);
        assert_eq!(judgement.errors.len(), 1);
        assert!(judgement.errors[0].contains(&format!("level {level}:")), "{:?}", judgement.errors);
    }
    // A texel that no filtering of the edge reads is not a seam.
    let mut elsewhere = finished(Slot::Occlusion, ramp);
    *code_mut(&mut elsewhere, 0, [0, 0], 2) += 10;
    assert!(measured(&asset, &elsewhere).channels[0].levels[0].seams.unwrap().max < 1e-3);
}

#[test]
fn color_is_filtered_in_linear_light() {
    // The exact border value of the diagonal in linear light is not the one in codes.
    let codes = |triangle: usize, at: Vec3| {
        let slope = if triangle == 0 { 100.0 } else { 0.0 };
        [(148.0 - 40.0 * at.x + slope * (at.x + at.y - 1.0)) as u8; 3]
    };
    let with = |slot| measured(&square(slot, flat(9)), &finished_by_triangle(slot, codes));
    let (in_codes, in_data) = (with(Slot::BaseColor), with(Slot::Occlusion));
    let coarsest = |measured: &Measured| measured.channels[0].levels[EXPONENT].seams.unwrap().max;
    assert!(coarsest(&in_codes) > 1.5, "{}", coarsest(&in_codes));
    assert!(coarsest(&in_data) < 1e-3, "{}", coarsest(&in_data));
}

#[test]
fn cut_edges_are_left_out_whichever_side_says_so() {
    let asset = square(Slot::Occlusion, flat(9));
    for bits in [vec![2, 0], vec![0, 2], vec![2, 2]] {
        let mut cut = finished(Slot::Occlusion, ramp);
        *code_mut(&mut cut, 0, [2, 2], 2) += 10;
        cut.primitives[0].cuts[0].bits = bits;
        let result = measured(&asset, &cut);
        let channel = &result.channels[0];
        assert_eq!(channel.levels[0].seams, None);
        // Drift knows no cuts.
        assert!(channel.levels[0].drift.unwrap() > 0.5);
        assert_eq!((channel.cuts.cut_edge_count, channel.cuts.cut_share), (1, 1.0));
        assert_eq!(result.focus, None);
    }
}

#[test]
fn a_constant_texture_does_not_drift() {
    let asset = square(Slot::BaseColor, flat(77));
    let result = measured(&asset, &finished(Slot::BaseColor, |_| [77; 3]));
    for level in &result.channels[0].levels {
        let source = level.source.unwrap();
        assert_eq!((level.drift, source.drift), (Some(0.0), Some(0.0)));
        assert_eq!(source.seams.unwrap().max, 0.0);
        assert_eq!(source.size, [64 >> level.level; 2]);
    }
    let fidelity = result.channels[0].fidelity.unwrap();
    assert_eq!((fidelity.psnr_db, fidelity.rms, fidelity.yardstick_psnr_db), (99.0, 0.0, Some(99.0)));
}

/// Both charts white at their common edge, the image black left of its middle and gray right of it.
fn gutters() -> Image {
    image([64, 64], |x, y| {
        let (u, v) = ((x as f32 + 0.5) / 64.0, (y as f32 + 0.5) / 64.0);
        // Both diagonals run from the lower right to the upper left of their chart.
        let left = (u - 0.1) / 0.3 + (v - 0.2) / 0.6 - 1.0;
        let right = (u - 0.6) / 0.3 + (v - 0.2) / 0.6 - 1.0;
        let [near, behind] = if u < 0.5 { [left, 0.0] } else { [right, 120.0] };
        [if near.abs() < 0.25 { 250 } else { behind as u8 }; 3]
    })
}

#[test]
fn ordinary_mips_come_apart_and_the_conversion_does_not() {
    let asset = square(Slot::BaseColor, gutters());
    let result = measured(&asset, &finished(Slot::BaseColor, |_| [250; 3]));
    let levels = &result.channels[0].levels;
    let source: Vec<f64> = levels.iter().map(|level| level.source.unwrap().drift.unwrap()).collect();
    assert!(source[0] < 1.0 && source[2] > source[0], "{source:?}");
    assert!(levels.iter().all(|level| level.drift == Some(0.0)));
    let focus = result.focus.unwrap();
    assert_eq!((focus.mesh, focus.primitive, focus.texture), (0, 0, 0));
    assert_eq!((focus.position, focus.normal), (Vec3::new(0.5, 0.5, 0.0), Vec3::Z));
    assert!(focus.source_jumps_codes[4] > 8.0, "{focus:?}");
    let plain = super::source(&asset, &Unwatched).unwrap();
    assert_eq!(plain.channels[0].levels.len(), 7);
    assert_eq!(plain.channels[0].levels[2].drift, levels[2].source.unwrap().drift);
    assert_eq!(plain.channels[0].cuts.seam_share, 1.0);
}

#[test]
fn a_painted_seam_is_no_drift() {
    let halves = image([64, 64], |x, _| [if x < 32 { 10 } else { 200 }; 3]);
    let asset = square(Slot::BaseColor, halves);
    let result = measured(&asset, &finished(Slot::BaseColor, |_| [77; 3]));
    let source = result.channels[0].levels[0].source.unwrap();
    assert_eq!((result.channels[0].levels[0].drift, source.drift, result.focus), (None, None, None));
    assert_eq!(source.seams.unwrap().mean, 190.0);
}

#[test]
fn normals_are_judged_in_the_frames_that_they_stand_in() {
    let asset = square(Slot::Normal, image([8, 8], |_, _| [128, 128, 255]));
    let mut tilted = finished(Slot::Normal, |_| [255, 128, 255]);
    let turned = Frame { tangent: Vec4::new(0.0, 1.0, 0.0, 1.0), ..UPRIGHT };
    tilted.primitives[0].frames = vec![[UPRIGHT; 3], [turned; 3]];
    let result = measured(&asset, &tilted);
    let channel = &result.channels[0];
    assert_eq!(channel.unit, Unit::Degrees);
    // (1, 0, 1) and (0, 1, 1) enclose 60 degrees; the middle code 128 is not quite 0.
    assert!((channel.levels[0].seams.unwrap().max - 60.0).abs() < 0.5);
    assert!((channel.fidelity.unwrap().rms - 45.0).abs() < 0.5);
    let judgement = judge(SubjectKind::Converted, &result.channels);
    assert_eq!((judgement.verdict, judgement.max_seam_delta_codes), (Verdict::Warn, 0.0));
    tilted.primitives[0].frames = vec![[UPRIGHT; 3]; 2];
    assert!(measured(&asset, &tilted).channels[0].levels[0].seams.unwrap().max < 0.01);
}

#[test]
fn a_file_is_measured_without_a_source() {
    let asset = square(Slot::Occlusion, flat(9));
    let mut broken = finished(Slot::Occlusion, ramp);
    *code_mut(&mut broken, 1, [1, 1], 0) += 4;
    let result = converted_file(&asset, &broken, &Unwatched).unwrap();
    let channel = &result.channels[0];
    assert!((channel.levels[1].seams.unwrap().max - 4.0).abs() < 1e-3);
    assert_eq!((channel.fidelity, channel.levels[1].source, channel.levels[1].drift), (None, None, None));
    assert_eq!(result.layouts[0].levels[0].efficiency, None);
}

#[test]
fn extras_are_copied_and_counted() {
    let asset = square(Slot::Occlusion, flat(9));
    let extras = Extras {
        sample_counts: vec![SampleCounts { material: 0, part: 0, levels: vec![25, 9, 4] }],
        channels: vec![ChannelExtras {
            material: 0,
            slots: vec![Slot::Occlusion],
            solver: vec![SolverReport { level: 1, row_count: 7, ..SolverReport::default() }],
            stored: Vec::new(),
        }],
        ..Extras::default()
    };
    let result = converted(&asset, &finished(Slot::Occlusion, ramp), &[], &extras, &Unwatched).unwrap();
    assert_eq!(result.channels[0].solver[0].row_count, 7);
    assert_eq!(result.layouts[0].levels[0].efficiency, Some(25.0 / 50.0));
}

#[test]
fn nonsense_is_refused_in_words() {
    let asset = square(Slot::Normal, flat(9));
    let made = || finished(Slot::Normal, ramp);
    let refused = |finished: &Finished| converted_file(&asset, finished, &Unwatched).unwrap_err().code;
    assert_eq!(refused(&made()), ErrorCode::InvalidModel);
    let mut outside = made();
    outside.primitives[0].triangles[1].vertices[0] = 6;
    assert_eq!(refused(&outside), ErrorCode::InvalidModel);
    let mut elsewhere = made();
    elsewhere.primitives[0].mesh = 1;
    assert_eq!(refused(&elsewhere), ErrorCode::InvalidModel);
    let offset = |x: f32| Anchor::Offset(Vec2::new(x, 0.5));
    let mut endless = made();
    endless.primitives[0].triangles[0].anchor = offset(f32::NAN);
    assert_eq!(refused(&endless), ErrorCode::InvalidModel);
    endless.primitives[0].triangles[0].anchor = offset(1e30);
    assert_eq!(refused(&endless), ErrorCode::InvalidModel);
    let mut far = finished(Slot::Occlusion, ramp);
    far.primitives[0].triangles[0].anchor = offset(-1e8);
    far.primitives[0].cuts[0].bits.clear();
    assert!(converted_file(&asset, &far, &Unwatched).is_ok());
}

#[test]
fn cancel_reaches_in() {
    struct Impatient;
    impl Watch for Impatient {
        fn canceled(&self) -> bool {
            true
        }
    }
    let asset = square(Slot::BaseColor, flat(9));
    let conversion = finished(Slot::BaseColor, ramp);
    let error = converted(&asset, &conversion, &[], &Extras::default(), &Impatient).unwrap_err();
    assert_eq!(error.code, ErrorCode::Canceled);
    assert_eq!(super::source(&asset, &Impatient).unwrap_err().code, ErrorCode::Canceled);
}

#[test]
fn threads_change_nothing() {
    let asset = square(Slot::BaseColor, gutters());
    let conversion = finished(Slot::BaseColor, ramp);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| measured(&asset, &conversion))
    };
    let (one, four) = (with(1), with(4));
    assert_eq!((one.channels, one.layouts, one.focus), (four.channels, four.layouts, four.focus));
}

/// Indexed coordinates, with a face of each kind of block.
#[test]
fn a_sheet_with_indexed_coordinates_has_no_seam_at_any_level() {
    let (asset, mut sheet) = hand_made::sheet();
    let result = measured(&asset, &sheet);
    let channel = &result.channels[0];
    for level in &channel.levels {
        assert!(level.seams.unwrap().max < 1e-2, "{level:?}");
        assert!(level.seams.unwrap().sample_count > 19 * 10);
        // No face is beyond vertex colors in the sense that texels are extrapolated.
        assert_eq!(level.seams_8bit_weights, None);
    }
    assert!(channel.fidelity.unwrap().psnr_db > 45.0, "{:?}", channel.fidelity);
    let layout = &result.layouts[0];
    assert_eq!((layout.face_count, layout.quad_count), (11, 7));
    assert_eq!((layout.merged_pair_count, layout.lone_triangle_count), (1, 2));
    assert_eq!(layout.exponents, vec![0, 4, 4, 3]);
    assert_eq!(layout.coordinates, CoordinatesKind::Indexed);
    assert_eq!(layout.table, Some(TableReport { class_count: 6, byte_count: 6 * (32 + 6 * 16) }));
    let white = |image: &Image| {
        let Pixels::U8(codes) = &image.pixels else { panic!("8 bits") };
        codes.chunks(3).filter(|texel| *texel == [255; 3]).count() as f64 / image.texel_count() as f64
    };
    for (level, image) in layout.levels.iter().zip(&sheet.textures[0].levels) {
        assert!((level.waste - white(image)).abs() < 1e-9, "{level:?}");
    }

    // One code at a corner of the larger block, at a level far beyond vertex colors.
    let table = hand_made::table();
    let [x, y] = table.levels[5].origins[4];
    *code_mut(&mut sheet, 5, [x as usize + 1, y as usize], 0) += 9;
    let levels = &measured(&asset, &sheet).channels[0].levels;
    assert!((levels[5].seams.unwrap().max - 9.0).abs() < 1e-3 && levels[4].seams.unwrap().max < 1e-2);
    let anchor = Anchor::Block { class: 4, number: 99 };
    sheet.primitives[0].triangles[0].anchor = anchor;
    assert_eq!(converted_file(&asset, &sheet, &Unwatched).unwrap_err().code, ErrorCode::InvalidModel);
}
