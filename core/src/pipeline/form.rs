//! What a channel stands for and how it is stored, wherever its samples come from.

use crate::asset::{AlphaMode, Asset, MeshColorChannel, Slot};
use crate::assign::Codec;
use crate::image::Transfer;
use crate::source::{ChannelKind, SourceChannel};

#[derive(Clone, Debug)]
pub struct ChannelForm {
    pub material: usize,
    pub slots: Vec<Slot>,
    pub kind: ChannelKind,
    pub codec: Codec,
    /// Of numbers of any size: what a value of 1 stands for. They are stored in ranges at every level.
    pub value_scale: Option<f32>,
}

impl ChannelForm {
    /// As its texture stores it, without an alpha that nobody reads; of an attribute every component is read.
    pub fn of_source(channel: &SourceChannel<'_>) -> Self {
        let is_gray = channel.image.components <= 2 && !channel.is_normal() && !channel.is_tinted;
        let keeps_alpha = channel.is_alpha_weighted() || channel.is_attribute() && channel.image.has_alpha();
        let components = if is_gray { 1 } else { 3 } + u8::from(keeps_alpha);
        Self {
            material: channel.material,
            slots: channel.slots.clone(),
            kind: channel.kind,
            codec: Codec { transfer: channel.transfer, components, bits: channel.image.bits() },
            value_scale: channel.image.value_scale(),
        }
    }

    /// As its file says, without an alpha that the material ignores.
    pub fn of_colors(asset: &Asset, material: usize, channel: &MeshColorChannel) -> Self {
        let properties = &asset.materials[material];
        let has_alpha = channel.components.is_multiple_of(2) && !channel.slots.iter().any(Slot::is_attribute);
        let shows_alpha =
            channel.slots.contains(&Slot::BaseColor) && properties.alpha_mode != AlphaMode::Opaque;
        let kind = match (channel.slots.contains(&Slot::Normal), has_alpha && shows_alpha) {
            (true, _) => ChannelKind::Normal { scale: properties.normal_scale },
            (false, true) => ChannelKind::AlphaWeighted,
            (false, false) => ChannelKind::Plain,
        };
        let is_color = channel.slots.iter().any(|slot| slot.is_color());
        let codec = Codec {
            transfer: if is_color { Transfer::Srgb } else { Transfer::Linear },
            components: channel.components - u8::from(has_alpha && !shows_alpha),
            bits: channel.bits,
        };
        Self { material, slots: channel.slots.clone(), kind, codec, value_scale: channel.value_scale }
    }
}
