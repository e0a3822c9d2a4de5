//! What is recorded of a run.

use meshcolor::measure::{ChannelReport, LevelReport, SolverReport, Unit};
use serde_json::{Map, Value, json};

use super::Outcome;

/// The key figures of a run over all its materials and channels, in codes unless a channel says degrees.
pub fn of(outcome: &Outcome) -> Value {
    let report = &outcome.conversion.report;
    let layouts = || report.layouts.iter();
    let warnings: Map<String, Value> =
        report.warnings.iter().map(|warning| (warning.code.clone(), warning.count.into())).collect();
    let mut figures = json!({
        "verdict": report.verdict,
        "warnings": warnings,
        "faces": layouts().map(|layout| layout.face_count).sum::<u64>(),
        "quads": layouts().map(|layout| layout.quad_count).sum::<u64>(),
        "pairs": layouts().map(|layout| layout.merged_pair_count).sum::<u64>(),
        "lone": layouts().map(|layout| layout.lone_triangle_count).sum::<u64>(),
        "exponents": layouts().next().map(|layout| &layout.exponents),
        "cut_edges": report.channels.iter().map(|channel| channel.cuts.cut_edge_count).sum::<u64>(),
        "levels": report.layouts.iter().map(|layout| layout.levels.len()).max(),
        "seam_max": rounded(report.max_seam_delta_codes),
        "change_max": rounded(largest(solved(outcome).map(|level| level.change_max_codes))),
        "residual_below": residual_below(outcome),
        "channels": report.channels.iter().map(channel).collect::<Vec<_>>(),
    });
    for level in 0..report.layouts.iter().map(|layout| layout.levels.len()).max().unwrap_or(0) {
        let here = || solved(outcome).filter(|entry| entry.level as usize == level);
        if here().next().is_some() {
            figures[format!("level_{level}")] = json!({
                "violated": here().map(|entry| entry.violated_count).sum::<u64>(),
                "change_max": rounded(largest(here().map(|entry| entry.change_max_codes))),
            });
        }
    }
    figures
}

fn channel(channel: &ChannelReport) -> Value {
    let unit = if channel.unit == Unit::Codes { "codes" } else { "degrees" };
    json!({
        "slots": channel.slots.join(" "),
        "bits": channel.bits,
        "levels": channel.levels.len(),
        "unit": unit,
        "seam_max": rounded(seam_max(channel)),
    })
}

/// The largest residual that the solver left, as the power of ten above it; `None` where nothing was solved.
fn residual_below(outcome: &Outcome) -> Option<i32> {
    let is_solved = solved(outcome).next().is_some();
    is_solved.then(|| power(largest(solved(outcome).map(|level| level.residual))))
}

/// One line for each run: enough to see what moved.
pub fn lines(all: &Value) -> String {
    let members = all.as_object().into_iter().flatten();
    let lines: Vec<String> = members.map(|(name, value)| format!(" {}: {value}", json!(name))).collect();
    format!("{{\n{}\n}}\n", lines.join(",\n"))
}

pub fn solved(outcome: &Outcome) -> impl Iterator<Item = &SolverReport> {
    outcome.conversion.report.channels.iter().flat_map(|channel| &channel.solver)
}

pub fn seam_max(channel: &ChannelReport) -> f64 {
    let of = |level: &LevelReport| level.seams.map_or(0.0, |seams| seams.max);
    largest(channel.levels.iter().map(of))
}

/// Of a row of figures of 0 or more; not a number where one of them is none.
pub fn largest(figures: impl Iterator<Item = f64>) -> f64 {
    figures
        .fold(0.0, |largest: f64, figure| if figure > largest || figure.is_nan() { figure } else { largest })
}

pub fn rounded(figure: f64) -> f64 {
    (figure * 100.0).round() / 100.0
}

/// The power of ten above a figure, -12 for whatever is less: that is rounding, and another on every processor.
fn power(figure: f64) -> i32 {
    (figure.max(1e-13).log10().floor() as i32 + 1).max(-12)
}
