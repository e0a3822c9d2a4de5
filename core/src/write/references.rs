//! Every place of a glTF file that points into an array which the writer may renumber: accessors,
//! buffer views, images, samplers, textures. Used to find what is in use and to move the pointers.

use serde_json::{Map, Value};

use crate::asset::{MESH_COLORS_EXTENSION, NGON_EXTENSION};
use crate::finished::EXTENSION;

use super::draft::Draft;

/// An array that can be pointed into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Accessor,
    View,
    Image,
    Sampler,
    Texture,
}

/// Called with each pointer; the value is an unsigned integer in valid files.
pub type Visit<'f> = dyn FnMut(Kind, &mut Value) + 'f;

/// Texture extensions whose `source` is an image.
pub const TEXTURE_SOURCES: [&str; 4] =
    ["KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds"];

/// Extensions of which all pointers are known here (most have none).
const UNDERSTOOD: [&str; 19] = [
    EXTENSION,
    MESH_COLORS_EXTENSION,
    NGON_EXTENSION,
    "KHR_texture_transform",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "KHR_node_visibility",
    "KHR_node_selectability",
    "KHR_node_hoverability",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "MSFT_lod",
    TEXTURE_SOURCES[0],
    TEXTURE_SOURCES[1],
    TEXTURE_SOURCES[2],
    TEXTURE_SOURCES[3],
];

/// Whether all pointers of the extension are visited by this module. Of the material extensions of
/// Khronos every pointer is a texture info, and `KHR_materials_variants` points at materials alone,
/// which are never renumbered.
pub fn understood(extension: &str) -> bool {
    extension.starts_with("KHR_materials_") || UNDERSTOOD.contains(&extension)
}

/// Pointers of the parts that are never swept: meshes, materials, nodes, skins, animations.
pub fn visit_roots(draft: &mut Draft<'_>, visit: &mut Visit<'_>) {
    for mesh in &mut draft.meshes {
        for primitive in items(mesh, "primitives") {
            visit_primitive(primitive, visit);
        }
    }
    for material in &mut draft.materials {
        visit_texture_infos(material, &mut |_, info| {
            if let Some(index) = info.get_mut("index") {
                visit(Kind::Texture, index);
            }
        });
        if let Some(own) = extension(material, MESH_COLORS_EXTENSION) {
            visit_mesh_colors(own, visit);
        }
    }
    for node in named(&mut draft.root, "nodes") {
        if let Some(instancing) = extension(node, "EXT_mesh_gpu_instancing") {
            visit_values(instancing.get_mut("attributes"), visit);
        }
    }
    for skin in named(&mut draft.root, "skins") {
        visit_member(skin, "inverseBindMatrices", Kind::Accessor, visit);
    }
    for animation in named(&mut draft.root, "animations") {
        for sampler in items(animation, "samplers") {
            visit_member(sampler, "input", Kind::Accessor, visit);
            visit_member(sampler, "output", Kind::Accessor, visit);
        }
    }
}

/// Pointers of one item of a renumbered array.
pub fn visit_item(kind: Kind, item: &mut Value, visit: &mut Visit<'_>) {
    match kind {
        Kind::Texture => {
            visit_member(item, "sampler", Kind::Sampler, visit);
            visit_member(item, "source", Kind::Image, visit);
            for name in TEXTURE_SOURCES {
                if let Some(extension) = extension(item, name) {
                    visit_member(extension, "source", Kind::Image, visit);
                }
            }
            if let Some(extension) = extension(item, EXTENSION) {
                for level in items(extension, "levels") {
                    visit(Kind::Image, level);
                }
            }
        }
        Kind::Accessor => {
            visit_member(item, "bufferView", Kind::View, visit);
            if let Some(sparse) = item.get_mut("sparse") {
                for part in ["indices", "values"] {
                    if let Some(part) = sparse.get_mut(part) {
                        visit_member(part, "bufferView", Kind::View, visit);
                    }
                }
            }
        }
        Kind::Image => visit_member(item, "bufferView", Kind::View, visit),
        Kind::View | Kind::Sampler => {}
    }
}

/// Every texture info of a material, those of extensions too: an object with an `index`, under a name
/// that ends in `Texture`, which is passed on too. Extras are the author's own and are left alone.
pub fn visit_texture_infos(material: &mut Value, visit: &mut dyn FnMut(&str, &mut Map<String, Value>)) {
    let Value::Object(members) = material else { return };
    for (name, value) in members {
        if name == "extras" {
            continue;
        }
        match value {
            Value::Object(info) if name.ends_with("Texture") && info.contains_key("index") => {
                visit(name, info);
            }
            Value::Object(_) => visit_texture_infos(value, visit),
            _ => {}
        }
    }
}

/// Whether a material's JSON names any texture.
pub fn shows_textures(material: &Value) -> bool {
    let mut is_shown = false;
    visit_texture_infos(&mut material.clone(), &mut |_, _| is_shown = true);
    is_shown
}

fn visit_primitive(primitive: &mut Value, visit: &mut Visit<'_>) {
    visit_values(primitive.get_mut("attributes"), visit);
    visit_member(primitive, "indices", Kind::Accessor, visit);
    for target in items(primitive, "targets") {
        visit_values(Some(target), visit);
    }
    if let Some(draco) = extension(primitive, "KHR_draco_mesh_compression") {
        visit_member(draco, "bufferView", Kind::View, visit);
    }
    if let Some(own) = extension(primitive, EXTENSION) {
        visit_values(own.get_mut("cuts"), visit);
    }
    if let Some(own) = extension(primitive, MESH_COLORS_EXTENSION) {
        visit_member(own, "quads", Kind::Accessor, visit);
    }
}

fn visit_mesh_colors(own: &mut Value, visit: &mut Visit<'_>) {
    for name in ["partners", "exponents"] {
        visit_member(own, name, Kind::Accessor, visit);
    }
    for channel in items(own, "channels") {
        for name in ["samples", "cuts", "tangents"] {
            visit_member(channel, name, Kind::Accessor, visit);
        }
    }
}

fn visit_values(map: Option<&mut Value>, visit: &mut Visit<'_>) {
    if let Some(Value::Object(map)) = map {
        for (_, accessor) in map {
            visit(Kind::Accessor, accessor);
        }
    }
}

fn visit_member(value: &mut Value, name: &str, kind: Kind, visit: &mut Visit<'_>) {
    if let Some(pointer) = value.get_mut(name) {
        visit(kind, pointer);
    }
}

fn items<'v>(value: &'v mut Value, name: &str) -> &'v mut [Value] {
    match value.get_mut(name) {
        Some(Value::Array(items)) => items,
        _ => &mut [],
    }
}

fn named<'v>(root: &'v mut Map<String, Value>, name: &str) -> &'v mut [Value] {
    match root.get_mut(name) {
        Some(Value::Array(items)) => items,
        _ => &mut [],
    }
}

fn extension<'v>(value: &'v mut Value, name: &str) -> Option<&'v mut Value> {
    value.get_mut("extensions")?.get_mut(name)
}
