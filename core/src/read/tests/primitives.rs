//! Modes, attributes, repairs and limits of primitives.

use glam::{Vec3, Vec4};

use super::*;
use crate::asset::Primitive;

fn first(asset: &Asset) -> &Primitive {
    &asset.meshes[0].primitives[0]
}

fn with_mode(mode: u64, vertices: usize) -> Gltf {
    let mut gltf = Gltf::triangle();
    let numbers: Vec<f32> = (0..3 * vertices).map(|i| (i * i % 17) as f32).collect();
    let index = gltf.floats("VEC3", &numbers);
    gltf.primitive()["attributes"]["POSITION"] = json!(index);
    gltf.primitive()["mode"] = json!(mode);
    gltf
}

#[test]
fn modes_become_triangles_in_the_winding_of_the_source() {
    let cases: [(u64, usize, &[[u32; 3]]); 7] = [
        (4, 6, &[[0, 1, 2], [3, 4, 5]]),
        (5, 5, &[[0, 1, 2], [1, 3, 2], [2, 3, 4]]),
        (6, 5, &[[1, 2, 0], [2, 3, 0], [3, 4, 0]]),
        (0, 2, &[]),
        (1, 4, &[]),
        (2, 3, &[]),
        (3, 3, &[]),
    ];
    for (mode, vertices, triangles) in cases {
        let asset = with_mode(mode, vertices).read().unwrap();
        let faces: Vec<Vec<u32>> = first(&asset).faces.iter().map(|face| face.corners().to_vec()).collect();
        assert_eq!(faces, triangles, "mode {mode}");
        assert_eq!(first(&asset).positions.len(), vertices, "mode {mode}");
    }
}

#[test]
fn counts_that_make_no_primitive_are_refused() {
    for (mode, vertices) in [(4, 4), (4, 2), (5, 2), (6, 2), (1, 3), (2, 1)] {
        with_mode(mode, vertices).refused(ErrorCode::InvalidModel, "/meshes/0/primitives/0");
    }
    with_mode(7, 3).refused(ErrorCode::InvalidModel, "/meshes/0/primitives/0");
}

#[test]
fn attributes_are_needed_and_of_one_length() {
    let mut gltf = Gltf::triangle();
    gltf.primitive()["attributes"] = json!({});
    gltf.refused(ErrorCode::InvalidModel, "/meshes/0/primitives/0/attributes");
    let mut gltf = Gltf::triangle();
    let index = gltf.floats("VEC2", &[0.0; 4]);
    gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(index);
    gltf.refused(ErrorCode::InvalidModel, "/meshes/0/primitives/0/attributes/TEXCOORD_0");
    let mut gltf = Gltf::triangle();
    gltf.primitive()["attributes"]["COLOR_0"] = json!(99);
    gltf.refused(ErrorCode::InvalidModel, "/meshes/0/primitives/0/attributes/COLOR_0");
}

