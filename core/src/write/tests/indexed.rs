//! Indexed coordinates in files: round trips, types, sharing, and files that lie.

use glam::Vec2;
use serde_json::{Value, json};

use super::{fixture, parse};
use crate::asset::{Asset, Attribute, Document, EncodedImage};
use crate::error::ErrorCode;
use crate::finished::{Anchor, Coordinates, Finished, extract, hand_made};
use crate::watch::Unwatched;
use crate::write::glb;

/// The sheet with a document to write it into.
pub fn sheet() -> (Asset, Finished) {
    let (mut asset, finished) = hand_made::sheet();
    let file =
        EncodedImage { media_type: "image/png".into(), bytes: crate::write::png(&asset.images[0]).unwrap() };
    asset.document = Document {
        json: json!({
            "asset": { "version": "2.0" },
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "material": 0 }] }],
            "materials": [{ "occlusionTexture": { "index": 0 } }],
            "textures": [{ "source": 0 }],
            "images": [{ "name": "sheet" }],
        }),
        buffers: Vec::new(),
        encoded_images: vec![file],
    };
    (asset, finished)
}

fn written(asset: &Asset, finished: &Finished) -> Vec<u8> {
    glb(asset, finished, &Unwatched).unwrap().bytes
}

fn extension(json: &Value) -> &Value {
    &json["meshes"][0]["primitives"][0]["extensions"]["MCT_mesh_color_texture"]
}

#[test]
fn indexed_coordinates_come_back_to_the_bit() {
    let (asset, mut finished) = sheet();
    let mut bits = vec![0; finished.primitives[0].triangles.len()];
    bits[3] = 0b010;
    finished.primitives[0].cuts = vec![crate::finished::PrimitiveCuts { texture: 0, bits }];
    let back = parse::asset(&written(&asset, &finished));
    let read = extract(&back).unwrap().unwrap();
    assert_eq!(read.textures, finished.textures);
    let (piece, wrote) = (&read.primitives[0], &finished.primitives[0]);
    assert_eq!((&piece.coordinates, &piece.cuts), (&wrote.coordinates, &wrote.cuts));
    let size =
        Vec2::new(finished.textures[0].levels[0].width as f32, finished.textures[0].levels[0].height as f32);
    for (number, (read, old)) in piece.triangles.iter().zip(&wrote.triangles).enumerate() {
        assert_eq!((read.corners, read.anchor), (old.corners, old.anchor));
        for k in 0..3 {
            let positions = |asset: &Asset| asset.meshes[0].primitives[0].positions.clone();
            let vertex = read.vertices[k] as usize;
            assert_eq!(positions(&back)[vertex], positions(&asset)[old.vertices[k] as usize]);
            let texcoord = back.meshes[0].primitives[0].texcoords[0][vertex];
            assert_eq!(texcoord, wrote.place(number, k, 0) / size);
        }
    }
}

#[test]
fn the_table_stands_in_the_extension_as_the_bundle_says() {
    let (asset, finished) = sheet();
    let (json, _) = parse::split(&written(&asset, &finished));
    let coordinates = &extension(&json)["coordinates"];
    assert_eq!(
        coordinates["classes"][3],
        json!({ "r": 2, "s": 2, "cells": [1, 1], "gap": [4, 1], "shift": [3, 0] })
    );
    assert_eq!(coordinates["classes"][5]["r"], 3);
    assert_eq!(coordinates["classes"][5]["s"], 1);
    let table = hand_made::table();
    assert_eq!(coordinates["levels"].as_array().unwrap().len(), hand_made::LEVEL_COUNT);
    assert_eq!(coordinates["levels"][1]["columns"], json!(table.levels[1].columns));
    assert_eq!(coordinates["levels"][1]["origin"], json!(table.levels[1].origins));
    let primitive = &json["meshes"][0]["primitives"][0];
    let names: Vec<&String> = primitive["attributes"].as_object().unwrap().keys().collect();
    assert!(names.iter().all(|name| *name != "_MCT_SCALED" && *name != "_MCT_OFFSET"), "{names:?}");
}

#[test]
fn inner_corners_of_a_larger_block_are_shared() {
    let (asset, finished) = sheet();
    let vertices = |asset: &Asset, finished: &Finished| {
        let glb = glb(asset, finished, &Unwatched).unwrap();
        let back = parse::asset(&glb.bytes);
        assert_eq!(back.meshes[0].primitives[0].positions.len() as u64, glb.vertex_count);
        glb.vertex_count
    };
    assert_eq!(vertices(&asset, &finished), hand_made::VERTEX_COUNT as u64);
    // The second quad as its neighbor's mirror image: their common corners differ by the block alone.
    let mut mirrored = finished.clone();
    for triangle in &mut mirrored.primitives[0].triangles[2..4] {
        triangle.corners = triangle.corners.map(|corner| Vec2::new(1.0 - corner.x, corner.y));
    }
    assert_eq!(vertices(&asset, &mirrored), hand_made::VERTEX_COUNT as u64);
}

