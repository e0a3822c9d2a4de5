//! The record as Markdown tables.

use super::curve::{self, Curve};
use super::record::{Done, End, Run, Tradeoff};
use super::words::{figure, grouped, headline, mib};

/// The whole page.
pub fn markdown(record: &Tradeoff) -> String {
    let unit = record.runs.iter().find_map(|run| Some(run.done()?.errors.main()?.1)).unwrap_or("codes");
    let plural = if record.repeat_count == 1 { "" } else { "s" };
    format!(
        "# {}: what accuracy costs\n\n{}.\n\n\
         {} faces; {} threads of {} processors ({}); best of {} run{plural}. Times are CPU seconds of all \
         threads.\n\n\
         ## Runs\n\n\
         *computing* is sampling, mip levels, layout, texel rules and the solver; *all* adds reading, \
         measuring and writing. Errors are {unit} over all channels in that unit: the root mean square at \
         level 0 and over all levels, the 99th percentile and the maximum of the worst channel. *seam* is the \
         largest jump over an uncut edge, with the largest 99.9th percentile. *change* is what the solver did, or storing in a range, \
         on the worst level of the worst channel. Of the runs without seams, those that no other beats are \
         marked: ● by the error of level 0, ◆ by that over all levels; ○ has seams.\n\n{}\n\
         ## Seconds by stage\n\n{}\n\
         ## Error by level\n\nRoot mean square, in {unit}.\n\n{}{}",
        record.model,
        headline(record),
        grouped(record.face_count),
        record.machine.thread_count,
        record.machine.processor_count,
        record.machine.architecture,
        record.repeat_count,
        runs(record),
        stages(record),
        levels(record),
        record.curve.as_ref().map_or_else(String::new, texels),
    )
}

/// The curve, with what its columns mean.
fn texels(curve: &Curve) -> String {
    format!(
        "\n## Texels against error\n\nTexels of level 0 of one map, and by face as it is stored (a quad, a pair of triangles, a \
         triangle alone). *plain* is the source resampled once, bilinearly, to as many texels; *gain* is how much nearer to \
         the source the run is: of base color, and of all maps as the mean, the worst and the best. The runs took {} CPU \
         seconds.\n\n{}",
        figure(curve.cpu_seconds),
        curve::table(curve)
    )
}

/// Every run with its cost and its errors.
pub fn runs(record: &Tradeoff) -> String {
    let heading = [
        "run",
        "computing",
        "all",
        "memory, MiB",
        "RMS",
        "99 %",
        "max",
        "all levels",
        "seam",
        "99.9 %",
        "change",
        "95 %",
        "max",
        "texels",
        "bytes",
        "best",
    ];
    let line = |run: &Run| match &run.end {
        End::Refused { reason, .. } => {
            let mut cells = vec![run.name.clone(), format!("refused: {}", reason.replace('|', "\\|"))];
            cells.resize(heading.len(), String::new());
            cells
        }
        End::Done(done) => std::iter::once(run.name.clone()).chain(run_cells(done)).collect(),
    };
    table(&heading, record.runs.iter().map(line))
}

fn run_cells(done: &Done) -> Vec<String> {
    let shown = |value: Option<f64>| value.map_or_else(String::new, figure);
    let errors = done.errors.main().map(|(errors, _)| errors);
    let change = done.errors.change;
    let marks = [(done.is_on_front, "●"), (done.is_on_mip_front, "◆"), (!done.is_seamless, "○")];
    vec![
        figure(done.cost.converting_cpu_seconds),
        figure(done.cost.cpu_seconds),
        mib(done.cost.peak_memory_bytes),
        shown(errors.map(|e| e.level_0.rms)),
        shown(errors.and_then(|e| e.level_0.p99)),
        shown(errors.and_then(|e| e.level_0.max)),
        shown(done.mip_error()),
        shown(errors.map(|e| e.seam_max)),
        shown(errors.map(|e| e.seam_p999)),
        shown(change.map(|change| change.mean_codes)),
        shown(change.and_then(|change| change.p95_codes)),
        shown(change.map(|change| change.max_codes)),
        grouped(done.output.texels_all_levels),
        grouped(done.output.bytes),
        marks.into_iter().filter(|(is_on, _)| *is_on).map(|(_, mark)| mark).collect(),
    ]
}

fn stages(record: &Tradeoff) -> String {
    let mut names: Vec<&str> = Vec::new();
    let all = || record.runs.iter().filter_map(Run::done).flat_map(|done| &done.cost.stages);
    for stage in all() {
        if !names.contains(&stage.stage.as_str()) {
            names.push(&stage.stage);
        }
    }
    let heading: Vec<&str> = std::iter::once("run").chain(names.iter().copied()).collect();
    let line = |run: &Run| {
        let done = run.done()?;
        let of = |name: &&str| {
            let stage = done.cost.stages.iter().find(|stage| stage.stage == *name);
            stage.map_or_else(String::new, |stage| figure(stage.cpu_seconds))
        };
        Some(std::iter::once(run.name.clone()).chain(names.iter().map(of)).collect())
    };
    table(&heading, record.runs.iter().filter_map(line))
}

fn levels(record: &Tradeoff) -> String {
    let errors = |run: &Run| run.done().and_then(|done| done.errors.main().map(|(errors, _)| errors.clone()));
    let count = record.runs.iter().filter_map(errors).map(|errors| errors.levels.len()).max().unwrap_or(0);
    let numbers: Vec<String> = (0..count).map(|level| level.to_string()).collect();
    let heading: Vec<&str> = std::iter::once("run").chain(numbers.iter().map(String::as_str)).collect();
    let line = |run: &Run| {
        let errors = errors(run)?;
        let of = |level: usize| {
            let found = errors.levels.iter().find(|error| error.level as usize == level);
            found.map_or_else(String::new, |found| figure(found.error.rms))
        };
        Some(std::iter::once(run.name.clone()).chain((0..count).map(of)).collect())
    };
    table(&heading, record.runs.iter().filter_map(line))
}

/// Every column but the first is figures, set to the right.
pub(super) fn table(heading: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let rule: String = (1..heading.len()).map(|_| " --: |").collect();
    let rows: String = rows.map(|cells| format!("| {} |\n", cells.join(" | "))).collect();
    format!("| {} |\n| --- |{rule}\n{rows}", heading.join(" | "))
}
