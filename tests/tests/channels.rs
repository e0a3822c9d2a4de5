//! Channels of named images: data of 8 and 16 bits, and numbers of any size.

use std::io::{Cursor, Write};

use exr::prelude::{ReadChannels, ReadLayers, f16};
use glam::{Vec2, Vec3, Vec4};
use meshcolor::asset::{AttributeName, Slot};
use meshcolor::edit::{self, ResolutionChange, Scheme, Selection};
use meshcolor::finished::FinishedTexture;
use meshcolor::image::{LevelRange, Pixels};
use meshcolor::pipeline::{Conversion, MipFilter, Options, check, convert};
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor_tests::baked::{Depth, flat_half, gray16, number, openexr, rgba8, share, sheet, upload};
use meshcolor_tests::patches::Random;
use meshcolor_tests::reading::jumps_codes;
use meshcolor_tests::validator;
use serde_json::json;

fn options(list: &[(&str, &str)]) -> Options {
    let mut options = Options::default();
    list.iter().for_each(|(name, value)| options.set(name, value).unwrap());
    options
}

fn converted(upload: &Upload, options: &Options) -> Conversion {
    convert(upload, options, &Limits::default(), &Unwatched).unwrap_or_else(|error| panic!("{error}"))
}

fn file<'a>(conversion: &'a Conversion, path: &str) -> &'a [u8] {
    &conversion.files.iter().find(|file| file.path == path).unwrap_or_else(|| panic!("no {path}")).bytes
}

fn slot(name: &str) -> Slot {
    Slot::Attribute(AttributeName::new(name).unwrap())
}

fn texture<'a>(conversion: &'a Conversion, name: &str) -> &'a FinishedTexture {
    conversion.finished.textures.iter().find(|own| own.slots.contains(&slot(name))).unwrap()
}

/// What level 0 shows at a place: stored values, mixed, times the scale.
fn shown(texture: &FinishedTexture, at_texels: Vec2) -> Vec4 {
    let (image, range) = (&texture.levels[0], texture.ranges.get(&0));
    let (floor, part) = ((at_texels - 0.5).floor(), (at_texels - 0.5).fract());
    let texel = |dx: f32, dy: f32| {
        let side = |at: f32, side: u32| at.clamp(0.0, side as f32 - 1.0) as u32;
        let (x, y) = (side(floor.x + dx, image.width), side(floor.y + dy, image.height));
        image.value(x, y, texture.transfer, range)
    };
    let row = |dy: f32| texel(0.0, dy).lerp(texel(1.0, dy), part.x);
    row(0.0).lerp(row(1.0), part.y) * texture.value_scale.unwrap_or(1.0)
}

/// The largest difference from a function of the sheet's points, of the components that count.
fn error(conversion: &Conversion, name: &str, of: impl Fn(Vec2) -> Vec4, components: &[usize]) -> f32 {
    let texture = texture(conversion, name);
    let mut random = Random::new(3);
    let mut most = 0.0f32;
    for piece in
        conversion.finished.primitives.iter().filter(|piece| texture.materials.contains(&piece.material))
    {
        let positions = &conversion.asset.meshes[piece.mesh].primitives[piece.primitive].positions;
        for (number, triangle) in piece.triangles.iter().enumerate() {
            for _ in 0..20 {
                let (mut s, mut t) = (random.unit(), random.unit());
                if s + t > 1.0 {
                    (s, t) = (1.0 - s, 1.0 - t);
                }
                let weights = Vec3::new(1.0 - s - t, s, t);
                let at: Vec3 = (0..3).map(|k| positions[triangle.vertices[k] as usize] * weights[k]).sum();
                let found = shown(texture, piece.place_at(number, weights, 0));
                let difference = (found - of(at.truncate())).abs();
                components.iter().for_each(|&k| most = most.max(difference[k]));
            }
        }
    }
    most
}

/// No seam at any level, and a file that says the same of itself.
fn expect_sound(name: &str, conversion: &Conversion) {
    for number in 0..conversion.finished.textures.len() {
        let jumps = jumps_codes(&conversion.asset, &conversion.finished, number);
        assert!(jumps.len() > 4 && jumps.iter().all(|&jump| jump < 1.5), "{name}: {jumps:?}");
    }
    let glb = file(conversion, "asset.glb");
    validator::expect_valid(name, glb, true);
    let again = Upload::single("asset.glb", glb.to_vec());
    let back = read(&again, &Limits::default(), &Unwatched).unwrap();
    let found = meshcolor::finished::extract(&back).unwrap().unwrap().textures;
    // Not the whole textures: a range says nothing of an alpha that is not stored.
    let told = |texture: &FinishedTexture| (texture.slots.clone(), texture.value_scale, texture.ranges.len());
    for (found, own) in found.iter().zip(&conversion.finished.textures) {
        assert!(told(found) == told(own) && found.levels == own.levels, "{name}");
    }
    let report = check(&again, &Options::default(), &Limits::default(), &Unwatched).unwrap();
    assert_eq!(report.max_seam_delta_codes, conversion.report.max_seam_delta_codes, "{name}");
    let scales = |report: &meshcolor::measure::Report| {
        report.channels.iter().map(|channel| channel.value_scale).collect::<Vec<_>>()
    };
    assert_eq!(scales(&report), scales(&conversion.report), "{name}");
}

