//! Converted textures by material: which slots read them, and their level images.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use serde_json::Value;

use crate::asset::{Asset, Slot};
use crate::error::{Error, Result};
use crate::finished::FinishedTexture;
use crate::image::{Image, LevelRange, Transfer};

use super::parts::PartOf;
use super::{EXTENSION, ranges};

/// More levels than any image size can have.
const LEVEL_COUNT_MAX: usize = 32;

/// All converted textures, in order of their first material, its part, then of the first slot that reads them.
/// `places` are the parts that glTF materials are. A texture of several materials is one where the same slots read it.
pub fn of(asset: &Asset, places: &[PartOf]) -> Result<Vec<FinishedTexture>> {
    let json = &asset.document.json;
    let mut order: Vec<(PartOf, usize)> = places.iter().copied().zip(0..).collect();
    order.sort_unstable();
    let mut all: Vec<FinishedTexture> = Vec::new();
    // By glTF texture, part and slots: which of `all` it is.
    let mut known: BTreeMap<(u64, usize, Vec<Slot>), usize> = BTreeMap::new();
    for (PartOf { material, part }, number) in order {
        for (texture, slots) in read_by(json, number)? {
            match known.entry((texture, part, slots)) {
                Entry::Occupied(entry) => all[*entry.get()].materials.push(material),
                Entry::Vacant(entry) => {
                    let (_, _, slots) = entry.key();
                    all.push(converted(asset, texture, PartOf { material, part }, slots.clone())?);
                    entry.insert(all.len() - 1);
                }
            }
        }
    }
    Ok(all)
}

/// The converted textures of a glTF material, each with the slots that read it, in order of the first of them.
fn read_by(json: &Value, material: usize) -> Result<Vec<(u64, Vec<Slot>)>> {
    let mut textures: Vec<(u64, Vec<Slot>)> = Vec::new();
    let kind = |slot: &Slot| (slot.is_color(), slot.is_attribute());
    for slot in slots_of(json, material) {
        let Some(number) = texture_number(json, material, &slot) else { continue };
        if extension_json(json, number).is_none() {
            continue;
        }
        match textures.iter_mut().find(|(known, _)| *known == number) {
            None => textures.push((number, vec![slot])),
            Some((_, slots)) if slots.iter().all(|known| kind(known) == kind(&slot)) => {
                slots.push(slot);
            }
            Some(_) => {
                let rule = "one converted texture is read as color and as data, or by an attribute and something else: each needs a texture \
                     of its own";
                return Err(Error::invalid(rule).at(format!("/materials/{material}")));
            }
        }
    }
    Ok(textures)
}

fn converted(asset: &Asset, number: u64, place: PartOf, slots: Vec<Slot>) -> Result<FinishedTexture> {
    let extension = extension_json(&asset.document.json, number).unwrap_or(&Value::Null);
    let levels = levels_of(asset, number, extension)?;
    let below = format!("/textures/{number}/extensions/{EXTENSION}/ranges");
    // What loaders without the extension show is level 0 of the core slots.
    let first = usize::from(!slots.iter().all(Slot::is_attribute));
    let ranges = ranges::of(extension.get("ranges"), &levels, first, &below)?;
    check_codes(&levels, &ranges, number)?;
    let value_scale = value_scale(extension, &slots, ranges.len() == levels.len())
        .map_err(|error| error.at(format!("/textures/{number}/extensions/{EXTENSION}/valueScale")))?;
    let is_color = slots.iter().any(|slot| slot.is_color());
    let transfer = if is_color { Transfer::Srgb } else { Transfer::Linear };
    let PartOf { material, part } = place;
    Ok(FinishedTexture { materials: vec![material], part, slots, transfer, levels, ranges, value_scale })
}