/// A chart's border runs through the larger block: its vertices are there twice, told apart by what is not
/// written any more.
#[test]
fn corners_are_shared_across_charts_of_the_source() {
    let (mut asset, mut finished) = sheet();
    let primitive = &mut asset.meshes[0].primitives[0];
    let count = primitive.positions.len() as u32;
    primitive.positions.extend_from_within(..);
    let twins = primitive.texcoords[0].iter().map(|uv| 1.0 - *uv).collect::<Vec<_>>();
    primitive.texcoords[0].extend(twins);
    for triangle in finished.primitives[0].triangles.iter_mut().skip(9) {
        triangle.vertices = triangle.vertices.map(|vertex| vertex + count);
    }
    let glb = glb(&asset, &finished, &Unwatched).unwrap();
    assert_eq!(glb.vertex_count, hand_made::VERTEX_COUNT as u64);
}

/// The accessor of the local coordinates, and the stride of its view.
fn local(glb: &[u8]) -> (u64, u64) {
    let (json, _) = parse::split(glb);
    let number = json["meshes"][0]["primitives"][0]["attributes"]["_MCT_LOCAL"].as_u64().unwrap();
    let accessor = &json["accessors"][number as usize];
    assert_eq!((&accessor["type"], accessor.get("normalized")), (&"VEC2".into(), None));
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    assert_eq!(view["byteOffset"].as_u64().unwrap_or(0) % 4, 0);
    (accessor["componentType"].as_u64().unwrap(), view["byteStride"].as_u64().unwrap_or(0))
}

#[test]
fn local_coordinates_take_the_smallest_type_that_holds_them() {
    let (asset, finished) = sheet();
    let with = |cells: u32, corner: f32| {
        let mut finished = finished.clone();
        let mut table = hand_made::table();
        table.classes[4].cells = [cells, 2];
        for level in &mut finished.textures[0].levels {
            *level = fixture::noise(2000, 100, 3, 1);
        }
        let triangle = finished.primitives[0]
            .triangles
            .iter_mut()
            .find(|triangle| matches!(triangle.anchor, Anchor::Block { class: 4, .. }));
        triangle.unwrap().corners[1].x = corner;
        finished.primitives[0].coordinates = Coordinates::Indexed(table.into());
        let glb = written(&asset, &finished);
        let read = extract(&parse::asset(&glb)).unwrap().unwrap();
        let corners = |finished: &Finished| -> Vec<[Vec2; 3]> {
            finished.primitives[0].triangles.iter().map(|triangle| triangle.corners).collect()
        };
        assert_eq!(corners(&read), corners(&finished));
        local(&glb)
    };
    const BYTE: u64 = 5121;
    const SHORT: u64 = 5123;
    const FLOAT: u64 = 5126;
    assert_eq!(with(2, 1.0), (BYTE, 4));
    assert_eq!(with(300, 255.0), (BYTE, 4));
    assert_eq!(with(300, 256.0), (SHORT, 0));
    assert_eq!(with(2, 0.5), (FLOAT, 0));
}

#[test]
fn numbers_that_floats_do_not_hold_are_not_written() {
    let (asset, mut finished) = sheet();
    finished.primitives[0].triangles[0].anchor = Anchor::Block { class: 0, number: (1 << 24) + 1 };
    let error = glb(&asset, &finished, &Unwatched).unwrap_err();
    assert_eq!(error.code, ErrorCode::Internal);
    assert!(error.detail.contains("below 16777216"), "{error}");
}

/// The error's place and text after a change to a sound file.
fn lie(change: impl FnOnce(&mut Asset)) -> (String, String) {
    let (asset, finished) = sheet();
    let mut asset = parse::asset(&written(&asset, &finished));
    assert!(extract(&asset).unwrap().is_some());
    change(&mut asset);
    let error = extract(&asset).unwrap_err();
    assert_eq!(error.code, ErrorCode::InvalidModel);
    (error.pointer.unwrap_or_default(), error.detail)
}

fn expect(lie: (String, String), pointer: &str, rule: &str) {
    assert!(lie.0 == format!("/meshes/0/primitives/0{pointer}") && lie.1.contains(rule), "{lie:?}");
}

fn attribute<'a>(asset: &'a mut Asset, name: &str) -> &'a mut Attribute {
    let attributes = &mut asset.meshes[0].primitives[0].attributes;
    attributes.iter_mut().find(|attribute| attribute.semantic == name).unwrap()
}

