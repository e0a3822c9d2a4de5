//! The lists of extensions at the file's root, and what stands for them in the rest of the file.

use std::collections::BTreeSet;

use serde_json::{Map, Value};

use crate::finished::EXTENSION;

use super::draft::Draft;
use super::in_use;

/// Extensions that go out of use where conversion replaced the last thing that had them.
const MAY_LEAVE: [&str; 5] = [
    "KHR_texture_transform",
    "KHR_draco_mesh_compression",
    "KHR_mesh_quantization",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
];

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

/// Brings `extensionsUsed` and `extensionsRequired` up to date.
pub fn settle(draft: &mut Draft<'_>, converted: bool) {
    let mut in_use = names(draft);
    in_use::add_names(draft, &mut in_use);
    for list in ["extensionsUsed", "extensionsRequired"] {
        let Some(Value::Array(listed)) = draft.root.get_mut(list) else { continue };
        listed.retain(|name| {
            let name = name.as_str().unwrap_or_default();
            // Its own name in a source is an earlier conversion's.
            let leaves = MAY_LEAVE.contains(&name) || name == EXTENSION;
            !leaves || (in_use.contains(name) && name != EXTENSION)
        });
        if listed.is_empty() {
            draft.root.remove(list);
        }
    }
    if converted || in_use.contains(EXTENSION) {
        let used = draft.root.entry("extensionsUsed").or_insert_with(|| Value::Array(Vec::new()));
        if let Value::Array(used) = used {
            used.push(EXTENSION.into());
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
