//! The report of one conversion: what `measure` found, and what was done and why.

use crate::asset::Asset;
use crate::assign::Range;
use crate::error::{Error, Result, Warning};
use crate::finished::Finished;
use crate::layout::BlockKind;
use crate::measure::{
    self, ChannelExtras, ChannelReport, Effect, EffectState, Extras, Growth, LayoutReport, Measured, Report,
    SampleCounts, SavingsReport, SolverReport, SubjectKind, judge,
};
use crate::pack::Savings;
use crate::solve::Solver;
use crate::write;

use super::ENGINE_VERSION;
use super::channel::FinishedChannel;
use super::group::Group;
use super::material::MaterialConversion;
use super::options::Options;

/// A conversion before its report.
pub struct Converted<'a> {
    pub asset: &'a Asset,
    pub finished: &'a Finished,
    pub materials: &'a [MaterialConversion],
    pub groups: &'a [Group],
}

/// What only the conversion knows and the measures pass on.
pub fn extras(materials: &[MaterialConversion], groups: &[Group]) -> Extras {
    // All channels share the layout; the one with most cuts has most samples.
    let most = |conversion: &MaterialConversion, level: usize| {
        conversion.channels.iter().filter_map(|channel| channel.sample_counts.get(level)).max().copied()
    };
    // Which samples stand in which of several parts is not counted.
    let counts = groups.iter().filter(|group| group.part_count == 1).map(|group| {
        let members = || group.members.iter().map(|&member| &materials[member]);
        let level_count = members().map(|conversion| conversion.layout.level_count()).max().unwrap_or(0);
        let of_level = |level: usize| members().filter_map(|conversion| most(conversion, level)).sum();
        let material = materials[group.members[0]].material;
        SampleCounts { material, part: 0, levels: (0..level_count).map(of_level).collect() }
    });
    let channels = |conversion: &MaterialConversion| {
        let extras = |channel: &FinishedChannel| ChannelExtras {
            material: conversion.material,
            slots: channel.form.slots.clone(),
            solver: channel.solver.clone(),
            stored: channel.stored.clone(),
        };
        conversion.channels.iter().map(extras).collect::<Vec<_>>()
    };
    Extras {
        sample_counts: counts.collect(),
        channels: materials.iter().flat_map(channels).collect(),
        ..Extras::default()
    }
}

pub fn of_conversion(
    converted: &Converted<'_>,
    measured: Measured,
    options: &Options,
    glb: &write::Glb,
) -> Report {
    let Converted { asset, finished, materials, groups } = *converted;
    let mut report = of_check(asset, SubjectKind::Converted, Some(finished), measured, options);
    report.growth.converted_bytes = glb.bytes.len() as u64;
    report.growth.converted_vertices = glb.vertex_count;
    report.warnings.extend(write::losses(asset, finished));
    report.warnings.extend(report.channels.iter().filter_map(unsolved));
    report.warnings.extend(report.channels.iter().filter_map(changed));
    report.warnings.extend(materials.iter().flat_map(unfitted));
    let parts = finished.parts();
    for layout in &mut report.layouts {
        let parts = parts.get(&layout.material);
        let is_whole = layout.materials.is_empty() && parts.is_some_and(|parts| parts.len() == 1);
        if let Some(conversion) = materials.iter().find(|m| is_whole && m.material == layout.material) {
            describe_layout(layout, conversion);
        }
    }
    for group in groups {
        let material = materials[group.members[0]].material;
        let layout = report.layouts.iter_mut().find(|layout| layout.material == material && layout.part == 0);
        if let Some((layout, packed)) = layout.zip(group.packed.as_ref()) {
            layout.savings = Some(savings(&packed.savings));
        }
    }
    report.effects = effects(materials, finished.vertex_colors.len(), options);
    report
}

/// What is left of the solver's conditions (slack times multiplier, gradient) beyond which its answer keeps
/// every rule but is not the nearest.
const UNSOLVED: f64 = 1e-4;

fn unsolved(channel: &ChannelReport) -> Option<Warning> {
    let is_left = |level: &&SolverReport| level.dual_residual.max(level.complementarity) > UNSOLVED;
    let mut levels = channel.solver.iter().filter(is_left);
    let first = levels.next()?;
    Some(Warning {
        code: "solver_stopped_early".to_owned(),
        detail: format!(
            "level {}: every texel can be stored, but the samples were changed more than they had to be \
             (gradient {:.1e}, complementarity {:.1e})",
            first.level, first.dual_residual, first.complementarity
        ),
        pointer: format!("/materials/{}/{}", channel.material, channel.slots.join("+")),
        count: 1 + levels.count() as u64,
    })
}

/// What more than one of twenty samples of level 0 may change by before it is told, in codes.
const TOLD_CHANGE: f64 = 4.0;

