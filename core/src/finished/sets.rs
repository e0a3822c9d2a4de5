//! Which textures stand together. Faces of one material read one set of textures, or several where it has parts; and
//! several materials may share one.

use std::collections::{BTreeMap, BTreeSet};

use super::{Finished, FinishedTexture};
use crate::asset::Slot;
use crate::error::{Error, Result};
use crate::image::Pixels;

impl Finished {
    /// The parts of each material that has converted textures, both ascending.
    pub fn parts(&self) -> BTreeMap<usize, BTreeSet<usize>> {
        let mut parts: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for texture in &self.textures {
            for &material in &texture.materials {
                parts.entry(material).or_default().insert(texture.part);
            }
        }
        parts
    }

    /// The textures that faces of a material read that stand in one of its parts, with their numbers.
    pub fn textures_of(
        &self,
        material: usize,
        part: usize,
    ) -> impl Iterator<Item = (usize, &FinishedTexture)> + Clone {
        self.textures.iter().enumerate().filter(move |(_, texture)| texture.is_of(material, part))
    }

    /// The channels of a material in the order of its first part's textures: of each the numbers of its textures, part
    /// by part. A part that lacks a channel is left out, which [`Finished::check`] refuses.
    pub fn channels(&self, material: usize) -> Vec<Vec<usize>> {
        let own = self.textures.iter().filter(|texture| texture.materials.contains(&material));
        let parts: BTreeSet<usize> = own.map(|texture| texture.part).collect();
        let Some(&first) = parts.first() else { return Vec::new() };
        let channel = |slots: &[Slot]| {
            let of_part =
                |&part: &usize| self.textures_of(material, part).find(|(_, own)| own.slots == slots);
            parts.iter().filter_map(of_part).map(|(number, _)| number).collect()
        };
        self.textures_of(material, first).map(|(_, texture)| channel(&texture.slots)).collect()
    }

    /// Checks that the parts of each material show the same channels in images of one kind, and that every primitive
    /// has coordinates that fit its textures.
    ///
    /// # Errors
    /// `InvalidModel` with the material and the rule: a texture without materials, or with materials that do not
    /// ascend; textures of one part that differ in size; parts that differ in their slots, in the number of levels, in
    /// components or bits. Those of [`Finished::check_coordinates`].
    pub fn check(&self) -> Result<()> {
        for (number, texture) in self.textures.iter().enumerate() {
            if texture.materials.is_empty() || !texture.materials.is_sorted_by(|a, b| a < b) {
                let rule = format!("converted texture {number} needs ascending materials that show it");
                return Err(Error::invalid(rule));
            }
        }
        for (material, parts) in self.parts() {
            self.check_parts(material, &parts)
                .map_err(|rule| Error::invalid(rule).at(format!("/materials/{material}")))?;
        }
        self.check_coordinates()
    }

    fn check_parts(&self, material: usize, parts: &BTreeSet<usize>) -> std::result::Result<(), String> {
        let mut first: Option<(usize, Vec<Kind<'_>>)> = None;
        for &part in parts {
            let textures = || self.textures_of(material, part).map(|(_, texture)| texture);
            check_sizes(textures())?;
            let mut kinds: Vec<Kind<'_>> = textures().map(Kind::of).collect();
            kinds.sort_unstable();
            match &first {
                None => first = Some((part, kinds)),
                Some((_, own)) if *own == kinds => {}
                Some((own, _)) => {
                    return Err(format!(
                        "parts {own} and {part} of one material have to show the same channels, with as many \
                         levels, components and bits"
                    ));
                }
            }
        }
        Ok(())
    }
}

/// What a channel has in common over the parts of a material.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Kind<'a> {
    slots: &'a [Slot],
    level_count: usize,
    /// Of level 0.
    components: Option<u8>,
    is_deep: bool,
    /// The bits of its scale.
    value_scale: Option<u32>,
}

impl<'a> Kind<'a> {
    fn of(texture: &'a FinishedTexture) -> Self {
        let finest = texture.levels.first();
        Self {
            slots: &texture.slots,
            level_count: texture.levels.len(),
            components: finest.map(|image| image.components),
            is_deep: finest.is_some_and(|image| matches!(image.pixels, Pixels::U16(_))),
            value_scale: texture.value_scale.map(f32::to_bits),
        }
    }
}

/// They share coordinates.
fn check_sizes<'a>(
    mut textures: impl Iterator<Item = &'a FinishedTexture>,
) -> std::result::Result<(), String> {
    let sizes = |texture: &FinishedTexture| -> Vec<[u32; 2]> {
        texture.levels.iter().map(|level| level.size()).collect()
    };
    let Some(first) = textures.next() else { return Ok(()) };
    match textures.find(|other| sizes(other) != sizes(first)) {
        Some(other) => Err(format!(
            "{} and {} have to have the same sizes at every level, because they share coordinates",
            name(first),
            name(other)
        )),
        None => Ok(()),
    }
}

fn name(texture: &FinishedTexture) -> &str {
    texture.slots.first().map_or("a texture without slots", |slot| slot.gltf_name())
}
