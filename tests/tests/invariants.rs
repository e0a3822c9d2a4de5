//! What holds for every conversion, on random models: continuity, no bleeding, exact placement,
//! faithfulness, and that nothing hangs on threads or on the unit of length. (`transforms.rs` has the rest: the
//! order of faces, their corners, where a model stands.)

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use meshcolor::asset::{Asset, Slot};
use meshcolor::finished::{Anchor, Finished, FinishedTriangle};
use meshcolor::image::{Image, Pixels};
use meshcolor::pipeline::{
    Beyond, Conversion, Coordinates, Options, Resolution, Sampling, check, convert, convert_asset,
};
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor_tests::patches::{Corner, Patch, Random, noise, picture, smooth};
use meshcolor_tests::reading::{jumps_codes, shown_codes, texel, texels_read};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Largest jump that rounding explains, in codes.
const ROUNDING_CODES: f32 = 1.5;

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn converted(upload: &Upload, options: &Options) -> Conversion {
    convert(upload, options, &Limits::default(), &Unwatched).unwrap_or_else(|error| panic!("{error}"))
}

fn wild(seed: u64) -> (Patch, Image) {
    let mut random = Random::new(seed);
    (Patch::wild(&mut random, 5), noise(&mut random, 64, 64))
}

/// The asset of an upload, with its picture as a data channel instead of a color.
fn as_data(upload: &Upload) -> Asset {
    let mut asset = read(upload, &Limits::default(), &Unwatched).unwrap();
    let material = &mut asset.materials[0];
    let texture = material.slots.remove(&Slot::BaseColor).unwrap();
    material.slots.insert(Slot::Occlusion, texture);
    let json = &mut asset.document.json["materials"][0];
    let slot = json["pbrMetallicRoughness"].as_object_mut().unwrap().remove("baseColorTexture").unwrap();
    json["occlusionTexture"] = slot;
    asset
}

