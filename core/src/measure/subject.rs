//! The three things that can be measured: a conversion beside its source, a converted file on its own,
//! and a plain model by its mip maps.

use super::fidelity::{self, fidelity};
use super::figures::weighted_mean;
use super::focus::{self, Candidate, Focus};
use super::mip_error::Averages;
use super::origin::{Origin, SourceSeams, meaning};
use super::report::{
    ChannelReport, CutShare, Growth, LayoutReport, LevelReport, SolverReport, SourceLevel, StoredReport, Unit,
};
use super::seams::{self, Converted};
use super::surface::Surface;
use super::yardstick::Extent;
use super::{layout, mips, points, surface};
use crate::asset::{Asset, Slot};
use crate::error::{Error, Result};
use crate::finished::{Finished, FinishedTexture};
use crate::image::{Image, Pixels};
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
    /// By material: the distinct mesh color samples of each level.
    pub sample_counts: Vec<(usize, Vec<u64>)>,
    /// By finished texture; may be shorter.
    pub solver: Vec<Vec<SolverReport>>,
    /// By finished texture; may be shorter.
    pub stored: Vec<Vec<StoredReport>>,
    /// What area the yardstick spreads its texels over.
    pub yardstick: Extent,
}

/// What measuring ends in.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// In the order of the finished textures; of a plain source by material and slot.
    pub channels: Vec<ChannelReport>,
    /// By material; empty for a plain source.
    pub layouts: Vec<LayoutReport>,
    pub focus: Option<Focus>,
}

/// Measures a conversion beside the source that it came from.
///
/// # Errors
/// `Canceled`; `Internal` or `InvalidModel` where `finished` does not belong to `asset`.
pub fn converted(asset: &Asset, finished: &Finished, extras: &Extras, watch: &dyn Watch) -> Result<Measured> {
    Subject { asset, finished, extras, has_source: true, watch }.measured()
}

/// Measures a converted file alone: `asset` is the file's own, whose textures are the converted ones.
///
/// # Errors
/// `Canceled`; `InvalidModel` where the coordinates do not fit the geometry.
pub fn converted_file(asset: &Asset, finished: &Finished, watch: &dyn Watch) -> Result<Measured> {
    Subject { asset, finished, extras: &Extras::default(), has_source: false, watch }.measured()
}

