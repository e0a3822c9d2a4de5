//! The mesh colors of a model as it has them, at as many levels as are asked for: what conversions of them are held against.
//!
//! Faces, cuts and samples are taken from the model once more, apart from any conversion. Coarser levels come about as a conversion's
//! do ([`Levels`]), and end before anything is changed to be stored.

use glam::Vec4;

use crate::asset::Asset;
use crate::assign::choose_frames;
use crate::colors::{ChannelTopology, LevelNumbering, Resolutions};
use crate::error::{Error, Result};
use crate::filter::{Level, MeshColors, Triangles};
use crate::finished::Finished;
use crate::mesh::CanvasMesh;
use crate::mip::Rungs;
use crate::source::painted::{PaintedChannel, PaintedSource};
use crate::watch::Watch;

use super::form::ChannelForm;
use super::levels::{Levels, Rooms};
use super::material::mask_cutoff;
use super::options::Options;
use super::painted::{Restored, restore};
use super::prepare::{canvas_of, normals_of};

/// The mesh colors of one material.
pub struct Reference {
    material: usize,
    canvas: CanvasMesh,
    resolutions: Resolutions,
    channels: Vec<ReferenceChannel>,
}

/// Asks whether to go on, and announces nothing: levels of a reference are none of a conversion's.
struct Aside<'a>(&'a dyn Watch);

impl Watch for Aside<'_> {
    fn canceled(&self) -> bool {
        self.0.canceled()
    }
}

struct ReferenceChannel {
    form: ChannelForm,
    topology: ChannelTopology,
    /// By level and sample.
    levels: Vec<Vec<Vec4>>,
}

impl Reference {
    /// Level 0 of every material of a model that has mesh colors and faces.
    ///
    /// # Errors
    /// `Canceled`; `InvalidModel` where mesh colors do not fit their faces.
    pub fn finest(asset: &Asset, watch: &dyn Watch) -> Result<Vec<Self>> {
        Self::all(asset, &Options::default(), &|_| 1, watch)
    }

    /// As many levels as a conversion of the model has, filtered as its options say.
    ///
    /// # Errors
    /// As [`Reference::finest`].
    pub fn beside(
        asset: &Asset,
        finished: &Finished,
        options: &Options,
        watch: &dyn Watch,
    ) -> Result<Vec<Self>> {
        let level_count = |material: usize| {
            let own = finished.textures.iter().filter(|texture| texture.materials.contains(&material));
            own.map(|texture| texture.levels.len()).max().unwrap_or(1)
        };
        Self::all(asset, options, &level_count, watch)
    }

    fn all(
        asset: &Asset,
        options: &Options,
        level_count: &dyn Fn(usize) -> usize,
        watch: &dyn Watch,
    ) -> Result<Vec<Self>> {
        let of_material = |material: usize| {
            let of = Self::new(asset, material, options, level_count(material), &Aside(watch));
            of.map_err(|error| error.at(format!("/materials/{material}"))).transpose()
        };
        (0..asset.materials.len()).filter_map(of_material).collect()
    }

    fn new(
        asset: &Asset,
        material: usize,
        options: &Options,
        level_count: usize,
        watch: &dyn Watch,
    ) -> Result<Option<Self>> {
        let Some(colors) = &asset.materials[material].mesh_colors else { return Ok(None) };
        let canvas = canvas_of(asset, material);
        if canvas.faces.is_empty() {
            return Ok(None);
        }
        // Textures beside mesh colors are refused by a conversion; here they are nobody's concern.
        let Restored { canvas, cuts, painted } = restore(canvas, colors, false)?;
        let mut channels = Vec::with_capacity(colors.channels.len());
        let mut rooms = Rooms::default();
        for (number, (channel, cuts)) in colors.channels.iter().zip(cuts).enumerate() {
            let form = ChannelForm::of_colors(asset, material, channel);
            let topology = ChannelTopology::new(&canvas, &painted.resolutions, &cuts);
            let frames = form.kind.normal_scale().map(|scale| {
                let normals = normals_of(asset, &canvas);
                // Only their normals count.
                choose_frames(&canvas, &normals, &vec![None; canvas.faces.len()], scale)
            });
            let levels = Levels {
                resolutions: &painted.resolutions,
                count: level_count,
                rungs: Rungs {
                    filter: options.mip,
                    beyond: options.beyond,
                    by_alpha: form.kind.is_alpha_weighted(),
                },
                frames: frames.as_ref(),
                mask_cutoff: mask_cutoff(asset, &form),
            };
            let finest = LevelNumbering::new(&canvas, &topology, &painted.resolutions, 0);
            let mut values = Vec::with_capacity(level_count);
            levels.each((finest, painted.samples(number)), &mut rooms, watch, |_, level| {
                values.push(level);
                Ok(Vec::new())
            })?;
            channels.push(ReferenceChannel { form, topology, levels: values });
        }
        let resolutions = painted.resolutions;
        Ok(Some(Self { material, canvas, resolutions, channels }))
    }

    /// The sample numbers of every level, by channel.
    fn numberings(&self) -> Vec<Vec<LevelNumbering<'_>>> {
        let at = |topology, level| LevelNumbering::new(&self.canvas, topology, &self.resolutions, level);
        let of_channel = self
            .channels
            .iter()
            .map(|channel| (0..channel.levels.len()).map(|level| at(&channel.topology, level)).collect());
        of_channel.collect()
    }

    fn source<'a>(&'a self, levels: &'a [Vec<Level<'a>>]) -> Option<PaintedSource<'a>> {
        let channels = self.channels.iter().zip(levels).map(|(channel, levels)| {
            Some(PaintedChannel {
                slots: &channel.form.slots,
                components: channel.form.codec.components,
                colors: MeshColors::new(levels, Triangles::Linear)?,
            })
        });
        Some(PaintedSource::new(self.material, &self.canvas, channels.collect::<Option<_>>()?))
    }
}

/// Calls `then` with references ready to be filtered (MC 4), and returns what it returns.
///
/// # Errors
/// `Internal` where samples do not fit their numbering.
pub fn with_filters<T>(references: &[Reference], then: impl FnOnce(&[PaintedSource<'_>]) -> T) -> Result<T> {
    let numberings: Vec<_> = references.iter().map(Reference::numberings).collect();
    let levels = references.iter().zip(&numberings).map(|(reference, numberings)| {
        let channels = reference.channels.iter().zip(numberings).map(|(channel, numberings)| {
            let levels = numberings.iter().zip(&channel.levels);
            levels.map(|(numbering, values)| Level { numbering, values }).collect::<Vec<_>>()
        });
        channels.collect::<Vec<_>>()
    });
    let levels: Vec<_> = levels.collect();
    let sources = references.iter().zip(&levels).map(|(reference, levels)| reference.source(levels));
    let sources: Option<Vec<_>> = sources.collect();
    let sources =
        sources.ok_or_else(|| Error::internal("samples of mesh colors do not fit their numbering"))?;
    Ok(then(&sources))
}
