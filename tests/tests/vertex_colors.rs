//! Vertex colors as base color: alone, and times a texture.

use glam::{Vec2, Vec3};
use image::{Rgb, RgbImage};
use meshcolor::asset::{Asset, Slot};
use meshcolor::finished::FinishedTexture;
use meshcolor::pipeline::{Conversion, Options, Resolution, VertexColors, convert};
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor_tests::gltf::Gltf;
use meshcolor_tests::patches::Random;
use meshcolor_tests::reading::{shown_alpha, shown_codes};
use meshcolor_tests::validator;
use serde_json::{Value, json};

/// Vertices a side of a sheet.
const SIDE: u32 = 6;

/// How colors are stored.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Float3,
    Byte4,
    Short4,
}

/// A smooth color of a vertex, with an alpha, linear.
fn color(vertex: u32) -> [f32; 4] {
    let (x, y) = ((vertex % SIDE) as f32 / 5.0, (vertex / SIDE) as f32 / 5.0);
    [0.2 + 0.8 * x, 1.0 - 0.7 * y, 0.5 + 0.4 * (x * y), 0.4 + 0.6 * y]
}

/// Without neighbors that look alike.
fn noisy(vertex: u32) -> [f32; 4] {
    let code = |k: u32| (vertex * 7 + k * 5) % 11;
    [0, 1, 2, 3].map(|k| code(k) as f32 / 10.0)
}

fn picture() -> RgbImage {
    let code = |value: f32| (value * 255.0).round() as u8;
    RgbImage::from_fn(64, 64, |x, y| {
        let (u, v) = (x as f32 / 63.0, y as f32 / 63.0);
        Rgb([code(0.3 + 0.7 * u), code(0.9 - 0.5 * v), code(0.5 + 0.3 * u * v)])
    })
}

/// A sheet of triangles in `gltf`, `at` meters to the right, with vertex colors of this kind.
fn add_sheet(gltf: &mut Gltf, at: f32, of: impl Fn(u32) -> [f32; 4], kind: Kind) -> Value {
    let place = |vertex: u32| [(vertex % SIDE) as f32 / 5.0, (vertex / SIDE) as f32 / 5.0];
    let places: Vec<[f32; 2]> = (0..SIDE * SIDE).map(place).collect();
    let positions: Vec<[f32; 3]> = places.iter().map(|[x, y]| [x + at, *y, 0.2 * y * y]).collect();
    let mut indices = Vec::new();
    for cell in (0..SIDE * (SIDE - 1)).filter(|cell| cell % SIDE != SIDE - 1) {
        let [a, b, c, d] = [cell, cell + 1, cell + SIDE + 1, cell + SIDE];
        indices.extend([a, b, c, a, c, d]);
    }
    let colors: Vec<[f32; 4]> = (0..SIDE * SIDE).map(of).collect();
    let colors = match kind {
        Kind::Float3 => {
            let numbers: Vec<f32> = colors.iter().flat_map(|color| color[..3].to_vec()).collect();
            gltf.floats("VEC3", &numbers)
        }
        Kind::Byte4 => {
            let bytes: Vec<u8> = colors.iter().flatten().map(|value| (value * 255.0).round() as u8).collect();
            gltf.accessor("VEC4", 5121, &bytes, true)
        }
        Kind::Short4 => {
            let shorts = colors.iter().flatten().map(|value| (value * 65_535.0).round() as u16);
            let bytes: Vec<u8> = shorts.flat_map(u16::to_le_bytes).collect();
            gltf.accessor("VEC4", 5123, &bytes, true)
        }
    };
    json!({
        "attributes": {
            "POSITION": gltf.positions(&positions),
            "TEXCOORD_0": gltf.floats("VEC2", places.as_flattened()),
            "COLOR_0": colors,
        },
        "indices": gltf.indices(&indices),
    })
}

fn textured(gltf: &mut Gltf, more: Value) -> usize {
    let texture = gltf.texture(&picture());
    let mut material = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } });
    material.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    gltf.material(material)
}

