//! The tables of `docs/ladders.md`: what each rung of a ladder gives on three models, level by level. Times are in
//! `docs/tradeoff.md`.

use std::collections::BTreeMap;

use meshcolor::measure::{ChannelReport, LayoutLevel, LevelReport, Report};
use meshcolor::pipeline::{Options, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_tests::models;
use meshcolor_tests::repository::{hold, markdown};

const DOCUMENT: &str = "docs/ladders.md";

/// What is beside `standard`, by the name that tables use.
const RUNS: [(&str, &[(&str, &str)]); 10] = [
    ("standard", &[]),
    ("filtered", &[("sampling", "filtered")]),
    ("fitted", &[("sampling", "fitted")]),
    ("indexed one-ring", &[("beyond", "one-ring")]),
    ("float16", &[FOUR_D]),
    ("scaled16", &[FOUR_D, ("range", "scaled16")]),
    ("one-ring", &[FOUR_D, ("beyond", "one-ring")]),
    ("unorm8", &[FOUR_D, ("range", "unorm8")]),
    ("unorm8 one-ring", &[FOUR_D, ("range", "unorm8"), ("beyond", "one-ring")]),
    ("unorm8 local", &[FOUR_D, ("range", "unorm8"), ("solver", "local")]),
];
/// Coordinates that have texels beyond vertex colors, which the ladders of ranges and solvers are about.
const FOUR_D: (&str, &str) = ("coordinates", "4d");

/// A model's reports by run, and its base color's part of one.
struct Runs(BTreeMap<&'static str, Report>);

impl Runs {
    fn new(upload: &Upload) -> Self {
        let report = |changes: &[(&str, &str)]| {
            let mut options = Options::default();
            changes.iter().for_each(|(name, value)| options.set(name, value).unwrap());
            convert(upload, &options, &Limits::default(), &Unwatched).unwrap().report
        };
        Self(RUNS.iter().map(|(name, changes)| (*name, report(changes))).collect())
    }

    fn color(&self, run: &str) -> &ChannelReport {
        let mut channels = self.0[run].channels.iter();
        channels.find(|channel| channel.slots.iter().any(|slot| slot == "baseColorTexture")).unwrap()
    }

    /// A table by level of the base color; levels where every cell is empty are left out.
    fn by_level(&self, heading: &[&str], cells: impl Fn(usize) -> Vec<String>) -> String {
        let heading: Vec<&str> = std::iter::once("level").chain(heading.iter().copied()).collect();
        let rows = (0..self.color("standard").levels.len()).map(|level| (level, cells(level)));
        let rows = rows.filter(|(_, cells)| cells.iter().any(|cell| !cell.is_empty()));
        let row = |(level, cells): (usize, Vec<String>)| {
            std::iter::once(level.to_string()).chain(cells).collect::<Vec<_>>()
        };
        markdown(&heading, rows.map(row))
    }
}

fn sampling(runs: &Runs) -> String {
    let heading =
        ["channel", "point, RMS", "filtered", "fitted", "unit", "point, PSNR dB", "filtered", "fitted"];
    let fidelity = |run: &str, channel: usize| runs.0[run].channels[channel].fidelity;
    let rows = runs.0["standard"].channels.iter().enumerate().map(|(number, channel)| {
        let rungs = ["standard", "filtered", "fitted"].map(|run| fidelity(run, number));
        let slots: Vec<_> = channel.slots.iter().map(|slot| slot.trim_end_matches("Texture")).collect();
        let shown = |of: &dyn Fn(usize) -> Option<String>| {
            (0..3).map(|k| of(k).unwrap_or_default()).collect::<Vec<_>>()
        };
        let rms = shown(&|k| rungs[k].map(|fidelity| format!("{:.2}", fidelity.rms)));
        let psnr = shown(&|k| rungs[k].map(|fidelity| format!("{:.1}", fidelity.psnr_db)));
        let unit = serde_json::to_value(channel.unit).unwrap();
        let unit = unit.as_str().unwrap_or_default().to_owned();
        std::iter::once(slots.join(" + ")).chain(rms).chain([unit]).chain(psnr).collect()
    });
    markdown(&heading, rows)
}

/// What the solver and then storing did to the samples of a level: mean, 95th percentile, largest.
fn changes(channel: &ChannelReport, level: usize) -> [f64; 3] {
    let solved = channel.solver.iter().find(|own| own.level as usize == level);
    let solved = solved.map(|own| [own.change_mean_codes, own.change_p95_codes, own.change_max_codes]);
    let stored = channel.stored.iter().find(|own| own.level as usize == level);
    let stored = stored.map(|own| [own.change_mean_codes, own.change_p95_codes, own.change_max_codes]);
    let (solved, stored) = (solved.unwrap_or_default(), stored.unwrap_or_default());
    [0, 1, 2].map(|k| solved[k] + stored[k])
}

fn formats(runs: &Runs) -> String {
    let heading =
        ["unorm8: mean", "95 %", "max", "scaled16: mean", "95 %", "max", "float16: mean", "95 %", "max"];
    runs.by_level(&heading, |level| {
        let all = ["unorm8", "scaled16", "float16"].map(|run| changes(runs.color(run), level));
        if all == [[0.0; 3]; 3] {
            return Vec::new();
        }
        all.iter().flatten().map(|codes| format!("{codes:.2}")).collect()
    })
}

/// Texels, and what of them no face uses, level by level and over all levels, which are levels of the first material.
fn coordinates(runs: &Runs) -> String {
    let heading = ["texels, indexed", "4d", "not used, indexed", "4d", "error, indexed", "4d"];
    let levels = |run: &str| &runs.0[run].layouts[0].levels;
    let error = |run: &str, level: usize| {
        let error = runs.color(run).levels.get(level).and_then(|level| level.mip_error);
        error.map_or_else(String::new, |error| format!("{:.2}", error.rms))
    };
    let both = ["standard", "float16"];
    runs.by_level(&heading, |level| {
        let of = |show: &dyn Fn(&LayoutLevel) -> String| {
            both.map(|run| levels(run).get(level).map_or_else(String::new, show))
        };
        let texels = of(&|level| level.allocated_texels.to_string());
        let waste = of(&|level| format!("{:.1} %", 100.0 * level.waste));
        [texels, waste, both.map(|run| error(run, level))].concat()
    })
}

fn beyond(runs: &Runs) -> String {
    let heading = ["error, heat", "one-ring", "out of range, heat", "one-ring"];
    let error = |run: &str, level: usize| {
        let error = runs.color(run).levels[level].mip_error;
        error.map_or_else(String::new, |error| format!("{:.2}", error.rms))
    };
    let outside = |run: &str, level: usize| {
        let solved = runs.color(run).solver.iter().find(|own| own.level as usize == level);
        let share = solved.map_or(0.0, |own| own.violated_count as f64 / own.row_count as f64);
        if share == 0.0 { String::new() } else { format!("{:.1} %", 100.0 * share) }
    };
    runs.by_level(&heading, |level| {
        vec![
            error("standard", level),
            error("indexed one-ring", level),
            outside("unorm8", level),
            outside("unorm8 one-ring", level),
        ]
    })
}

fn solvers(runs: &Runs) -> String {
    let heading = ["global: max", "99.9 %", "local: max", "99.9 %"];
    let seams = |run: &str, level: usize| {
        let level: &LevelReport = &runs.color(run).levels[level];
        level.seams.map_or([String::new(), String::new()], |seams| {
            [seams.max, seams.p999].map(|codes| format!("{codes:.2}"))
        })
    };
    runs.by_level(&heading, |level| [seams("unorm8", level), seams("unorm8 local", level)].concat())
}

fn compare(model: &str) {
    let Some(upload) = models::upload(model) else { return };
    let runs = Runs::new(&upload);
    for (ladder, text) in [
        ("sampling", sampling(&runs)),
        ("coordinates", coordinates(&runs)),
        ("range", formats(&runs)),
        ("beyond", beyond(&runs)),
        ("solver", solvers(&runs)),
    ] {
        hold(DOCUMENT, &format!("{ladder} {model}"), &text);
    }
}

#[test]
fn fox() {
    compare("Fox");
}

#[test]
fn spot() {
    compare("spot");
}

#[test]
fn damaged_helmet() {
    compare("DamagedHelmet");
}
