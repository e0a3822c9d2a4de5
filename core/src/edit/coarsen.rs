//! Fewer samples: those of later mip levels.

use glam::{Vec4, Vec4Swizzles};

use crate::asset::{Asset, MeshColorChannel, MeshColors};
use crate::colors::{ChannelTopology, LevelNumbering, Resolutions};
use crate::error::Result;
use crate::mip::{Beyond, Coarsener, MipFilter, Rungs};
use crate::pipeline::form::ChannelForm;
use crate::pipeline::painted::cut_bits;
use crate::watch::Watch;

use super::painting::{PaintedChannel, Painting};

/// The mesh colors with the exponents of `selected` faces lower by `by`, 0 at least.
///
/// Inside of a face and along an edge samples are those of the level that has as many there. A vertex is as many levels on
/// as the face around it that falls least, so it stays as it is beside a face that stays.
pub fn coarsened(
    asset: &Asset,
    painting: &Painting,
    selected: &[bool],
    (by, filter): (u8, MipFilter),
    watch: &dyn Watch,
) -> Result<MeshColors> {
    let fall = |(exponents, selected): (&[u8; 2], &bool)| {
        exponents.map(|exponent| if *selected { exponent.saturating_sub(by) } else { exponent })
    };
    let faces: Vec<[u8; 2]> = painting.resolutions.faces.iter().zip(selected).map(fall).collect();
    let falls = painting
        .resolutions
        .faces
        .iter()
        .zip(&faces)
        .map(|(old, new)| old[0].max(old[1]) - new[0].max(new[1]));
    let task = Task { painting, falls: falls.collect(), resolutions: Resolutions { faces }, filter };
    let channels = painting.channels.iter().map(|channel| task.channel(asset, channel, watch));
    let channels = channels.collect::<Result<_>>()?;
    Ok(MeshColors { partners: painting.partners.clone(), exponents: task.resolutions.faces, channels })
}

struct Task<'a> {
    painting: &'a Painting,
    /// By face: how many levels it falls.
    falls: Vec<u8>,
    /// Afterwards.
    resolutions: Resolutions,
    filter: MipFilter,
}

impl Task<'_> {
    fn channel(
        &self,
        asset: &Asset,
        channel: &PaintedChannel,
        watch: &dyn Watch,
    ) -> Result<MeshColorChannel> {
        let canvas = &self.painting.canvas;
        let levels = self.levels(asset, channel, watch)?;
        let topology = ChannelTopology::new(canvas, &self.resolutions, &channel.cuts);
        let after = LevelNumbering::new(canvas, &topology, &self.resolutions, 0);
        let mut values = after.values_in(Vec::new());
        for (fan, value) in values[..topology.fan_count()].iter_mut().enumerate() {
            let around = topology.corners(fan).iter().map(|&(face, _)| self.falls[face as usize]);
            *value = levels[usize::from(around.min().unwrap_or(0))].1[fan];
        }
        for (number, (old, new)) in channel.topology.strips.iter().zip(&topology.strips).enumerate() {
            let (numbering, of_level) = &levels[usize::from(old.exponent - new.exponent)];
            values[after.strip_range(number)].copy_from_slice(&of_level[numbering.strip_range(number)]);
        }
        for face in 0..canvas.faces.len() {
            let range = after.face_range(face);
            // What has samples inside has fallen as far as was asked for.
            if !range.is_empty() {
                let (numbering, of_level) = &levels[usize::from(self.falls[face])];
                values[range].copy_from_slice(&of_level[numbering.face_range(face)]);
            }
        }
        if channel.is_normal() {
            let unit =
                |value: &Vec4| value.xyz().try_normalize().map_or(Vec4::Z, |normal| normal.extend(1.0));
            values.iter_mut().for_each(|value| *value = unit(value));
        }
        Ok(channel.with(&values, cut_bits(canvas, &channel.cuts), channel.tangents.clone()))
    }

    /// Samples of every level that is asked for.
    fn levels<'c>(
        &'c self,
        asset: &Asset,
        channel: &'c PaintedChannel,
        watch: &dyn Watch,
    ) -> Result<Vec<(LevelNumbering<'c>, Vec<Vec4>)>> {
        let bare = channel.with(&[], Vec::new(), Vec::new());
        let by_alpha = ChannelForm::of_colors(asset, self.painting.material, &bare).kind.is_alpha_weighted();
        let mut coarsener = Coarsener::new(Rungs { filter: self.filter, beyond: Beyond::OneRing, by_alpha });
        let mut levels = vec![(self.painting.numbering(channel, 0), channel.values.clone())];
        for level in 1..=usize::from(self.falls.iter().copied().max().unwrap_or(0)) {
            let coarse = self.painting.numbering(channel, level);
            let (fine, values) = &levels[level - 1];
            let values = coarsener.coarsen([fine, &coarse], values, Vec::new(), watch)?;
            levels.push((coarse, values));
        }
        Ok(levels)
    }
}
