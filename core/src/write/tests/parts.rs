//! Materials in parts: split primitives come back, and files that lie about parts are found out.

use glam::Vec3;
use serde_json::{Value, json};

use super::{fixture, indexed, parse, special};
use crate::asset::Asset;
use crate::error::ErrorCode;
use crate::finished::{
    Anchor, EXTENSION, Finished, FinishedPrimitive, FinishedTriangle, extract, hand_made::split,
};
use crate::measure;
use crate::watch::Unwatched;
use crate::write::{glb, losses};

/// Triangles with an odd offset, or in a larger block, or a lone pair's second one.
fn is_second(triangle: &FinishedTriangle) -> bool {
    match triangle.anchor {
        Anchor::Offset(offset) => offset.x != 0.5,
        Anchor::Block { class, .. } => class > 2,
    }
}

fn written(asset: &Asset, finished: &Finished) -> Asset {
    parse::asset(&glb(asset, finished, &Unwatched).unwrap().bytes)
}

/// The places of a piece's corners in its mesh, and everything that does not depend on the numbers of vertices.
fn shown(asset: &Asset, piece: &FinishedPrimitive) -> (Vec<[Vec3; 3]>, FinishedPrimitive) {
    let positions = &asset.meshes[piece.mesh].primitives[piece.primitive].positions;
    let places = piece.triangles.iter().map(|t| t.vertices.map(|vertex| positions[vertex as usize]));
    let places = places.collect();
    let triangles = piece.triangles.iter().map(|t| FinishedTriangle { vertices: [0; 3], ..*t }).collect();
    (places, FinishedPrimitive { primitive: 0, triangles, ..piece.clone() })
}

#[test]
fn parts_come_back_from_their_file_to_the_bit() {
    let (flat, scaled, _) = fixture::converted();
    let (sheet, indexed) = indexed::sheet();
    for (asset, whole) in [(flat, scaled), (sheet, indexed)] {
        let finished = split(&whole, is_second);
        assert_eq!(finished.primitives.len(), 2);
        finished.check().unwrap();
        let back = written(&asset, &finished);
        let read = extract(&back).unwrap().unwrap();
        assert_eq!(read.textures, finished.textures);
        assert_eq!(read.primitives.len(), 2);
        for (read, wrote) in read.primitives.iter().zip(&finished.primitives) {
            assert_eq!(shown(&back, read), shown(&asset, wrote));
        }
        // Faces of one part alone need no other.
        let alone = split(&whole, |_| true);
        let read = extract(&written(&asset, &alone)).unwrap().unwrap();
        assert_eq!(read.primitives.len(), 1);
        assert_eq!((read.primitives[0].primitive, read.primitives[0].part), (0, 1));
        assert_eq!(read.textures, alone.textures[whole.textures.len()..]);
    }
}

#[test]
fn a_copy_is_told_by_its_name_and_keeps_the_rest() {
    let (asset, whole, _) = fixture::converted();
    let finished = split(&whole, is_second);
    let (json, bin) = parse::split(&glb(&asset, &finished, &Unwatched).unwrap().bytes);
    let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
    // The points keep their place, and the source's material in a copy of its own.
    assert_eq!((primitives.len(), &primitives[1]["mode"]), (3, &json!(0)));
    let materials: Vec<_> = primitives.iter().map(|own| own["material"].as_u64().unwrap()).collect();
    assert_eq!(materials, [0, 3, 2]);
    let [first, copy] = [&json["materials"][0], &json["materials"][2]];
    assert_eq!((&first["name"], &copy["name"]), (&json!("coat"), &json!("coat (part 2)")));
    assert_eq!(first["extensions"].get(EXTENSION), None);
    assert_eq!(copy["extensions"][EXTENSION], json!({ "partOf": 0, "part": 1 }));
    let clearcoat = "KHR_materials_clearcoat";
    assert_eq!(first["extensions"][clearcoat], copy["extensions"][clearcoat]);
    assert_ne!(first["normalTexture"]["index"], copy["normalTexture"]["index"]);
    assert_eq!(copy["normalTexture"]["scale"], 0.5);
    let keys =
        |own: &Value| -> Vec<String> { own["attributes"].as_object().unwrap().keys().cloned().collect() };
    assert_eq!(keys(&primitives[0]), keys(&primitives[2]));
    assert_eq!(primitives[2]["targets"].as_array().unwrap().len(), 1);
    let colors = |own: &Value| {
        let accessor = own["attributes"]["COLOR_0"].as_u64().unwrap() as usize;
        parse::attribute(&json, &bin, "", accessor).bytes
    };
    // Corners 0, 1, 2 and 0, 2, 3.
    assert_eq!(colors(&primitives[0]), [10, 20, 30, 40, 50, 60, 70, 80, 90]);
    assert_eq!(colors(&primitives[2]), [10, 20, 30, 70, 80, 90, 1, 2, 3]);
    assert_eq!(losses(&asset, &finished)[0].count, 1);
}

