//! Primitives that have something to show and no material.

use serde_json::{Value, json};

use super::gltf::blank_material;
use crate::asset::{Material, Mesh, Primitive};
use crate::error::Result;

/// Gives those with faces that `shows` names glTF's default material, written out at the end of `materials`: it can have a texture
/// then. Those that switch materials (`KHR_materials_variants`) stay without.
pub(super) fn give_material(
    json: &mut Value,
    meshes: &mut [Mesh],
    all: &mut Vec<Material>,
    shows: impl Fn(&Primitive) -> bool,
) -> Result<()> {
    let number = all.len();
    let mut is_used = false;
    for (mesh, content) in meshes.iter_mut().enumerate() {
        for (primitive, own) in content.primitives.iter_mut().enumerate() {
            let is_bare = own.material.is_none() && !own.faces.is_empty() && shows(own);
            let place = format!("/meshes/{mesh}/primitives/{primitive}");
            let Some(json) = json.pointer_mut(&place).filter(|_| is_bare) else { continue };
            if json.pointer("/extensions/KHR_materials_variants").is_none() {
                own.material = Some(number);
                json["material"] = number.into();
                is_used = true;
            }
        }
    }
    if is_used {
        all.push(blank_material()?);
        match json.get_mut("materials").and_then(Value::as_array_mut) {
            Some(list) => list.push(json!({})),
            None => json["materials"] = json!([{}]),
        }
    }
    Ok(())
}
