//! The three things that can be measured: a conversion beside its source, a converted file on its own,
//! and a plain model by its mip maps.

use std::collections::BTreeMap;

use super::fidelity::{self, fidelity, painted_fidelity};
use super::figures::weighted_mean;
use super::focus::{self, Candidate, Focus};
use super::mip_error::Averages;
use super::origin::{Origin, SourceSeams, meaning};
use super::original::Original;
use super::painted::PaintedOrigin;
use super::report::{
    ChannelReport, CutShare, Growth, LayoutReport, LevelReport, SolverReport, SourceLevel, StoredReport, Unit,
};
use super::seams::{self, Converted};
use super::sets::Channel;
use super::surface::Surface;
use super::yardstick::Extent;
use super::{layout, mips, points, surface};
use crate::asset::{Asset, Slot, TextureRef};
use crate::error::{Error, Result};
use crate::finished::Finished;
use crate::image::Image;
use crate::source::painted::PaintedSource;
use crate::watch::{self, Watch};

/// Levels of the source that a close-up names.
const FOCUS_LEVELS: usize = 8;

/// Probes of mip errors: for a material, and for all together as far as the least of each allows.
const PROBES_MOST: usize = 256;
const PROBES_LEAST: usize = 32;
const PROBES_OF_ALL: usize = 2048;

/// Fidelity's points for each probe at least, but for the least number of probes.
const POINTS_PER_PROBE: usize = 64;

/// What only the conversion knows, copied into the reports as it stands.
#[derive(Clone, Debug, Default)]
pub struct Extras {
    /// What is not there gives no efficiency.
    pub sample_counts: Vec<SampleCounts>,
    /// Of the channels that have any.
    pub channels: Vec<ChannelExtras>,
    /// What area the yardstick spreads its texels over.
    pub yardstick: Extent,
}

/// The distinct mesh color samples of each level that stand in one part of a material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SampleCounts {
    pub material: usize,
    pub part: usize,
    pub levels: Vec<u64>,
}

/// What was done to one channel of a material, over all its parts.
#[derive(Clone, Debug)]
pub struct ChannelExtras {
    pub material: usize,
    /// As its textures have them.
    pub slots: Vec<Slot>,
    pub solver: Vec<SolverReport>,
    pub stored: Vec<StoredReport>,
}

/// What measuring ends in.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// By material, and there in the order of the finished textures; of a plain source by material and slot.
    pub channels: Vec<ChannelReport>,
    /// By set of textures: one for each part of a material, or for several materials that share it. Empty for a plain
    /// source.
    pub layouts: Vec<LayoutReport>,
    pub focus: Option<Focus>,
}

/// Measures a conversion beside the source that it came from; `painted`: the mesh colors of materials that have these.
///
/// # Errors
/// `Canceled`; `Internal` or `InvalidModel` where `finished` or `painted` does not belong to `asset`.
pub fn converted(
    asset: &Asset,
    finished: &Finished,
    painted: &[PaintedSource<'_>],
    extras: &Extras,
    watch: &dyn Watch,
) -> Result<Measured> {
    Subject { asset, finished, painted, extras, has_source: true, watch }.measured()
}

/// Measures a converted file alone: `asset` is the file's own, whose textures are the converted ones.
///
/// # Errors
/// `Canceled`; `InvalidModel` where the coordinates do not fit the geometry.
pub fn converted_file(asset: &Asset, finished: &Finished, watch: &dyn Watch) -> Result<Measured> {
    let extras = &Extras::default();
    Subject { asset, finished, painted: &[], extras, has_source: false, watch }.measured()
}

struct Subject<'a> {
    asset: &'a Asset,
    finished: &'a Finished,
    painted: &'a [PaintedSource<'a>],
    extras: &'a Extras,
    has_source: bool,
    watch: &'a dyn Watch,
}

/// What a material's channels have in common.
struct Shared<'a> {
    surface: &'a Surface<'a>,
    /// Where fidelity is judged; empty without a source.
    points: &'a [points::SurfacePoint],
    averages: Option<&'a Averages>,
}

