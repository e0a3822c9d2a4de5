use glam::Vec3;
use proptest::prelude::*;

use super::*;
use crate::asset::Slot;
use crate::measure::hand_made::{finished, image, square, surface_of};

#[test]
fn lone_triangles_use_half_a_block_and_their_border() {
    let asset = square(Slot::Occlusion, image([4, 4], |_, _| [0; 3]));
    let conversion = finished(Slot::Occlusion, |_| [0; 3]);
    let surface = surface_of(&asset, &conversion);
    let [report] = &reports(&asset, &conversion, tallies(&surface).unwrap(), &[])[..] else { panic!() };
    // 15 samples and 4 border texels, twice, of 50; 6 and 2 of 18; 3 and 1 of 8.
    let waste: Vec<f64> = report.levels.iter().map(|level| level.waste).collect();
    assert_eq!(waste, vec![1.0 - 38.0 / 50.0, 1.0 - 16.0 / 18.0, 0.0]);
    assert_eq!((report.face_count, report.merged_pair_count, report.lone_triangle_count), (2, 0, 2));
    assert_eq!(report.exponents, vec![0, 0, 2]);
    assert_eq!(report.levels[1].allocated_texels, 18);
}

#[test]
fn a_merged_pair_is_told_by_its_texels() {
    let asset = square(Slot::Occlusion, image([4, 4], |_, _| [0; 3]));
    let mut conversion = finished(Slot::Occlusion, |_| [0; 3]);
    let [first, second] = &mut conversion.primitives[0].triangles[..] else { panic!() };
    second.corners = [Vec2::splat(4.0), first.corners[2], first.corners[1]];
    second.anchor = first.anchor;
    let surface = surface_of(&asset, &conversion);
    let [report] = &reports(&asset, &conversion, tallies(&surface).unwrap(), &[])[..] else { panic!() };
    assert_eq!((report.merged_pair_count, report.lone_triangle_count, report.quad_count), (1, 0, 0));
    assert_eq!(report.levels[0].waste, 1.0 - 25.0 / 50.0);
}

#[test]
fn runs_cross_words_and_stop_at_the_border() {
    let mut mask = Mask::new([130, 3]);
    mask.fill(1, -7.0, 500.0);
    assert_eq!(mask.count(), 130);
    mask.fill(0, 63.0, 64.0);
    mask.fill(0, 5.0, 4.0);
    assert_eq!(mask.count(), 132);
}

#[test]
fn far_and_flat_triangles_end() {
    let mut mask = Mask::new([8, 8]);
    mask.mark([Vec2::splat(-1e30), Vec2::splat(1e30), Vec2::new(1e30, -1e30)]);
    mask.mark([Vec2::splat(3.5); 3]);
    let mut point = Mask::new([8, 8]);
    point.mark([Vec2::splat(3.5); 3]);
    assert_eq!(point.count(), 1);
    let mut line = Mask::new([8, 8]);
    line.mark([Vec2::new(1.5, 2.5), Vec2::new(4.5, 2.5), Vec2::new(2.5, 2.5)]);
    assert_eq!(line.count(), 4);
}

proptest! {
    /// A texel is marked where bilinear filtering inside the triangle weighs it, and nowhere else.
    #[test]
    fn marks_are_the_texels_that_filtering_weighs(places in prop::array::uniform6(2u32..28)) {
        let at = |k: usize| Vec2::new(places[2 * k] as f32, places[2 * k + 1] as f32) / 2.0;
        let corners = [at(0), at(1), at(2)];
        let mut mask = Mask::new([16, 16]);
        mask.mark(corners);
        let mut weights = [[0.0f32; 16]; 16];
        let steps = 96;
        for i in 0..=steps {
            for j in 0..=steps - i {
                let at = Vec3::new(i as f32, j as f32, (steps - i - j) as f32) / steps as f32;
                let place = corners[0] * at.x + corners[1] * at.y + corners[2] * at.z - 0.5;
                for (y, row) in weights.iter_mut().enumerate() {
                    for (x, weight) in row.iter_mut().enumerate() {
                        let apart = (place - Vec2::new(x as f32, y as f32)).abs();
                        *weight = weight.max((1.0 - apart.x).max(0.0) * (1.0 - apart.y).max(0.0));
                    }
                }
            }
        }
        for (y, row) in weights.iter().enumerate() {
            for (x, &weight) in row.iter().enumerate() {
                let is_marked = mask.words[y * mask.words_per_row] >> x & 1 == 1;
                // Between the steps of the sweep a weight can be small and still there.
                prop_assert!(is_marked || weight < 1e-4, "({x}, {y}) weighs {weight}");
                prop_assert!(!is_marked || weight > 0.0 || near(corners, x, y), "({x}, {y}) weighs nothing");
            }
        }
    }
}

/// Whether the texel's reach comes within a step of the sweep of the triangle.
fn near(corners: [Vec2; 3], x: usize, y: usize) -> bool {
    let center = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
    let fine = 1000;
    (0..3).any(|k| {
        (0..=fine).any(|step| {
            let place = corners[k].lerp(corners[(k + 1) % 3], step as f32 / fine as f32);
            (place - center).abs().max_element() < 1.0
        })
    })
}
