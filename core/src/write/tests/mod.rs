//! Writes made-up conversions and reads them back with a small reader of its own.

mod compressed;
mod fixture;
mod indexed;
mod lies;
mod parse;
mod parts;
mod special;
mod united;

use glam::Vec2;

use crate::finished::extract;

#[test]
fn a_finished_conversion_comes_back_from_its_file_to_the_bit() {
    let (asset, finished, glb) = fixture::converted();
    let back = parse::asset(&glb);
    let read = extract(&back).unwrap().unwrap();
    assert_eq!(read.textures, finished.textures);
    assert_eq!(read.primitives.len(), 1);
    let (read, wrote) = (&read.primitives[0], &finished.primitives[0]);
    assert_eq!((&read.frames, &read.cuts), (&wrote.frames, &wrote.cuts));
    let (before, after) = (&asset.meshes[0].primitives[0], &back.meshes[0].primitives[0]);
    let piece = wrote;
    for (number, (read, wrote)) in read.triangles.iter().zip(&wrote.triangles).enumerate() {
        assert_eq!((read.corners, read.anchor), (wrote.corners, wrote.anchor));
        for k in 0..3 {
            let (old, new) = (wrote.vertices[k] as usize, read.vertices[k] as usize);
            assert_eq!(after.positions[new], before.positions[old]);
            assert_eq!(after.texcoords[0][new], piece.place(number, k, 0) / Vec2::new(16.0, 8.0));
            assert_eq!(after.texcoords[1][new], before.texcoords[1][old]);
        }
    }
}

#[test]
fn attributes_and_morph_targets_follow_their_vertices() {
    let (asset, finished, glb) = fixture::converted();
    let back = parse::asset(&glb);
    let (before, after) = (&asset.meshes[0].primitives[0], &back.meshes[0].primitives[0]);
    let old: Vec<u32> = finished.primitives[0].triangles.iter().flat_map(|t| t.vertices).collect();
    let new: Vec<u32> = after.faces.iter().flat_map(|face| face.corners().to_vec()).collect();
    for name in ["COLOR_0", "JOINTS_0", "WEIGHTS_0"] {
        let of =
            |p: &crate::asset::Primitive| p.attributes.iter().find(|a| a.semantic == name).cloned().unwrap();
        let (before, after) = (of(before), of(after));
        let element = |a: &crate::asset::Attribute, v: u32| {
            a.bytes[v as usize * a.element_bytes..][..a.element_bytes].to_vec()
        };
        for (old, new) in old.iter().zip(&new) {
            assert_eq!(element(&before, *old), element(&after, *new), "{name}");
        }
    }
    // The frames replace the source's tangents, so the target keeps its positions alone.
    let names: Vec<_> = after.targets[0].attributes.iter().map(|a| a.semantic.as_str()).collect();
    assert_eq!(names, ["POSITION"]);
    assert_eq!(super::losses(&asset, &finished)[0].code, "morph_tangents_dropped");
}

#[test]
fn materials_keep_all_but_the_converted_textures() {
    let (_, _, glb) = fixture::converted();
    let (json, _) = parse::split(&glb);
    let coat = &json["materials"][0];
    assert_eq!(coat["normalTexture"]["scale"], 0.5);
    assert_eq!(coat["occlusionTexture"]["strength"], 0.7);
    let base = &coat["pbrMetallicRoughness"]["baseColorTexture"];
    assert!(base.get("extensions").is_none() && base.get("texCoord").is_none());
    let roughness = &coat["pbrMetallicRoughness"]["metallicRoughnessTexture"];
    assert_eq!(roughness["index"], coat["occlusionTexture"]["index"]);
    let texture = &json["textures"][base["index"].as_u64().unwrap() as usize];
    let levels = texture["extensions"][crate::finished::EXTENSION]["levels"].as_array().unwrap();
    assert_eq!((levels.len(), &levels[0]), (3, &texture["source"]));
    let sampler = &json["samplers"][texture["sampler"].as_u64().unwrap() as usize];
    assert_eq!((sampler["minFilter"].as_u64(), sampler["wrapS"].as_u64()), (Some(9729), Some(33071)));
    // The clear coat is not converted; it reads the same coordinates in a set behind the new one.
    let clearcoat = &coat["extensions"]["KHR_materials_clearcoat"]["clearcoatTexture"];
    assert_eq!(clearcoat["texCoord"], 1);
}

