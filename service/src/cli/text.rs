//! A report for people: one table for each channel, a row for each level.

use std::fmt::Write;

use meshcolor::measure::{ChannelReport, Figures, LevelReport, Report, SubjectKind, Unit, Verdict};

/// Characters of a model's own names that are shown.
const SHOWN_NAME_CHARS: usize = 256;

/// The report of one file.
pub fn table(path: &str, report: &Report) -> String {
    let mut out = String::new();
    let kind = match report.kind {
        SubjectKind::Source => "source",
        SubjectKind::Converted => "converted",
        SubjectKind::MeshColors => "mesh colors",
    };
    let verdict = match report.verdict {
        Verdict::Pass => "pass",
        Verdict::Warn => "warn",
        Verdict::Fail => "fail",
    };
    let _ = writeln!(
        out,
        "{}: {kind}, {verdict}, largest seam {:.3} codes",
        plain(path),
        report.max_seam_delta_codes
    );
    for error in &report.errors {
        let _ = writeln!(out, "  error: {}", plain(error));
    }
    for warning in &report.warnings {
        let _ = writeln!(
            out,
            "  warning: {} ({}, {})",
            plain(&warning.detail),
            plain(&warning.pointer),
            warning.count
        );
    }
    for channel in &report.channels {
        describe_channel(&mut out, channel);
    }
    for channel in &report.mesh_colors {
        let _ = writeln!(
            out,
            "  material {}, {}: {} samples of {} components on {} faces, {} edges cut",
            channel.material,
            channel.slots.join(", "),
            channel.sample_count,
            channel.components,
            channel.face_count,
            channel.cut_edge_count
        );
    }
    out.push_str(&compression(report));
    out
}

/// What blocks do to the levels of each channel; nothing where there are none.
pub fn compression(report: &Report) -> String {
    let mut out = String::new();
    for channel in &report.compression {
        let name = plain(&format!("{} / {}", channel.material_name, channel.slots.join("+")));
        let _ = writeln!(out, "  {name} in blocks ({})", unit_name(channel.unit));
        let heads = ["level", "format", "PSNR, dB", "max", "blocks", "fitted", "mean", "blocks", "fitted"];
        let _ = writeln!(out, "    {}", heads.map(|head| format!("{head:>8}")).join(" "));
        for level in &channel.levels {
            let fitted = level.seams.as_ref().filter(|_| level.is_refitted);
            let versions = [level.seams_before.as_ref(), level.seams_unfitted.as_ref(), fitted].map(figures);
            let [max, mean] = [0, 2].map(|k| versions.each_ref().map(|version| version[k].clone()));
            let first = [level.level.to_string(), plain(&level.format), format!("{:.2}", level.psnr_db)];
            let cells = first.into_iter().chain(max).chain(mean).map(|cell| format!("{cell:>8}"));
            let _ = writeln!(out, "    {}", cells.collect::<Vec<_>>().join(" "));
        }
    }
    out
}

fn describe_channel(out: &mut String, channel: &ChannelReport) {
    let cuts = &channel.cuts;
    let edges = if cuts.seam_edge_count == 0 {
        format!("{} edges cut", cuts.cut_edge_count)
    } else {
        let [seams, joined, cut] = [cuts.seam_share, cuts.welded_share, cuts.cut_share].map(|s| s * 100.0);
        format!("{seams:.1} % of inner edge length is seams, of that {joined:.1} % joined, {cut:.1} % cut")
    };
    let name = plain(&channel.material_name);
    let _ = writeln!(
        out,
        "  {name} / {} ({}): {edges}",
        plain(&channel.slots.join("+")),
        unit_name(channel.unit)
    );
    let _ = writeln!(
        out,
        "    {:>5} {:>11} {:>9} {:>9} {:>9} {:>9}",
        "level", "size", "max", "99.9 %", "mean", "drift"
    );
    for level in &channel.levels {
        describe_level(out, level);
    }
}

fn describe_level(out: &mut String, level: &LevelReport) {
    let size = format!("{}x{}", level.size[0], level.size[1]);
    let [max, p999, mean] = figures(level.seams.as_ref());
    let drift = figure(level.drift);
    let _ = writeln!(out, "    {:>5} {size:>11} {max:>9} {p999:>9} {mean:>9} {drift:>9}", level.level);
    if let Some(source) = &level.source {
        let size = format!("{}x{}", source.size[0], source.size[1]);
        let [max, p999, mean] = figures(source.seams.as_ref());
        let drift = figure(source.drift);
        let _ = writeln!(out, "    {:>5} {size:>11} {max:>9} {p999:>9} {mean:>9} {drift:>9}  source", "");
    }
}

