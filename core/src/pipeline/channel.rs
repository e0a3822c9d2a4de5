//! One channel's journey: samples of level 0 to level images, with what the solver did on the way.

use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::asset::Slot;
use crate::assign::{Codec, LevelChannel, LevelValues, NormalFrames, paint, rules};
use crate::colors::{Cuts, LevelNumbering, Resolutions};
use crate::error::Result;
use crate::image::{Image, Pixels, Transfer};
use crate::layout::Layout;
use crate::measure::SolverReport;
use crate::mip::{Beyond, MipFilter, Rungs, coarsen, coverage, keep_coverage};
use crate::resample::{Fit, Samples};
use crate::solve::Solver;
use crate::source::SourceChannel;
use crate::watch::{Stage, Watch};

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
}

pub struct FinishedChannel {
    pub slots: Vec<Slot>,
    pub transfer: Transfer,
    pub cuts: Cuts,
    pub levels: Vec<Image>,
    /// Distinct samples by level.
    pub sample_counts: Vec<u64>,
    pub solver: Vec<SolverReport>,
    /// How the samples of level 0 were fitted, where they were.
    pub fit: Option<Fit>,
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
        sample_counts: Vec::new(),
        solver: Vec::new(),
        fit: samples.fit,
        is_alpha_weighted: by_alpha,
        keeps_coverage: input.mask_cutoff.is_some(),
    };
    let (canvas, topology) = (numbering.canvas, numbering.topology);
    let mut values = samples.values;
    let rungs = Rungs { filter: input.mip, beyond: input.beyond, by_alpha };
    let mut wanted_coverage = 0.0;
    for level in 0..input.layout.level_count() {
        watch.stage(Stage::Mip);
        if level > 0 {
            let coarse = LevelNumbering::new(canvas, topology, input.resolutions, level);
            values = coarsen(&numbering, &coarse, &values, rungs, watch)?;
            numbering = coarse;
        }
        let mut wanted = if input.channel.is_normal() { normalized(&values) } else { values.clone() };
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
        let rules = rules(&level_channel);
        let mut wanted = LevelValues::new(wanted, topology.fan_count());
        watch.stage(Stage::Solve);
        finished.solver.extend(represent(&level_channel, &rules, &mut wanted, input.solver, watch)?);
        watch.stage(Stage::Assign);
        finished.levels.push(paint(&level_channel, &wanted, watch)?);
        finished.sample_counts.push(numbering.sample_count() as u64);
    }
    finished.cuts = input.cuts;
    Ok(finished)
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

fn normalized(values: &[Vec4]) -> Vec<Vec4> {
    values.par_iter().map(|value| value.xyz().try_normalize().unwrap_or(Vec3::Z).extend(1.0)).collect()
}
