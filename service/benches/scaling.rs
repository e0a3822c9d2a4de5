//! Time and memory from a thousand faces to a million.
//!
//! `cargo bench -p meshcolor --bench scaling -- [--most FACES] [--rungs-most FACES] [--threads COUNT]`
//! prints the figures; with `MESHCOLOR_WRITE_DOCS=1` it writes `docs/scaling.*` too. Rungs are left out
//! beyond `--rungs-most`. Run it on a machine that does nothing else.

use std::fs;
use std::path::Path;

use meshcolor_service::scaling::{FACE_COUNTS, Scaling, svg, text};
use meshcolor_service::{plot, work};

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let figure = |name: &str, default: u64| {
        let place = arguments.iter().position(|argument| argument == name);
        place.map_or(Ok(default), |place| match arguments.get(place + 1).map(|text| text.parse()) {
            Some(Ok(value)) => Ok(value),
            _ => Err(anyhow::anyhow!("{name} needs a number")),
        })
    };
    let most = figure("--most", 1_000_000)?;
    let rungs_most = figure("--rungs-most", most)?;
    let threads = figure("--threads", work::processor_count() as u64)?;
    let pool = work::thread_pool(threads as usize)?;
    let scaling = pool.install(|| -> anyhow::Result<Scaling> {
        let mut scaling = Scaling::begin();
        for faces in FACE_COUNTS.into_iter().filter(|faces| *faces <= most) {
            eprintln!("{faces} faces");
            scaling.add(faces, faces <= rungs_most)?;
        }
        Ok(scaling)
    })?;
    println!("{}", text(&scaling));
    if std::env::var_os("MESHCOLOR_WRITE_DOCS").is_some_and(|value| value == "1") {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let svg = svg(&scaling);
        fs::write(docs.join("scaling.json"), format!("{}\n", serde_json::to_string_pretty(&scaling)?))?;
        fs::write(docs.join("scaling.png"), plot::png(&svg)?)?;
        fs::write(docs.join("scaling.svg"), svg)?;
    }
    Ok(())
}