impl Subject<'_> {
    fn measured(&self) -> Result<Measured> {
        self.finished.check()?;
        let parts = self.finished.parts();
        let mut channels = Vec::new();
        let mut tallies = Vec::new();
        let mut best = None;
        let by_material = surface::by_material(self.asset, self.finished);
        let probe_count = (PROBES_OF_ALL / parts.len().max(1)).clamp(PROBES_LEAST, PROBES_MOST);
        for material in parts.into_keys() {
            watch::check(self.watch)?;
            self.watch.step(Some("layout"));
            let written = by_material.get(material).map_or(&[][..], Vec::as_slice);
            let surface = Surface::of_finished(self.asset, written, material)?;
            tallies.extend(layout::tallies(&surface)?);
            let own: Vec<Channel<'_>> = Channel::all(self.finished, material);
            let (mut points, mut averages) = (Vec::new(), None);
            if self.has_source {
                self.watch.step(Some("mip_error"));
                let texel_count = own.iter().map(|channel| channel.texel_count).max().unwrap_or(0);
                points = points::scatter(&surface, fidelity::point_count(texel_count));
                let probe_count = probe_count.min(points.len() / POINTS_PER_PROBE).max(PROBES_LEAST);
                let level_count = own.iter().map(Channel::level_count).max().unwrap_or(0);
                averages = Some(Averages::new(&surface, texel_count, probe_count, level_count));
            }
            let shared = Shared { surface: &surface, points: &points, averages: averages.as_ref() };
            for channel in &own {
                let (report, candidate) = self.channel(channel, &shared)?;
                channels.push(report);
                best = Candidate::better(best, candidate);
            }
        }
        self.watch.step(Some("layout"));
        let layouts = layout::reports(self.asset, self.finished, tallies, &self.extras.sample_counts);
        self.watch.step(None);
        Ok(Measured { channels, layouts, focus: best.map(|candidate| candidate.focus) })
    }

    fn channel(&self, own: &Channel<'_>, shared: &Shared<'_>) -> Result<(ChannelReport, Option<Candidate>)> {
        let surface = shared.surface;
        let (Some(&slot), Some(finest)) = (own.slots().first(), own.finest()) else {
            return Err(Error::internal("a finished texture has no slot or no level")
                .at(format!("/materials/{}", surface.material)));
        };
        let slot = if own.slots().contains(&Slot::Normal) { Slot::Normal } else { slot };
        let meaning = meaning(self.asset, surface.material, slot);
        let converted = Converted::new(surface, own.textures.clone(), meaning)?;
        let takes_colors = self.finished.vertex_colors.contains(&surface.material);
        let origin = match self.has_source {
            true => Origin::new(self.asset, surface, slot, takes_colors)?,
            false => None,
        };
        let painted = PaintedOrigin::new(self.asset, surface, slot, self.painted)?;
        let level_limit = own.level_count().max(FOCUS_LEVELS);
        self.watch.step(Some("source"));
        let source = match &origin {
            Some(origin) => Some(SourceSeams::survey(origin, surface, level_limit, self.watch)?),
            None => None,
        };
        let cut_flags = surface.cut_flags(&own.numbers);
        let mut channel = described(self.asset, surface.material, own.slots(), finest);
        channel.unit = converted.meaning.unit();
        channel.value_scale = own.textures.first().and_then(|texture| texture.value_scale);
        let seam = source.as_ref().map_or(&[][..], |source| &source.seam);
        channel.cuts = seams::cut_share(surface, seam, &cut_flags);
        self.watch.step(Some("seams"));
        channel.levels = self.levels(&converted, source.as_ref(), &cut_flags)?;
        let original = origin.as_ref().map(Original::Image).or(painted.as_ref().map(Original::Painted));
        if let Some(original) = original {
            self.watch.step(Some("fidelity"));
            let yardstick = (self.extras.yardstick, own.texel_count as usize);
            channel.fidelity = match original {
                Original::Image(origin) => fidelity(origin, &converted, shared.points, yardstick),
                Original::Painted(painted) => painted_fidelity(painted, &converted, shared.points),
            };
            self.watch.step(Some("mip_error"));
            let errors =
                shared.averages.map(|averages| averages.mip_errors(original, &converted, &cut_flags));
            let beyond_first = channel.levels.iter_mut().skip(1);
            beyond_first.zip(errors.into_iter().flatten()).for_each(|(level, error)| level.mip_error = error);
        }
        let is_own =
            |of: &&ChannelExtras| of.material == surface.material && of.slots.as_slice() == own.slots();
        if let Some(done) = self.extras.channels.iter().find(is_own) {
            (channel.solver, channel.stored) = (done.solver.clone(), done.stored.clone());
        }
        let candidate = source.as_ref().and_then(|source| {
            let kind = (channel.unit, focus::Kind::of(own.slots()));
            let texture = |part: usize| own.numbers[converted.texture_of(part)];
            focus::candidate(surface, source, &cut_flags, &texture, kind)
        });
        Ok((channel, candidate))
    }

    fn levels(
        &self,
        converted: &Converted<'_>,
        source: Option<&SourceSeams>,
        cut_flags: &[bool],
    ) -> Result<Vec<LevelReport>> {
        let surface = converted.surface;
        let uncut = seams::uncut(cut_flags);
        let agreed = source.map(SourceSeams::agreed_pairs).unwrap_or_default();
        let level_count = converted.level_count();
        let mut levels = Vec::with_capacity(level_count);
        for number in 0..level_count {
            watch::check(self.watch)?;
            let [seams, seams_8bit_weights] = converted.figures(number, &uncut);
            let means = converted.survey(number, &agreed).edge_means;
            let range = converted.textures.iter().find_map(|texture| texture.ranges.get(&number));
            levels.push(LevelReport {
                level: number as u32,
                size: converted.textures.first().map_or([0; 2], |texture| texture.levels[number].size()),
                seams,
                seams_8bit_weights,
                range: range.map(|range| range.name().to_owned()),
                drift: weighted_mean(&surface.pairs, &agreed, means.into_iter()),
                source: source.and_then(|source| source.report(surface, number)),
                mip_error: None,
            });
        }
        Ok(levels)
    }
}

