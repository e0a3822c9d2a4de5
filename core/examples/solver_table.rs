//! What each solver costs and leaves on one model: `RAYON_NUM_THREADS=1 cargo run --release -p meshcolor-core
//! --example solver_table -- MODEL [OPTION VALUE]...`, such as `Fox.glb resolution fixed:3`. A model's other
//! files are looked for beside it. Processor seconds are those of stage `solve`, all threads (Linux).

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::sync::Mutex;

use meshcolor::pipeline::{Options, convert_asset};
use meshcolor::read::{Limits, MemoryFiles, Upload, read};
use meshcolor::watch::{Stage, Watch};

/// Processor seconds of this process inside one stage, visit by visit: one for each level of each channel.
#[derive(Default)]
struct SolveClock(Mutex<(Option<f64>, Vec<f64>)>);

impl Watch for SolveClock {
    fn stage(&self, stage: Stage) {
        let now = processor_seconds();
        let Ok(mut state) = self.0.lock() else { return };
        if let Some(entered) = state.0.take() {
            state.1.push(now - entered);
        }
        state.0 = (stage == Stage::Solve).then_some(now);
    }
}

/// All threads, to some milliseconds; 0 where the system does not tell.
fn processor_seconds() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return 0.0 };
    let nanoseconds = threads.flatten().filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    nanoseconds.sum::<f64>() * 1e-9
}

/// What a solver took and where it ended.
struct Run {
    objective: f64,
    /// By visit.
    seconds: Vec<f64>,
}

/// `exact` over `global`: objectives, seconds, and the level that takes `exact` longest.
fn compare(global: &Run, exact: &Run) {
    let total = |run: &Run| run.seconds.iter().sum::<f64>();
    println!(
        "\nexact / global: objective {:.7}, CPU s {:.1}",
        exact.objective / global.objective,
        total(exact) / total(global)
    );
    let longest = (0..exact.seconds.len()).max_by(|&a, &b| exact.seconds[a].total_cmp(&exact.seconds[b]));
    if let Some((global, exact)) = longest.and_then(|at| Some((global.seconds.get(at)?, exact.seconds[at]))) {
        println!(
            "the level that takes exact longest: {exact:.2} / {global:.3} CPU s = {:.1}",
            exact / global
        );
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = PathBuf::from(arguments.next().ok_or("which model?")?);
    let main = path.file_name().and_then(|name| name.to_str()).ok_or("which model?")?.to_owned();
    let mut options = Options::default();
    while let (Some(name), Some(value)) = (arguments.next(), arguments.next()) {
        options.set(&name, &value)?;
    }
    let mut files = BTreeMap::new();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    for entry in std::fs::read_dir(folder.unwrap_or(".".as_ref()))? {
        let entry = entry?;
        if let (true, Ok(name)) = (entry.file_type()?.is_file(), entry.file_name().into_string()) {
            files.insert(name, std::fs::read(entry.path())?);
        }
    }
    let upload = Upload { main, files: Box::new(MemoryFiles(files)) };
    println!("| solver | objective | residual | gradient | variables, most | CPU s | max seam, codes |");
    println!("|---|---|---|---|---|---|---|");
    let mut runs: BTreeMap<&str, Run> = BTreeMap::new();
    for solver in ["clamp", "local", "global", "exact"] {
        options.set("solver", solver)?;
        let clock = SolveClock::default();
        let asset = read(&upload, &Limits::default(), &clock)?;
        let conversion = match convert_asset(asset, &options, &Limits::default(), &clock) {
            Ok(conversion) => conversion,
            Err(error) => {
                println!("| {solver} | {error} | | | | | |");
                continue;
            }
        };
        let report = &conversion.report;
        let levels = || report.channels.iter().flat_map(|channel| &channel.solver);
        let objective: f64 = levels().map(|level| level.objective).sum();
        let residual = levels().map(|level| level.residual).fold(0.0, f64::max);
        let gradient = levels().map(|level| level.dual_residual).fold(0.0, f64::max);
        let components = levels().flat_map(|level| &level.components);
        let variables = components.map(|component| component.variable_count).max().unwrap_or(0);
        let by_visit = clock.0.lock().map(|state| state.1.clone()).unwrap_or_default();
        let seconds: f64 = by_visit.iter().sum();
        let seam = report.max_seam_delta_codes;
        println!(
            "| {solver} | {objective:.6e} | {residual:.1e} | {gradient:.1e} | {variables} | {seconds:.2} | {seam:.2} |"
        );
        runs.insert(solver, Run { objective, seconds: by_visit });
    }
    if let (Some(global), Some(exact)) = (runs.get("global"), runs.get("exact")) {
        compare(global, exact);
    }
    Ok(())
}