/// A sheet with its material; without a texture where `more` is none.
fn sheet(of: impl Fn(u32) -> [f32; 4], kind: Kind, more: Option<Value>) -> Gltf {
    let mut gltf = Gltf::default();
    let mut primitive = add_sheet(&mut gltf, 0.0, of, kind);
    let material = match more {
        Some(more) => textured(&mut gltf, more),
        None => gltf.material(json!({ "name": "bare" })),
    };
    primitive["material"] = json!(material);
    gltf.primitive(primitive);
    gltf
}

fn converted(glb: Vec<u8>, options: &Options) -> Conversion {
    convert(&Upload::single("sheet.glb", glb), options, &Limits::default(), &Unwatched).unwrap()
}

fn with(vertex_colors: VertexColors) -> Options {
    Options { vertex_colors, ..Options::default() }
}

fn file(conversion: &Conversion, path: &str) -> Vec<u8> {
    conversion.files.iter().find(|file| file.path == path).unwrap().bytes.clone()
}

/// The written model, which the validator has nothing against.
fn written(name: &str, conversion: &Conversion) -> Asset {
    let glb = file(conversion, "asset.glb");
    validator::expect_valid(name, &glb, true);
    read(&Upload::single("asset.glb", glb), &Limits::default(), &Unwatched).unwrap()
}

fn has_colors(asset: &Asset) -> Vec<bool> {
    let primitives = asset.meshes.iter().flat_map(|mesh| &mesh.primitives);
    primitives.map(|own| own.attributes.iter().any(|of| of.semantic == "COLOR_0")).collect()
}

fn encoded(value: f32) -> f32 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

fn decoded(code: f32) -> f32 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// The picture at a texture coordinate: linear light.
fn picture_at(picture: &RgbImage, uv: Vec2) -> Vec3 {
    let at = uv * 64.0 - 0.5;
    let (floor, part) = (at.floor(), at - at.floor());
    let texel = |x: f32, y: f32| {
        // The sheet's coordinates stay within the picture, which repeats.
        let [x, y] = [x, y].map(|at| at.rem_euclid(64.0) as u32);
        Vec3::from([0, 1, 2].map(|k| decoded(f32::from(picture.get_pixel(x, y)[k]) / 255.0)))
    };
    let row = |y: f32| texel(floor.x, y).lerp(texel(floor.x + 1.0, y), part.x);
    row(floor.y).lerp(row(floor.y + 1.0), part.y)
}

/// The largest and the mean difference of colors in codes, and the largest of alpha, at random points away from the picture's
/// border, where it repeats.
fn differences(conversion: &Conversion, of: impl Fn(u32) -> [f32; 4], has_picture: bool) -> [f32; 3] {
    let piece = &conversion.finished.primitives[0];
    let texture: &FinishedTexture =
        conversion.finished.textures.iter().find(|own| own.slots.contains(&Slot::BaseColor)).unwrap();
    let picture = picture();
    let mut random = Random::new(11);
    let (mut most, mut sum, mut count, mut most_alpha) = (0.0f32, 0.0, 0, 0.0f32);
    for number in 0..piece.triangles.len() {
        for _ in 0..20 {
            let (mut s, mut t) = (random.unit(), random.unit());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            let at = Vec3::new(1.0 - s - t, s, t);
            let corners = piece.triangles[number].vertices;
            let uv: Vec2 = (0..3)
                .map(|k| Vec2::new((corners[k] % SIDE) as f32, (corners[k] / SIDE) as f32) / 5.0 * at[k])
                .sum();
            if has_picture && (uv.min_element() < 0.02 || uv.max_element() > 0.98) {
                continue;
            }
            let mixed = |k: usize| (0..3).map(|corner| of(corners[corner])[k] * at[corner]).sum::<f32>();
            let base = if has_picture { picture_at(&picture, uv) } else { Vec3::ONE };
            let wanted = (base * Vec3::new(mixed(0), mixed(1), mixed(2))).map(encoded) * 255.0;
            let place = piece.place_at(number, at, 0);
            let error = (wanted - shown_codes(&texture.levels[0], texture.transfer, place)).abs();
            most = most.max(error.max_element());
            sum += error.element_sum() / 3.0;
            count += 1;
            if texture.levels[0].components == 4 {
                most_alpha = most_alpha.max((mixed(3) - shown_alpha(&texture.levels[0], place)).abs());
            }
        }
    }
    [most, sum / count as f32, most_alpha]
}

