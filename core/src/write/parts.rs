//! The glTF materials of a converted material's parts: the first stands in the source's place, the others are copies at
//! the end of `materials` that say what they are parts of.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};

use crate::asset::Asset;
use crate::error::{Error, Result};
use crate::finished::{EXTENSION, Finished};

use super::draft::{Draft, at, member, object, remove_extension};

/// The extension by which animations name properties.
pub const POINTER: &str = "KHR_animation_pointer";

/// An earlier conversion's parts are materials of their own now.
pub fn forget(draft: &mut Draft<'_>) {
    for material in draft.materials.iter_mut().filter_map(Value::as_object_mut) {
        remove_extension(material, EXTENSION);
    }
}

/// Makes a glTF material for each material and part that has faces, or for a first part where none has; returns their
/// numbers.
///
/// # Errors
/// `Internal` where a texture names a material that the asset lacks.
pub fn open(
    draft: &mut Draft<'_>,
    asset: &Asset,
    finished: &Finished,
) -> Result<BTreeMap<(usize, usize), usize>> {
    let drawn = finished.primitives.iter().filter(|piece| !piece.triangles.is_empty());
    let with_faces: BTreeSet<(usize, usize)> = drawn.map(|piece| (piece.material, piece.part)).collect();
    let mut numbers = BTreeMap::new();
    // What follows is appended behind all of the asset's.
    if let Some(last) = asset.materials.len().checked_sub(1) {
        at(&mut draft.materials, last);
    }
    for (material, parts) in finished.parts() {
        if material >= asset.materials.len() {
            return Err(Error::internal("a converted texture has no place in the asset's materials"));
        }
        let mut used: BTreeSet<usize> =
            parts.iter().copied().filter(|&part| with_faces.contains(&(material, part))).collect();
        used.extend(parts.first().copied().filter(|_| used.is_empty()));
        let source = at(&mut draft.materials, material).clone();
        let name = name(draft, material);
        for (rank, part) in used.into_iter().enumerate() {
            let mut own = Map::new();
            let number = if rank == 0 { material } else { draft.materials.len() };
            let json = object(at(&mut draft.materials, number));
            if rank > 0 {
                json.clone_from(source.as_object().unwrap_or(&Map::new()));
                json.insert("name".to_owned(), format!("{name} (part {})", rank + 1).into());
                own.insert("partOf".to_owned(), material.into());
            }
            if part > 0 {
                own.insert("part".to_owned(), part.into());
            }
            if !own.is_empty() {
                member(json, "extensions").insert(EXTENSION.to_owned(), Value::Object(own));
            }
            numbers.insert((material, part), number);
        }
    }
    Ok(numbers)
}

/// What a person calls a glTF material.
pub fn name(draft: &mut Draft<'_>, material: usize) -> String {
    let name = at(&mut draft.materials, material).get("name").and_then(Value::as_str);
    match name.filter(|name| !name.is_empty()) {
        Some(name) => name.to_owned(),
        None => format!("material {material}"),
    }
}

/// What is animated in a material is animated in all its parts.
pub fn follow(draft: &mut Draft<'_>, numbers: &BTreeMap<(usize, usize), usize>) {
    let mut copies: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (&(material, _), &number) in numbers.iter().filter(|((material, _), number)| material != *number) {
        copies.entry(material).or_default().push(number);
    }
    for channels in channels(draft) {
        let mut more = Vec::new();
        for channel in channels.iter() {
            let Some((material, rest)) = pointer(channel) else { continue };
            for copy in copies.get(&material).into_iter().flatten() {
                let mut channel = channel.clone();
                channel["target"]["extensions"][POINTER]["pointer"] =
                    json!(format!("/materials/{copy}{rest}"));
                more.push(channel);
            }
        }
        channels.extend(more);
    }
}

/// The materials that animations name.
pub fn animated(draft: &mut Draft<'_>) -> BTreeSet<usize> {
    let channels = channels(draft).flat_map(|channels| channels.iter());
    channels.filter_map(|channel| pointer(channel).map(|(material, _)| material)).collect()
}

fn channels<'d>(draft: &'d mut Draft<'_>) -> impl Iterator<Item = &'d mut Vec<Value>> {
    let animations = draft.root.get_mut("animations").and_then(Value::as_array_mut);
    animations.into_iter().flatten().filter_map(|animation| animation.get_mut("channels")?.as_array_mut())
}

/// The material that a channel's pointer names, and what follows in the pointer.
fn pointer(channel: &Value) -> Option<(usize, String)> {
    let pointer = channel.get("target")?.get("extensions")?.get(POINTER)?.get("pointer")?.as_str()?;
    let rest = pointer.strip_prefix("/materials/")?;
    let end = rest.find('/').unwrap_or(rest.len());
    Some((rest[..end].parse().ok()?, rest[end..].to_owned()))
}
