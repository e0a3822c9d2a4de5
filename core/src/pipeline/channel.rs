//! One channel's journey: samples of level 0 to level images, with what the solver did on the way.

use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::asset::Slot;
use crate::assign::{Codec, LevelChannel, LevelValues, NormalFrames, Rules, paint, rules};
use crate::colors::{Cuts, LevelNumbering, Resolutions, sample_areas};
use crate::error::Result;
use crate::image::{Image, Pixels, Transfer};
use crate::layout::Layout;
use crate::math::transfer::linear_to_srgb;
use crate::measure::SolverReport;
use crate::mip::{coarsen, coverage, keep_coverage};
use crate::solve::{Problem, Solution, Solver, solve, violated_count};
use crate::source::SourceChannel;
use crate::watch::{self, Stage, Watch};

/// A sample counts for at least this share of the mean sample in the solver's objective: faces of no area
/// must not make it singular.
const WEIGHT_FLOOR: f64 = 1e-4;

pub struct ChannelInput<'a> {
    pub channel: &'a SourceChannel<'a>,
    pub resolutions: &'a Resolutions,
    pub layout: &'a Layout,
    pub cuts: Cuts,
    pub frames: Option<&'a NormalFrames>,
    /// Of a masked material: keep the share of surface above this.
    pub mask_cutoff: Option<f32>,
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
    pub is_alpha_weighted: bool,
    pub keeps_coverage: bool,
}