#[test]
fn texture_times_color_is_what_the_source_shows() {
    let fine = Options { resolution: Resolution::Area(16.0), ..with(VertexColors::Bake) };
    for kind in [Kind::Float3, Kind::Byte4, Kind::Short4] {
        let conversion = converted(sheet(color, kind, Some(json!({}))).glb(), &fine);
        let [most, mean, _] = differences(&conversion, color, true);
        assert!(most < 2.5 && mean < 0.5, "{kind:?}: {most} {mean}");
        let fidelity = conversion.report.channels[0].fidelity.unwrap();
        assert!(fidelity.psnr_db > 50.0 && fidelity.p99 < 1.0, "{kind:?}: {fidelity:?}");
        let levels = &conversion.report.channels[0].levels;
        let errors: Vec<f64> = levels.iter().filter_map(|level| Some(level.mip_error?.rms)).collect();
        assert!(errors.len() > 3 && errors.iter().all(|&rms| rms < 6.0), "{errors:?}");
        assert_eq!(has_colors(&written("times", &conversion)), [false]);
        assert!(conversion.report.warnings.is_empty(), "{:?}", conversion.report.warnings);
    }
}

#[test]
fn alpha_multiplies_where_it_is_shown() {
    let fine = Options { resolution: Resolution::Area(16.0), ..with(VertexColors::Bake) };
    let blend = || Some(json!({ "alphaMode": "BLEND" }));
    let conversion = converted(sheet(color, Kind::Short4, blend()).glb(), &fine);
    let [most, _, alpha] = differences(&conversion, color, true);
    assert!(most < 2.5 && alpha < 0.01, "{most} {alpha}");
    assert_eq!(conversion.finished.textures[0].levels[0].components, 4);
    for (kind, more) in [(Kind::Float3, blend()), (Kind::Short4, Some(json!({})))] {
        let conversion = converted(sheet(color, kind, more).glb(), &fine);
        assert_eq!(conversion.finished.textures[0].levels[0].components, 3, "{kind:?}");
    }
}

#[test]
fn colors_alone_are_base_color_without_any_option() {
    let conversion = converted(sheet(color, Kind::Byte4, None).glb(), &Options::default());
    let [most, mean, _] = differences(&conversion, color, false);
    assert!(most < 2.0 && mean < 0.5, "{most} {mean}");
    let fidelity = conversion.report.channels[0].fidelity.unwrap();
    assert!(fidelity.psnr_db > 50.0, "{fidelity:?}");
    // A cell of six by six vertices needs no more than these.
    assert!(conversion.report.growth.converted_texels < 200, "{:?}", conversion.report.growth);
    let asset = written("bare", &conversion);
    assert_eq!(has_colors(&asset), [false]);
    let pbr = &asset.document.json["materials"][0]["pbrMetallicRoughness"];
    assert!(pbr["baseColorTexture"].is_object());

    let mut without = sheet(color, Kind::Byte4, None);
    without.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("material");
    let conversion = converted(without.glb(), &Options::default());
    assert_eq!(has_colors(&written("without a material", &conversion)), [false]);

    let refused = convert(
        &Upload::single("sheet.glb", sheet(color, Kind::Byte4, None).glb()),
        &with(VertexColors::Keep),
        &Limits::default(),
        &Unwatched,
    );
    let error = refused.err().unwrap();
    assert!(error.code == meshcolor::ErrorCode::NothingToConvert, "{error}");
    assert!(error.detail.contains("vertex colors") && error.detail.contains("mesh colors"), "{error}");
}