fn assert_continuous(conversion: &Conversion) -> Result<(), TestCaseError> {
    for (level, jump) in jumps_codes(&conversion.asset, &conversion.finished, 0).into_iter().enumerate() {
        prop_assert!(jump <= ROUNDING_CODES, "level {level} jumps by {jump} codes");
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(12))]

    /// Invariant 1: both sides of an uncut edge show one color at every level, whatever is joined.
    #[test]
    fn uncut_edges_are_continuous(seed in any::<u64>(), is_color in any::<bool>(), cut in prop_oneof![Just(8.0), Just(60.0), Just(255.0)]) {
        let (patch, picture) = wild(seed);
        let options = Options { cut_codes: cut, ..Options::default() };
        let upload = patch.upload(&picture);
        let conversion = if is_color {
            converted(&upload, &options)
        } else {
            convert_asset(as_data(&upload), &options, &Limits::default(), &Unwatched).unwrap()
        };
        assert_continuous(&conversion)?;
        prop_assert_eq!(cut == 255.0, conversion.finished.primitives[0].cuts.is_empty());

        let file = Upload::single("asset.glb", conversion.files[0].bytes.clone());
        let report = check(&file, &options, &Limits::default(), &Unwatched).unwrap();
        let seams = |report: &meshcolor::measure::Report| -> Vec<_> {
            report.channels[0].levels.iter().map(|level| level.seams).collect()
        };
        prop_assert_eq!(seams(&report), seams(&conversion.report));
        prop_assert!(report.max_seam_delta_codes <= f64::from(ROUNDING_CODES));
    }

    /// The same at every resolution and sampling; clamping alone promises places, not colors.
    #[test]
    fn every_option_gives_a_sound_file(
        seed in any::<u64>(),
        sampling in prop_oneof![Just("point"), Just("filtered")],
        resolution in prop_oneof![Just("fixed:0"), Just("fixed:1"), Just("fixed:5"), Just("area:0.01"), Just("area:4"), Just("density:9")],
        solver in prop_oneof![Just("global"), Just("clamp")],
        mip in prop_oneof![Just("uniform"), Just("area")],
        beyond in prop_oneof![Just("one-ring"), Just("heat")],
        cut in prop_oneof![Just("0"), Just("8"), Just("255")],
        coordinates in prop_oneof![Just("4d-rows"), Just("4d"), Just("indexed")],
        texels in prop_oneof![Just("none"), Just("4000")],
    ) {
        let (patch, picture) = wild(seed);
        let mut options = Options::default();
        let rungs = [("sampling", sampling), ("resolution", resolution), ("solver", solver), ("mip", mip), ("beyond", beyond), ("cut", cut), ("coordinates", coordinates), ("texels", texels)];
        for (name, value) in rungs {
            options.set(name, value).unwrap();
        }
        let conversion = converted(&patch.upload(&picture), &options);
        prop_assert_eq!(bleeding(&conversion.finished), None);
        prop_assert!(conversion.finished.primitives[0].triangles.iter().all(is_placed_exactly));
        if solver == "global" {
            assert_continuous(&conversion)?;
        }
        let file = Upload::single("asset.glb", conversion.files[0].bytes.clone());
        let report = check(&file, &options, &Limits::default(), &Unwatched).unwrap();
        prop_assert_eq!(report.max_seam_delta_codes, conversion.report.max_seam_delta_codes);
    }

    /// Levels in a range of their own come back from the file, and join by rounding, as all others do.
    #[test]
    fn ranges_keep_what_the_bounded_format_cannot(seed in any::<u64>(), range in prop_oneof![Just("scaled16"), Just("float16")]) {
        let (patch, picture) = wild(seed);
        let mut options = Options { cut_codes: 255.0, coordinates: Coordinates::Scaled, ..Options::default() };
        options.set("range", range).unwrap();
        let conversion = converted(&patch.upload(&picture), &options);
        assert_continuous(&conversion)?;
        let texture = &conversion.finished.textures[0];
        let is_deep = |level: &usize| *level > 0 && matches!(texture.levels[*level].pixels, Pixels::U16(_));
        prop_assert!(texture.ranges.keys().all(is_deep));
        let file = Upload::single("asset.glb", conversion.files[0].bytes.clone());
        let report = check(&file, &options, &Limits::default(), &Unwatched).unwrap();
        for (read, wrote) in report.channels[0].levels.iter().zip(&conversion.report.channels[0].levels) {
            prop_assert_eq!((read.seams, &read.range), (wrote.seams, &wrote.range));
            prop_assert_eq!(read.seams_8bit_weights, wrote.seams_8bit_weights);
        }
    }

    /// Invariants 2 and 4: no texel is read from two blocks, and samples sit on texel centers.
    #[test]
    fn blocks_stand_apart_and_exactly(
        seed in any::<u64>(),
        coordinates in prop_oneof![Just(Coordinates::ScaledInRows), Just(Coordinates::Scaled), Just(Coordinates::Indexed)],
    ) {
        let (patch, picture) = wild(seed);
        let options = Options { coordinates, ..Options::default() };
        let conversion = converted(&patch.upload(&picture), &options);
        prop_assert_eq!(bleeding(&conversion.finished), None);
        for triangle in &conversion.finished.primitives[0].triangles {
            prop_assert!(is_placed_exactly(triangle), "{triangle:?}");
        }
        for level in &conversion.finished.textures[0].levels {
            prop_assert!(level.width >= 1 && level.height >= 1);
        }
    }
}

/// A model drawn out until it is one texel at level 20 alone: blocks stand apart and edges are joined there
/// too, where a face is a millionth of a texel.
#[test]
fn twenty_levels_hold_what_the_first_ones_do() {
    for (seed, beyond) in [(4, Beyond::Heat), (5, Beyond::OneRing)] {
        let (mut patch, picture) = wild(seed);
        patch.positions.iter_mut().for_each(|position| *position *= Vec3::new(1e8, 1e-6, 1e-6));
        for coordinates in [Coordinates::ScaledInRows, Coordinates::Scaled, Coordinates::Indexed] {
            let options =
                Options { beyond, coordinates, resolution: Resolution::Area(4.0), ..Options::default() };
            let conversion = converted(&patch.upload(&picture), &options);
            assert_eq!(conversion.finished.textures[0].levels.len(), 21);
            assert_eq!(bleeding(&conversion.finished), None);
            assert_continuous(&conversion).unwrap();
        }
    }
}