struct Subject<'a> {
    asset: &'a Asset,
    finished: &'a Finished,
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
        self.finished.check_coordinates()?;
        let textures = &self.finished.textures;
        let mut materials: Vec<usize> =
            textures.iter().flat_map(|texture| texture.materials.clone()).collect();
        materials.sort_unstable();
        materials.dedup();
        let mut channels: Vec<Option<ChannelReport>> = vec![None; textures.len()];
        let mut layouts = Vec::new();
        let mut best = None;
        let parts = surface::by_material(self.asset, self.finished);
        let probe_count = (PROBES_OF_ALL / materials.len().max(1)).clamp(PROBES_LEAST, PROBES_MOST);
        for material in materials {
            watch::check(self.watch)?;
            self.watch.step(Some("layout"));
            let written = parts.get(material).map_or(&[][..], Vec::as_slice);
            let surface = Surface::of_finished(self.asset, written, material)?;
            let counts = self.extras.sample_counts.iter().find(|(of, _)| *of == material);
            let counts = counts.map(|(_, counts)| counts.as_slice());
            layouts.push(layout::report(self.asset, self.finished, &surface, counts));
            let of_material = || textures.iter().enumerate().filter(move |(_, t)| t.is_of(material, 0));
            let (mut points, mut averages) = (Vec::new(), None);
            if self.has_source {
                self.watch.step(Some("mip_error"));
                let finest = of_material().filter_map(|(_, texture)| texture.levels.first());
                let texel_count = finest.map(|image| image.texel_count() as u64).max().unwrap_or(0);
                points = points::scatter(&surface, fidelity::point_count(texel_count));
                let probe_count = probe_count.min(points.len() / POINTS_PER_PROBE).max(PROBES_LEAST);
                let level_count = of_material().map(|(_, texture)| texture.levels.len()).max().unwrap_or(0);
                averages = Some(Averages::new(&surface, texel_count, probe_count, level_count));
            }
            let shared = Shared { surface: &surface, points: &points, averages: averages.as_ref() };
            for (number, texture) in of_material() {
                let (channel, candidate) = self.channel(number, texture, &shared)?;
                channels[number] = Some(channel);
                best = Candidate::better(best, candidate);
            }
        }
        self.watch.step(None);
        Ok(Measured {
            channels: channels.into_iter().flatten().collect(),
            layouts,
            focus: best.map(|candidate| candidate.focus),
        })
    }

    fn channel(
        &self,
        number: usize,
        texture: &FinishedTexture,
        shared: &Shared<'_>,
    ) -> Result<(ChannelReport, Option<Candidate>)> {
        let surface = shared.surface;
        let (Some(&slot), Some(finest)) = (texture.slots.first(), texture.levels.first()) else {
            return Err(Error::internal(format!("finished texture {number} has no slot or no level")));
        };
        let slot = if texture.is_normal() { Slot::Normal } else { slot };
        let converted = Converted { surface, texture, meaning: meaning(self.asset, surface.material, slot) };
        converted.check()?;
        let origin = if self.has_source { Origin::new(self.asset, surface, slot)? } else { None };
        let level_limit = texture.levels.len().max(FOCUS_LEVELS);
        self.watch.step(Some("source"));
        let source = match &origin {
            Some(origin) => Some(SourceSeams::survey(origin, surface, level_limit, self.watch)?),
            None => None,
        };
        let cut_flags = surface.cut_flags(number);
        let mut channel = described(self.asset, surface.material, &texture.slots, finest);
        channel.unit = converted.meaning.unit();
        let seam = source.as_ref().map_or(&[][..], |source| &source.seam);
        channel.cuts = seams::cut_share(surface, seam, &cut_flags);
        self.watch.step(Some("seams"));
        channel.levels = self.levels(&converted, source.as_ref(), &cut_flags)?;
        if let Some(origin) = &origin {
            self.watch.step(Some("fidelity"));
            channel.fidelity = fidelity(origin, &converted, shared.points, self.extras.yardstick);
            self.watch.step(Some("mip_error"));
            let errors = shared.averages.map(|averages| averages.mip_errors(origin, &converted, &cut_flags));
            let beyond_first = channel.levels.iter_mut().skip(1);
            beyond_first.zip(errors.into_iter().flatten()).for_each(|(level, error)| level.mip_error = error);
        }
        channel.solver = self.extras.solver.get(number).cloned().unwrap_or_default();
        channel.stored = self.extras.stored.get(number).cloned().unwrap_or_default();
        let candidate = source.as_ref().and_then(|source| {
            let kind = (channel.unit, texture.slots.contains(&Slot::BaseColor));
            focus::candidate(surface, source, &cut_flags, number, kind)
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
        let mut levels = Vec::with_capacity(converted.texture.levels.len());
        for (number, image) in converted.texture.levels.iter().enumerate() {
            watch::check(self.watch)?;
            let [seams, seams_8bit_weights] = converted.figures(number, &uncut);
            let means = converted.survey(number, &agreed).edge_means;
            levels.push(LevelReport {
                level: number as u32,
                size: image.size(),
                seams,
                seams_8bit_weights,
                range: converted.texture.ranges.get(&number).map(|range| range.name().to_owned()),
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
            let Some(origin) = Origin::new(asset, &surface, slot)? else { continue };
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
fn distinct_slots(slots: &[Option<crate::asset::TextureRef>; 5]) -> Vec<(Slot, Vec<Slot>)> {
    let mut groups: Vec<(Slot, Vec<Slot>)> = Vec::new();
    let kind = |slot: Slot| (slot.is_color(), slot == Slot::Normal);
    for slot in Slot::ALL {
        let Some(texture) = slots[slot as usize] else { continue };
        let same = |(first, _): &&mut (Slot, Vec<Slot>)| {
            slots[*first as usize] == Some(texture) && kind(*first) == kind(slot)
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
        bits: if matches!(image.pixels, Pixels::U8(_)) { 8 } else { 16 },
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
    let vertices = asset.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|p| p.positions.len() as u64);
    Growth {
        source_texels: images.iter().filter_map(|&image| asset.images.get(image)).map(texels).sum(),
        converted_texels: finished.textures.iter().filter_map(|t| t.levels.first()).map(texels).sum(),
        converted_texels_all_levels: finished.textures.iter().flat_map(|t| &t.levels).map(texels).sum(),
        source_vertices: vertices.sum(),
        ..Growth::default()
    }
}

#[cfg(test)]
mod tests;