/// What a value of 1 stands for, of attributes whose levels are all in ranges.
fn value_scale(extension: &Value, slots: &[Slot], is_ranged: bool) -> Result<Option<f32>> {
    let Some(scale) = extension.get("valueScale") else { return Ok(None) };
    let scale = scale.as_f64().map(|scale| scale as f32).filter(|scale| scale.is_finite() && *scale > 0.0);
    match scale.filter(|_| is_ranged && slots.iter().all(Slot::is_attribute)) {
        Some(scale) => Ok(Some(scale)),
        None => Err(Error::invalid(
            "\"valueScale\" has to be a finite number above 0, of a texture of attributes whose levels all have ranges",
        )),
    }
}

/// The slots that a glTF material may have a texture in.
fn slots_of(json: &Value, material: usize) -> Vec<Slot> {
    let pointer = format!("/materials/{material}/extensions/{EXTENSION}/channels");
    let channels = json.pointer(&pointer).and_then(Value::as_object);
    let attributes = channels.into_iter().flat_map(|channels| channels.keys());
    let attributes = attributes.filter_map(|name| Slot::of_gltf_name(name)).filter(Slot::is_attribute);
    let mut slots: Vec<Slot> = Slot::CORE.into_iter().chain(attributes).collect();
    slots.sort_unstable();
    slots
}

fn texture_number(json: &Value, material: usize, slot: &Slot) -> Option<u64> {
    let mut info = json.get("materials")?.get(material)?;
    for step in slot.path() {
        info = info.get(step)?;
    }
    info.get("index")?.as_u64()
}

fn texture_json(json: &Value, number: u64) -> Option<&Value> {
    json.get("textures")?.get(usize::try_from(number).ok()?)
}

fn extension_json(json: &Value, number: u64) -> Option<&Value> {
    texture_json(json, number)?.get("extensions")?.get(EXTENSION)
}

fn levels_place(number: u64) -> String {
    format!("/textures/{number}/extensions/{EXTENSION}/levels")
}

fn levels_of(asset: &Asset, number: u64, extension: &Value) -> Result<Vec<Image>> {
    let place = levels_place(number);
    let lie = |rule: String| Error::invalid(rule).at(&place);
    let levels = extension.get("levels").and_then(Value::as_array);
    let levels = levels.filter(|levels| !levels.is_empty() && levels.len() <= LEVEL_COUNT_MAX);
    let levels = levels.ok_or_else(|| {
        lie(format!("\"levels\" has to be a list of 1 to {LEVEL_COUNT_MAX} image numbers, level 0 first"))
    })?;
    let source = texture_json(&asset.document.json, number).and_then(|texture| texture.get("source"));
    if source != levels.first() {
        return Err(lie("level 0 has to be the texture's \"source\"".to_owned()));
    }
    let mut images: Vec<Image> = Vec::with_capacity(levels.len());
    for (level, index) in levels.iter().enumerate() {
        let image = index.as_u64().and_then(|index| asset.images.get(usize::try_from(index).ok()?));
        let image = image.filter(|image| is_decoded(image));
        let image = image.ok_or_else(|| {
            let count = asset.images.len();
            lie(format!("level {level} is {index}, which is not one of the file's {count} images"))
        })?;
        if let Some(first) = images.first() {
            // With indexed coordinates a level may be wider than the one before, not larger.
            let texels = |image: &Image| u64::from(image.width) * u64::from(image.height);
            if first.components != image.components || texels(image) > texels(first) {
                return Err(lie(format!(
                    "level {level} has to have the components of level 0, and at most its texels"
                )));
            }
        }
        images.push(image.clone());
    }
    Ok(images)
}

/// Levels without a range are stored as level 0 is.
fn check_codes(levels: &[Image], ranges: &BTreeMap<usize, LevelRange>, number: u64) -> Result<()> {
    let differs = |level: &usize| levels[*level].code_max() != levels[0].code_max();
    match (0..levels.len()).filter(|level| !ranges.contains_key(level)).find(differs) {
        Some(level) => {
            Err(Error::invalid(format!("level {level} has to have the bits of level 0, or a range"))
                .at(levels_place(number)))
        }
        None => Ok(()),
    }
}

/// Whether `read` decoded the image: one that it left out has no texels.
fn is_decoded(image: &Image) -> bool {
    image.width > 0 && image.height > 0
}