/// Two triangles of different blocks that read one texel, in words; blocks are told apart by their
/// offsets or numbers.
fn bleeding(finished: &Finished) -> Option<String> {
    let piece = &finished.primitives[0];
    let block = |triangle: usize| block_of(&piece.triangles[triangle]);
    for (level, image) in finished.textures[0].levels.iter().enumerate() {
        let mut readers: BTreeMap<[i64; 2], usize> = BTreeMap::new();
        for number in 0..piece.triangles.len() {
            for place in texels_read(piece, number, level) {
                let [x, y] = place;
                if x < 0 || y < 0 || x >= i64::from(image.width) || y >= i64::from(image.height) {
                    return Some(format!(
                        "level {level}: triangle {number} reads {place:?} beyond the image"
                    ));
                }
                let first = *readers.entry(place).or_insert(number);
                if block(first) != block(number) {
                    return Some(format!("level {level}: triangles {first} and {number} read {place:?}"));
                }
            }
        }
    }
    None
}

/// Local coordinates are corners of faces of the block; or `u_s` spans a rectangle whose sides are powers of two and which begins at multiples of them, each corner at a corner of the
/// rectangle; `u_δ` is whole texels and a half.
fn is_placed_exactly(triangle: &FinishedTriangle) -> bool {
    let Anchor::Offset(offset) = triangle.anchor else {
        return triangle
            .corners
            .iter()
            .flat_map(|corner| corner.to_array())
            .all(|at| at >= 0.0 && at.fract() == 0.0);
    };
    let least = triangle.corners.into_iter().fold(Vec2::INFINITY, Vec2::min);
    let most = triangle.corners.into_iter().fold(Vec2::NEG_INFINITY, Vec2::max);
    let sides = most - least;
    let are_powers = sides.to_array().iter().all(|side| *side >= 1.0 && side.log2().fract() == 0.0);
    let is_multiple = (least / sides).fract() == Vec2::ZERO && least.min_element() >= 0.0;
    let at_corners = triangle.corners.iter().all(|corner| ((*corner - least) / sides).fract() == Vec2::ZERO);
    are_powers && is_multiple && at_corners && offset.fract() == Vec2::splat(0.5)
}

/// What tells its block from others: `u_δ`, or class and number.
fn block_of(triangle: &FinishedTriangle) -> [u32; 2] {
    match triangle.anchor {
        Anchor::Offset(offset) => offset.to_array().map(f32::to_bits),
        Anchor::Block { class, number } => [class, number],
    }
}

#[test]
fn the_checks_see_what_they_look_for() {
    let (patch, picture) = wild(3);
    let options = Options { cut_codes: 255.0, coordinates: Coordinates::Scaled, ..Options::default() };
    let mut conversion = converted(&patch.upload(&picture), &options);
    assert_continuous(&conversion).unwrap();
    let sound = conversion.finished.clone();

    // A block moved by one texel along both axes runs into another, or out of the image.
    let moved = &mut conversion.finished.primitives[0].triangles;
    let first = moved[0].anchor;
    let Anchor::Offset(offset) = first else { panic!("4D coordinates") };
    let further = Anchor::Offset(offset + 1.0);
    moved.iter_mut().filter(|triangle| triangle.anchor == first).for_each(|t| t.anchor = further);
    assert!(bleeding(&conversion.finished).is_some());

    // The texel at a triangle's corner, brightened or darkened by 40 codes: a jump wherever the corner is
    // shared.
    let seen = |number: &usize| {
        let mut conversion =
            Conversion { finished: sound.clone(), ..converted(&patch.upload(&picture), &options) };
        let place = sound.primitives[0].place(*number, 0, 0).floor();
        let image = &mut conversion.finished.textures[0].levels[0];
        let Pixels::U8(codes) = &mut image.pixels else { panic!("8 bits") };
        let at = (place.y as usize * image.width as usize + place.x as usize) * 3;
        codes[at] = if codes[at] < 128 { codes[at] + 40 } else { codes[at] - 40 };
        assert_continuous(&conversion).is_err()
    };
    assert!((0..20).filter(seen).count() >= 10);

    let mut triangle = sound.primitives[0].triangles[0];
    triangle.anchor = Anchor::Offset(offset + Vec2::new(0.5, 0.0));
    assert!(!is_placed_exactly(&triangle));
    triangle = sound.primitives[0].triangles[0];
    triangle.corners[1].x += 1.0;
    assert!(!is_placed_exactly(&triangle));
}

