//! Materials in parts, and materials that share their textures.

use super::*;
use crate::finished::PrimitiveCuts;
use crate::image::Pixels;

/// The second triangle in a part of its own, with images of another size.
fn in_parts(whole: &Finished) -> Finished {
    let mut finished = hand_made::split(whole, |triangle| triangle.vertices[0] == 5);
    for image in &mut finished.textures[1].levels {
        *image = image_with_row_below(image);
    }
    finished
}

fn image_with_row_below(image: &Image) -> Image {
    let Pixels::U8(codes) = &image.pixels else { panic!("8 bits") };
    let row = vec![255; image.width as usize * 3];
    let codes = codes.iter().copied().chain(row).collect();
    Image { height: image.height + 1, pixels: Pixels::U8(codes), ..*image }
}

#[test]
fn parts_are_judged_as_the_whole() {
    for slot in [Slot::Occlusion, Slot::BaseColor] {
        let asset = square(slot, gutters());
        let whole = finished(slot, ramp);
        let finished = in_parts(&whole);
        let [whole, parts] = [&whole, &finished].map(|finished| measured(&asset, finished));
        let [one, both] = [&whole, &parts].map(|measured| &measured.channels[0]);
        assert_eq!((parts.channels.len(), parts.layouts.len()), (1, 2));
        assert_eq!(both.cuts, one.cuts);
        for (both, one) in both.levels.iter().zip(&one.levels) {
            assert_eq!((both.seams, both.drift, both.mip_error), (one.seams, one.drift, one.mip_error));
        }
        // Points are as many as texels, and the yardstick has as many: 50 of the first and 60 of the second.
        let [of_one, of_both] = [one, both].map(|channel| channel.fidelity.unwrap());
        assert_eq!(of_both.point_count, of_one.point_count);
        assert_eq!((of_both.psnr_db, of_both.max), (of_one.psnr_db, of_one.max));
        assert!(
            of_both.yardstick_psnr_db.unwrap() > of_one.yardstick_psnr_db.unwrap() + 1.0,
            "{of_both:?} {of_one:?}"
        );
        assert_eq!(parts.focus.unwrap().position, whole.focus.unwrap().position);
        // 19 texels of each are read.
        let texels =
            |layout: &LayoutReport| (layout.part, layout.face_count, layout.levels[0].allocated_texels);
        assert_eq!(parts.layouts.iter().map(texels).collect::<Vec<_>>(), [(0, 1, 50), (1, 1, 60)]);
        assert_eq!(parts.layouts[1].levels[0].waste, 1.0 - 19.0 / 60.0);
    }
}

#[test]
fn a_seam_between_parts_is_found() {
    let asset = square(Slot::Occlusion, flat(9));
    let mut broken = in_parts(&finished(Slot::Occlusion, ramp));
    // The second block's corner on the diagonal.
    let Pixels::U8(codes) = &mut broken.textures[1].levels[1].pixels else { panic!("8 bits") };
    let width = 6;
    let [column, row] = [5, 0];
    codes[(row * width + column) * 3] += 7;
    let result = measured(&asset, &broken);
    let seams: Vec<f64> = result.channels[0].levels.iter().map(|level| level.seams.unwrap().max).collect();
    assert!(seams[0] < 1e-3 && (seams[1] - 7.0).abs() < 1e-3 && seams[2] < 1e-3, "{seams:?}");
    // Said to be a cut by the side in the second part.
    broken.primitives[1].cuts = vec![PrimitiveCuts { texture: 1, bits: vec![0b010] }];
    assert_eq!(measured(&asset, &broken).channels[0].levels[1].seams, None);
}

#[test]
fn parts_that_contradict_each_other_are_refused() {
    let asset = square(Slot::Occlusion, flat(9));
    let sound = in_parts(&finished(Slot::Occlusion, ramp));
    type Change = fn(&mut Finished);
    let changes: [(Change, &str); 5] = [
        (|finished| drop(finished.textures[1].levels.pop()), "same channels"),
        (|finished| finished.textures[1].slots = vec![Slot::Emissive], "same channels"),
        (|finished| finished.primitives[1].part = 2, "has no texture"),
        (|finished| finished.textures[0].materials.clear(), "ascending materials"),
        (
            |finished| finished.primitives[1].triangles[0].vertices = [0, 1, 3],
            "not those of the asset's faces",
        ),
    ];
    for (change, rule) in changes {
        let mut finished = sound.clone();
        change(&mut finished);
        let error = converted(&asset, &finished, &[], &Extras::default(), &Unwatched).unwrap_err();
        assert!(error.detail.contains(rule), "{error}");
    }
}

/// The two triangles as primitives of two materials that share their textures.
fn shared_by_two() -> (Asset, Finished) {
    let mut asset = square(Slot::Occlusion, gutters());
    let mut whole = finished(Slot::Occlusion, ramp);
    let mut other = asset.meshes[0].primitives[0].clone();
    other.material = Some(1);
    other.faces.remove(0);
    asset.meshes[0].primitives[0].faces.truncate(1);
    asset.meshes[0].primitives.push(other);
    asset.materials.push(asset.materials[0].clone());
    whole.textures[0].materials = vec![0, 1];
    let mut second = whole.primitives[0].clone();
    (second.primitive, second.material) = (1, 1);
    second.triangles.remove(0);
    second.cuts.clear();
    whole.primitives[0].triangles.truncate(1);
    whole.primitives[0].cuts.clear();
    whole.primitives.push(second);
    (asset, whole)
}

#[test]
fn materials_that_share_textures_are_judged_each_with_its_share() {
    let (asset, finished) = shared_by_two();
    let counts = |material: usize| SampleCounts { material, part: 0, levels: vec![15, 6, 3] };
    let extras = Extras { sample_counts: vec![counts(0), counts(1)], ..Extras::default() };
    let result = converted(&asset, &finished, &[], &extras, &Unwatched).unwrap();
    let [layout] = &result.layouts[..] else { panic!("one set") };
    assert_eq!((layout.material, &layout.materials[..], layout.face_count), (0, &[0, 1][..], 2));
    assert_eq!((layout.levels[0].allocated_texels, layout.levels[0].efficiency), (50, Some(30.0 / 50.0)));
    assert_eq!(layout.levels[0].waste, 1.0 - 38.0 / 50.0);
    let materials: Vec<usize> = result.channels.iter().map(|channel| channel.material).collect();
    assert_eq!(materials, [0, 1]);
    // The two meet at an edge, but nothing is promised there.
    assert!(result.channels.iter().all(|channel| channel.levels[0].seams.is_none()));
    // Each has half of the texels, as both triangles are of one size.
    let texels = |material: usize| Channel::all(&finished, material)[0].texel_count;
    assert_eq!([texels(0), texels(1)], [25, 25]);
    // What is not known of one of them is not known of both.
    let extras = Extras { sample_counts: vec![counts(0)], ..Extras::default() };
    let result = converted(&asset, &finished, &[], &extras, &Unwatched).unwrap();
    assert_eq!(result.layouts[0].levels[0].efficiency, None);
}