/// Before and after: the largest seam of each channel's levels, source against converted.
pub fn before_and_after(report: &Report) -> String {
    let mut out = String::new();
    for channel in &report.channels {
        let name = plain(&format!("{} / {}", channel.material_name, channel.slots.join("+")));
        let _ =
            writeln!(out, "{name}, {} at {} seams", unit_name(channel.unit), channel.cuts.seam_edge_count);
        let _ = writeln!(out, "  {:>5}  {:>21}  {:>21}", "", "largest seam", "drift");
        let _ = writeln!(
            out,
            "  {:>5}  {:>10} {:>10}  {:>10} {:>10}",
            "level", "source", "converted", "source", "converted"
        );
        for level in &channel.levels {
            let source = level.source.as_ref();
            let pair = |figures: Option<&Figures>| figures.map(|f| f.max);
            let _ = writeln!(
                out,
                "  {:>5}  {:>10} {:>10}  {:>10} {:>10}",
                level.level,
                figure(pair(source.and_then(|source| source.seams.as_ref()))),
                figure(pair(level.seams.as_ref())),
                figure(source.and_then(|source| source.drift)),
                figure(level.drift),
            );
        }
    }
    out
}

fn unit_name(unit: Unit) -> &'static str {
    match unit {
        Unit::Codes => "codes",
        Unit::Degrees => "degrees",
    }
}

fn figures(figures: Option<&Figures>) -> [String; 3] {
    [figures.map(|f| f.max), figures.map(|f| f.p999), figures.map(|f| f.mean)].map(figure)
}

fn figure(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"))
}

/// Text from a model without control characters, which could steer a terminal, and not without end.
fn plain(text: &str) -> String {
    text.chars().take(SHOWN_NAME_CHARS).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
pub(super) fn sample_report() -> Report {
    use meshcolor::measure::{CompressedLevel, CompressionReport, CutShare, Growth, SourceLevel};
    let seams = |max| Some(Figures { max, p999: max, mean: max / 2.0, sample_count: 9 });
    Report {
        kind: SubjectKind::Converted,
        engine_version: "0".into(),
        verdict: Verdict::Pass,
        errors: vec![],
        warnings: vec![],
        max_seam_delta_codes: 0.5,
        options: serde_json::Map::new(),
        channels: vec![ChannelReport {
            material: 0,
            material_name: "wood\x1b[31m".into(),
            slots: vec!["baseColorTexture".into()],
            unit: Unit::Codes,
            value_scale: None,
            components: 3,
            bits: 8,
            cuts: CutShare { seam_edge_count: 12, ..CutShare::default() },
            levels: vec![LevelReport {
                level: 0,
                size: [64, 32],
                seams: seams(0.5),
                seams_8bit_weights: None,
                range: None,
                drift: Some(0.25),
                source: Some(SourceLevel { size: [128, 128], seams: seams(31.0), drift: None }),
                mip_error: None,
            }],
            fidelity: None,
            solver: vec![],
            stored: vec![],
        }],
        layouts: vec![],
        growth: Growth::default(),
        effects: vec![],
        compression: vec![CompressionReport {
            material: 0,
            material_name: "wood\x1b[31m".into(),
            slots: vec!["baseColorTexture".into()],
            unit: Unit::Codes,
            levels: vec![CompressedLevel {
                level: 0,
                format: "bc7".into(),
                bytes: 2048,
                psnr_db: 46.5,
                seams_before: seams(0.5),
                seams_unfitted: seams(7.75),
                seams: seams(6.5),
                is_refitted: true,
            }],
        }],
        mesh_colors: vec![],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_the_figures_and_no_control_characters() {
        let report = sample_report();
        for text in [table("a\r\nb.glb", &report), before_and_after(&report)] {
            assert!(text.contains("31.000") && text.contains("0.500"), "{text}");
            assert!(!text.replace('\n', "").contains(char::is_control), "{text:?}");
        }
        assert!(table("x", &report).lines().any(|line| line.ends_with("source")));
        let row = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let text = compression(&report);
        assert_eq!(
            row(text.lines().last().unwrap()),
            ["0", "bc7", "46.50", "0.500", "7.750", "6.500", "0.250", "3.875", "3.250"]
        );
        assert!(!text.replace('\n', "").contains(char::is_control) && table("x", &report).ends_with(&text));
    }
}