/// Measures a plain model: its seams at every level of ordinary mip maps.
///
/// # Errors
/// `Canceled`.
pub fn source(asset: &Asset, watch: &dyn Watch) -> Result<Measured> {
    let mut measured = Measured::default();
    for (number, (material, parts)) in asset.materials.iter().zip(surface::of_source(asset)).enumerate() {
        let surface = Surface::of_source(parts, number);
        if surface.parts.is_empty() {
            continue;
        }
        for (slot, slots) in distinct_slots(&material.slots) {
            let Some(origin) = Origin::new(asset, &surface, slot, false)? else { continue };
            let seams = SourceSeams::survey(&origin, &surface, mips::level_count(origin.image), watch)?;
            let mut channel = described(asset, number, &slots, origin.image);
            channel.unit = origin.meaning.unit();
            // Nothing is joined and nothing is cut yet.
            let shares = seams::cut_share(&surface, &seams.seam, &vec![false; surface.pairs.len()]);
            channel.cuts = CutShare { welded_share: 0.0, ..shares };
            channel.levels = (0..seams.levels.len())
                .filter_map(|level| Some((level, seams.report(&surface, level)?)))
                .map(|(level, SourceLevel { size, seams, drift })| LevelReport {
                    level: level as u32,
                    size,
                    seams,
                    seams_8bit_weights: None,
                    range: None,
                    drift,
                    source: None,
                    mip_error: None,
                })
                .collect();
            measured.channels.push(channel);
        }
    }
    Ok(measured)
}

/// The slots of a material that read the same thing, together; each group under its first slot.
fn distinct_slots(slots: &BTreeMap<Slot, TextureRef>) -> Vec<(Slot, Vec<Slot>)> {
    let mut groups: Vec<(Slot, Vec<Slot>)> = Vec::new();
    let kind = |slot: Slot| (slot.is_color(), slot == Slot::Normal);
    for (&slot, texture) in slots {
        let same = |(first, _): &&mut (Slot, Vec<Slot>)| {
            slots.get(first) == Some(texture) && kind(*first) == kind(slot)
        };
        match groups.iter_mut().find(same) {
            Some((_, group)) => group.push(slot),
            None => groups.push((slot, vec![slot])),
        }
    }
    groups
}

fn described(asset: &Asset, material: usize, slots: &[Slot], image: &Image) -> ChannelReport {
    ChannelReport {
        material,
        material_name: asset.materials.get(material).map(|m| m.name.clone()).unwrap_or_default(),
        slots: slots.iter().map(|slot| slot.gltf_name().to_owned()).collect(),
        unit: Unit::Codes,
        components: u32::from(image.components),
        bits: image.bits().into(),
        value_scale: image.value_scale(),
        cuts: CutShare::default(),
        levels: Vec::new(),
        fidelity: None,
        solver: Vec::new(),
        stored: Vec::new(),
    }
}

/// Texels and vertices before and after; bytes and written vertices are for the caller to add.
pub fn growth(asset: &Asset, finished: &Finished) -> Growth {
    let mut images: Vec<usize> = finished
        .textures
        .iter()
        .flat_map(|texture| {
            let slot = texture.slots.first().copied();
            let shown = |&material: &usize| asset.materials.get(material)?.slot(slot?).map(|of| of.image);
            texture.materials.iter().filter_map(shown).collect::<Vec<_>>()
        })
        .collect();
    images.sort_unstable();
    images.dedup();
    let texels = |image: &Image| image.texel_count() as u64;
    let painted = |image: &Image| texels(image) / u64::from(image.texels_per_painted()).pow(2);
    let vertices = asset.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|p| p.positions.len() as u64);
    Growth {
        source_texels: images.iter().filter_map(|&image| asset.images.get(image)).map(painted).sum(),
        converted_texels: finished.textures.iter().filter_map(|t| t.levels.first()).map(texels).sum(),
        converted_texels_all_levels: finished.textures.iter().flat_map(|t| &t.levels).map(texels).sum(),
        source_vertices: vertices.sum(),
        ..Growth::default()
    }
}

#[cfg(test)]
mod tests;
