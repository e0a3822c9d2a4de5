//! Node graphs: transforms, which scene, and graphs that are none (B5 of the abuse list).

use glam::Vec3;

use super::*;

fn with_nodes(nodes: Value) -> Gltf {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"] = nodes;
    gltf
}

#[test]
fn transforms_multiply_down_the_graph() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let gltf = with_nodes(json!([
        { "children": [1], "translation": [10, 0, 0], "rotation": [0, 0, half, half] },
        { "mesh": 0, "scale": [2, 3, 4], "children": [2] },
        { "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1] },
    ]));
    let asset = gltf.read().unwrap();
    assert_eq!(asset.instances.len(), 2);
    let near = |at: Vec3, expected: [f32; 3]| assert!((at - Vec3::from(expected)).length() < 1e-4, "{at}");
    near(asset.instances[0].transform.transform_point3(Vec3::ONE), [7.0, 2.0, 4.0]);
    near(asset.instances[1].transform.transform_point3(Vec3::ZERO), [-8.0, 10.0, 28.0]);
}

#[test]
fn the_default_scene_counts_then_the_first_then_all_roots() {
    let mut gltf = with_nodes(json!([{ "mesh": 0 }, { "mesh": 0 }, { "mesh": 0 }]));
    gltf.json["scenes"] = json!([{ "nodes": [0, 2] }, { "nodes": [1] }, {}]);
    let count = |gltf: &Gltf| gltf.read().unwrap().instances.len();
    assert_eq!(count(&gltf), 2);
    gltf.json["scene"] = json!(1);
    assert_eq!(count(&gltf), 1);
    gltf.json["scene"] = json!(2);
    assert_eq!(count(&gltf), 0);
    gltf.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(count(&gltf), 2);
    gltf.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(count(&gltf), 3);
}

#[test]
fn cycles_second_parents_and_wrong_roots_are_refused() {
    let cases = [
        (json!([{ "children": [0] }]), "/nodes/0"),
        (json!([{}, { "children": [2] }, { "children": [1] }]), "/nodes/1"),
        (json!([{ "children": [1] }, {}, { "children": [1] }]), "/nodes/2/children/0"),
        (json!([{ "children": [1, 1] }, {}]), "/nodes/0/children/1"),
        (json!([{}, { "children": [0] }]), "/scenes/0/nodes/0"),
        (json!([{ "children": [7] }]), "/nodes/0/children/0"),
        (json!([{ "mesh": 1 }]), "/nodes/0/mesh"),
        (json!([{ "skin": 0 }]), "/nodes/0/skin"),
        (json!([{ "rotation": [0, 0, 0, 0] }]), "/nodes/0"),
        (json!([{ "scale": [1, 1, 1e39] }]), "/nodes/0/scale"),
        (json!([{ "matrix": [1, 2, 3] }]), "/nodes/0/matrix"),
        (json!([{ "matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }]), "/nodes/0"),
        (
            json!([{ "children": [1], "scale": [1e38, 1, 1] }, { "mesh": 0, "scale": [1e38, 1, 1] }]),
            "/nodes/1",
        ),
    ];
    for (nodes, pointer) in cases {
        with_nodes(nodes).refused(ErrorCode::InvalidModel, pointer);
    }
}

#[test]
fn chains_of_100_000_nodes_are_walked_and_more_are_refused() {
    let chain = |length: usize| {
        let mut nodes: Vec<Value> =
            (1..length).map(|next| json!({ "children": [next], "translation": [0.5, 0, 0] })).collect();
        nodes.push(json!({ "mesh": 0 }));
        with_nodes(Value::Array(nodes))
    };
    let asset = chain(100_000).read().unwrap();
    assert_eq!(asset.instances[0].transform.translation.x, 49_999.5);
    let error = chain(100_001).refused(ErrorCode::ModelTooLarge, "/nodes");
    assert_eq!((error.limit, error.actual), (Some(100_000), Some(100_001)));
}

#[test]
fn indices_of_parts_that_pass_through_are_checked() {
    let cases = [
        ("skins", json!([{ "joints": [0, 5] }]), "/skins/0/joints/1"),
        ("skins", json!([{ "joints": [0], "inverseBindMatrices": 5 }]), "/skins/0/inverseBindMatrices"),
        (
            "animations",
            json!([{ "samplers": [{ "input": 0, "output": 3 }] }]),
            "/animations/0/samplers/0/output",
        ),
        (
            "animations",
            json!([{ "samplers": [], "channels": [{ "sampler": 0 }] }]),
            "/animations/0/channels/0/sampler",
        ),
        ("scene", json!(1), "/scene"),
        (
            "materials",
            json!([{ "extensions": { "KHR_materials_clearcoat": { "clearcoatTexture": { "index": 0 } } } }]),
            "/materials/0/extensions/KHR_materials_clearcoat/clearcoatTexture/index",
        ),
    ];
    for (key, value, pointer) in cases {
        let mut gltf = Gltf::triangle();
        gltf.json[key] = value;
        gltf.refused(ErrorCode::InvalidModel, pointer);
    }
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    gltf.refused(ErrorCode::InvalidModel, "/nodes/0/extensions/KHR_lights_punctual/light");
    gltf.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{}] } });
    assert!(gltf.read().is_ok());
}

#[test]
fn the_document_is_kept_as_it_came() {
    let mut gltf = Gltf::triangle();
    gltf.json["extras"] = json!({ "z": 1, "a": [1.5, null] });
    gltf.json["buffers"][0]["byteLength"] = json!(gltf.bin.len());
    let asset = gltf.read().unwrap();
    assert_eq!(asset.document.json.to_string(), gltf.json.to_string());
    assert_eq!(asset.document.buffers, [gltf.bin.clone()]);
}
