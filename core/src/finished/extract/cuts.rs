//! Cuts of a primitive: one byte for each triangle and slot.

use serde_json::Value;

use crate::asset::Slot;
use crate::error::Result;
use crate::finished::{FinishedTexture, PrimitiveCuts};

use super::parts::PartOf;
use super::{EXTENSION, Place};

const UNSIGNED_BYTE: u64 = 5121;
/// One bit for each edge of a triangle.
const EDGE_BITS: u8 = 0b111;

/// The cuts of all textures that have any here, in the order of the textures.
pub fn of(
    place: &Place<'_>,
    PartOf { material, part }: PartOf,
    textures: &[FinishedTexture],
    triangle_count: usize,
) -> Result<Vec<PrimitiveCuts>> {
    let named = place
        .json()
        .and_then(|json| json.get("extensions")?.get(EXTENSION)?.get("cuts")?.as_object())
        .cloned()
        .unwrap_or_default();
    let below = |name: &str| format!("/extensions/{EXTENSION}/cuts/{name}");
    let mut cuts: Vec<PrimitiveCuts> = Vec::new();
    for (texture, channel) in textures.iter().enumerate().filter(|(_, own)| own.is_of(material, part)) {
        let mut shared: Option<Vec<u8>> = None;
        for slot in &channel.slots {
            let bits = match named.get(slot.gltf_name()) {
                Some(accessor) => bytes(place, slot.gltf_name(), accessor, triangle_count)?,
                None => vec![0; triangle_count],
            };
            if shared.as_ref().is_some_and(|shared| *shared != bits) {
                let rule = "slots that read one texture have to have the same cuts";
                return Err(place.lie(&below(slot.gltf_name()), rule));
            }
            shared = Some(bits);
        }
        let bits = shared.unwrap_or_default();
        if bits.iter().any(|bits| *bits != 0) {
            cuts.push(PrimitiveCuts { texture, bits });
        }
    }
    let converted = |name: &str| {
        textures.iter().any(|texture| {
            texture.is_of(material, part) && texture.slots.iter().any(|slot: &Slot| slot.gltf_name() == name)
        })
    };
    match named.keys().find(|name| !converted(name)) {
        Some(name) => Err(place.lie(&below(name), "the material has no converted texture of this name")),
        None => Ok(cuts),
    }
}

/// The bytes of a cuts accessor, which only this extension points at.
fn bytes(place: &Place<'_>, name: &str, accessor: &Value, triangle_count: usize) -> Result<Vec<u8>> {
    let document = &place.asset.document;
    let lie = |rule: &str| place.lie(&format!("/extensions/{EXTENSION}/cuts/{name}"), rule);
    let item = |array: &str, index: &Value| {
        let index = usize::try_from(index.as_u64()?).ok()?;
        document.json.get(array)?.get(index)
    };
    let accessor = item("accessors", accessor).ok_or_else(|| lie("there is no accessor of this number"))?;
    let is_plain = accessor.get("componentType").and_then(Value::as_u64) == Some(UNSIGNED_BYTE)
        && accessor.get("type").and_then(Value::as_str) == Some("SCALAR")
        && accessor.get("sparse").is_none();
    if !is_plain {
        return Err(lie("the accessor has to be SCALAR of UNSIGNED_BYTE, not sparse"));
    }
    let count = number(accessor, "count").unwrap_or(0);
    if count != triangle_count {
        return Err(lie(&format!("there are {count} values for {triangle_count} triangles")));
    }
    let view = accessor.get("bufferView").and_then(|view| item("bufferViews", view));
    let view = view.ok_or_else(|| lie("the accessor needs a buffer view"))?;
    let stride = number(view, "byteStride").unwrap_or(1).max(1);
    let read = || {
        let buffer = document.buffers.get(number(view, "buffer")?)?;
        let view_start = number(view, "byteOffset").unwrap_or(0);
        let view_end = view_start.checked_add(number(view, "byteLength")?)?;
        let view = buffer.get(view_start..view_end)?;
        let start = number(accessor, "byteOffset").unwrap_or(0);
        let end = start.checked_add(stride.checked_mul(count.checked_sub(1)?)?)?;
        Some(view.get(start..=end)?.iter().step_by(stride).copied().collect::<Vec<u8>>())
    };
    let bytes = read().ok_or_else(|| lie("the accessor leaves its buffer view"))?;
    if bytes.iter().any(|bits| bits & !EDGE_BITS != 0) {
        return Err(lie("a triangle has three edges: only bits 0 to 2 may be set"));
    }
    Ok(bytes)
}

fn number(value: &Value, name: &str) -> Option<usize> {
    value.get(name)?.as_u64().and_then(|number| usize::try_from(number).ok())
}