#[test]
fn other_attributes_and_morph_targets_stay_as_bytes() {
    let mut gltf = Gltf::triangle();
    let color = gltf.accessor("VEC4", 5121, 3, &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
    gltf.json["accessors"][color]["normalized"] = json!(true);
    let custom = gltf.accessor("SCALAR", 5122, 3, &[1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0]);
    let view = gltf.json["accessors"][custom]["bufferView"].as_u64().unwrap() as usize;
    gltf.json["bufferViews"][view]["byteStride"] = json!(4);
    let delta = gltf.floats("VEC3", &[0.5; 9]);
    gltf.primitive()["attributes"]["COLOR_0"] = json!(color);
    gltf.primitive()["attributes"]["_CUSTOM"] = json!(custom);
    gltf.primitive()["targets"] = json!([{ "POSITION": delta }]);
    let asset = gltf.read().unwrap();
    let primitive = first(&asset);
    let [color, custom] = &primitive.attributes[..] else { panic!("two attributes") };
    assert_eq!((color.component_type, color.normalized, color.element_bytes), (5121, true, 4));
    assert_eq!(color.bytes, [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
    assert_eq!((custom.semantic.as_str(), custom.kind.as_str()), ("_CUSTOM", "SCALAR"));
    assert_eq!(custom.bytes, [1, 0, 2, 0, 3, 0]);
    let target = &primitive.targets[0].attributes[0];
    assert_eq!((target.semantic.as_str(), target.bytes.len()), ("POSITION", 36));
}

#[test]
fn normals_and_tangents_end_at_unit_length() {
    let mut gltf = Gltf::triangle();
    let normals = gltf.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 3.0, 4.0, 1e-30, 0.0, 0.0]);
    let tangents = gltf.floats("VEC4", &[2.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.3]);
    gltf.primitive()["attributes"]["NORMAL"] = json!(normals);
    gltf.primitive()["attributes"]["TANGENT"] = json!(tangents);
    let asset = gltf.read().unwrap();
    let primitive = first(&asset);
    assert_eq!(primitive.normals, [Vec3::Z, Vec3::new(0.0, 0.6, 0.8), Vec3::X]);
    assert_eq!(primitive.tangents[0], Vec4::new(1.0, 0.0, 0.0, -1.0));
    assert!(primitive.tangents[1].truncate().dot(primitive.normals[1]).abs() < 1e-6);
    assert!((primitive.tangents[1].truncate().length() - 1.0).abs() < 1e-6);
    assert_eq!(primitive.tangents[2], Vec4::new(0.0, 1.0, 0.0, 1.0));
    let counts: Vec<_> = asset.warnings.iter().map(|w| (w.code.as_str(), w.count)).collect();
    assert_eq!(counts, [("zero_normal", 1), ("bad_tangent", 2)]);
    assert_eq!(asset.warnings[0].pointer, "/meshes/0/primitives/0");
}

#[test]
fn degenerate_faces_are_kept_and_counted() {
    let mut gltf = Gltf::triangle();
    let positions = gltf.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0]);
    let indices = gltf.accessor("SCALAR", 5121, 9, &[0, 1, 2, 0, 1, 1, 2, 2, 2]);
    gltf.primitive()["attributes"]["POSITION"] = json!(positions);
    gltf.primitive()["indices"] = json!(indices);
    let asset = gltf.read().unwrap();
    assert_eq!(first(&asset).faces.len(), 3);
    let counts: Vec<_> = asset.warnings.iter().map(|w| (w.code.as_str(), w.count)).collect();
    assert_eq!(counts, [("degenerate_face", 2), ("zero_area_face", 1)]);
}

#[test]
fn left_out_coordinate_sets_are_zero() {
    let mut gltf = Gltf::triangle();
    let index = gltf.floats("VEC2", &[0.5; 6]);
    gltf.primitive()["attributes"]["TEXCOORD_2"] = json!(index);
    let asset = gltf.read().unwrap();
    assert_eq!(first(&asset).texcoords.iter().map(|set| set[0].x).collect::<Vec<_>>(), [0.0, 0.0, 0.5]);
    assert_eq!(asset.warnings[0].count, 2);
    for name in ["TEXCOORD_16", "TEXCOORD_4294967295", "TEXCOORD_", "TEXCOORD_01", "TEXCOORD_-1"] {
        let mut gltf = Gltf::triangle();
        gltf.primitive()["attributes"][name] = json!(index);
        gltf.floats("VEC2", &[0.5; 6]);
        gltf.refused(ErrorCode::InvalidModel, &format!("/meshes/0/primitives/0/attributes/{name}"));
    }
}

#[test]
fn elements_are_counted_over_the_whole_model() {
    let mut gltf = Gltf::triangle();
    let primitive = gltf.primitive().clone();
    gltf.json["meshes"][0]["primitives"] = json!(vec![primitive; 10]);
    let limited = |limits: Limits| read_limited(gltf.glb(), limits).unwrap_err();
    let error = limited(Limits { triangles: 9, ..Limits::default() });
    assert_eq!((error.code, error.actual), (ErrorCode::TooManyTriangles, Some(10)));
    assert_eq!(error.pointer.as_deref(), Some("/meshes/0/primitives/9"));
    let error = limited(Limits { vertices: 29, ..Limits::default() });
    assert_eq!((error.code, error.actual), (ErrorCode::ModelTooLarge, Some(30)));
}
