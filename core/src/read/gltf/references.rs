//! Every index of the document against the list that it points into, so that whoever copies the
//! document's parts meets none that dangles.

use serde_json::Value;

use super::super::json::At;
use crate::error::{Error, Result};

/// Where indices stand (`*` is every element or member) and the list that they count in.
const REFERENCES: &[(&str, &str)] = &[
    ("scene", "scenes"),
    ("scenes/*/nodes/*", "nodes"),
    ("nodes/*/children/*", "nodes"),
    ("nodes/*/mesh", "meshes"),
    ("nodes/*/skin", "skins"),
    ("nodes/*/camera", "cameras"),
    ("nodes/*/extensions/KHR_lights_punctual/light", "extensions/KHR_lights_punctual/lights"),
    ("skins/*/inverseBindMatrices", "accessors"),
    ("skins/*/skeleton", "nodes"),
    ("skins/*/joints/*", "nodes"),
    ("animations/*/samplers/*/input", "accessors"),
    ("animations/*/samplers/*/output", "accessors"),
    ("animations/*/channels/*/target/node", "nodes"),
    ("meshes/*/primitives/*/attributes/*", "accessors"),
    ("meshes/*/primitives/*/targets/*/*", "accessors"),
    ("meshes/*/primitives/*/indices", "accessors"),
    ("meshes/*/primitives/*/material", "materials"),
    ("meshes/*/primitives/*/extensions/KHR_materials_variants/mappings/*/material", "materials"),
    ("meshes/*/primitives/*/extensions/MCT_mesh_color_texture/cuts/*", "accessors"),
    ("materials/*/pbrMetallicRoughness/baseColorTexture/index", "textures"),
    ("materials/*/pbrMetallicRoughness/metallicRoughnessTexture/index", "textures"),
    ("materials/*/normalTexture/index", "textures"),
    ("materials/*/occlusionTexture/index", "textures"),
    ("materials/*/emissiveTexture/index", "textures"),
    // Texture slots of material extensions, whatever their names.
    ("materials/*/extensions/*/*/index", "textures"),
    ("textures/*/source", "images"),
    ("textures/*/sampler", "samplers"),
    ("textures/*/extensions/MCT_mesh_color_texture/levels/*", "images"),
    ("textures/*/extensions/*/source", "images"),
    ("images/*/bufferView", "bufferViews"),
    ("bufferViews/*/buffer", "buffers"),
    ("accessors/*/bufferView", "bufferViews"),
    ("accessors/*/sparse/indices/bufferView", "bufferViews"),
    ("accessors/*/sparse/values/bufferView", "bufferViews"),
];

pub(super) fn check(root: &At) -> Result<()> {
    for (pattern, list) in REFERENCES {
        let length = list_length(root.value, list);
        let what = list.rsplit('/').next().unwrap_or(list);
        check_pattern(root.value, pattern, &mut String::new(), length, what)?;
    }
    for (index, animation) in root.objects("animations")?.iter().enumerate() {
        let length = animation.list("samplers")?.len();
        let mut pointer = format!("/animations/{index}");
        check_pattern(animation.value, "channels/*/sampler", &mut pointer, length, "samplers")?;
    }
    Ok(())
}

fn list_length(root: &Value, path: &str) -> usize {
    root.pointer(&format!("/{path}")).and_then(Value::as_array).map_or(0, Vec::len)
}

/// Recursion is as deep as the pattern is long. What is absent or of another shape is left to whoever
/// reads that part.
fn check_pattern(value: &Value, pattern: &str, at: &mut String, length: usize, what: &str) -> Result<()> {
    let (head, rest) = match pattern.split_once('/') {
        Some((head, rest)) => (head, Some(rest)),
        None => (pattern, None),
    };
    let mut visit = |key: &str, child: &Value| {
        let parent_length = at.len();
        at.push('/');
        at.push_str(key);
        let result = match rest {
            Some(rest) => check_pattern(child, rest, at, length, what),
            None => check_index(child, at, length, what),
        };
        at.truncate(parent_length);
        result
    };
    match (head, value) {
        ("*", Value::Array(list)) => {
            list.iter().enumerate().try_for_each(|(index, child)| visit(&index.to_string(), child))
        }
        ("*", Value::Object(members)) => {
            members.iter().try_for_each(|(key, child)| visit(&shown(key), child))
        }
        (key, Value::Object(members)) => members.get(key).map_or(Ok(()), |child| visit(key, child)),
        _ => Ok(()),
    }
}

fn shown(key: &str) -> String {
    key.chars().take(80).collect::<String>().escape_debug().to_string()
}

fn check_index(value: &Value, pointer: &str, length: usize, what: &str) -> Result<()> {
    let in_place = At { value, pointer: String::new() };
    in_place.index_below(length, what).map(drop).map_err(|error| Error::at(error, pointer))
}
