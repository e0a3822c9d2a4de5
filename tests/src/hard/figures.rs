//! What is recorded of a run, and the table of all cases.

use meshcolor::measure::{ChannelReport, LevelReport, SolverReport, Unit};
use serde_json::{Map, Value, json};

use super::{HardCase, Outcome, promises};

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
        "change_max": rounded(largest(solved(outcome).map(|level| level.change_max_codes))),
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

fn rounded(figure: f64) -> f64 {
    (figure * 100.0).round() / 100.0
}

/// Heading of [`row`].
pub const HEADING: &[&str] = &[
    "case",
    "what it is",
    "levels",
    "residual",
    "max seam",
    "max seam, `local`",
    "max seam, `clamp`",
    "max change",
    "from `exact`",
];

/// The row of a case: over all runs that keep edges the largest residual and seam (channels in codes), the
/// seams of `local` and `clamp`, the largest change of any sample, and how many codes the images of `global`
/// and `exact` differ by.
pub fn row(hard: &HardCase) -> Vec<String> {
    let what = hard.case.purpose.clone();
    let outcomes = match hard.outcomes() {
        Ok(outcomes) => outcomes,
        Err(error) => {
            let refused = format!("refused: `{}`", error.code.name());
            let blank = std::iter::repeat_n(String::new(), HEADING.len() - 3);
            return [format!("`{}`", hard.name), what, refused].into_iter().chain(blank).collect();
        }
    };
    let kept: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.keeps_edges()).collect();
    let seam = |outcome: &Outcome| outcome.conversion.report.max_seam_delta_codes;
    let is_solved = kept.iter().any(|outcome| solved(outcome).next().is_some());
    let residual = largest(kept.iter().flat_map(|outcome| solved(outcome)).map(|level| level.residual));
    let change = largest(kept.iter().flat_map(|outcome| solved(outcome)).map(|level| level.change_max_codes));
    let levels = outcomes[0].conversion.finished.textures.iter().map(|texture| texture.levels.len()).max();
    let damage = |name: &str| codes(seam(super::by_name(&outcomes, name)));
    let [global, library] = [super::GLOBAL, super::LIBRARY].map(|name| super::by_name(&outcomes, name));
    vec![
        format!("`{}`", hard.name),
        what,
        levels.unwrap_or(0).to_string(),
        if is_solved { power(residual) } else { "not solved".to_owned() },
        codes(largest(kept.iter().map(|outcome| seam(outcome)))),
        damage("local"),
        damage("clamp"),
        codes(change),
        if is_solved { codes(promises::texels_apart_codes(global, library)) } else { String::new() },
    ]
}

fn codes(figure: f64) -> String {
    format!("{figure:.1}")
}

/// The power of ten above a figure: what lies below is rounding, and another on every processor.
fn power(figure: f64) -> String {
    if figure == 0.0 { "0".to_owned() } else { format!("< 1e{}", figure.log10().floor() as i32 + 1) }
}
