//! Converted textures by material: which slots read them, and their level images.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::asset::{Asset, Slot};
use crate::error::{Error, Result};
use crate::finished::FinishedTexture;
use crate::image::{Image, LevelRange, Transfer};

use super::{EXTENSION, ranges};

/// More levels than any image size can have.
const LEVEL_COUNT_MAX: usize = 32;

/// All converted textures, in order of material, then of the first slot that reads them.
pub fn of(asset: &Asset) -> Result<Vec<FinishedTexture>> {
    let mut all: Vec<FinishedTexture> = Vec::new();
    for material in 0..asset.materials.len() {
        let first = all.len();
        // The glTF texture that each of `all[first..]` came from.
        let mut numbers: Vec<u64> = Vec::new();
        for slot in Slot::ALL {
            let Some(number) = texture_number(&asset.document.json, material, slot) else { continue };
            let Some(extension) = extension_json(&asset.document.json, number) else { continue };
            match numbers.iter().position(|known| *known == number) {
                Some(known) => all[first + known].add_slot(slot, material)?,
                None => {
                    numbers.push(number);
                    let levels = levels_of(asset, number, extension)?;
                    let place = format!("/textures/{number}/extensions/{EXTENSION}/ranges");
                    let ranges = ranges::of(extension.get("ranges"), &levels, &place)?;
                    check_codes(&levels, &ranges, number)?;
                    let transfer = transfer_of(slot);
                    let slots = vec![slot];
                    let materials = vec![material];
                    all.push(FinishedTexture { materials, part: 0, slots, transfer, levels, ranges });
                }
            }
        }
        check_sizes(&all[first..], material)?;
    }
    Ok(all)
}

impl FinishedTexture {
    fn add_slot(&mut self, slot: Slot, material: usize) -> Result<()> {
        if self.transfer != transfer_of(slot) {
            let rule = "one converted texture is read as color and as data: each needs a texture of its own";
            return Err(Error::invalid(rule).at(format!("/materials/{material}")));
        }
        self.slots.push(slot);
        Ok(())
    }
}

fn transfer_of(slot: Slot) -> Transfer {
    if slot.is_color() { Transfer::Srgb } else { Transfer::Linear }
}

fn texture_number(json: &Value, material: usize, slot: Slot) -> Option<u64> {
    let material = json.get("materials")?.get(material)?;
    let holder = if slot.in_pbr() { material.get("pbrMetallicRoughness")? } else { material };
    holder.get(slot.gltf_name())?.get("index")?.as_u64()
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

fn check_sizes(textures: &[FinishedTexture], material: usize) -> Result<()> {
    let sizes = |texture: &FinishedTexture| texture.levels.iter().map(Image::size).collect::<Vec<_>>();
    let Some((first, others)) = textures.split_first() else { return Ok(()) };
    match others.iter().find(|other| sizes(other) != sizes(first)) {
        Some(other) => Err(Error::invalid(format!(
            "{} and {} have to have the same sizes at every level, because they share coordinates",
            first.slots[0].gltf_name(),
            other.slots[0].gltf_name()
        ))
        .at(format!("/materials/{material}"))),
        None => Ok(()),
    }
}
