//! Every accessor form, and what hostile ones say (B4 of the abuse list).

use glam::{Vec2, Vec3};

use super::*;
use crate::asset::Primitive;

fn read_primitive(gltf: &Gltf) -> Primitive {
    gltf.read().unwrap().meshes.remove(0).primitives.remove(0)
}

#[test]
fn texture_coordinates_of_all_types() {
    let expected = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.2, 0.4)];
    let u8s = [0u8, 255, 255, 0, 51, 102];
    let u16s: Vec<u8> = [0u16, 65535, 65535, 0, 13107, 26214].iter().flat_map(|n| n.to_le_bytes()).collect();
    for (component, bytes) in [(5121, u8s.to_vec()), (5123, u16s)] {
        let mut gltf = Gltf::triangle();
        let index = gltf.accessor("VEC2", component, 3, &bytes);
        gltf.json["accessors"][index]["normalized"] = json!(true);
        gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(index);
        let primitive = read_primitive(&gltf);
        for (read, expected) in primitive.texcoords[0].iter().zip(expected) {
            assert!((*read - expected).abs().max_element() < 1e-6, "{component}: {read}");
        }
        gltf.json["accessors"][index]["normalized"] = json!(false);
        gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}"));
    }
}

#[test]
fn indices_of_all_types() {
    for (component, bytes) in [
        (5121, vec![2u8, 0, 1]),
        (5123, vec![2, 0, 0, 0, 1, 0]),
        (5125, vec![2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]),
    ] {
        let mut gltf = Gltf::triangle();
        let index = gltf.accessor("SCALAR", component, 3, &bytes);
        gltf.primitive()["indices"] = json!(index);
        assert_eq!(read_primitive(&gltf).faces[0].corners(), [2, 0, 1], "{component}");
    }
    let mut gltf = Gltf::triangle();
    let index = gltf.accessor("SCALAR", 5122, 3, &[0; 6]);
    gltf.primitive()["indices"] = json!(index);
    gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}"));
}

#[test]
fn indices_out_of_range_and_restarts_are_refused() {
    for (bytes, words) in [([0u8, 1, 3], "3 vertices"), ([0, 1, 255], "restarts")] {
        let mut gltf = Gltf::triangle();
        let index = gltf.accessor("SCALAR", 5121, 3, &bytes);
        gltf.primitive()["indices"] = json!(index);
        let error = gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}"));
        assert!(error.detail.contains(words), "{error}");
    }
}

#[test]
fn strides_and_offsets_are_followed() {
    let mut gltf = Gltf::triangle();
    // Position and coordinate interleaved behind four bytes of something else.
    let mut bytes = vec![9u8; 4];
    for vertex in 0..3u8 {
        for number in [f32::from(vertex), 5.0, 6.0, 0.25, 0.5] {
            bytes.extend(number.to_le_bytes());
        }
    }
    let view = gltf.view(&bytes);
    gltf.json["bufferViews"][view]["byteStride"] = json!(20);
    let of = |offset: usize, kind: &str| json!({ "bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 3, "type": kind });
    let positions = gltf.push("accessors", of(4, "VEC3"));
    let uv = gltf.push("accessors", of(16, "VEC2"));
    gltf.primitive()["attributes"] = json!({ "POSITION": positions, "TEXCOORD_0": uv });
    let primitive = read_primitive(&gltf);
    assert_eq!(primitive.positions[2], Vec3::new(2.0, 5.0, 6.0));
    assert_eq!(primitive.texcoords[0][2], Vec2::new(0.25, 0.5));
    gltf.json["accessors"][uv]["byteOffset"] = json!(20);
    gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{uv}"));
}

fn sparse(gltf: &mut Gltf, index_type: u32, indices: &[u8], base: bool) -> usize {
    let index_view = gltf.view(indices);
    let values: Vec<u8> = [7.0f32, 8.0, 9.0].iter().flat_map(|n| n.to_le_bytes()).collect();
    let value_view = gltf.view(&values);
    let mut accessor = json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": {
        "count": 1,
        "indices": { "bufferView": index_view, "componentType": index_type },
        "values": { "bufferView": value_view },
    }});
    if base {
        accessor["bufferView"] = json!(0);
    }
    let index = gltf.push("accessors", accessor);
    gltf.primitive()["attributes"]["POSITION"] = json!(index);
    index
}

#[test]
fn sparse_elements_replace_those_of_the_view() {
    for (index_type, indices) in [(5121, vec![1u8]), (5123, vec![1, 0]), (5125, vec![1, 0, 0, 0])] {
        for base in [true, false] {
            let mut gltf = Gltf::triangle();
            sparse(&mut gltf, index_type, &indices, base);
            let first = if base { Vec3::Y } else { Vec3::ZERO };
            let positions = read_primitive(&gltf).positions;
            assert_eq!(positions, [Vec3::ZERO, Vec3::new(7.0, 8.0, 9.0), first], "{index_type} {base}");
        }
    }
}