#[test]
fn attributes_of_indexed_coordinates_are_complete_and_sound() {
    for name in ["_MCT_BLOCK", "_MCT_LOCAL"] {
        let missing = lie(|asset| attribute(asset, name).semantic = "_OTHER".to_owned());
        expect(missing, "/attributes", &format!("{name} is missing"));
        let at = format!("/attributes/{name}");
        expect(lie(|asset| attribute(asset, name).kind = "VEC3".to_owned()), &at, "VEC2");
        expect(lie(|asset| attribute(asset, name).normalized = true), &at, "not normalized");
        expect(lie(|asset| attribute(asset, name).component_type = 5125), &at, "VEC2 of FLOAT");
        let short = lie(|asset| {
            attribute(asset, name).bytes.pop();
        });
        expect(short, &at, "one for each vertex");
    }
    let block = |value: f32, at: usize| {
        lie(move |asset| {
            attribute(asset, "_MCT_BLOCK").bytes[at..at + 4].copy_from_slice(&value.to_le_bytes())
        })
    };
    let at = "/attributes/_MCT_BLOCK";
    for value in [0.5, -1.0, f32::NAN, f32::INFINITY, 1e9] {
        expect(block(value, 0), at, "triangle 0: number and class have to be whole numbers");
        expect(block(value, 4), at, "triangle 0: number and class have to be whole numbers");
    }
    // Of the second corner both, of the third the number.
    for byte in [8, 12, 16] {
        let rule = "triangle 0: number and class have to be the same at all three corners";
        expect(block(1.0, byte), at, rule);
    }
    let far = lie(|asset| attribute(asset, "_MCT_LOCAL").bytes[0] = 2);
    expect(
        far,
        "/attributes/_MCT_LOCAL",
        "triangle 0: every value has to be within the block's 1 by 1 faces",
    );
    let all = lie(|asset| {
        for vertex in attribute(asset, "_MCT_BLOCK").bytes.chunks_exact_mut(8) {
            vertex[4..].copy_from_slice(&6f32.to_le_bytes());
        }
    });
    expect(all, at, "triangle 0: there is no class 6, the table has 6");
}

/// A file whose table was changed.
fn table_lie(change: impl FnOnce(&mut Value)) -> (String, String) {
    lie(|asset| {
        let primitive = &mut asset.document.json["meshes"][0]["primitives"][0];
        change(&mut primitive["extensions"]["MCT_mesh_color_texture"]["coordinates"]);
    })
}

#[test]
fn tables_are_whole_numbers_that_fit() {
    let place = "/extensions/MCT_mesh_color_texture/coordinates";
    let at = |below: &str| format!("{place}{below}");
    expect(table_lie(|table| *table = json!(7)), place, "\"classes\" has to be a list of objects");
    expect(table_lie(|table| table["levels"] = Value::Null), place, "\"levels\" has to be a list of objects");
    expect(table_lie(|table| table["classes"] = json!([])), &at("/classes"), "1 to 4096 classes");
    for value in [json!(21), json!(300), json!(-1), json!(2.5), json!("3"), Value::Null] {
        expect(
            table_lie(|table| table["classes"][2]["s"] = value),
            &at("/classes/2"),
            "\"r\" and \"s\" have to be 0 to 20",
        );
    }
    for name in ["cells", "gap", "shift"] {
        for value in [json!([1]), json!([1, 2, 3]), json!([1, -1]), json!([1, 1u64 << 40]), json!(1)] {
            let rule = format!("\"{name}\" has to be two whole numbers");
            expect(table_lie(|table| table["classes"][0][name] = value), &at("/classes/0"), &rule);
        }
    }
    expect(
        table_lie(|table| table["classes"][0]["cells"][1] = 0.into()),
        &at("/classes/0"),
        "\"cells\" has to be 1 to",
    );
    let level = at("/levels/1");
    expect(
        table_lie(|table| table["levels"][1]["columns"] = json!({})),
        &level,
        "\"columns\" has to be a list",
    );
    expect(
        table_lie(|table| table["levels"][1]["columns"][0] = json!(1.5)),
        &level,
        "\"columns\" has to be a list",
    );
    expect(table_lie(|table| table["levels"][1]["columns"][0] = json!(0)), &level, "at least 1");
    expect(
        table_lie(|table| table["levels"][1]["origin"][0] = json!([1])),
        &level,
        "\"origin\" has to be a list of pairs",
    );
    expect(
        table_lie(|table| table["levels"][1]["origin"][0] = json!([900, 0])),
        &level,
        "leaves the image of level 1",
    );
    expect(
        table_lie(|table| table["levels"][1]["origin"] = json!([])),
        &level,
        "one entry for each of 6 classes",
    );
    let fewer = table_lie(|table| {
        table["levels"].as_array_mut().unwrap().pop();
    });
    expect(fewer, &at("/levels"), "there are 5 levels");
}

#[test]
fn a_file_without_its_table_lacks_the_other_attributes() {
    let bare = lie(|asset| {
        asset.document.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("extensions");
    });
    expect(bare, "/attributes", "_MCT_SCALED is missing");
}