/// Builds, solves and paints every level. `samples` and their `numbering` are those of level 0.
pub fn finish_channel(
    input: ChannelInput<'_>,
    mut numbering: LevelNumbering<'_>,
    samples: Vec<Vec4>,
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
        is_alpha_weighted: by_alpha,
        keeps_coverage: input.mask_cutoff.is_some(),
    };
    let (canvas, topology) = (numbering.canvas, numbering.topology);
    let mut values = samples;
    let mut wanted_coverage = 0.0;
    for level in 0..input.layout.level_count() {
        watch.stage(Stage::Mip);
        if level > 0 {
            let coarse = LevelNumbering::new(canvas, topology, input.resolutions, level);
            values = coarsen(&numbering, &coarse, &values, by_alpha, watch)?;
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

/// Brings the samples to where every texel can be stored; `None` where nothing was out of range.
fn represent(
    channel: &LevelChannel<'_>,
    rules: &Rules,
    values: &mut LevelValues,
    solver: Solver,
    watch: &dyn Watch,
) -> Result<Option<SolverReport>> {
    let systems = if channel.frames.is_some() { vec![System::Normals] } else { System::components(channel) };
    let wanted: Vec<Vec<f64>> =
        systems.par_iter().map(|system| system.gather(rules, &values.samples)).collect();
    if wanted.iter().all(|wanted| violated_count(rules, wanted) == 0) {
        return Ok(None);
    }
    let weights = weights(channel, rules);
    let is_stored = channel.frames.is_none();
    let center = if is_stored { 0.5 } else { 0.0 };
    // Gray stored as RGB is common: components that want the same get the same.
    let twin = |k: usize| (0..k).find(|&earlier| wanted[earlier] == wanted[k]);
    let twins: Vec<Option<usize>> = (0..systems.len()).map(twin).collect();
    let solved: Vec<Option<Solution>> = (wanted.par_iter().zip(&twins))
        .map(|(wanted, twin)| {
            let problem = Problem { rules, wanted, weights: &weights, center, is_stored };
            twin.is_none().then(|| {
                solve(&problem, matches!(solver, Solver::Global | Solver::Exact), &|| watch.canceled())
            })
        })
        .collect();
    watch::check(watch)?;
    let solutions: Vec<&Solution> =
        (0..systems.len()).filter_map(|k| solved[twins[k].unwrap_or(k)].as_ref()).collect();
    let before = samples_of(channel, rules, &values.samples);
    for (system, solution) in systems.iter().zip(&solutions) {
        system.scatter(rules, &solution.values, values);
    }
    let after = samples_of(channel, rules, &values.samples);
    let (change_sum_codes, change_max_codes) = changes(channel, &before, &after);
    Ok(Some(SolverReport {
        level: channel.numbering.level as u32,
        row_count: (rules.len() * systems.len()) as u64,
        violated_count: solutions.iter().map(|solution| solution.violated_count).sum(),
        iteration_count: solutions.iter().map(|solution| solution.step_count).max().unwrap_or(0),
        residual: largest(&solutions, |solution| solution.residual),
        dual_residual: largest(&solutions, |solution| solution.dual_residual),
        complementarity: largest(&solutions, |solution| solution.complementarity),
        change_mean_codes: change_sum_codes / values.samples.len() as f64,
        change_max_codes,
    }))
}

/// The weight of each variable's change: the surface area of its sample, 1 in the mean over all samples.
fn weights(channel: &LevelChannel<'_>, rules: &Rules) -> Vec<f64> {
    let areas = sample_areas(channel.numbering);
    let mean = areas.iter().map(|&area| f64::from(area)).sum::<f64>() / areas.len() as f64;
    // A mesh without any area still has a mean to divide by.
    let mean = if mean > 0.0 { mean } else { 1.0 };
    let weight = |sample: u32| (f64::from(areas[sample as usize]) / mean).max(WEIGHT_FLOOR);
    let per_sample = if channel.frames.is_some() { 3 } else { 1 };
    rules.variables().iter().map(|variable| weight(variable / per_sample)).collect()
}

/// The values of the samples that rules are about.
fn samples_of(channel: &LevelChannel<'_>, rules: &Rules, values: &[Vec4]) -> Vec<Vec4> {
    let per_sample = if channel.frames.is_some() { 3 } else { 1 };
    let mut samples: Vec<u32> = rules.variables().iter().map(|variable| variable / per_sample).collect();
    samples.dedup();
    samples.into_iter().map(|sample| values[sample as usize]).collect()
}

fn largest(solutions: &[&Solution], figure: impl Fn(&Solution) -> f64) -> f64 {
    solutions.iter().map(|solution| figure(solution)).fold(0.0, f64::max)
}

/// The variables that one solve is about.
#[derive(Clone, Copy, PartialEq, Eq)]
enum System {
    /// One component of every sample.
    Component(usize),
    /// All three components of every normal, which the frames mix.
    Normals,
}

impl System {
    fn components(channel: &LevelChannel<'_>) -> Vec<Self> {
        let stored: &[usize] = match channel.codec.components {
            1 => &[0],
            2 => &[0, 3],
            3 => &[0, 1, 2],
            _ => &[0, 1, 2, 3],
        };
        stored.iter().map(|&component| System::Component(component)).collect()
    }

    /// The values of the rules' variables.
    fn gather(self, rules: &Rules, values: &[Vec4]) -> Vec<f64> {
        let variables = rules.variables().iter().map(|&variable| variable as usize);
        match self {
            System::Component(k) => variables.map(|sample| f64::from(values[sample][k])).collect(),
            System::Normals => variables.map(|at| f64::from(values[at / 3][at % 3])).collect(),
        }
    }

    fn scatter(self, rules: &Rules, solved: &[f64], values: &mut LevelValues) {
        for (&variable, &value) in rules.variables().iter().zip(solved) {
            let variable = variable as usize;
            match self {
                System::Component(k) => values.set(variable, k, value),
                System::Normals => values.set(variable / 3, variable % 3, value),
            }
        }
    }
}

/// Sum and maximum of the samples' changes in codes, the largest component counting.
fn changes(channel: &LevelChannel<'_>, before: &[Vec4], after: &[Vec4]) -> (f64, f64) {
    let is_color = channel.codec.transfer == Transfer::Srgb;
    let encode = |value: Vec4| {
        if !is_color {
            return value;
        }
        value.xyz().map(linear_to_srgb).extend(value.w)
    };
    // Normals span [-1, 1], two of these to a code range.
    let scale = if channel.frames.is_some() { 127.5 } else { 255.0 };
    let mut sum = 0.0;
    let mut max = 0.0f64;
    for (before, after) in before.iter().zip(after).filter(|(before, after)| before != after) {
        let change = f64::from((encode(*before) - encode(*after)).abs().max_element()) * scale;
        sum += change;
        max = max.max(change);
    }
    (sum, max)
}