/// Half floats under 32 have steps of 1/64; what filtering takes away of the function's bend is less than the rest.
const NUMBER_TOLERANCE: f32 = 0.05;

#[test]
fn numbers_of_any_size_keep_their_size() {
    type Case = (&'static [&'static str], Depth, &'static [(&'static str, &'static str)], &'static [usize]);
    let cases: [Case; 5] = [
        (&["height"], Depth::Half, &[], &[0, 1, 2]),
        (&["R", "G"], Depth::Float, &[("range", "scaled16")], &[0, 1]),
        (&["X", "Y", "Z"], Depth::Half, &[("coordinates", "4d")], &[0, 1, 2]),
        (&["R", "G", "B", "A"], Depth::Float, &[("range", "unorm8"), ("sampling", "fitted")], &[0, 1, 2, 3]),
        (
            &["R", "G", "B", "A"],
            Depth::Half,
            &[("sampling", "filtered"), ("coordinates", "4d-rows")],
            &[0, 1, 2, 3],
        ),
    ];
    for (names, depth, list, components) in cases {
        let place = format!("{names:?} {depth:?} {list:?}");
        let of = |at: Vec2| if names.len() == 1 { Vec4::splat(number(at).x) } else { number(at) };
        let upload = upload(sheet(&["clay"], 0), &[("models/light.exr", openexr(names, depth))]);
        let options = options(
            &[list, &[("channel", "light=light.exr"), ("textures", "exr,ktx2"), ("resolution", "area:4")]]
                .concat(),
        );
        let conversion = converted(&upload, &options);
        let found = error(&conversion, "light", of, components);
        assert!(found < NUMBER_TOLERANCE, "{place}: {found}");
        expect_sound(&place, &conversion);
        let texture = texture(&conversion, "light");
        assert_eq!(texture.value_scale, Some(32.0), "{place}");
        assert_eq!(texture.ranges.len(), texture.levels.len(), "{place}");
        let is_half = texture.ranges.values().all(|range| *range == LevelRange::Float16);
        assert_eq!(is_half, options.to_json()["range"] == "float16", "{place}");
        let report = &conversion.report.channels[0];
        assert_eq!(
            (report.value_scale, report.slots.as_slice()),
            (Some(32.0), ["lightTexture".to_owned()].as_slice())
        );
        let fidelity = report.fidelity.unwrap();
        assert!(fidelity.psnr_db > 60.0, "{place}: {fidelity:?}");
        expect_loose(&place, &conversion);
    }
}

/// The loose files hold the numbers themselves.
fn expect_loose(place: &str, conversion: &Conversion) {
    let texture = texture(conversion, "light");
    for (level, image) in texture.levels.iter().enumerate() {
        let bytes = file(conversion, &format!("textures/00_clay/light/level_{level:02}.exr"));
        let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
        let found = reader
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .unwrap();
        let planes = &found.layer_data.channel_data.list;
        assert_eq!(planes.len(), usize::from(image.components), "{place}");
        for plane in planes {
            let component = ["R", "G", "B", "A"].iter().position(|name| plane.name.eq(name)).unwrap_or(0);
            for (k, number) in plane.sample_data.values_as_f32().enumerate() {
                let (x, y) = (k as u32 % image.width, k as u32 / image.width);
                let stored = image.value(x, y, texture.transfer, texture.ranges.get(&level));
                assert_eq!(number, stored[component] * 32.0, "{place}, level {level}, {x} {y}");
            }
        }
        let ktx2 = file(conversion, &format!("textures/00_clay/light/level_{level:02}.ktx2"));
        let pair = b"MCTvalueScale\x0032\0";
        assert!(ktx2.windows(pair.len()).any(|window| window == pair), "{place}, level {level}");
    }
}

