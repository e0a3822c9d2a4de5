//! Extensions of compressed sources leave the file's lists with the last thing that needs them.

use serde_json::{Value, json};

use super::{fixture, parse};
use crate::asset::Asset;

const NAMES: [&str; 4] =
    ["KHR_mesh_quantization", "EXT_meshopt_compression", "EXT_texture_webp", "KHR_texture_basisu"];

/// Which of the names are left in a file whose source requires all of them.
fn left(change: impl FnOnce(&mut Asset)) -> Vec<String> {
    let mut asset = parse::asset(&fixture::source_glb());
    let json = &mut asset.document.json;
    json["extensionsUsed"].as_array_mut().unwrap().extend(NAMES.map(Value::from));
    json["extensionsRequired"] = json!(NAMES);
    change(&mut asset);
    let finished = fixture::finished(&asset);
    let glb = super::super::glb(&asset, &finished, &crate::watch::Unwatched).unwrap().bytes;
    let (json, _) = parse::split(&glb);
    let listed = |list: &str| -> Vec<String> {
        let names = json[list].as_array().into_iter().flatten().filter_map(Value::as_str);
        names.filter(|name| NAMES.contains(name)).map(str::to_owned).collect()
    };
    assert_eq!(listed("extensionsUsed"), listed("extensionsRequired"));
    listed("extensionsRequired")
}

#[test]
fn nothing_is_left_where_all_is_plain() {
    assert_eq!(left(|_| {}), [""; 0]);
}

#[test]
fn quantized_primitives_and_morph_targets_that_stay_keep_the_name() {
    let points = |asset: &mut Asset| {
        let json = &mut asset.document.json;
        let position = &json["meshes"][0]["primitives"][1]["attributes"]["POSITION"];
        let position = position.as_u64().unwrap() as usize;
        json["accessors"][position]["componentType"] = 5123.into();
    };
    assert_eq!(left(points), [NAMES[0]]);
    let target = |asset: &mut Asset| {
        let target = &mut asset.meshes[0].primitives[0].targets[0];
        let position = target.attributes.iter_mut().find(|own| own.semantic == "POSITION").unwrap();
        position.component_type = 5122;
        position.element_bytes = 6;
        position.bytes.truncate(4 * 6);
    };
    assert_eq!(left(target), [NAMES[0]]);
}

#[test]
fn images_that_stay_keep_the_name() {
    for (media_type, name) in [("image/webp", NAMES[2]), ("image/ktx2", NAMES[3])] {
        assert_eq!(left(|asset| asset.document.json["images"][1]["mimeType"] = media_type.into()), [name]);
    }
}