#[test]
fn textured_materials_keep_their_colors_unless_asked() {
    let glb = sheet(color, Kind::Byte4, Some(json!({}))).glb();
    let [auto, keep] =
        [VertexColors::Auto, VertexColors::Keep].map(|rung| converted(glb.clone(), &with(rung)));
    assert!(file(&auto, "asset.glb") == file(&keep, "asset.glb"));
    assert_eq!(has_colors(&written("kept", &auto)), [true]);
    // Another texture than base color is one too, an extension's as well.
    for slot in ["emissiveTexture", "extensions"] {
        let mut gltf = sheet(color, Kind::Byte4, Some(json!({})));
        let info = gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].take();
        let coat = json!({ "KHR_materials_clearcoat": { "clearcoatTexture": info.clone() } });
        gltf.json["materials"][0] = json!({ slot: if slot == "extensions" { coat } else { info } });
        gltf.json["extensionsUsed"] = json!(["KHR_materials_clearcoat"]);
        let textured = add_sheet(&mut gltf, 3.0, color, Kind::Float3);
        let other = add_textured(&mut gltf, textured);
        assert_eq!(other, 1);
        let asset = written(slot, &converted(gltf.glb(), &Options::default()));
        assert_eq!(has_colors(&asset), [true, true], "{slot}");
    }
}

/// Adds a primitive with a textured material of its own; returns its number.
fn add_textured(gltf: &mut Gltf, mut primitive: Value) -> usize {
    primitive["material"] = json!(textured(gltf, json!({})));
    let number = gltf.json["meshes"][0]["primitives"].as_array().unwrap().len();
    gltf.primitive(primitive);
    number
}

#[test]
fn only_what_was_taken_goes() {
    let mut gltf = sheet(color, Kind::Byte4, None);
    let mut points = gltf.json["meshes"][0]["primitives"][0].clone();
    points["mode"] = json!(0);
    gltf.primitive(points);
    let other = add_sheet(&mut gltf, 3.0, color, Kind::Float3);
    add_textured(&mut gltf, other);
    // Of the first material, without colors: it counts as white.
    let mut white = add_sheet(&mut gltf, 6.0, color, Kind::Float3);
    white["attributes"].as_object_mut().unwrap().remove("COLOR_0");
    white["material"] = json!(0);
    gltf.primitive(white);
    let auto = converted(gltf.glb(), &Options::default());
    assert_eq!(has_colors(&written("auto", &auto)), [false, true, true, false]);
    let piece = auto.finished.primitives.iter().find(|piece| piece.primitive == 3).unwrap();
    let texture = auto.finished.textures.iter().find(|own| own.is_of(0, piece.part)).unwrap();
    let shown = shown_codes(&texture.levels[0], texture.transfer, piece.place(0, 0, 0));
    assert!((shown - 255.0).abs().max_element() < 1e-3, "{shown}");
    let bake = converted(gltf.glb(), &with(VertexColors::Bake));
    assert_eq!(has_colors(&written("bake", &bake)), [false, true, false, false]);
}

#[test]
fn sides_of_two_colors_are_cut() {
    // Two sheets side by side, the second mirrored in color: their common edge shows two values.
    let cut_count = |of: fn(u32) -> [f32; 4]| {
        let mut gltf = sheet(|vertex| [color(vertex)[1]; 4], Kind::Float3, None);
        let mut other = add_sheet(&mut gltf, 1.0, of, Kind::Float3);
        other["material"] = json!(0);
        gltf.primitive(other);
        let conversion = converted(gltf.glb(), &Options::default());
        assert!(conversion.report.max_seam_delta_codes < 1e-3);
        conversion.report.channels[0].cuts.cut_edge_count
    };
    assert_eq!(cut_count(|vertex| [color(vertex)[1]; 4]), 0);
    assert_eq!(cut_count(|vertex| [1.0 - color(vertex)[1]; 4]), 5);
}

