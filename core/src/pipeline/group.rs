//! Materials whose textures are set out together: each by itself, or all that have the same channels.

use crate::asset::Slot;
use crate::error::Result;
use crate::finished::FinishedTexture;
use crate::image::{Image, Transfer};
use crate::layout::Coordinates;
use crate::pack::{Channel, PackOptions, Packed, Painted, pack};

use super::channel::FinishedChannel;
use super::material::MaterialConversion;
use super::options::Options;

/// Materials with one set of textures.
pub struct Group {
    /// Of the conversions, ascending.
    pub members: Vec<usize>,
    /// With indexed coordinates: where everything stands. 4D coordinates keep what was painted.
    pub packed: Option<Packed>,
}

/// What the channels of two materials have to have in common.
type Kind = Vec<(Vec<Slot>, Transfer, u8, bool)>;

/// Sets out all materials.
///
/// # Errors
/// `TextureTooLarge`.
pub fn groups(conversions: &[MaterialConversion], options: &Options) -> Result<Vec<Group>> {
    let mut groups: Vec<(Kind, Group)> = Vec::new();
    for (number, conversion) in conversions.iter().enumerate() {
        let kind = conversion.channels.iter().map(kind).collect();
        match groups.iter_mut().find(|(known, _)| options.merges && *known == kind) {
            Some((_, group)) => group.members.push(number),
            None => groups.push((kind, Group { members: vec![number], packed: None })),
        }
    }
    let mut groups: Vec<Group> = groups.into_iter().map(|(_, group)| group).collect();
    if options.coordinates == Coordinates::Indexed {
        for group in &mut groups {
            let painted: Vec<Painted<'_>> =
                group.members.iter().map(|&member| painted(&conversions[member])).collect();
            let pack_options = PackOptions { shares: options.shares, max_side: options.max_side };
            group.packed = Some(pack(&painted, pack_options)?);
        }
    }
    Ok(groups)
}

fn kind(channel: &FinishedChannel) -> (Vec<Slot>, Transfer, u8, bool) {
    let image = channel.levels.first();
    let components = image.map_or(0, |image| image.components);
    let is_wide = image.is_some_and(|image| image.code_max() > 255.0);
    (channel.slots.clone(), channel.transfer, components, is_wide)
}

fn painted(conversion: &MaterialConversion) -> Painted<'_> {
    let images = conversion.channels.iter().map(|channel| &channel.levels[..]).collect();
    Painted { canvas: &conversion.canvas, layout: &conversion.layout, images }
}

impl Group {
    pub fn part_count(&self) -> usize {
        self.packed.as_ref().map_or(1, |packed| packed.pages.len())
    }

    /// Takes the level images out of the conversions: all textures, part by part and of each part by channel.
    pub fn take_textures(&self, conversions: &mut [MaterialConversion]) -> Vec<FinishedTexture> {
        let first = self.members[0];
        let materials: Vec<usize> = self.members.iter().map(|&member| conversions[member].material).collect();
        let mut textures: Vec<FinishedTexture> = Vec::new();
        for channel in 0..conversions[first].channels.len() {
            // One channel after the other: what was painted of it goes before the next comes.
            let painted: Vec<Vec<Image>> = (self.members.iter())
                .map(|&member| std::mem::take(&mut conversions[member].channels[channel].levels))
                .collect();
            let ranges = std::mem::take(&mut conversions[first].channels[channel].ranges);
            for (part, levels) in self.parts(conversions, painted).into_iter().enumerate() {
                let channel = &conversions[first].channels[channel];
                textures.push(FinishedTexture {
                    materials: materials.clone(),
                    part,
                    slots: channel.slots.clone(),
                    transfer: channel.transfer,
                    levels,
                    ranges: ranges.clone(),
                });
            }
        }
        // Stable: channels stay in their order.
        textures.sort_by_key(|texture| texture.part);
        textures
    }

    /// The level images of a channel, part by part.
    fn parts(&self, conversions: &[MaterialConversion], mut painted: Vec<Vec<Image>>) -> Vec<Vec<Image>> {
        let Some(packed) = &self.packed else { return vec![painted.swap_remove(0)] };
        let channels: Vec<Channel<'_>> = (self.members.iter().zip(&painted))
            .map(|(&member, levels)| Channel { layout: &conversions[member].layout, levels })
            .collect();
        (0..packed.pages.len()).map(|part| packed.images(part, &channels)).collect()
    }
}

#[cfg(test)]
mod tests;
