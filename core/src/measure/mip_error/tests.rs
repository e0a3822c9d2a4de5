use super::*;
use crate::asset::{Asset, Slot};
use crate::finished::Finished;
use crate::image::Image;
use crate::measure::hand_made::{code_mut, finished, finished_by_triangle, image, square, surface_of};
use crate::measure::origin::{Origin, meaning};

const CUT: [bool; 1] = [true];
const JOINED: [bool; 1] = [false];

fn errors(slot: Slot, asset: &Asset, conversion: &Finished, cut_flags: &[bool]) -> Vec<MipError> {
    let surface = surface_of(asset, conversion);
    let origin = Origin::new(asset, &surface, slot, false).unwrap().unwrap();
    let converted = Converted::new(&surface, vec![&conversion.textures[0]], meaning(asset, 0, slot)).unwrap();
    let averages = Averages::new(&surface, 0, 256, 3);
    let found = averages.mip_errors(Original::Image(&origin), &converted, cut_flags);
    found.into_iter().map(|error| error.unwrap()).collect()
}

#[test]
fn a_constant_is_its_mean() {
    for slot in [Slot::Occlusion, Slot::BaseColor] {
        let asset = square(slot, image([32, 32], |_, _| [100; 3]));
        for level in errors(slot, &asset, &finished(slot, |_| [100; 3]), &JOINED) {
            assert!(level.rms < 1e-2 && level.reference_error < 1e-2, "{level:?}");
            assert_eq!(level.probe_count, 256);
        }
        // A level that is off by three codes is off by three codes.
        let three = errors(slot, &asset, &finished(slot, |_| [103; 3]), &JOINED);
        assert!(three.iter().all(|level| (level.rms - 3.0).abs() < 1e-2 && (level.p99 - 3.0).abs() < 1e-2));
    }
}

#[test]
fn one_broken_level_is_the_one_found() {
    let asset = square(Slot::Occlusion, image([32, 32], |_, _| [100; 3]));
    let mut broken = finished(Slot::Occlusion, |_| [100; 3]);
    *code_mut(&mut broken, 2, [0, 0], 1) += 60;
    let found = errors(Slot::Occlusion, &asset, &broken, &JOINED);
    assert!(found[0].rms < 1e-2 && found[1].rms > 3.0, "{found:?}");
}

#[test]
fn a_cut_keeps_its_sides_apart() {
    // Each triangle has a color of its own, in the source and at every level.
    let two = image([64, 64], |x, _| [if x < 32 { 40 } else { 200 }; 3]);
    let asset = square(Slot::Occlusion, two);
    let conversion =
        finished_by_triangle(Slot::Occlusion, |number, _| [if number == 0 { 40 } else { 200 }; 3]);
    let apart = errors(Slot::Occlusion, &asset, &conversion, &CUT);
    assert!(apart.iter().all(|level| level.rms < 1e-2), "{apart:?}");
    // Without the cut the mean near the diagonal is of both.
    let joined = errors(Slot::Occlusion, &asset, &conversion, &JOINED);
    assert!(joined.iter().all(|level| level.rms > 10.0), "{joined:?}");
}

#[test]
fn normals_are_averaged_as_vectors() {
    use crate::measure::hand_made::UPRIGHT;
    // Half the columns lean 45 degrees one way, half the other: on the whole they stand.
    let leaning = image([64, 64], |x, _| if x % 2 == 0 { [255, 128, 255] } else { [0, 128, 255] });
    let asset = square(Slot::Normal, leaning);
    let mut conversion = finished(Slot::Normal, |_| [128, 128, 255]);
    conversion.primitives[0].frames = vec![[UPRIGHT; 3]; 2];
    let upright = errors(Slot::Normal, &asset, &conversion, &JOINED);
    assert!(upright[1].rms < 6.0, "{upright:?}");
    let mut fallen = finished(Slot::Normal, |_| [255, 128, 255]);
    fallen.primitives[0].frames = vec![[UPRIGHT; 3]; 2];
    let fallen = errors(Slot::Normal, &asset, &fallen, &JOINED);
    assert!((fallen[1].rms - 45.0).abs() < 6.0, "{fallen:?}");
}

#[test]
fn what_cannot_be_seen_has_no_color() {
    use crate::asset::AlphaMode;
    use crate::image::Pixels;
    // White and opaque beside black and transparent, in squares of 16 texels.
    let is_seen = |x: usize, y: usize| (x / 16 + y / 16).is_multiple_of(2);
    let codes = (0..256 * 256).flat_map(|i| [if is_seen(i % 256, i / 256) { 255 } else { 0 }; 4]);
    let checker = Image { width: 256, height: 256, components: 4, pixels: Pixels::U8(codes.collect()) };
    let mut asset = square(Slot::BaseColor, checker);
    asset.materials[0].alpha_mode = AlphaMode::Blend;
    let mut conversion = finished(Slot::BaseColor, |_| [0; 3]);
    for level in &mut conversion.textures[0].levels {
        let count = level.texel_count();
        level.components = 4;
        level.pixels = Pixels::U8([255, 255, 255, 128].repeat(count));
    }
    let found = errors(Slot::BaseColor, &asset, &conversion, &JOINED);
    // The plain mean of the colors would be 67 codes darker.
    assert!(found[1].rms < 25.0, "{found:?}");
}

#[test]
fn threads_change_nothing() {
    let asset = square(Slot::Occlusion, image([128, 128], |x, y| [(x + y / 2) as u8; 3]));
    let conversion = finished(Slot::Occlusion, |at| [(60.0 + 90.0 * at.x) as u8; 3]);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| errors(Slot::Occlusion, &asset, &conversion, &JOINED))
    };
    assert_eq!(with(1), with(3));
}