proptest! {
    #![proptest_config(config(16))]

    /// Invariant 6: faces that lie on the picture's own grid come back with its codes, one by one.
    #[test]
    fn a_picture_on_the_same_grid_is_kept_to_the_code(seed in any::<u64>(), exponent in 0u8..=4, is_wide in any::<bool>()) {
        let mut random = Random::new(seed);
        let (side, segments) = (3, 1usize << exponent);
        // With sides of a power of two texel centers are exact.
        let width = (side * segments + 1).next_power_of_two();
        let center = |k: usize| ((k * segments) as f32 + 0.5) / width as f32;
        let mut patch = Patch::grid(&mut random, side, |_, _, [x, y]| Vec2::new(center(x), center(y)));
        // Border texels of triangles are in range where all samples lie in the middle third of linear light.
        let mut source = if patch.faces.iter().any(|face| face.len() == 4) && random.below(2) == 0 {
            patch.faces.retain(|face| face.len() == 4);
            noise(&mut random, width as u32, width as u32)
        } else {
            picture(width as u32, width as u32, |_, _| [0; 3].map(|_: u8| 158 + random.below(54) as u8))
        };
        if is_wide {
            let Pixels::U8(codes) = &source.pixels else { unreachable!() };
            source.pixels = Pixels::U16(codes.iter().map(|&code| u16::from(code) * 251 + 7).collect());
        }
        let options = Options { sampling: Sampling::Point, resolution: Resolution::Fixed(exponent), ..Options::default() };
        let conversion = converted(&patch.upload(&source), &options);
        let level = &conversion.finished.textures[0].levels[0];
        prop_assert_eq!(level.code_max(), source.code_max());
        // A quad of the canvas is two triangles in a row.
        let corners = patch.faces.iter().flat_map(|face| (1..face.len() - 1).map(move |k| [face[0], face[k], face[k + 1]]));
        let piece = &conversion.finished.primitives[0];
        for (triangle, corners) in (0..piece.triangles.len()).zip(corners) {
            for (i, j) in (0..=segments).flat_map(|j| (0..=segments - j).map(move |i| (i, j))) {
                let weights = Vec3::new((segments - i - j) as f32, i as f32, j as f32) / segments as f32;
                let wanted = (corners[0].1 * weights.x + corners[1].1 * weights.y + corners[2].1 * weights.z) * width as f32;
                let [found, wanted] = [piece.place_at(triangle, weights, 0), wanted].map(|place| place.floor().as_uvec2());
                prop_assert_eq!(texel(level, found.x, found.y), texel(&source, wanted.x, wanted.y));
            }
        }
    }
}

#[test]
fn one_two_and_four_threads_give_the_same_bytes() {
    for seed in [1, 2] {
        let (patch, picture) = wild(seed);
        let upload = patch.upload(&picture);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| converted(&upload, &Options::default()).files)
        };
        let one = with(1);
        assert!(one == with(2) && one == with(4) && one == with(4), "seed {seed}");
        let others = converted(&wild(seed + 1).0.upload(&picture), &Options::default()).files;
        assert!(one != others, "two models give the same files");
    }
}