#[test]
fn variants_and_animations_follow_into_every_part() {
    let mut asset = special::made_up_document();
    let mapping = |material: usize| json!({ "material": material, "variants": [material] });
    let json = &mut asset.document.json;
    json["extensionsUsed"] = json!(["KHR_materials_variants", "KHR_animation_pointer"]);
    json["extensions"] =
        json!({ "KHR_materials_variants": { "variants": [{ "name": "a" }, { "name": "b" }] } });
    json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_materials_variants": { "mappings": [mapping(0), mapping(1)] } });
    let channel = |pointer: &str| {
        let extensions = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        json!({ "sampler": 0, "target": { "path": "pointer", "extensions": extensions } })
    };
    let pointers = ["/materials/0/emissiveFactor", "/materials/1/emissiveFactor", "/nodes/0/scale"];
    json["animations"] =
        json!([{ "samplers": [{ "input": 0, "output": 0 }], "channels": pointers.map(channel) }]);
    let finished = split(&special::finished(&asset), is_second);
    let (json, _) = parse::split(&glb(&asset, &finished, &Unwatched).unwrap().bytes);
    let primitive = &json["meshes"][0]["primitives"][2];
    let mappings = &primitive["extensions"]["KHR_materials_variants"]["mappings"];
    assert_eq!((&primitive["material"], &mappings[0]["material"]), (&json!(2), &json!(2)));
    // The other material's copy reads the moved set, which is the same in both parts.
    let of_first = &json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"];
    assert_eq!((&of_first[0]["material"], &of_first[1]), (&json!(0), &mappings[1]));
    let channels = json["animations"][0]["channels"].as_array().unwrap();
    let named: Vec<_> =
        channels.iter().map(|c| &c["target"]["extensions"]["KHR_animation_pointer"]["pointer"]).collect();
    assert_eq!(named, [pointers[0], pointers[1], pointers[2], "/materials/2/emissiveFactor"]);
}

#[test]
fn a_file_is_judged_across_its_parts() {
    let (asset, whole) = indexed::sheet();
    let mut finished = split(&whole, is_second);
    let check = |finished: &Finished| {
        let back = written(&asset, finished);
        let read = extract(&back).unwrap().unwrap();
        measure::converted_file(&back, &read, &Unwatched).unwrap()
    };
    let sound = check(&finished);
    let joined = check(&whole);
    assert_eq!((sound.channels.len(), sound.layouts.len()), (1, 2));
    let count = |measured: &measure::Measured| measured.channels[0].levels[0].seams.unwrap().sample_count;
    assert_eq!(count(&sound), count(&joined));
    assert_eq!(sound.layouts.iter().map(|layout| layout.part).collect::<Vec<_>>(), [0, 1]);
    let faces = sound.layouts.iter().map(|layout| layout.face_count).sum::<u64>();
    assert_eq!(faces, joined.layouts[0].face_count);
    assert!(sound.channels[0].levels.iter().all(|level| level.seams.unwrap().max < 1.0));
    // The second part's texels a little brighter: nothing but the edges between the parts shows it.
    let image = &mut finished.textures[1].levels[2];
    let crate::image::Pixels::U8(codes) = &mut image.pixels else { panic!("8 bits") };
    codes.iter_mut().for_each(|code| *code = code.saturating_add(5));
    let broken = check(&finished);
    let seams = |level: usize| broken.channels[0].levels[level].seams.unwrap().max;
    assert!((seams(2) - 5.0).abs() < 1e-3 && seams(1) < 1.0, "{} {}", seams(2), seams(1));
}

#[test]
fn an_earlier_conversion_s_parts_are_forgotten() {
    let (asset, whole, _) = fixture::converted();
    let mut asset = asset;
    asset.document.json["materials"][0]["extensions"][EXTENSION] = json!({ "partOf": 1, "part": 3 });
    asset.document.json["materials"][1]["extensions"] = json!({ EXTENSION: { "part": 3 } });
    let (json, _) = parse::split(&glb(&asset, &whole, &Unwatched).unwrap().bytes);
    for material in json["materials"].as_array().unwrap() {
        assert_eq!(material.get("extensions").and_then(|own| own.get(EXTENSION)), None);
    }
}

#[test]
fn lies_about_parts_are_found() {
    let (asset, whole, _) = fixture::converted();
    let split = split(&whole, is_second);
    let lie = |pointer: &str, rule: &str, change: &dyn Fn(&mut Value)| {
        let mut back = written(&asset, &split);
        change(&mut back.document.json["materials"]);
        let error = extract(&back).unwrap_err();
        assert_eq!(error.code, ErrorCode::InvalidModel);
        let found = (error.pointer.unwrap_or_default(), error.detail);
        assert!(found.0.starts_with(pointer) && found.1.contains(rule), "{found:?}");
    };
    let own = |json: Value| move |materials: &mut Value| materials[2]["extensions"][EXTENSION] = json.clone();
    let part_of = "/materials/2/extensions/MCT_mesh_color_texture/partOf";
    let part = "/materials/2/extensions/MCT_mesh_color_texture/part";
    lie(part_of, "it is this one", &own(json!({ "partOf": 2, "part": 1 })));
    lie(part_of, "number of another material", &own(json!({ "partOf": 9, "part": 1 })));
    lie(part_of, "number of another material", &own(json!({ "partOf": "0", "part": 1 })));
    lie(part, "0 to 65535", &own(json!({ "partOf": 0, "part": -1 })));
    lie(part, "0 to 65535", &own(json!({ "partOf": 0, "part": 65536 })));
    lie(part, "both part 0 of material 0", &own(json!({ "partOf": 0 })));
    lie(part_of, "a part itself", &|materials| {
        materials[0]["extensions"][EXTENSION] = json!({ "partOf": 1, "part": 5 });
    });
    lie("/materials/0", "same channels", &|materials| {
        materials[2].as_object_mut().unwrap().remove("normalTexture");
    });
}