#[test]
fn bent_quads_get_more_than_their_corners() {
    let fidelity = |resolution: Resolution| {
        let options = Options { resolution, ..Options::default() };
        let conversion = converted(sheet(noisy, Kind::Byte4, None).glb(), &options);
        let [most, _, _] = differences(&conversion, noisy, false);
        (most, conversion.report.channels[0].fidelity.unwrap().psnr_db)
    };
    let (coarse, standard) = (fidelity(Resolution::Fixed(0)), fidelity(Resolution::Area(1.0)));
    assert!(coarse.0 > 40.0 && coarse.1 < 30.0, "{coarse:?}");
    assert!(standard.0 < 12.0 && standard.1 > 45.0, "{standard:?}");
}

#[test]
fn mesh_colors_go_round() {
    for (rung, more) in [(VertexColors::Auto, None), (VertexColors::Bake, Some(json!({})))] {
        let options = Options { mesh_colors: true, ..with(rung) };
        let there = converted(sheet(noisy, Kind::Byte4, more).glb(), &options);
        let colors = file(&there, "mesh_colors.glb");
        validator::expect_valid("mesh colors", &colors, true);
        let back = converted(colors, &options);
        assert!(file(&back, "asset.glb") == file(&there, "asset.glb"), "{rung:?}");
    }
}

#[test]
fn moving_colors_stay() {
    let mut gltf = sheet(color, Kind::Float3, Some(json!({})));
    let moves = gltf.floats("VEC3", &[0.1; 3 * 36]);
    gltf.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "COLOR_0": moves }]);
    let conversion = converted(gltf.glb(), &with(VertexColors::Bake));
    assert_eq!(has_colors(&written("moving", &conversion)), [true]);
    let codes: Vec<_> = conversion.report.warnings.iter().map(|warning| warning.code.as_str()).collect();
    assert_eq!(codes, ["moving_vertex_colors"]);
}

#[test]
fn scans_convert_without_any_option() {
    let mut obj = String::new();
    let mut ply =
        "ply\nformat ascii 1.0\nelement vertex 36\nproperty float x\nproperty float y\nproperty float z\n\
                   property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 25\n\
                   property list uchar int vertex_indices\nend_header\n"
            .to_owned();
    for vertex in 0..SIDE * SIDE {
        let (x, y) = (vertex % SIDE, vertex / SIDE);
        let codes = [40 * x, 255 - 30 * y, 10 * x * y];
        let [r, g, b] = codes.map(|code| code as f32 / 255.0);
        obj += &format!("v {x} {y} 0 {r} {g} {b}\n");
        ply += &format!("{x} {y} 0 {} {} {}\n", codes[0], codes[1], codes[2]);
    }
    for cell in (0..SIDE * (SIDE - 1)).filter(|cell| cell % SIDE != SIDE - 1) {
        let corners = [cell, cell + 1, cell + SIDE + 1, cell + SIDE];
        obj += &format!("f {} {} {} {}\n", corners[0] + 1, corners[1] + 1, corners[2] + 1, corners[3] + 1);
        ply += &format!("4 {} {} {} {}\n", corners[0], corners[1], corners[2], corners[3]);
    }
    for (name, text) in [("scan.obj", obj), ("scan.ply", ply)] {
        let upload = Upload::single(name, text.into_bytes());
        let conversion = convert(&upload, &Options::default(), &Limits::default(), &Unwatched).unwrap();
        assert_eq!(has_colors(&written(name, &conversion)), [false]);
        let piece = &conversion.finished.primitives[0];
        let texture = &conversion.finished.textures[0];
        for number in 0..piece.triangles.len() {
            for k in 0..3 {
                let vertex = piece.triangles[number].vertices[k] as usize;
                let position = conversion.asset.meshes[0].primitives[0].positions[vertex];
                let [x, y] = [position.x, position.y];
                let wanted = Vec3::new(40.0 * x, 255.0 - 30.0 * y, 10.0 * x * y);
                let shown = shown_codes(&texture.levels[0], texture.transfer, piece.place(number, k, 0));
                assert!((shown - wanted).abs().max_element() < 0.01, "{name}: {shown} {wanted}");
            }
        }
        let fidelity = conversion.report.channels[0].fidelity.unwrap();
        println!("{name}: {fidelity:?}");
        assert!(fidelity.psnr_db > 40.0, "{name}: {fidelity:?}");
    }
}
