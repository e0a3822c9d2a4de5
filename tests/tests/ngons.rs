//! `FB_ngon_encoding`: quads are converted as quads, and a converted file says so only where it is still true.

use image::{Rgb, RgbImage};
use meshcolor::asset::Asset;
use meshcolor::pipeline::{Coordinates, Options, convert};
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor_tests::gltf::Gltf;
use meshcolor_tests::validator;
use serde_json::{Value, json};

const MARK: &str = "FB_ngon_encoding";

/// A bent sheet of 4 x 4 quads with a vertex for each corner of the grid; `more` triangles after it.
fn sheet(more: &[[u32; 3]]) -> Gltf {
    let mut gltf = Gltf::default();
    let places: Vec<[f32; 2]> = (0..25).map(|at| [(at % 5) as f32 / 4.0, (at / 5) as f32 / 4.0]).collect();
    let positions: Vec<[f32; 3]> = places.iter().map(|[x, y]| [*x, *y, x * y]).collect();
    let mut indices = Vec::new();
    for cell in (0..20u32).filter(|cell| cell % 5 != 4) {
        let [a, b, c, d] = [cell, cell + 1, cell + 6, cell + 5];
        // No polygon may begin as the one before it does.
        indices.extend([a, b, c, a, c, d]);
    }
    indices.extend(more.as_flattened());
    let attributes = json!({
        "POSITION": gltf.positions(&positions), "TEXCOORD_0": gltf.floats("VEC2", places.as_flattened())
    });
    let indices = gltf.indices(&indices);
    let picture = RgbImage::from_fn(32, 32, |x, y| Rgb([x as u8 * 8, y as u8 * 8, (x * y) as u8]));
    let texture = gltf.texture(&picture);
    let material =
        gltf.material(json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
    gltf.json["extensionsUsed"] = json!([MARK]);
    gltf.primitive(json!({
        "attributes": attributes, "indices": indices, "material": material, "extensions": { MARK: {} }
    }));
    gltf
}

fn converted(gltf: &Gltf, options: &Options) -> (Asset, Vec<u8>, Vec<u8>) {
    let upload = Upload::single("sheet.glb", gltf.glb());
    let conversion = convert(&upload, options, &Limits::default(), &Unwatched).unwrap();
    let file = |path: &str| conversion.files.iter().find(|file| file.path == path).unwrap().bytes.clone();
    let [asset, colors] = ["asset.glb", "mesh_colors.glb"].map(file);
    let back = read(&Upload::single("asset.glb", asset.clone()), &Limits::default(), &Unwatched).unwrap();
    (back, asset, colors)
}

fn options(coordinates: Coordinates) -> Options {
    Options { coordinates, mesh_colors: true, ..Options::default() }
}

fn quad_count(asset: &Asset) -> usize {
    asset.meshes[0].primitives.iter().flat_map(|own| &own.faces).filter(|face| face.count == 4).count()
}

fn is_marked(asset: &Asset) -> bool {
    let json = &asset.document.json;
    let used = json["extensionsUsed"].as_array().is_some_and(|used| used.contains(&Value::from(MARK)));
    let primitive = json["meshes"][0]["primitives"][0]["extensions"].get(MARK).is_some();
    assert_eq!(used, primitive, "the list and its use");
    assert!(json["meshes"][0].get("extensions").is_none());
    primitive
}

#[test]
fn quads_go_through_and_come_back() {
    for coordinates in [Coordinates::Indexed, Coordinates::Scaled] {
        for of_mesh in [false, true] {
            let mut gltf = sheet(&[]);
            if of_mesh {
                gltf.json["meshes"][0]["extensions"] = json!({ MARK: {} });
                gltf.json["meshes"][0]["primitives"][0]["extensions"] = json!({});
            }
            let options = options(coordinates);
            let (back, asset, colors) = converted(&gltf, &options);
            validator::expect_valid("sheet", &asset, true);
            assert!(is_marked(&back) && quad_count(&back) == 16, "{coordinates:?}");
            let upload = Upload::single("mesh_colors.glb", colors);
            let again = convert(&upload, &options, &Limits::default(), &Unwatched).unwrap();
            let again = again.files.iter().find(|file| file.path == "asset.glb").unwrap();
            assert!(again.bytes == asset, "{coordinates:?} {of_mesh}");
        }
    }
}

#[test]
fn a_polygon_that_falls_apart_takes_the_mark_along() {
    // A pentagon over the sheet's corners.
    let gltf = sheet(&[[0, 4, 24], [0, 24, 22], [0, 22, 20]]);
    let (back, ..) = converted(&gltf, &options(Coordinates::Scaled));
    assert!(!is_marked(&back) && quad_count(&back) == 0);
}
