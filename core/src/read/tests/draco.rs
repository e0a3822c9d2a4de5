//! Primitives compressed by `KHR_draco_mesh_compression`. The streams are from the reference encoder (draco3d 1.5.7).

use glam::{Vec2, Vec3};

use super::*;
use crate::asset::Primitive;

/// Two triangles over four vertices, nothing quantized, sequential connectivity.
const SEQUENTIAL: &str = "\
     445241434f020201000000020401000102020103010500090300000109030001030902000202020300030404040004000000010100000000\
     00000000000000000000803f0000000000000000000000000000803f000000000000803f0000803f0000003f00000000000000000000803f\
     00000000000000000000803f00000000000000000000803f00000000000000000000803f00000000000000000000803f0000000000000000\
     0000803f0000803f0000803f00010101013d55054b55054b55054b053004baa2d0970a0000007800000000010100060b0110012001100300\
     9090108d8888888810ba000000002c010000";
/// The same with 12 bits for positions and texture coordinates, 8 for normals, edgebreaker with valences.
const EDGEBREAKER: &str = "\
     445241434f02020101000000040204020000011fff0111ff0111ff0111ff0111ff011105ff00010000000100000200000300000100090300\
     000201010903000103010309020002020102020300030101040404000401010101000d0301200110230110030030904a002000fe1f000000\
     00ff0f00000000000000000000000000000000803f0c060301000903011017013003002882d515d515c11f00ff0000007f000000ff024440\
     0805010100030301300110030024822600020000008002807000000000ff0f000000000000000000000000803f0c0101010105660110e701\
     100355054b55054b59150600e67c876f800a0000007800000001010100060b01200301200300e8835052fbff10c207c0000000002c010000";
/// A triangle whose weights are quantized to 7 bits, those of the first vertex a quarter each.
const WEIGHTS: &str = "\
     445241434f02020100000001030100010201020009030000040904000100020000000000000000000000000000803f000000000000000000\
     0000000000803f000000000001010008175515ad2a03fb6f812aa3d198368e1ab84ddf000000007f000000cdcccc3d000000000000000000\
     0000006666663f07";

fn bytes(hex: &str) -> Vec<u8> {
    let digits: Vec<u32> = hex.chars().filter_map(|digit| digit.to_digit(16)).collect();
    digits.chunks(2).map(|pair| (pair[0] * 16 + pair[1]) as u8).collect()
}

fn compressed(stream: &[u8]) -> Gltf {
    let mut gltf = Gltf::triangle();
    gltf.bin.clear();
    gltf.json["bufferViews"] = json!([]);
    gltf.json["accessors"] = json!([
        { "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, 0], "max": [1, 1, 0.5] },
        { "componentType": 5126, "count": 4, "type": "VEC3" },
        { "componentType": 5126, "count": 4, "type": "VEC2" },
        { "componentType": 5121, "count": 4, "type": "VEC3", "normalized": true },
        { "componentType": 5123, "count": 4, "type": "VEC4" },
        { "componentType": 5123, "count": 6, "type": "SCALAR" },
    ]);
    let view = gltf.view(stream);
    gltf.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    gltf.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    *gltf.primitive() = json!({
        "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3, "JOINTS_0": 4 },
        "indices": 5,
        "extensions": { "KHR_draco_mesh_compression": {
            "bufferView": view,
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3, "JOINTS_0": 4 },
        } },
    });
    gltf
}

/// A file for the mutations.
pub(super) fn seed() -> Vec<u8> {
    compressed(&bytes(EDGEBREAKER)).glb()
}

const POSITIONS: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.5)];
const COLORS: [[u8; 3]; 4] = [[10, 20, 30], [40, 50, 60], [70, 80, 90], [100, 110, 120]];
const JOINTS: [[u16; 4]; 4] = [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11], [12, 13, 14, 300]];

/// The number in the source of each vertex: encoders put them in an order of their own.
fn numbers(primitive: &Primitive, tolerance: f32) -> Vec<usize> {
    let near = |position: &Vec3| POSITIONS.iter().position(|p| p.distance(*position) <= tolerance).unwrap();
    primitive.positions.iter().map(near).collect()
}

