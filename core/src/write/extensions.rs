//! The lists of extensions at the file's root, and what stands for them in the rest of the file.

use std::collections::BTreeSet;

use serde_json::{Map, Value};

use crate::asset::{MESH_COLORS_EXTENSION, NGON_EXTENSION};
use crate::finished::EXTENSION;

use super::draft::Draft;
use super::in_use;

/// Extensions that go out of use where conversion replaced the last thing that had them.
const MAY_LEAVE: [&str; 7] = [
    "KHR_texture_transform",
    "KHR_draco_mesh_compression",
    "KHR_mesh_quantization",
    "EXT_meshopt_compression",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    NGON_EXTENSION,
];

const OWN: [&str; 2] = [EXTENSION, MESH_COLORS_EXTENSION];

/// The name of every extension object in the draft, extras left out.
pub fn names(draft: &Draft<'_>) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    collect_members(&draft.root, &mut names);
    let arrays =
        [&draft.accessors, &draft.images, &draft.samplers, &draft.textures, &draft.materials, &draft.meshes];
    for value in arrays.into_iter().flatten() {
        collect(value, &mut names);
    }
    for view in &draft.views {
        collect_members(&view.json, &mut names);
    }
    names
}

/// Brings `extensionsUsed` and `extensionsRequired` up to date. `added`: those that the file uses now.
pub fn settle(draft: &mut Draft<'_>, added: &[&str]) {
    let mut in_use = names(draft);
    in_use::add_names(draft, &mut in_use);
    for list in ["extensionsUsed", "extensionsRequired"] {
        let Some(Value::Array(listed)) = draft.root.get_mut(list) else { continue };
        listed.retain(|name| {
            let name = name.as_str().unwrap_or_default();
            // Its own names in a source are an earlier conversion's.
            let is_own = OWN.contains(&name);
            !is_own && (!MAY_LEAVE.contains(&name) || in_use.contains(name))
        });
        if listed.is_empty() {
            draft.root.remove(list);
        }
    }
    let own = OWN.into_iter().filter(|name| added.contains(name) || in_use.contains(*name));
    for name in own {
        let used = draft.root.entry("extensionsUsed").or_insert_with(|| Value::Array(Vec::new()));
        if let Value::Array(used) = used {
            used.push(name.into());
        }
    }
}

fn collect(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(members) => collect_members(members, names),
        Value::Array(items) => items.iter().for_each(|item| collect(item, names)),
        _ => {}
    }
}

fn collect_members(members: &Map<String, Value>, names: &mut BTreeSet<String>) {
    for (name, value) in members {
        match (name.as_str(), value) {
            ("extras", _) => {}
            ("extensions", Value::Object(extensions)) => {
                names.extend(extensions.keys().cloned());
                extensions.values().for_each(|extension| collect(extension, names));
            }
            _ => collect(value, names),
        }
    }
}
