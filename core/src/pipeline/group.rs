//! Materials whose textures are set out together: each by itself, or all that have the same channels.

use std::collections::BTreeMap;

use crate::asset::Slot;
use crate::assign::Codec;
use crate::error::Result;
use crate::finished::FinishedTexture;
use crate::image::{Image, LevelRange};
use crate::layout::Coordinates;
use crate::pack::{Channel, PackOptions, Packed, Painted, pack};

use super::form::ChannelForm;
use super::material::MaterialConversion;
use super::options::Options;
use super::prepare::Prepared;
use super::together::{self, together};

/// Materials with one set of textures.
pub struct Group {
    /// Of the conversions, ascending.
    pub members: Vec<usize>,
    /// With indexed coordinates: where everything stands. 4D coordinates keep their layout.
    pub packed: Option<Packed>,
    pub part_count: usize,
}

/// What the channels of two materials have to have in common: of each its slots and how it is stored.
type Kind = Vec<(Vec<Slot>, Codec, Option<f32>)>;

/// Which materials have one set of textures, ascending: each alone, or, merged, all whose channels are of the same kinds.
pub fn sets(materials: &[Prepared<'_>], merges: bool) -> Vec<Vec<usize>> {
    let mut sets: Vec<(Kind, Vec<usize>)> = Vec::new();
    for (number, material) in materials.iter().enumerate() {
        let of_form = |form: &ChannelForm| (form.slots.clone(), form.codec, form.value_scale);
        let kind = material.channels.iter().map(of_form).collect();
        match sets.iter_mut().find(|(known, _)| merges && *known == kind) {
            Some((_, set)) => set.push(number),
            None => sets.push((kind, vec![number])),
        }
    }
    sets.into_iter().map(|(_, set)| set).collect()
}

/// Sets out all materials. `sets`: which have their textures in common.
///
/// # Errors
/// `TextureTooLarge`.
pub fn groups(
    conversions: &[MaterialConversion],
    sets: Vec<Vec<usize>>,
    options: &Options,
) -> Result<Vec<Group>> {
    let group = |members: Vec<usize>| {
        let packed = (options.coordinates == Coordinates::Indexed)
            .then(|| {
                let painted: Vec<_> = members.iter().map(|&member| painted(&conversions[member])).collect();
                let pack_options = PackOptions {
                    shares: options.shares,
                    max_side: options.max_side,
                    packing: options.packing,
                };
                pack(&painted, pack_options)
            })
            .transpose()?;
        let part_count =
            packed.as_ref().map_or(conversions[members[0]].layout.parts.len(), |packed| packed.pages.len());
        Ok(Group { members, packed, part_count })
    };
    sets.into_iter().map(group).collect()
}

fn painted(conversion: &MaterialConversion) -> Painted<'_> {
    let images = conversion.channels.iter().map(|channel| &channel.levels[..]).collect();
    Painted { canvas: &conversion.canvas, layout: &conversion.layout, images }
}

impl Group {
    /// Takes the level images out of the conversions: all textures, part by part and of each part by channel.
    pub fn take_textures(&self, conversions: &mut [MaterialConversion]) -> Vec<FinishedTexture> {
        let first = self.members[0];
        let materials: Vec<usize> = self.members.iter().map(|&member| conversions[member].material).collect();
        let mut textures: Vec<FinishedTexture> = Vec::new();
        for channel in 0..conversions[first].channels.len() {
            // One channel after the other: what was painted of it goes before the next comes.
            let (parts, ranges) = self.parts(conversions, channel);
            for (part, levels) in parts.into_iter().enumerate() {
                let channel = &conversions[first].channels[channel];
                textures.push(FinishedTexture {
                    materials: materials.clone(),
                    part,
                    slots: channel.form.slots.clone(),
                    transfer: channel.form.codec.transfer,
                    levels,
                    ranges: ranges.clone(),
                    value_scale: channel.form.value_scale,
                });
            }
        }
        // Stable: channels stay in their order.
        textures.sort_by_key(|texture| texture.part);
        textures
    }

    /// The level images of a channel, part by part, and the ranges of its levels.
    fn parts(
        &self,
        conversions: &mut [MaterialConversion],
        channel: usize,
    ) -> (Vec<Vec<Image>>, BTreeMap<usize, LevelRange>) {
        let mut taken = Vec::with_capacity(self.members.len());
        for &member in &self.members {
            let channel = &mut conversions[member].channels[channel];
            taken.push((std::mem::take(&mut channel.levels), std::mem::take(&mut channel.ranges)));
        }
        let layouts = self.members.iter().map(|&member| &conversions[member].layout);
        let Some(packed) = &self.packed else {
            let painted = layouts.zip(taken).map(|(layout, (levels, ranges))| together::Painted {
                layout,
                levels,
                ranges,
            });
            return together(
                painted.collect(),
                conversions[self.members[0]].channels[channel].form.codec.transfer,
            );
        };
        let channels: Vec<Channel<'_>> =
            layouts.zip(&taken).map(|(layout, (levels, _))| Channel { layout, levels }).collect();
        let parts = (0..self.part_count).map(|part| packed.images(part, &channels)).collect();
        // With indexed coordinates nothing but numbers of any size is in ranges, and of these in the same.
        (parts, taken[0].1.clone())
    }
}

#[cfg(test)]
mod tests;
