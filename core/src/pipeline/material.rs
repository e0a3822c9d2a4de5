//! One material's journey, from its faces to its level images.

use crate::asset::{AlphaMode, Asset};
use crate::assign::{NormalFrames, choose_frames};
use crate::colors::{ChannelTopology, LevelNumbering, Resolutions};
use crate::error::Result;
use crate::layout::Layout;
use crate::mesh::CanvasMesh;
use crate::resample::sample;
use crate::source::SourceChannel;
use crate::watch::{Stage, Watch};

use super::arrange::Arranged;
use super::channel::{ChannelInput, FinishedChannel, Rooms, finish_channel};
use super::options::Options;
use super::prepare::Prepared;
use super::progress::Progress;

/// A converted material: its layout, and its channels with what was done to each.
pub struct MaterialConversion {
    pub material: usize,
    pub canvas: CanvasMesh,
    pub resolutions: Resolutions,
    /// With which everything was painted.
    pub layout: Layout,
    /// Of a material with a normal map.
    pub frames: Option<NormalFrames>,
    pub channels: Vec<FinishedChannel>,
}

/// Converts one material.
pub fn convert_material(
    asset: &Asset,
    prepared: Prepared<'_>,
    arranged: Arranged,
    options: &Options,
    watch: &dyn Watch,
    progress: &mut Progress<'_>,
) -> Result<MaterialConversion> {
    let Prepared { material, canvas, sources, cuts, normals, .. } = prepared;
    let Arranged { resolutions, layout } = arranged;
    let normal_scale = sources.iter().find_map(|source| source.channel.normal_scale()).unwrap_or(1.0);
    let frames = normals.map(|normals| {
        let normal_map = sources.iter().find(|source| source.channel.is_normal());
        let given = normal_map.filter(|_| options.shares).map(|source| source.repeated_frames(&canvas));
        let given = given.unwrap_or_else(|| vec![None; canvas.faces.len()]);
        choose_frames(&canvas, &normals, &given, normal_scale)
    });
    let mut finished = Vec::with_capacity(sources.len());
    let mut rooms = Rooms::default();
    for (source, cuts) in sources.iter().zip(cuts) {
        let topology = ChannelTopology::new(&canvas, &resolutions, &cuts);
        let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
        watch.stage(Stage::Resample);
        let samples = sample(source, &numbering, rooms.take(0), options.sampling, watch)?;
        let input = ChannelInput {
            channel: source.channel,
            resolutions: &resolutions,
            layout: &layout,
            cuts,
            frames: frames.as_ref().filter(|_| source.channel.is_normal()),
            mask_cutoff: mask_cutoff(asset, source.channel),
            mip: options.mip,
            beyond: options.beyond,
            solver: options.solver,
            range: options.range,
            rounding: options.rounding,
        };
        finished.push(finish_channel(input, numbering, samples, &mut rooms, watch)?);
        progress.advance(1.0 / sources.len() as f32);
    }
    drop(sources);
    Ok(MaterialConversion { material, canvas, resolutions, layout, frames, channels: finished })
}

fn mask_cutoff(asset: &Asset, channel: &SourceChannel<'_>) -> Option<f32> {
    match asset.materials[channel.material].alpha_mode {
        AlphaMode::Mask(cutoff) if channel.is_alpha_weighted() => Some(cutoff),
        _ => None,
    }
}
