//! What each solver costs and leaves on one model: `cargo run --release -p meshcolor-core --example
//! solver_table -- MODEL [OPTION VALUE]...`, such as `Fox.glb resolution fixed:3`. A model's other files
//! are looked for beside it. Processor seconds are those of stage `solve` (Linux).

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::sync::Mutex;

use meshcolor::pipeline::{Options, convert_asset};
use meshcolor::read::{Limits, MemoryFiles, Upload, read};
use meshcolor::watch::{Stage, Watch};

/// Processor seconds of this process inside one stage.
#[derive(Default)]
struct SolveClock(Mutex<(Option<f64>, f64)>);

impl Watch for SolveClock {
    fn stage(&self, stage: Stage) {
        let now = processor_seconds();
        let Ok(mut state) = self.0.lock() else { return };
        if let Some(entered) = state.0.take() {
            state.1 += now - entered;
        }
        state.0 = (stage == Stage::Solve).then_some(now);
    }
}

/// All threads, in hundredths; 0 where the system does not tell.
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = text.rsplit(')').next().unwrap_or_default();
    let fields = after_name.split_whitespace().skip(11).take(2);
    fields.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
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
        let seconds = clock.0.lock().map(|state| state.1).unwrap_or_default();
        let seam = report.max_seam_delta_codes;
        println!(
            "| {solver} | {objective:.6e} | {residual:.1e} | {gradient:.1e} | {variables} | {seconds:.2} | {seam:.2} |"
        );
    }
    Ok(())
}
