//! One channel's journey: samples of level 0 to level images, with what the solver did on the way.

use std::collections::BTreeMap;

use crate::asset::Slot;
use crate::assign::{
    Codec, LevelChannel, LevelValues, NormalFrames, Range, Rounding, Storing, choose_range, paint, read_back,
    rules,
};
use crate::colors::{Cuts, LevelNumbering, Resolutions};
use crate::error::Result;
use crate::image::{Image, LevelRange, Pixels, Transfer};
use crate::layout::Layout;
use crate::measure::{SolverReport, StoredReport};
use crate::mip::{Beyond, MipFilter, Rungs, coarsen, coverage, keep_coverage};
use crate::resample::{Fit, Samples};
use crate::solve::Solver;
use crate::source::SourceChannel;
use crate::watch::{Stage, Watch};

use super::bare_normals::{bare_normals, shown};
use super::changes::Changes;
use super::represent::represent;

pub struct ChannelInput<'a> {
    pub channel: &'a SourceChannel<'a>,
    pub resolutions: &'a Resolutions,
    pub layout: &'a Layout,
    pub cuts: Cuts,
    pub frames: Option<&'a NormalFrames>,
    /// Of a masked material: keep the share of surface above this.
    pub mask_cutoff: Option<f32>,
    pub mip: MipFilter,
    pub beyond: Beyond,
    pub solver: Solver,
    pub range: Range,
    pub rounding: Rounding,
}

pub struct FinishedChannel {
    pub slots: Vec<Slot>,
    pub transfer: Transfer,
    pub cuts: Cuts,
    pub levels: Vec<Image>,
    /// Of levels that are stored in one.
    pub ranges: BTreeMap<usize, LevelRange>,
    /// Distinct samples by level.
    pub sample_counts: Vec<u64>,
    pub solver: Vec<SolverReport>,
    /// How the samples of level 0 were fitted, where they were.
    pub fit: Option<Fit>,
    /// Of levels in a range.
    pub stored: Vec<StoredReport>,
    pub is_alpha_weighted: bool,
    pub keeps_coverage: bool,
}

/// Builds, solves and paints every level. `samples` and their `numbering` are those of level 0.
pub fn finish_channel(
    input: ChannelInput<'_>,
    mut numbering: LevelNumbering<'_>,
    samples: Samples,
    watch: &dyn Watch,
) -> Result<FinishedChannel> {
    let codec = codec(input.channel);
    let by_alpha = input.channel.is_alpha_weighted();
    let mut finished = FinishedChannel {
        slots: input.channel.slots.clone(),
        transfer: input.channel.transfer,
        cuts: Cuts { edges: Vec::new() },
        levels: Vec::new(),
        ranges: BTreeMap::new(),
        sample_counts: Vec::new(),
        solver: Vec::new(),
        fit: samples.fit,
        stored: Vec::new(),
        is_alpha_weighted: by_alpha,
        keeps_coverage: input.mask_cutoff.is_some(),
    };
    let (canvas, topology) = (numbering.canvas, numbering.topology);
    let mut values = samples.values;
    let mut bare = input.frames.map(|frames| bare_normals(&numbering, frames));
    for (value, bare) in values.iter_mut().zip(bare.iter().flatten()) {
        *value -= *bare;
    }
    let rungs = Rungs { filter: input.mip, beyond: input.beyond, by_alpha };
    let mut wanted_coverage = 0.0;
    for level in 0..input.layout.level_count() {
        watch.stage(Stage::Mip);
        if level > 0 {
            let coarse = LevelNumbering::new(canvas, topology, input.resolutions, level);
            values = coarsen(&numbering, &coarse, &values, rungs, watch)?;
            numbering = coarse;
            bare = input.frames.map(|frames| bare_normals(&numbering, frames));
        }
        let mut wanted = bare.as_ref().map_or_else(|| values.clone(), |bare| shown(bare, &values));
        if let Some(cutoff) = input.mask_cutoff {
            if level == 0 {
                wanted_coverage = coverage(&numbering, &wanted, cutoff, watch)?;
            } else {
                keep_coverage(&numbering, &mut wanted, (cutoff, wanted_coverage), watch)?;
            }
        }
        watch.stage(Stage::Assign);
        let level_channel = LevelChannel {
            layout: input.layout,
            numbering: &numbering,
            cuts: &input.cuts,
            codec,
            frames: input.frames,
        };
        let mut wanted = LevelValues::new(wanted, topology.fan_count());
        let range = choose_range(&level_channel, &wanted, input.range, watch)?;
        if range.is_none() {
            let rules = rules(&level_channel);
            watch.stage(Stage::Solve);
            finished.solver.extend(represent(&level_channel, &rules, &mut wanted, input.solver, watch)?);
            watch.stage(Stage::Assign);
        }
        let storing = Storing { rounding: input.rounding, range };
        let image = paint(&level_channel, &wanted, storing, watch)?;
        if let Some(range) = range {
            let changes = read_back(&level_channel, &wanted, &image, &range);
            finished.stored.push(stored_report(level, range.name(), &Changes::new(changes)));
            finished.ranges.insert(level, range);
        }
        finished.levels.push(image);
        finished.sample_counts.push(numbering.sample_count() as u64);
    }
    finished.cuts = input.cuts;
    Ok(finished)
}

fn stored_report(level: usize, range: &str, changes: &Changes) -> StoredReport {
    StoredReport {
        level: level as u32,
        range: range.to_owned(),
        change_mean_codes: changes.mean_codes,
        change_p95_codes: changes.p95_codes,
        change_max_codes: changes.max_codes,
    }
}

/// What the channel is stored as: the source's components and bits, without an alpha that nobody reads.
fn codec(channel: &SourceChannel<'_>) -> Codec {
    let is_gray = channel.image.components <= 2 && !channel.is_normal();
    let components = if is_gray { 1 } else { 3 } + u8::from(channel.is_alpha_weighted());
    let bits = match channel.image.pixels {
        Pixels::U8(_) => 8,
        Pixels::U16(_) => 16,
    };
    Codec { transfer: channel.transfer, components, bits }
}
