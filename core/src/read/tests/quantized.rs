//! Attributes of `KHR_mesh_quantization`, quantized by hand.

use super::*;
use crate::asset::Primitive;

const EXTENSION: &str = "KHR_mesh_quantization";

/// Codes and what they stand for: at both ends and between them.
fn codes(component: u32, normalized: bool) -> [(i32, f32); 4] {
    match (component, normalized) {
        (5120, false) => [(-128, -128.0), (-1, -1.0), (0, 0.0), (127, 127.0)],
        (5120, true) => [(-128, -1.0), (-127, -1.0), (-1, -1.0 / 127.0), (127, 1.0)],
        (5121, false) => [(0, 0.0), (1, 1.0), (128, 128.0), (255, 255.0)],
        (5121, true) => [(0, 0.0), (51, 0.2), (128, 128.0 / 255.0), (255, 1.0)],
        (5122, false) => [(-32768, -32768.0), (-1, -1.0), (300, 300.0), (32767, 32767.0)],
        (5122, true) => [(-32768, -1.0), (-32767, -1.0), (300, 300.0 / 32767.0), (32767, 1.0)],
        (5123, false) => [(0, 0.0), (300, 300.0), (32768, 32768.0), (65535, 65535.0)],
        _ => [(0, 0.0), (13107, 0.2), (32768, 32768.0 / 65535.0), (65535, 1.0)],
    }
}

fn bytes(component: u32, code: i32) -> Vec<u8> {
    match component {
        5120 | 5121 => vec![code as u8],
        _ => (code as u16).to_le_bytes().to_vec(),
    }
}

/// Three elements of `width` codes, each padded to four bytes; accessor, and the numbers.
fn attribute(gltf: &mut Gltf, width: usize, (component, normalized): (u32, bool)) -> (usize, Vec<f32>) {
    let codes = codes(component, normalized);
    let mut packed = Vec::new();
    let mut numbers = Vec::new();
    for element in 0..3 {
        for k in 0..width {
            let (code, number) = codes[(element + k) % 4];
            packed.extend(bytes(component, code));
            numbers.push(number);
        }
        packed.resize(packed.len().next_multiple_of(4), 0xEE);
    }
    let stride = packed.len() / 3;
    let index = gltf.accessor(["", "SCALAR", "VEC2", "VEC3", "VEC4"][width], component, 3, &packed);
    let view = gltf.json["accessors"][index]["bufferView"].as_u64().unwrap() as usize;
    gltf.json["bufferViews"][view]["byteStride"] = json!(stride);
    gltf.json["accessors"][index]["normalized"] = json!(normalized);
    (index, numbers)
}

fn values(primitive: &Primitive, semantic: &str) -> Vec<f32> {
    match semantic {
        "POSITION" => primitive.positions.iter().flat_map(|v| v.to_array()).collect(),
        _ => primitive.texcoords[0].iter().flat_map(|v| v.to_array()).collect(),
    }
}

/// A triangle that may be quantized, with an attribute of this type.
fn with(semantic: &str, width: usize, kind: (u32, bool)) -> (Gltf, usize, Vec<f32>) {
    let mut gltf = Gltf::triangle();
    gltf.json["extensionsUsed"] = json!([EXTENSION]);
    gltf.json["extensionsRequired"] = json!([EXTENSION]);
    let (index, numbers) = attribute(&mut gltf, width, kind);
    gltf.primitive()["attributes"][semantic] = json!(index);
    (gltf, index, numbers)
}

fn all_kinds() -> impl Iterator<Item = (u32, bool)> {
    [5120, 5121, 5122, 5123].into_iter().flat_map(|component| [(component, false), (component, true)])
}

#[test]
fn positions_and_texture_coordinates_stand_for_their_numbers_exactly() {
    for kind in all_kinds() {
        for (semantic, width) in [("POSITION", 3), ("TEXCOORD_0", 2)] {
            let (gltf, _, numbers) = with(semantic, width, kind);
            let primitive = gltf.read().unwrap().meshes.remove(0).primitives.remove(0);
            assert_eq!(values(&primitive, semantic), numbers, "{semantic} {kind:?}");
        }
    }
}

#[test]
fn normals_and_tangents_keep_their_directions() {
    for kind in [(5120, true), (5122, true)] {
        let (gltf, _, numbers) = with("NORMAL", 3, kind);
        let read = gltf.read().unwrap();
        for (normal, exact) in read.meshes[0].primitives[0].normals.iter().zip(numbers.chunks(3)) {
            let exact = glam::Vec3::from_slice(exact).normalize();
            assert!((*normal - exact).abs().max_element() < 1e-6, "{kind:?}");
        }
        let (gltf, _, numbers) = with("TANGENT", 4, kind);
        let read = gltf.read().unwrap();
        for (tangent, exact) in read.meshes[0].primitives[0].tangents.iter().zip(numbers.chunks(4)) {
            let direction = glam::Vec3::from_slice(exact).normalize();
            assert!((tangent.truncate() - direction).abs().max_element() < 1e-6, "{kind:?}");
            assert_eq!(tangent.w, if exact[3] < 0.0 { -1.0 } else { 1.0 });
        }
    }
}

#[test]
fn types_that_the_extension_lacks_are_refused() {
    for kind in all_kinds() {
        for (semantic, width) in [("NORMAL", 3), ("TANGENT", 4)] {
            let (gltf, index, _) = with(semantic, width, kind);
            if matches!(kind, (5120 | 5122, true)) {
                gltf.read().unwrap();
            } else {
                gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}"));
            }
        }
        for (semantic, width) in [("POSITION", 2), ("NORMAL", 4), ("TANGENT", 3), ("TEXCOORD_0", 3)] {
            let (gltf, index, _) = with(semantic, width, kind);
            let error = gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}"));
            assert!(error.detail.contains(semantic), "{error}");
        }
    }
}

#[test]
fn a_file_that_does_not_name_the_extension_has_none_of_it() {
    for kind in all_kinds() {
        for (semantic, width) in [("POSITION", 3), ("NORMAL", 3), ("TANGENT", 4), ("TEXCOORD_0", 2)] {
            let (mut gltf, index, _) = with(semantic, width, kind);
            gltf.json["extensionsUsed"] = json!([]);
            gltf.json["extensionsRequired"] = json!([]);
            if semantic == "TEXCOORD_0" && matches!(kind, (5121 | 5123, true)) {
                gltf.read().unwrap();
                continue;
            }
            let error = gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}"));
            assert!(error.detail.contains(semantic), "{error}");
        }
    }
}
