//! Extensions that a file has no object of, but types and formats that only they allow.

use std::collections::BTreeSet;

use serde_json::Value;

use super::draft::Draft;

const FLOAT: u64 = 5126;
const UNSIGNED_BYTE: u64 = 5121;
const UNSIGNED_SHORT: u64 = 5123;

/// Adds `KHR_mesh_quantization` where a vertex attribute or a morph target is of a type that glTF 2.0 lacks, and
/// `EXT_texture_webp` or `KHR_texture_basisu` where an image is WebP or KTX2.
pub fn add_names(draft: &Draft<'_>, names: &mut BTreeSet<String>) {
    let primitives = draft.meshes.iter().flat_map(|mesh| items(mesh, "primitives"));
    let mut attribute_sets = primitives.flat_map(|primitive| {
        let attributes = primitive.get("attributes").into_iter();
        attributes.chain(items(primitive, "targets"))
    });
    if attribute_sets.any(|attributes| is_quantized(draft, attributes)) {
        names.insert("KHR_mesh_quantization".to_owned());
    }
    for (media_type, name) in [("image/webp", "EXT_texture_webp"), ("image/ktx2", "KHR_texture_basisu")] {
        let is_one = |image: &Value| image.get("mimeType").and_then(Value::as_str) == Some(media_type);
        if draft.images.iter().any(is_one) {
            names.insert(name.to_owned());
        }
    }
}

fn is_quantized(draft: &Draft<'_>, attributes: &Value) -> bool {
    attributes.as_object().into_iter().flatten().any(|(semantic, accessor)| {
        let is_texcoord = semantic.starts_with("TEXCOORD_");
        let number = accessor.as_u64().and_then(|number| usize::try_from(number).ok());
        let accessor = number.and_then(|number| draft.accessors.get(number));
        let component = accessor.and_then(|accessor| accessor.get("componentType")?.as_u64());
        let is_normalized = accessor.is_some_and(|accessor| accessor.get("normalized") == Some(&true.into()));
        match component {
            None | Some(FLOAT) => false,
            Some(UNSIGNED_BYTE | UNSIGNED_SHORT) if is_texcoord => !is_normalized,
            _ => is_texcoord || matches!(semantic.as_str(), "POSITION" | "NORMAL" | "TANGENT"),
        }
    })
}

fn items<'v>(value: &'v Value, name: &str) -> impl Iterator<Item = &'v Value> {
    value.get(name).and_then(Value::as_array).into_iter().flatten()
}