/// A channel whose picture is another one, since the texels beside its faces could not be stored otherwise.
fn changed(channel: &ChannelReport) -> Option<Warning> {
    let finest = channel.solver.iter().find(|level| level.level == 0);
    let finest = finest.filter(|level| level.change_p95_codes > TOLD_CHANGE)?;
    Some(Warning {
        code: "samples_changed".to_owned(),
        detail: format!(
            "level 0: to have no seams, samples were changed by {:.1} codes in the mean, at most {:.1}; with more samples on its \
             faces, or triangles in pairs as quads, less changes",
            finest.change_mean_codes, finest.change_max_codes
        ),
        pointer: format!("/materials/{}/{}", channel.material, channel.slots.join("+")),
        count: 1,
    })
}

/// The channels whose fit of level 0 stopped at its limit of steps.
fn unfitted(conversion: &MaterialConversion) -> impl Iterator<Item = Warning> {
    conversion.channels.iter().filter_map(|channel| {
        let fit = channel.fit.filter(|fit| !fit.is_converged())?;
        let slots: Vec<_> = channel.form.slots.iter().map(|slot| slot.gltf_name()).collect();
        Some(Warning {
            code: "fit_stopped_early".to_owned(),
            detail: format!(
                "after {} steps the samples of level 0 would still change by {:.1e} of the range (asked for: \
                 {:.0e}); they are nearer to the source than sampled ones, but not the nearest",
                fit.step_count, fit.residual, fit.tolerance
            ),
            pointer: format!("/materials/{}/{}", conversion.material, slots.join("+")),
            count: 1,
        })
    })
}

/// A report of what measuring alone tells.
pub fn of_check(
    asset: &Asset,
    kind: SubjectKind,
    finished: Option<&Finished>,
    measured: Measured,
    options: &Options,
) -> Report {
    let judgement = judge(kind, &measured.channels);
    let mut warnings = asset.warnings.clone();
    warnings.extend(judgement.warnings);
    let mut growth = finished.map_or_else(Growth::default, |finished| measure::growth(asset, finished));
    growth.source_bytes = source_bytes(asset);
    Report {
        kind,
        engine_version: ENGINE_VERSION.to_owned(),
        verdict: judgement.verdict,
        errors: judgement.errors,
        warnings,
        max_seam_delta_codes: judgement.max_seam_delta_codes,
        options: options.to_json(),
        channels: measured.channels,
        layouts: measured.layouts,
        growth,
        effects: Vec::new(),
        compression: Vec::new(),
        mesh_colors: Vec::new(),
    }
}

/// Buffers, and images that stand outside of them.
fn source_bytes(asset: &Asset) -> u64 {
    let document = &asset.document;
    let buffers: usize = document.buffers.iter().map(Vec::len).sum();
    let images = document.json.get("images").and_then(|images| images.as_array());
    let stands_inside = |number: usize| {
        images.and_then(|images| images.get(number)).is_some_and(|image| image.get("bufferView").is_some())
    };
    let outside = document.encoded_images.iter().enumerate().filter(|(number, _)| !stands_inside(*number));
    (buffers + outside.map(|(_, image)| image.bytes.len()).sum::<usize>()) as u64
}

fn savings(savings: &Savings) -> SavingsReport {
    SavingsReport {
        shared_face_count: savings.shared_count,
        shared_texels: savings.shared_texels[0],
        shared_texels_all_levels: savings.shared_texels[1],
        joined_face_count: savings.joined_count,
        joined_texels: savings.joined_texels[0],
        joined_texels_all_levels: savings.joined_texels[1],
    }
}

fn describe_layout(report: &mut LayoutReport, conversion: &MaterialConversion) {
    let kinds = || conversion.layout.blocks.iter().map(|block| block.kind);
    let quad_count = kinds().filter(|kind| matches!(kind, BlockKind::Quad(_))).count() as u64;
    report.merged_pair_count = conversion.canvas.pair_count();
    report.quad_count = quad_count - report.merged_pair_count;
    report.lone_triangle_count = kinds()
        .map(|kind| match kind {
            BlockKind::Lone(_) => 1,
            BlockKind::Twins(_) => 2,
            BlockKind::Quad(_) => 0,
        })
        .sum();
    report.face_count = conversion.canvas.faces.len() as u64 + report.merged_pair_count;
    report.exponents = vec![0; usize::from(conversion.resolutions.max()) + 1];
    for (face, &[r, s]) in conversion.canvas.faces.iter().zip(&conversion.resolutions.faces) {
        report.exponents[usize::from(r.max(s))] += 1 + u64::from(face.is_pair());
    }
}

/// What effects had to do with, over all materials.
struct Counts {
    cut_edges: usize,
    merged: usize,
    lone: usize,
    /// Faces that go on beyond vertex colors.
    beyond: usize,
    normals: usize,
    alpha: usize,
    masks: usize,
    /// Levels of channels.
    levels: usize,
    solved: usize,
    stored: usize,
}