#[test]
fn points_of_a_converted_material_keep_the_old_one() {
    let (asset, _, glb) = fixture::converted();
    let (json, _) = parse::split(&glb);
    let points = &json["meshes"][0]["primitives"][1];
    assert_eq!((&points["mode"], &points["material"]), (&0.into(), &2.into()));
    let copy = &json["materials"][2];
    let before = &asset.document.json["materials"][0];
    assert_eq!(copy["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"], 1);
    assert_eq!(copy["name"], before["name"]);
}

#[test]
fn what_only_replaced_things_used_is_swept_out() {
    let (_, mut finished, _) = fixture::converted();
    let source = fixture::source_glb();
    let mut asset = parse::asset(&source);
    // Without the points nothing needs the old positions, texture and image any more.
    asset.meshes[0].primitives.pop();
    let primitives = asset.document.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.pop();
    finished.primitives[0].cuts.clear();
    let glb = super::glb(&asset, &finished, &crate::watch::Unwatched).unwrap().bytes;
    let (json, bin) = parse::split(&glb);
    let count = |name: &str| json[name].as_array().map_or(0, Vec::len);
    assert_eq!((count("textures"), count("images"), count("samplers")), (1 + 3, 1 + 9, 1 + 1));
    // Old: the plain triangle's two and its indices, the skin's one, the animation's two. New: ten
    // attributes, one of a morph target, indices.
    assert_eq!(count("accessors"), 3 + 3 + 10 + 1 + 1);
    assert_eq!(count("bufferViews"), count("accessors") + count("images"));
    let matrices = json["skins"][0]["inverseBindMatrices"].as_u64().unwrap() as usize;
    assert_eq!(parse::attribute(&json, &bin, "", matrices).kind, "MAT4");
    let used = ["KHR_materials_clearcoat", "KHR_lights_punctual", crate::finished::EXTENSION];
    assert_eq!(json["extensionsUsed"], serde_json::json!(used));
    assert!(json.get("extensionsRequired").is_none());
}

#[test]
fn a_file_with_an_unknown_extension_stays_in_place() {
    let source = fixture::source_glb();
    let mut asset = parse::asset(&source);
    asset.document.json["nodes"][0]["extensions"]["ACME_pointer"]["accessor"] = 2.into();
    let finished = fixture::finished(&asset);
    let glb = super::glb(&asset, &finished, &crate::watch::Unwatched).unwrap().bytes;
    let (json, _) = parse::split(&glb);
    for name in ["accessors", "textures", "images", "samplers"] {
        let before = asset.document.json[name].as_array().unwrap();
        let after = json[name].as_array().unwrap();
        assert_eq!(&after[..before.len()], before, "{name}");
    }
}

#[test]
fn the_same_bytes_with_any_number_of_threads() {
    let (asset, finished, glb) = fixture::converted();
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let again = pool.install(|| super::glb(&asset, &finished, &crate::watch::Unwatched)).unwrap().bytes;
        assert!(again == glb);
    }
}

#[test]
fn a_canceled_watch_ends_writing() {
    struct Canceled;
    impl crate::watch::Watch for Canceled {
        fn canceled(&self) -> bool {
            true
        }
    }
    let (asset, finished, _) = fixture::converted();
    let error = super::glb(&asset, &finished, &Canceled).unwrap_err();
    assert_eq!(error.code, crate::ErrorCode::Canceled);
}

#[test]
fn pngs_keep_every_code() {
    for components in 1..=4 {
        for seed in [1, 2] {
            let image = fixture::noise(7, 5, components, seed);
            assert_eq!(parse::decoded(&super::images::png(&image).unwrap()), image);
        }
    }
}
