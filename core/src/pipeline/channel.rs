//! One channel's journey: samples of level 0 to level images, with what the solver did on the way.

use std::collections::BTreeMap;

use glam::Vec4;

use crate::assign::{
    LevelChannel, LevelValues, Need, NormalFrames, RANGE_WIDTH, Range, Rounding, Storing, need_of_range,
    paint, range_of, read_back, rules,
};
use crate::colors::{Cuts, LevelNumbering, Resolutions};
use crate::error::Result;
use crate::image::{Image, LevelRange};
use crate::layout::Layout;
use crate::measure::{SolverReport, StoredReport};
use crate::mip::{Beyond, MipFilter, Rungs};
use crate::resample::{Fit, Samples};
use crate::solve::Solver;
use crate::watch::{Stage, Watch};

use super::changes::Changes;
use super::form::ChannelForm;
use super::levels::{Levels, Rooms};
use super::represent::{Task, represent};

pub struct ChannelInput<'a> {
    pub form: &'a ChannelForm,
    pub resolutions: &'a Resolutions,
    pub layout: &'a Layout,
    pub cuts: Cuts,
    pub frames: Option<&'a NormalFrames>,
    /// See [`Levels`].
    pub mask_cutoff: Option<f32>,
    pub mip: MipFilter,
    pub beyond: Beyond,
    pub solver: Solver,
    pub range: Range,
    pub rounding: Rounding,
}

pub struct FinishedChannel {
    pub form: ChannelForm,
    pub cuts: Cuts,
    /// Of level 0, before anything was changed to be stored: the components that are stored, one after the other. Empty where nobody
    /// asked for them.
    pub finest_samples: Vec<f32>,
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
    pub keeps_coverage: bool,
    /// The samples of every level as they were stored, to hold the level images against.
    #[cfg(test)]
    pub samples: Vec<Vec<Vec4>>,
}

/// Builds, solves and paints every level. `samples` and their `numbering` are those of level 0.
pub fn finish_channel(
    input: ChannelInput<'_>,
    numbering: LevelNumbering<'_>,
    samples: Samples,
    rooms: &mut Rooms,
    watch: &dyn Watch,
) -> Result<FinishedChannel> {
    let mut finished = unfinished(&input, samples.fit);
    let levels = Levels {
        resolutions: input.resolutions,
        count: input.layout.level_count(),
        rungs: Rungs {
            filter: input.mip,
            beyond: input.beyond,
            by_alpha: input.form.kind.is_alpha_weighted(),
        },
        frames: input.frames,
        mask_cutoff: input.mask_cutoff,
    };
    levels.each((numbering, samples.values), rooms, watch, |numbering, values| {
        finish_level(&input, numbering, values, &mut finished, watch)
    })?;
    finished.cuts = input.cuts;
    Ok(finished)
}

/// A channel without levels.
fn unfinished(input: &ChannelInput<'_>, fit: Option<Fit>) -> FinishedChannel {
    FinishedChannel {
        form: input.form.clone(),
        cuts: Cuts { edges: Vec::new() },
        finest_samples: Vec::new(),
        levels: Vec::new(),
        ranges: BTreeMap::new(),
        sample_counts: Vec::new(),
        solver: Vec::new(),
        fit,
        stored: Vec::new(),
        keeps_coverage: input.mask_cutoff.is_some(),
        #[cfg(test)]
        samples: Vec::new(),
    }
}

/// Solves and paints one level; hands its samples back, which are of no more use but for their memory.
fn finish_level(
    input: &ChannelInput<'_>,
    numbering: &LevelNumbering<'_>,
    wanted: Vec<Vec4>,
    finished: &mut FinishedChannel,
    watch: &dyn Watch,
) -> Result<Vec<Vec4>> {
    watch.stage(Stage::Assign);
    let level = numbering.level;
    let level_channel = LevelChannel {
        layout: input.layout,
        numbering,
        cuts: &input.cuts,
        codec: input.form.codec,
        frames: input.frames,
    };
    let mut wanted = LevelValues::new(wanted, numbering.topology.fan_count());
    let need = match input.form.value_scale {
        Some(_) => Need::Ranged { is_too_wide: false },
        None => need_of_range(&level_channel, &wanted, input.range, watch)?,
    };
    if need != (Need::Ranged { is_too_wide: false }) {
        let width = if need == Need::Plain { 1.0 } else { f64::from(RANGE_WIDTH) };
        let task = Task { solver: input.solver, width };
        let rules = rules(&level_channel);
        watch.stage(Stage::Solve);
        finished.solver.extend(represent(&level_channel, &rules, &mut wanted, task, watch)?);
        watch.stage(Stage::Assign);
    }
    let range = match need {
        Need::Plain => None,
        Need::Ranged { .. } => {
            let kind = (input.range, input.form.value_scale.is_some());
            Some(range_of(&level_channel, &wanted, kind, watch)?)
        }
    };
    let storing = Storing { rounding: input.rounding, range };
    let image = paint(&level_channel, &wanted, storing, watch)?;
    if let Some(range) = range {
        let changes = read_back(&level_channel, &wanted, &image, &range);
        finished.stored.push(stored_report(level, range.name(), &Changes::new(changes)));
        finished.ranges.insert(level, range);
    }
    finished.levels.push(image);
    finished.sample_counts.push(numbering.sample_count() as u64);
    #[cfg(test)]
    finished.samples.push(wanted.samples.clone());
    Ok(wanted.samples)
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