/// Numbers that half floats hold come back to the last bit where a sample stands on a texel's center.
#[test]
fn half_floats_stay_as_they_are() {
    for value in [0.0, 1.0, -2.5, 0.333, 65_504.0, 1e-4] {
        let half = f16::from_f32(value);
        let value = half.to_f32();
        let upload = upload(sheet(&["clay"], 0), &[("models/a.exr", flat_half(half))]);
        let conversion = converted(&upload, &options(&[("channel", "a=a.exr"), ("resolution", "fixed:2")]));
        let texture = texture(&conversion, "a");
        for (level, image) in texture.levels.iter().enumerate() {
            let own = image.value(1, 1, texture.transfer, texture.ranges.get(&level)).x;
            assert_eq!(own * texture.value_scale.unwrap(), value, "level {level}");
        }
    }
}

#[test]
fn codes_stay_codes_and_every_component_is_kept() {
    for (bytes, bits, components, of) in
        [(gray16(), 16, 1u8, (|at| Vec4::splat(share(at).x)) as fn(Vec2) -> Vec4), (rgba8(), 8, 4, share)]
    {
        let upload = upload(sheet(&["clay"], 0), &[("models/mask.png", bytes)]);
        let conversion =
            converted(&upload, &options(&[("channel", "mask=mask.png"), ("resolution", "area:4")]));
        let texture = texture(&conversion, "mask");
        assert_eq!((texture.value_scale, texture.levels[0].components), (None, components));
        assert_eq!(matches!(texture.levels[0].pixels, Pixels::U16(_)), bits == 16);
        let stored: Vec<usize> = (0..if components == 1 { 3 } else { 4 }).collect();
        let found = error(&conversion, "mask", of, &stored);
        assert!(found < if bits == 8 { 0.006 } else { 0.002 }, "{bits}: {found}");
        expect_sound(&format!("{bits} bits"), &conversion);
    }
}

/// One image under two names is one texture; materials have channels of their own; a second set of coordinates, in an archive.
#[test]
fn materials_and_sets_are_named() {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let glb = sheet(&["left", "right"], 1);
    for (name, bytes) in [
        ("a/sheet.glb", &glb),
        ("a/maps/gray.png", &gray16()),
        ("a/light.exr", &openexr(&["Y"], Depth::Half)),
    ] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    let upload = Upload::single("sheet.zip", zip.finish().unwrap().into_inner());
    let list = "wear=maps/gray.png#1,rust=maps/gray.png#1,light@right=light.exr#1";
    let conversion =
        converted(&upload, &options(&[("channel", list), ("resolution", "area:4"), ("cut", "255")]));
    let told: Vec<_> =
        conversion.report.channels.iter().map(|own| (own.material, own.slots.join(" "))).collect();
    let both = "rustTexture wearTexture".to_owned();
    assert_eq!(told, [(0, both.clone()), (1, "lightTexture".to_owned()), (1, both)]);
    assert!(error(&conversion, "rust", |at| Vec4::splat(share(at).x), &[0]) < 0.002);
    assert!(error(&conversion, "light", |at| Vec4::splat(number(at).x), &[0]) < NUMBER_TOLERANCE);
    let glb = file(&conversion, "asset.glb");
    validator::expect_valid("materials", glb, true);
    let asset = read(&Upload::single("asset.glb", glb.to_vec()), &Limits::default(), &Unwatched).unwrap();
    let channels = &asset.document.json["materials"][1]["extensions"]["MCT_mesh_color_texture"]["channels"];
    assert_eq!(channels.as_object().unwrap().len(), 3);
    assert_eq!(channels["rustTexture"], channels["wearTexture"]);
}

/// A model without a material gets one.
#[test]
fn faces_without_a_material_can_have_a_channel() {
    let files = [("models/mask.png", rgba8())];
    let conversion = converted(&upload(sheet(&[], 0), &files), &options(&[("channel", "mask=mask.png")]));
    assert!(error(&conversion, "mask", share, &[0, 1, 2, 3]) < 0.02);
    expect_sound("bare", &conversion);
}

/// A file of mesh colors has the channels too.
#[test]
fn mesh_colors_of_channels_convert_to_the_same_file() {
    let files = [("models/light.exr", openexr(&["R", "G", "B"], Depth::Float)), ("models/mask.png", rgba8())];
    for coordinates in ["indexed", "4d"] {
        let upload = upload(sheet(&["clay"], 0), &files);
        let list = [
            ("channel", "light=light.exr,mask=mask.png"),
            ("mesh-colors", "true"),
            ("coordinates", coordinates),
        ];
        let first = converted(&upload, &options(&list));
        let painted = Upload::single("mesh_colors.glb", file(&first, "mesh_colors.glb").to_vec());
        validator::expect_valid("mesh colors", file(&first, "mesh_colors.glb"), true);
        let again = converted(&painted, &options(&[("coordinates", coordinates)]));
        assert!(file(&again, "asset.glb") == file(&first, "asset.glb"), "{coordinates}");
    }
}