fn check(primitive: &Primitive, tolerance: f32) {
    let numbers = numbers(primitive, tolerance);
    let attribute = |name: &str| {
        let found = primitive.attributes.iter().find(|attribute| attribute.semantic == name).unwrap();
        found.bytes.chunks_exact(found.element_bytes).map(<[u8]>::to_vec).collect::<Vec<_>>()
    };
    let (colors, joints) = (attribute("COLOR_0"), attribute("JOINTS_0"));
    for (vertex, &number) in numbers.iter().enumerate() {
        let uv = Vec2::new(POSITIONS[number].x, POSITIONS[number].y);
        assert!(primitive.texcoords[0][vertex].distance(uv) <= tolerance);
        // Octahedral normals of 8 bits are off by 2 / 255 at most.
        assert!(primitive.normals[vertex].distance(Vec3::Z) <= 0.008);
        assert_eq!(colors[vertex][..3], COLORS[number]);
        assert_eq!(joints[vertex], JOINTS[number].iter().flat_map(|j| j.to_le_bytes()).collect::<Vec<u8>>());
    }
    let mut faces: Vec<[usize; 3]> = primitive
        .faces
        .iter()
        .map(|face| {
            let mut face: Vec<usize> =
                face.corners().iter().map(|&corner| numbers[corner as usize]).collect();
            let least = (0..3).min_by_key(|&k| face[k]).unwrap();
            face.rotate_left(least);
            [face[0], face[1], face[2]]
        })
        .collect();
    faces.sort_unstable();
    assert_eq!(faces, [[0, 1, 2], [1, 3, 2]]);
}

#[test]
fn streams_of_the_reference_encoder_are_read() {
    let exact = compressed(&bytes(SEQUENTIAL)).read().unwrap();
    check(&exact.meshes[0].primitives[0], 0.0);
    let near = compressed(&bytes(EDGEBREAKER)).read().unwrap();
    check(&near.meshes[0].primitives[0], 1.0 / 4095.0);
}

#[test]
fn the_document_is_left_without_compression() {
    let asset = compressed(&bytes(SEQUENTIAL)).read().unwrap();
    let json = &asset.document.json;
    assert!(json["meshes"][0]["primitives"][0].get("extensions").is_none());
    // The stream's view has become one of the plain ones.
    assert_eq!(json["bufferViews"].as_array().unwrap().len(), 6);
    // What the file said of the smallest was of other numbers.
    assert_eq!(json["accessors"][0]["min"], json!([0.0, 0.0, 0.0]));
    for (accessor, bytes) in [(0, 48), (3, 16), (5, 12)] {
        let view = json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
        let buffer = json["bufferViews"][view]["buffer"].as_u64().unwrap() as usize;
        assert_eq!(asset.document.buffers[buffer].len(), bytes);
    }
}

#[test]
fn a_written_file_is_plain() {
    let asset = compressed(&bytes(SEQUENTIAL)).read().unwrap();
    let glb = crate::write::glb(&asset, &crate::finished::Finished::default(), &Unwatched).unwrap();
    let text = String::from_utf8_lossy(&glb.bytes).into_owned();
    assert!(!text.contains("draco"));
    check(&read_bytes(glb.bytes).unwrap().meshes[0].primitives[0], 0.0);
}

#[test]
fn a_primitive_with_a_plain_form_is_read_from_that() {
    let mut gltf = Gltf::triangle();
    let indices = gltf.accessor("SCALAR", 5121, 3, &[0, 1, 2]);
    let view = gltf.view(b"DRACO, but broken");
    gltf.primitive()["indices"] = json!(indices);
    gltf.primitive()["extensions"]["KHR_draco_mesh_compression"] =
        json!({ "bufferView": view, "attributes": { "POSITION": 0 } });
    assert_eq!(gltf.read().unwrap().meshes[0].primitives[0].positions.len(), 3);
}

