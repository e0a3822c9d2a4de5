//! Materials that share their textures: one set of images, and one material where nothing else differs.

use glam::Vec3;
use serde_json::{Value, json};

use super::{parse, special};
use crate::asset::Asset;
use crate::finished::{EXTENSION, Finished, FinishedPrimitive, extract, hand_made::split};
use crate::measure;
use crate::watch::Unwatched;
use crate::write::glb;

/// Two primitives of one mesh with a material each, both converted to one set of textures. The second stands right of
/// the first and shares an edge with it.
fn merged() -> (Asset, Finished) {
    let mut asset = special::made_up_document();
    for position in &mut asset.meshes[0].primitives[1].positions {
        *position += Vec3::X;
    }
    let mut finished = special::finished(&asset);
    finished.textures[0].materials = vec![0, 1];
    let second = FinishedPrimitive { primitive: 1, material: 1, ..finished.primitives[0].clone() };
    finished.primitives.push(second);
    (asset, finished)
}

fn written(asset: &Asset, finished: &Finished) -> (Value, Asset, u64) {
    let glb = glb(asset, finished, &Unwatched).unwrap();
    (parse::split(&glb.bytes).0, parse::asset(&glb.bytes), glb.vertex_count)
}

fn count(json: &Value, name: &str) -> usize {
    json[name].as_array().map_or(0, Vec::len)
}

fn primitives(json: &Value) -> &Vec<Value> {
    json["meshes"][0]["primitives"].as_array().unwrap()
}

#[test]
fn textures_that_materials_share_are_stored_once() {
    let (mut asset, finished) = merged();
    asset.document.json["materials"][1]["doubleSided"] = json!(true);
    let (json, back, _) = written(&asset, &finished);
    assert_eq!([count(&json, "materials"), count(&json, "textures"), count(&json, "images")], [2, 1, 3]);
    let read = extract(&back).unwrap().unwrap();
    assert_eq!(read.textures, finished.textures);
    let places: Vec<_> = read.primitives.iter().map(|p| (p.primitive, p.material, p.part)).collect();
    assert_eq!(places, [(0, 0, 0), (1, 1, 0)]);
    let measured = measure::converted_file(&back, &read, &Unwatched).unwrap();
    assert_eq!((measured.channels.len(), measured.layouts.len()), (2, 1));
    assert_eq!(measured.layouts[0].materials, [0, 1]);
    assert_eq!(measured.layouts[0].face_count, 6);
}

#[test]
fn equal_materials_become_one_and_their_primitives_too() {
    let (mut asset, finished) = merged();
    asset.document.json["materials"][1]["name"] = json!("only the name differs");
    let (json, back, vertex_count) = written(&asset, &finished);
    assert_eq!([count(&json, "materials"), count(&json, "textures"), primitives(&json).len()], [1, 1, 1]);
    assert_eq!(vertex_count, 2 * 7);
    assert_eq!(back.meshes[0].primitives[0].positions.len(), 14);
    let read = extract(&back).unwrap().unwrap();
    assert_eq!(read.textures[0].materials, [0]);
    let [piece] = &read.primitives[..] else { panic!("one") };
    // First one's triangles, then the other's, each at its own place.
    let wrote = finished.primitives.iter().flat_map(|piece| piece.triangles.iter().map(move |t| (piece, t)));
    assert_eq!(piece.triangles.len(), 6);
    for (read, (own, wrote)) in piece.triangles.iter().zip(wrote) {
        assert_eq!((read.corners, read.anchor), (wrote.corners, wrote.anchor));
        for k in 0..3 {
            let positions = &asset.meshes[0].primitives[own.primitive].positions;
            let back = back.meshes[0].primitives[0].positions[read.vertices[k] as usize];
            assert_eq!(back, positions[wrote.vertices[k] as usize]);
        }
    }
    // The edge between them is a cut: from (1, 0) to (1, 1), of the first one's first triangle and of the other's
    // second.
    assert_eq!(piece.cuts[0].bits, [0b010, 0, 0, 0, 0b100, 0]);
}

#[test]
fn what_is_not_alike_stays_apart() {
    type Change = fn(&mut Asset, &mut Finished);
    let changes: [(Change, [usize; 2]); 5] = [
        // Materials and primitives that are left.
        (|asset, _| asset.document.json["materials"][1]["alphaCutoff"] = json!(0.25), [2, 2]),
        (|asset, _| asset.meshes[0].primitives[1].normals = vec![Vec3::Z; 5], [1, 2]),
        (|asset, _| asset.document.json["meshes"][0]["primitives"][1]["extras"] = json!(7), [1, 2]),
        (
            |asset, _| {
                let target = json!({ "path": "pointer", "extensions": {
                    "KHR_animation_pointer": { "pointer": "/materials/1/alphaCutoff" } } });
                asset.document.json["animations"] =
                    json!([{ "samplers": [{}], "channels": [{ "sampler": 0, "target": target }] }]);
            },
            [2, 2],
        ),
        (
            |_, finished| {
                let again = finished.textures[0].clone();
                finished.textures[0].materials = vec![0];
                finished.textures.push(crate::finished::FinishedTexture { materials: vec![1], ..again });
            },
            [2, 2],
        ),
    ];
    for (number, (change, left)) in changes.into_iter().enumerate() {
        let (mut asset, mut finished) = merged();
        change(&mut asset, &mut finished);
        let (json, back, _) = written(&asset, &finished);
        assert_eq!([count(&json, "materials"), primitives(&json).len()], left, "change {number}");
        extract(&back).unwrap().unwrap();
    }
}

#[test]
fn unknown_pointers_keep_materials_in_place() {
    let (mut asset, finished) = merged();
    asset.document.json["extensionsUsed"] = json!(["ACME_paint"]);
    asset.document.json["nodes"][0]["extensions"] = json!({ "ACME_paint": { "material": 1 } });
    let (json, back, _) = written(&asset, &finished);
    assert_eq!([count(&json, "materials"), primitives(&json).len()], [2, 1]);
    extract(&back).unwrap().unwrap();
}

#[test]
fn pointers_to_materials_behind_move() {
    let (mut asset, finished) = merged();
    let json = &mut asset.document.json;
    json["materials"] = json!([json["materials"][0], json["materials"][1], { "name": "coarse" }]);
    for material in 0..2 {
        json["materials"][material]["extensions"] = json!({ "MSFT_lod": { "ids": [2] } });
    }
    asset.materials.push(asset.materials[0].clone());
    let (json, ..) = written(&asset, &finished);
    assert_eq!(json["materials"][1]["name"], "coarse");
    assert_eq!(json["materials"][0]["extensions"]["MSFT_lod"]["ids"], json!([1]));
}

#[test]
fn materials_in_parts_become_one_part_by_part() {
    let (asset, whole) = merged();
    let finished = split(&whole, |triangle| triangle.anchor != whole.primitives[0].triangles[0].anchor);
    let (json, back, _) = written(&asset, &finished);
    assert_eq!([count(&json, "materials"), count(&json, "textures"), primitives(&json).len()], [2, 2, 2]);
    assert_eq!(json["materials"][1]["extensions"][EXTENSION], json!({ "partOf": 0, "part": 1 }));
    let read = extract(&back).unwrap().unwrap();
    let counts: Vec<_> = read.primitives.iter().map(|p| (p.material, p.part, p.triangles.len())).collect();
    assert_eq!(counts, [(0, 0, 4), (0, 1, 2)]);
}