#[test]
fn sparse_indices_are_checked() {
    let mut gltf = Gltf::triangle();
    let index = sparse(&mut gltf, 5121, &[3], true);
    gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}/sparse/indices"));
    let mut gltf = Gltf::triangle();
    let index = sparse(&mut gltf, 5122, &[1, 0], true);
    gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}/sparse/indices"));
    let mut gltf = Gltf::triangle();
    let index = sparse(&mut gltf, 5121, &[1, 1], true);
    gltf.json["accessors"][index]["sparse"]["count"] = json!(2);
    gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}/sparse/values"));
    // Values long enough: now the order is what is wrong.
    gltf.json["accessors"][index]["sparse"]["values"]["bufferView"] = json!(0);
    gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}/sparse/indices"));
    gltf.json["accessors"][index]["sparse"]["count"] = json!(4);
    gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}/sparse"));
}

/// What a file says about accessor 0 or its view, and where the refusal points.
#[test]
fn lying_accessors_and_views_are_refused() {
    let accessor: &[(&str, Value)] = &[
        ("count", json!(4)),
        ("count", json!(0)),
        ("count", json!(4_000_000_000u64)),
        ("count", json!(u64::MAX)),
        ("count", json!(-3)),
        ("count", json!(2.5)),
        ("byteOffset", json!(u64::MAX)),
        ("byteOffset", json!(4)),
        ("componentType", json!(5124)),
        ("componentType", json!(5123)),
        ("componentType", json!("5126")),
        ("type", json!("VEC2")),
        ("type", json!("VEC5")),
        ("normalized", json!(true)),
    ];
    for (key, value) in accessor {
        let mut gltf = Gltf::triangle();
        gltf.json["accessors"][0][*key] = value.clone();
        let error = gltf.read().expect_err(key);
        assert_eq!(error.code, ErrorCode::InvalidModel, "{key} {value}: {error}");
        assert!(error.pointer.as_deref().unwrap().starts_with("/accessors/0"), "{key} {value}: {error}");
    }
    let view: &[(&str, Value)] = &[
        ("byteLength", json!(37)),
        ("byteLength", json!(u64::MAX)),
        ("byteOffset", json!(u64::MAX)),
        ("byteOffset", json!(1)),
        ("byteStride", json!(0)),
        ("byteStride", json!(3)),
        ("byteStride", json!(256)),
        ("buffer", json!(1)),
    ];
    for (key, value) in view {
        let mut gltf = Gltf::triangle();
        gltf.json["bufferViews"][0][*key] = value.clone();
        let error = gltf.read().expect_err(key);
        assert_eq!(error.code, ErrorCode::InvalidModel, "{key} {value}: {error}");
        assert!(error.pointer.as_deref().unwrap().starts_with("/bufferViews/0"), "{key} {value}: {error}");
    }
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"][0]["byteLength"] = json!(1000);
    gltf.refused(ErrorCode::InvalidModel, "/buffers/0");
}

#[test]
fn accessors_that_nothing_uses_are_checked_too() {
    let mut gltf = Gltf::triangle();
    let index = gltf.floats("MAT4", &[0.0; 16]);
    gltf.json["accessors"][index]["count"] = json!(1);
    assert!(gltf.read().is_ok());
    gltf.json["accessors"][index]["count"] = json!(2);
    gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}"));
}

/// The columns of small matrices are padded to four bytes.
#[test]
fn matrix_columns_are_padded() {
    for (kind, component, element) in
        [("MAT2", 5121, 8), ("MAT3", 5121, 12), ("MAT3", 5123, 24), ("MAT4", 5121, 16), ("MAT2", 5126, 16)]
    {
        let mut gltf = Gltf::triangle();
        gltf.accessor(kind, component, 2, &vec![0; 2 * element]);
        assert!(gltf.read().is_ok(), "{kind} {component}");
        let mut gltf = Gltf::triangle();
        gltf.accessor(kind, component, 2, &vec![0; 2 * element - 1]);
        assert!(gltf.read().is_err(), "{kind} {component}");
    }
}

#[test]
fn zero_filled_accessors_are_counted_before_they_are_made() {
    let mut gltf = Gltf::triangle();
    let index =
        gltf.push("accessors", json!({ "componentType": 5126, "count": 4_000_000_000u64, "type": "VEC3" }));
    gltf.primitive()["attributes"]["POSITION"] = json!(index);
    let error = gltf.refused(ErrorCode::ModelTooLarge, "/meshes/0/primitives/0");
    assert_eq!((error.limit, error.actual), (Some(20_000_000), Some(4_000_000_000)));
}

#[test]
fn values_that_are_not_finite_name_their_element() {
    let cases = [
        ("POSITION", "VEC3", 9, f32::NAN),
        ("POSITION", "VEC3", 9, f32::INFINITY),
        ("POSITION", "VEC3", 9, 2e9),
        ("NORMAL", "VEC3", 9, f32::NAN),
        ("TANGENT", "VEC4", 12, f32::NEG_INFINITY),
        ("TEXCOORD_0", "VEC2", 6, f32::NAN),
        ("TEXCOORD_0", "VEC2", 6, 1.1e6),
    ];
    for (semantic, kind, length, value) in cases {
        let mut gltf = Gltf::triangle();
        let mut numbers = vec![1.0; length];
        numbers[length - 1] = value;
        let index = gltf.floats(kind, &numbers);
        gltf.primitive()["attributes"][semantic] = json!(index);
        let error = gltf.refused(ErrorCode::InvalidModel, &format!("/accessors/{index}"));
        assert!(error.detail.contains(&format!("{semantic}, element 2")), "{error}");
    }
}
