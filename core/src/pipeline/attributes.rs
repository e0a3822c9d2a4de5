//! Attributes of materials before anything is converted: that all asked for are there, and none was converted before.

use serde_json::Value;

use super::options::Options;
use crate::asset::{Asset, Slot};
use crate::error::{Error, ErrorCode, Result};
use crate::finished::EXTENSION;

/// # Errors
/// `InvalidOptions` where the model was read without a channel that is asked for; `InvalidModel` where it has one whose images are
/// levels in ranges, which no texture stands for.
pub fn check(asset: &Asset, options: &Options) -> Result<()> {
    for source in &options.channels {
        let slot = Slot::Attribute(source.name);
        if !asset.materials.iter().any(|material| material.slots.contains_key(&slot)) {
            let detail = format!("the model was read without its channel {}", source.name.as_str());
            return Err(Error::new(ErrorCode::InvalidOptions, detail).at("/channel"));
        }
    }
    for (number, material) in asset.materials.iter().enumerate() {
        for slot in material.slots.keys().filter(|slot| slot.is_attribute()) {
            if is_ranged(&asset.document.json, number, slot) {
                let detail = format!(
                    "{} was converted before, and its images hold numbers in ranges of their own; convert the model that this one \
                     was made of",
                    slot.gltf_name()
                );
                return Err(
                    Error::invalid(detail).at(format!("/materials/{number}/{}", slot.path().join("/")))
                );
            }
        }
    }
    Ok(())
}

fn is_ranged(json: &Value, material: usize, slot: &Slot) -> bool {
    let info = json.pointer(&format!("/materials/{material}/{}/index", slot.path().join("/")));
    let ranges = info
        .and_then(Value::as_u64)
        .and_then(|texture| json.pointer(&format!("/textures/{texture}/extensions/{EXTENSION}/ranges")));
    let is_first = |range: &Value| range.get("level").and_then(Value::as_u64) == Some(0);
    ranges.and_then(Value::as_array).is_some_and(|ranges| ranges.iter().any(is_first))
}
