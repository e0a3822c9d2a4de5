//! A painted material, taken apart.

use glam::Vec4;

use crate::asset::{Asset, MeshColorChannel, MeshColors, Slot};
use crate::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions};
use crate::error::{Error, ErrorCode, Result};
use crate::mesh::CanvasMesh;
use crate::pipeline::painted::{restore, unpacked};
use crate::pipeline::prepare::canvas_of;

/// The mesh colors of one material on their canvas.
pub struct Painting {
    pub material: usize,
    /// With partners as quads.
    pub canvas: CanvasMesh,
    pub resolutions: Resolutions,
    /// By face of the model.
    pub partners: Vec<Option<u32>>,
    pub channels: Vec<PaintedChannel>,
}

/// A channel's samples with who shares them.
pub struct PaintedChannel {
    pub slots: Vec<Slot>,
    pub components: u8,
    pub bits: u8,
    /// Of numbers of any size: what 1 stands for.
    pub value_scale: Option<f32>,
    /// By face and corner; may be empty.
    pub tangents: Vec<[[f32; 4]; 4]>,
    pub cuts: Cuts,
    pub topology: ChannelTopology,
    /// By sample of level 0.
    pub values: Vec<Vec4>,
}

impl Painting {
    /// # Errors
    /// `InvalidModel` where the mesh colors do not fit their faces.
    pub fn of(asset: &Asset, material: usize, colors: &MeshColors) -> Result<Self> {
        let has_textures = !asset.materials[material].slots.is_empty();
        let restored = restore(canvas_of(asset, material), colors, has_textures)
            .map_err(|error| error.at(format!("/materials/{material}")))?;
        let resolutions = restored.painted.resolutions;
        let channels = colors.channels.iter().zip(restored.cuts).map(|(channel, cuts)| PaintedChannel {
            slots: channel.slots.clone(),
            components: channel.components,
            bits: channel.bits,
            value_scale: channel.value_scale,
            tangents: channel.tangents.clone(),
            topology: ChannelTopology::new(&restored.canvas, &resolutions, &cuts),
            cuts,
            values: unpacked(channel).collect(),
        });
        let channels = channels.collect();
        Ok(Self {
            material,
            canvas: restored.canvas,
            resolutions,
            partners: colors.partners.clone(),
            channels,
        })
    }

    /// Sample numbers of one of its channels.
    pub fn numbering<'a>(&'a self, channel: &'a PaintedChannel, level: usize) -> LevelNumbering<'a> {
        LevelNumbering::new(&self.canvas, &channel.topology, &self.resolutions, level)
    }

    pub fn sample_count(&self) -> u64 {
        self.channels.iter().map(|channel| channel.values.len() as u64).sum()
    }
}

impl PaintedChannel {
    pub fn is_normal(&self) -> bool {
        self.slots.contains(&Slot::Normal)
    }

    /// A sample within what the channel may hold: interpolation rounds beyond it.
    pub fn in_range(&self, value: Vec4) -> Vec4 {
        let (least, most) = self.value_scale.map_or((0.0, 1.0), |_| (-1.0, 1.0));
        value.clamp(Vec4::splat(least), Vec4::splat(most))
    }

    /// The channel with other samples.
    pub fn with(&self, values: &[Vec4], cuts: Vec<u8>, tangents: Vec<[[f32; 4]; 4]>) -> MeshColorChannel {
        MeshColorChannel {
            slots: self.slots.clone(),
            components: self.components,
            bits: self.bits,
            value_scale: self.value_scale,
            cuts,
            samples: packed(values, self.components),
            tangents,
        }
    }
}

/// Components of all samples one after the other, see [`unpacked`].
fn packed(values: &[Vec4], components: u8) -> Vec<f32> {
    let stored: &[usize] = match components {
        1 => &[0],
        2 => &[0, 3],
        3 => &[0, 1, 2],
        _ => &[0, 1, 2, 3],
    };
    values.iter().flat_map(|value| stored.iter().map(|&component| value[component])).collect()
}

/// All painted materials of a model.
///
/// # Errors
/// `NothingToConvert` where there is none; `InvalidModel` where mesh colors do not fit their faces.
pub fn paintings(asset: &Asset) -> Result<Vec<Painting>> {
    let mut paintings = Vec::new();
    for (material, properties) in asset.materials.iter().enumerate() {
        if let Some(colors) = &properties.mesh_colors {
            paintings.push(Painting::of(asset, material, colors)?);
        }
    }
    if paintings.is_empty() {
        let detail = "the model has no mesh colors to edit; `meshcolor convert MODEL --mesh-colors` makes a file that has";
        return Err(Error::new(ErrorCode::NothingToConvert, detail).at("/materials"));
    }
    Ok(paintings)
}