#[test]
fn what_does_not_fit_is_refused_at_its_place() {
    const AT: &str = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    const PRIMITIVE: &str = "/meshes/0/primitives/0";
    type Change = fn(&mut Gltf);
    let cases: [(&str, Change); 11] = [
        (AT, |g| {
            g.json["accessors"].as_array_mut().unwrap()[..5].iter_mut().for_each(|a| a["count"] = json!(5))
        }),
        (AT, |g| g.json["accessors"][5]["count"] = json!(3)),
        (AT, |g| g.json["accessors"][2]["type"] = json!("VEC3")),
        (AT, |g| g.json["accessors"][4]["componentType"] = json!(5121)),
        (AT, |g| {
            g.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] = json!(9)
        }),
        (AT, |g| g.json["bufferViews"][0]["byteLength"] = json!(100)),
        (AT, |g| g.bin.fill(0xFF)),
        ("/accessors/1", |g| g.json["accessors"][1]["count"] = json!(3)),
        ("/accessors/5", |g| g.json["accessors"][5]["type"] = json!("VEC2")),
        (PRIMITIVE, |g| g.primitive()["mode"] = json!(5)),
        (PRIMITIVE, |g| drop(g.primitive().as_object_mut().unwrap().remove("indices"))),
    ];
    for (number, (pointer, change)) in cases.into_iter().enumerate() {
        let mut gltf = compressed(&bytes(SEQUENTIAL));
        change(&mut gltf);
        let error = gltf.read().expect_err("must be refused");
        let found = (error.code, error.pointer.as_deref());
        assert_eq!(found, (ErrorCode::InvalidModel, Some(pointer)), "case {number}: {error}");
    }
}

#[test]
fn counts_are_held_against_the_limits_before_anything_is_decoded() {
    let mut gltf = compressed(&bytes(SEQUENTIAL));
    for accessor in gltf.json["accessors"].as_array_mut().unwrap() {
        accessor["count"] = json!(9_007_199_254_740_992u64);
    }
    let error = gltf.read().unwrap_err();
    assert_eq!(error.code, ErrorCode::ModelTooLarge, "{error}");
    // The stream is not looked at.
    let file = compressed(&[0xFF; 100]).glb();
    let limits = [
        (ErrorCode::ModelTooLarge, Limits { vertices: 3, ..Limits::default() }),
        (ErrorCode::TooManyTriangles, Limits { triangles: 1, ..Limits::default() }),
        (ErrorCode::InvalidModel, Limits::default()),
    ];
    for (code, limits) in limits {
        let error = read_limited(file.clone(), limits).unwrap_err();
        assert_eq!(error.code, code, "{error}");
    }
}

#[test]
fn an_accessor_of_two_streams_is_refused() {
    let mut gltf = compressed(&bytes(SEQUENTIAL));
    let first = gltf.primitive().clone();
    // The same again is no contradiction.
    gltf.json["meshes"][0]["primitives"] = json!([first.clone(), first]);
    assert_eq!(gltf.read().unwrap().meshes[0].primitives.len(), 2);
    let view = gltf.view(&bytes(EDGEBREAKER));
    gltf.json["meshes"][0]["primitives"][1]["extensions"]["KHR_draco_mesh_compression"]["bufferView"] =
        json!(view);
    gltf.refused(ErrorCode::InvalidModel, "/accessors/0");
}

/// Quantized weights add up to 1 again, as those of the source did.
#[test]
fn weights_add_up_to_one() {
    let mut gltf = compressed(&bytes(WEIGHTS));
    gltf.json["accessors"] = json!([
        { "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
        { "componentType": 5126, "count": 3, "type": "VEC4" },
        { "componentType": 5123, "count": 3, "type": "SCALAR" },
    ]);
    gltf.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"] =
        json!({ "POSITION": 0, "WEIGHTS_0": 1 });
    gltf.primitive()["attributes"] = json!({ "POSITION": 0, "WEIGHTS_0": 1 });
    gltf.primitive()["indices"] = json!(2);
    let asset = gltf.read().unwrap();
    let weights = &asset.meshes[0].primitives[0].attributes[0];
    assert_eq!(weights.semantic, "WEIGHTS_0");
    let weights: Vec<f32> =
        weights.bytes.chunks(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect();
    assert_eq!(weights.len(), 12);
    for vertex in weights.chunks(4) {
        assert!((vertex.iter().sum::<f32>() - 1.0).abs() < 2e-7, "{vertex:?}");
    }
    // The sum of the stream's own is 0.9929.
    assert!((weights[0] - 0.2506).abs() < 1e-4, "{weights:?}");
}