#[test]
fn edits_keep_the_size_of_numbers() {
    let upload =
        upload(sheet(&["clay"], 0), &[("models/light.exr", openexr(&["R", "G", "B"], Depth::Float))]);
    let list = [("channel", "light=light.exr"), ("mesh-colors", "true"), ("resolution", "area:4")];
    let first = converted(&upload, &options(&list));
    let painted = Upload::single("mesh_colors.glb", file(&first, "mesh_colors.glb").to_vec());
    let painted = read(&painted, &Limits::default(), &Unwatched).unwrap();
    let finer = ResolutionChange { by: 1, filter: MipFilter::Area };
    let limits = Limits::default();
    for edited in [
        edit::resolution(&painted, &Selection::default(), finer, &limits, &Unwatched),
        edit::subdivide(&painted, Scheme::Midpoint, &limits, &Unwatched),
    ] {
        let edited = Upload::single("edited.glb", edited.unwrap().glb);
        let again = converted(&edited, &Options::default());
        assert_eq!(texture(&again, "light").value_scale, Some(32.0));
        assert!(error(&again, "light", number, &[0, 1, 2]) < NUMBER_TOLERANCE);
    }
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let whole = |bytes: Vec<u8>| {
        let mut cut = bytes;
        cut.truncate(cut.len() / 2);
        cut
    };
    let files = [
        ("models/mask.png", rgba8()),
        ("models/broken.exr", whole(openexr(&["Y"], Depth::Half))),
        ("models/odd.exr", openexr(&["R", "depth"], Depth::Half)),
        ("models/text.png", b"no picture".to_vec()),
    ];
    let upload = upload(sheet(&["left", "right", "unused"], 0), &files);
    for (list, code, place, told) in [
        (
            "a=none.png",
            "missing_resource",
            "/channel/a",
            "is not in the upload in the folder \"models/\"; add it",
        ),
        ("a=../mask.png", "unsafe_uri", "/channel/a", "`..`"),
        ("a@middle=mask.png", "invalid_options", "/channel", "there are: \"left\", \"right\", \"unused\""),
        (
            "a@unused=mask.png",
            "invalid_options",
            "/channel",
            "material \"unused\" has no face that channel a could be on",
        ),
        (
            "a=mask.png#1",
            "invalid_options",
            "/channel",
            "/meshes/0/primitives/0 has 1 sets of texture coordinates",
        ),
        ("a=mask.png,a@left=mask.png", "invalid_options", "/channel", "two channels a"),
        ("a=broken.exr", "invalid_model", "/channel/a", "the OpenEXR file cannot be decoded"),
        ("a=odd.exr", "invalid_model", "/channel/a", "2 channels (\"R\", \"depth\")"),
        ("a=text.png", "unsupported_media_type", "/channel/a", "none of PNG, JPEG, WebP and KTX2"),
    ] {
        let options = options(&[("channel", list)]);
        let error = match convert(&upload, &options, &Limits::default(), &Unwatched) {
            Err(error) => error,
            Ok(_) => panic!("{list} was converted"),
        };
        let own = serde_json::to_value(error.code).unwrap();
        assert_eq!((own, error.pointer.as_deref()), (json!(code), Some(place)), "{list}: {}", error.detail);
        assert!(error.detail.contains(told), "{list}: {}", error.detail);
    }
    let small = Limits { image_side: 64, ..Limits::default() };
    let options = options(&[("channel", "a=light.exr")]);
    let upload = self::upload(sheet(&["left"], 0), &[("models/light.exr", openexr(&["Y"], Depth::Half))]);
    let error = convert(&upload, &options, &small, &Unwatched).err().unwrap();
    assert_eq!(serde_json::to_value(error.code).unwrap(), "image_too_large");
}

/// Levels in ranges are no images to convert once more.
#[test]
fn converted_numbers_are_not_converted_again() {
    let upload = upload(
        sheet(&["clay"], 0),
        &[("models/light.exr", openexr(&["Y"], Depth::Half)), ("models/mask.png", rgba8())],
    );
    let first = converted(&upload, &options(&[("channel", "light=light.exr")]));
    let again = Upload::single("asset.glb", file(&first, "asset.glb").to_vec());
    let error = convert(&again, &Options::default(), &Limits::default(), &Unwatched).err().unwrap();
    assert!(error.detail.contains("lightTexture was converted before"), "{error}");
    let first = converted(&upload, &options(&[("channel", "mask=mask.png")]));
    let again = Upload::single("asset.glb", file(&first, "asset.glb").to_vec());
    expect_sound("twice", &converted(&again, &Options::default()));
}
