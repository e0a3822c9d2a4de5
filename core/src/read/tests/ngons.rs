//! `FB_ngon_encoding`: which triangles become quads.

use super::*;

const MARK: &str = "FB_ngon_encoding";

/// Eight vertices with these triangles, marked on the primitive.
fn model(triangles: &[[u8; 3]]) -> Gltf {
    model_at(|i| [i as f32, (i * i) as f32, (i % 3) as f32], triangles)
}

fn model_at(position: impl Fn(u8) -> [f32; 3], triangles: &[[u8; 3]]) -> Gltf {
    let mut gltf = Gltf::triangle();
    let positions: Vec<f32> = (0..8).flat_map(position).collect();
    let positions = gltf.floats("VEC3", &positions);
    let indices = gltf.accessor("SCALAR", 5121, 3 * triangles.len(), triangles.as_flattened());
    gltf.primitive()["attributes"]["POSITION"] = json!(positions);
    gltf.primitive()["indices"] = json!(indices);
    gltf.primitive()["extensions"] = json!({ MARK: {} });
    gltf
}

/// A quad, a triangle, a pentagon and another quad.
const POLYGONS: [[u8; 3]; 8] =
    [[0, 1, 2], [0, 2, 3], [4, 5, 6], [1, 2, 3], [1, 3, 4], [1, 4, 5], [7, 3, 1], [7, 1, 2]];

pub(super) fn seed() -> Vec<u8> {
    model(&POLYGONS).glb()
}

fn faces(asset: &Asset) -> Vec<Vec<u32>> {
    asset.meshes[0].primitives[0].faces.iter().map(|face| face.corners().to_vec()).collect()
}

#[test]
fn two_triangles_are_a_quad_and_more_stay() {
    let gltf = model(&POLYGONS);
    let expected: [&[u32]; 6] =
        [&[0, 1, 2, 3], &[4, 5, 6], &[1, 2, 3], &[1, 3, 4], &[1, 4, 5], &[7, 3, 1, 2]];
    let asset = gltf.read().unwrap();
    assert_eq!(faces(&asset), expected);
    assert_eq!(asset.warnings, []);

    let mut of_mesh = gltf.clone();
    of_mesh.primitive()["extensions"] = json!({});
    assert_eq!(faces(&of_mesh.read().unwrap()).len(), POLYGONS.len());
    of_mesh.json["meshes"][0]["extensions"] = json!({ MARK: {} });
    assert_eq!(faces(&of_mesh.read().unwrap()), expected);

    let mut strip = gltf.clone();
    strip.primitive()["mode"] = json!(5);
    assert!(faces(&strip.read().unwrap()).iter().all(|face| face.len() == 3));

    let mut required = gltf;
    required.json["extensionsRequired"] = json!([MARK]);
    required.read().unwrap();
}

#[test]
fn what_is_no_quad_stays_and_is_counted() {
    // Neither goes on where the other ends; then a corner that comes twice.
    let asset = model(&[[0, 1, 2], [0, 3, 4], [5, 6, 7], [5, 7, 6]]).read().unwrap();
    assert_eq!(faces(&asset).len(), 4);
    let codes: Vec<_> = asset.warnings.iter().map(|w| (w.code.as_str(), w.count)).collect();
    assert_eq!(codes[0], ("ngon_not_a_fan", 2));
}

#[test]
fn a_quad_with_a_side_of_no_length_stays_two_triangles() {
    let at_pole = |one: u8, other: u8| move |i| if i == one { other as f32 } else { i as f32 };
    for corner in 0..4 {
        let at = at_pole(corner, (corner + 1) % 4);
        let asset = model_at(|i| [at(i), at(i).powi(2), 0.0], &[[0, 1, 2], [0, 2, 3]]).read().unwrap();
        assert_eq!(faces(&asset), [[0, 1, 2], [0, 2, 3]], "{corner}");
    }
    let folded = at_pole(1, 3);
    let asset = model_at(|i| [folded(i), folded(i).powi(2), 0.0], &[[0, 1, 2], [0, 2, 3]]).read().unwrap();
    assert_eq!(faces(&asset), [[0, 1, 2, 3]]);
}

#[test]
fn a_list_of_quads_says_more() {
    let mut gltf = model(&[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
    let quads = gltf.accessor("SCALAR", 5121, 1, &[2]);
    gltf.primitive()["extensions"]["MCT_mesh_colors"] = json!({ "quads": quads });
    assert_eq!(faces(&gltf.read().unwrap()), [&[0, 1, 2][..], &[0, 2, 3], &[4, 5, 6, 7]]);
}