impl Counts {
    fn new(materials: &[MaterialConversion]) -> Self {
        let channels = || materials.iter().flat_map(|conversion| &conversion.channels);
        let blocks = || materials.iter().flat_map(|conversion| &conversion.layout.blocks);
        let beyond = |conversion: &MaterialConversion| {
            let last = conversion.layout.level_count() - 1;
            conversion.resolutions.faces.iter().filter(|&&[r, s]| usize::from(r.min(s)) < last).count()
        };
        Self {
            cut_edges: channels().flat_map(|channel| &channel.cuts.edges).filter(|cut| **cut).count(),
            merged: materials.iter().map(|conversion| conversion.canvas.pair_count() as usize).sum(),
            lone: blocks().filter(|block| block.kind.is_lone()).count(),
            beyond: materials.iter().map(beyond).sum(),
            normals: materials.iter().filter(|conversion| conversion.frames.is_some()).count(),
            alpha: channels().filter(|channel| channel.form.kind.is_alpha_weighted()).count(),
            masks: channels().filter(|channel| channel.keeps_coverage).count(),
            levels: channels().map(|channel| channel.sample_counts.len()).sum(),
            solved: channels().map(|channel| channel.solver.len()).sum(),
            stored: channels().map(|channel| channel.stored.len()).sum(),
        }
    }

    /// What was done about texels out of range.
    fn solve(&self, solver: Solver) -> String {
        let Self { solved, levels, .. } = self;
        let found = format!("{solved} of {levels} channel levels had texels out of range");
        match solver {
            Solver::Global | Solver::Exact => format!("{found} and were solved"),
            Solver::Local => format!(
                "{found} and were solved face by face: beyond vertex colors faces store shared samples \
                 differently, which shows as seams"
            ),
            Solver::Clamp => format!("{found}; clamped, not solved"),
        }
    }
}

/// What was done and what the asset did not call for. `taker_count`: materials that took their vertex colors.
fn effects(materials: &[MaterialConversion], taker_count: usize, options: &Options) -> Vec<Effect> {
    let effect = |name: &str, run: Option<String>, reason: &str| Effect {
        name: name.to_owned(),
        state: if run.is_some() { EffectState::Run } else { EffectState::Skipped },
        detail: run.unwrap_or_else(|| reason.to_owned()),
    };
    let some = |count: usize, text: String| (count > 0).then_some(text);
    let counts = Counts::new(materials);
    let solve = counts.solve(options.solver);
    let Counts { cut_edges, merged, lone, beyond, normals, alpha, masks, levels, solved, stored } = counts;
    vec![
        effect(
            "cuts",
            some(cut_edges, format!("{cut_edges} edges keep their two sides, over all channels")),
            "no edge shows two values in the source",
        ),
        effect(
            "merged_pairs",
            some(merged, format!("{merged} pairs of triangles share a block")),
            "no two triangles could share a block",
        ),
        effect(
            "border_texels",
            some(lone, format!("{lone} blocks of lone triangles have border lines")),
            "no triangle stands alone",
        ),
        effect(
            "beyond_vertex_colors",
            some(beyond, format!("{beyond} faces are beyond vertex colors at the last level")),
            "all faces reach vertex colors at the same level",
        ),
        effect(
            "representability",
            some(solved, solve),
            if stored > 0 {
                "levels with texels out of range are stored in a range of their own"
            } else {
                "no texel was out of range"
            },
        ),
        effect(
            "level_ranges",
            some(
                stored,
                format!(
                    "{stored} of {levels} channel levels are stored in 16 bits with a range of their own"
                ),
            ),
            match options.range {
                Range::Unorm8 => "the bounded format was asked for",
                Range::Scaled16 | Range::Float16 => {
                    "on no level did more texels beyond vertex colors leave [0, 1] than 5 % of its samples"
                }
            },
        ),
        effect(
            "normal_encoding",
            some(normals, format!("{normals} materials store normals in frames of their own")),
            "no normal map",
        ),
        effect(
            "alpha_weighting",
            some(alpha, format!("{alpha} channels weigh color by alpha")),
            "no material shows its alpha",
        ),
        effect(
            "alpha_coverage",
            some(masks, format!("{masks} masked channels keep the share of surface that passes the cutoff")),
            "no masked material",
        ),
        effect(
            "vertex_colors",
            some(
                taker_count,
                format!("{taker_count} materials hold their vertex colors in their base color"),
            ),
            "no material took vertex colors, see `vertex-colors`",
        ),
    ]
}

/// `report.json`: indented, for people too.
pub fn to_bytes(report: &Report) -> Result<Vec<u8>> {
    let mut bytes =
        serde_json::to_vec_pretty(report).map_err(|error| Error::internal(format!("report: {error}")))?;
    bytes.push(b'\n');
    Ok(bytes)
}
