//! One material's journey, from its faces to its level images.

use glam::Vec3;

use crate::asset::{AlphaMode, Asset};
use crate::assign::{NormalFrames, choose_frames};
use crate::colors::{ChannelTopology, LevelNumbering, Resolutions};
use crate::error::Result;
use crate::layout::Layout;
use crate::math::frame::Frame;
use crate::mesh::CanvasMesh;
use crate::resample::{Samples, sample};
use crate::watch::{Stage, Watch};

use super::arrange::Arranged;
use super::channel::{ChannelInput, FinishedChannel, finish_channel};
use super::form::ChannelForm;
use super::levels::Rooms;
use super::options::Options;
use super::painted::stored;
use super::prepare::{Content, Prepared};
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
    /// By face of such a material: frames that its normals share a block in.
    pub given_frames: Vec<Option<[Frame; 4]>>,
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
    let Prepared { material, canvas, channels, content, cuts, normals, .. } = prepared;
    let Arranged { resolutions, layout } = arranged;
    let normal_scale = channels.iter().find_map(|form| form.kind.normal_scale()).unwrap_or(1.0);
    let mut given_frames = Vec::new();
    let frames = normals.map(|normals| {
        let none = vec![None; canvas.faces.len()];
        let is_wanted = options.shares || options.mesh_colors;
        given_frames = if is_wanted { given(&content, &canvas, &normals) } else { none.clone() };
        choose_frames(&canvas, &normals, if options.shares { &given_frames } else { &none }, normal_scale)
    });
    let mut finished = Vec::with_capacity(channels.len());
    let mut rooms = Rooms::default();
    for (number, (form, cuts)) in channels.iter().zip(cuts).enumerate() {
        let topology = ChannelTopology::new(&canvas, &resolutions, &cuts);
        let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
        watch.stage(Stage::Resample);
        let samples = match &content {
            Content::Textures(sources) => {
                sample(&sources[number], &numbering, rooms.take(0), options.sampling, watch)?
            }
            Content::Painted(painted) => Samples { values: painted.samples(number), fit: None },
        };
        let kept = if options.mesh_colors { stored(form, &samples.values) } else { Vec::new() };
        let input = ChannelInput {
            form,
            resolutions: &resolutions,
            layout: &layout,
            cuts,
            frames: frames.as_ref().filter(|_| form.kind.is_normal()),
            mask_cutoff: mask_cutoff(asset, form),
            mip: options.mip,
            beyond: options.beyond,
            solver: options.solver,
            range: options.range,
            rounding: options.rounding,
        };
        let channel = finish_channel(input, numbering, samples, &mut rooms, watch)?;
        finished.push(FinishedChannel { finest_samples: kept, ..channel });
        progress.advance(1.0 / channels.len() as f32);
    }
    drop(content);
    Ok(MaterialConversion { material, canvas, resolutions, layout, frames, given_frames, channels: finished })
}

/// By face: the frames that the source's normals are stored in, where that lets faces share a block.
fn given(content: &Content<'_>, canvas: &CanvasMesh, normals: &[[Vec3; 4]]) -> Vec<Option<[Frame; 4]>> {
    match content {
        Content::Textures(sources) => {
            let normal_map = sources.iter().find(|source| source.channel.is_normal());
            normal_map.map_or_else(|| vec![None; canvas.faces.len()], |source| source.repeated_frames(canvas))
        }
        Content::Painted(painted) => painted.frames(normals),
    }
}

/// What [`super::levels::Levels`] keep the coverage of.
pub fn mask_cutoff(asset: &Asset, form: &ChannelForm) -> Option<f32> {
    match asset.materials[form.material].alpha_mode {
        AlphaMode::Mask(cutoff) if form.kind.is_alpha_weighted() => Some(cutoff),
        _ => None,
    }
}