/// What each face shows at its samples, by level, face, sample: independent of where it stands.
fn samples(conversion: &Conversion, exponent: u32) -> Vec<Vec<Vec<Vec3>>> {
    let texture = &conversion.finished.textures[0];
    let piece = &conversion.finished.primitives[0];
    let of = |level: usize, triangle: usize| {
        let n = 1 << (exponent as usize).saturating_sub(level);
        let points = (0..=n).flat_map(|j| (0..=n - j).map(move |i| (i, j)));
        let weights = points.map(|(i, j)| Vec3::new((n - i - j) as f32, i as f32, j as f32) / n as f32);
        weights
            .map(|at| {
                shown_codes(&texture.levels[level], texture.transfer, piece.place_at(triangle, at, level))
            })
            .collect()
    };
    let triangles = || 0..piece.triangles.len();
    (0..texture.levels.len()).map(|level| triangles().map(|t| of(level, t)).collect()).collect()
}

/// Triangles alone, on one smooth picture with seams inside of the grid.
fn calm(seed: u64) -> Patch {
    let mut random = Random::new(seed);
    let patch =
        Patch::grid(&mut random, 4, |_, _, [x, y]| Vec2::new(x as f32 * 0.23, y as f32 * 0.19 + 0.05));
    let cut = |face: &Vec<Corner>| {
        (1..face.len() - 1).map(|k| vec![face[0], face[k], face[k + 1]]).collect::<Vec<_>>()
    };
    Patch { faces: patch.faces.iter().flat_map(cut).collect(), ..patch }
}

proptest! {
    #![proptest_config(config(8))]

    /// Lengths enter as ratios: a model twice as large, or elsewhere, has the same textures.
    #[test]
    fn scale_and_place_change_nothing(seed in any::<u64>(), power in -20i32..=20, shift in -512i32..=512) {
        let (patch, picture) = wild(seed);
        let change = |position: Vec3| (position + shift as f32) * 2f32.powi(power);
        let other = Patch { positions: patch.positions.iter().map(|&p| change(p)).collect(), ..patch.clone() };
        let [first, second] = [&patch, &other].map(|patch| converted(&patch.upload(&picture), &Options::default()).finished);
        prop_assert!(first.textures == second.textures);
        prop_assert!(first.primitives == second.primitives);
    }
}

#[test]
fn density_follows_the_unit_of_length() {
    let patch = calm(5);
    let double = Patch { positions: patch.positions.iter().map(|p| *p * 2.0).collect(), ..patch.clone() };
    let with = |patch: &Patch, texels: f32| {
        let options = Options { resolution: Resolution::Density(texels), ..Options::default() };
        converted(&patch.upload(&smooth(32)), &options).finished
    };
    assert!(with(&patch, 8.0) == with(&double, 4.0));
    assert!(with(&patch, 8.0) != with(&double, 8.0));
}

#[test]
fn a_face_that_shares_nothing_has_no_say() {
    // Two triangles apart from each other; the picture of one changes.
    let corner = |k: u32, x: f32, y: f32| (k, Vec2::new(x, y));
    let patch = Patch {
        positions: [[0., 0.], [1., 0.], [0., 1.], [5., 5.], [6., 5.], [5., 6.]]
            .map(|[x, y]| Vec3::new(x, y, 0.0))
            .to_vec(),
        faces: vec![
            vec![corner(0, 0.1, 0.1), corner(1, 0.4, 0.1), corner(2, 0.1, 0.4)],
            vec![corner(3, 0.6, 0.6), corner(4, 0.9, 0.6), corner(5, 0.6, 0.9)],
        ],
    };
    let painted =
        |far: u8| picture(64, 64, move |x, y| if x < 32 { [x as u8 * 4, y as u8 * 4, 90] } else { [far; 3] });
    let options = Options { resolution: Resolution::Fixed(4), ..Options::default() };
    let [first, second] = [0, 255].map(|far| samples(&converted(&patch.upload(&painted(far)), &options), 4));
    for (level, (first, second)) in first.iter().zip(&second).enumerate() {
        assert_eq!(first[0], second[0], "level {level}");
        assert_ne!(first[1], second[1], "level {level}");
    }
}
