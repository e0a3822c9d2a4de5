//! What 4D coordinates leave empty on some models, by rows as in the paper and by shelves: `cargo run --release -p
//! meshcolor-core --example packing_table -- MODEL...`. A model's other files are looked for beside it.
//!
//! A block of `n` by `m` segments fills `(n / 2^level + 2)(m / 2^level + 2)` texels of a level, its separation of one texel
//! along each axis included (two lone triangles have three columns more). What is allocated besides is empty.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::path::Path;

use meshcolor::finished::{Anchor, Finished};
use meshcolor::pipeline::{Conversion, Options, convert};
use meshcolor::read::{Limits, MemoryFiles, Upload};
use meshcolor::watch::Unwatched;

/// As in the paper's Table 1.
const LEVELS_MAX: usize = 10;

/// Segments of each block along both axes, and columns that it has more.
fn blocks(finished: &Finished) -> Vec<([f64; 2], f64)> {
    let mut found: BTreeMap<[u32; 3], ([f64; 2], BTreeSet<u32>)> = BTreeMap::new();
    for piece in &finished.primitives {
        for triangle in &piece.triangles {
            let Anchor::Offset(offset) = triangle.anchor else { continue };
            let [a, b, c] = triangle.corners;
            let (least, most) = (a.min(b).min(c), a.max(b).max(c));
            let key = [piece.material as u32, least.x as u32, least.y as u32];
            let sides = (most - least).as_dvec2().to_array();
            found.entry(key).or_insert((sides, BTreeSet::new())).1.insert(offset.x as u32);
        }
    }
    // The second of two triangles alone has an offset of its own.
    found.into_values().map(|(sides, offsets)| (sides, if offsets.len() > 1 { 3.0 } else { 0.0 })).collect()
}

fn row(name: &str, coordinates: &str, conversion: &Conversion) -> String {
    let blocks = blocks(&conversion.finished);
    let filled = |level: usize, separation: f64| -> f64 {
        let scale = (-(level as f64)).exp2();
        let side = |segments: f64| segments * scale + 1.0 + separation;
        blocks.iter().map(|([n, m], more)| (side(*n) + more) * side(*m)).sum()
    };
    let allocated = |level: usize| -> f64 {
        let levels = conversion.report.layouts.iter().filter_map(|layout| layout.levels.get(level));
        levels.map(|level| level.allocated_texels as f64).sum()
    };
    let level_count = conversion.report.layouts.iter().map(|layout| layout.levels.len()).max().unwrap_or(0);
    let levels = 0..level_count.min(LEVELS_MAX);
    let share = |part: f64, whole: f64| format!("{:.1}", 100.0 * (1.0 - part / whole));
    let by_level: Vec<_> = levels.clone().map(|level| share(filled(level, 1.0), allocated(level))).collect();
    let all = [levels.clone().map(|l| filled(l, 1.0)).sum(), levels.map(allocated).sum()];
    format!(
        "| {name} | {coordinates} | {:.3} M | {:.3} M | {} | {} | {} | {} |",
        allocated(0) * 1e-6,
        all[1] * 1e-6,
        share(filled(0, 0.0), filled(0, 1.0)),
        by_level.first().map_or("", String::as_str),
        share(all[0], all[1]),
        by_level.get(1..).unwrap_or_default().join(" ")
    )
}

fn upload(path: &Path) -> Result<(String, Upload), Box<dyn Error>> {
    let main = path.file_name().and_then(|name| name.to_str()).ok_or("no file name")?.to_owned();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(folder.unwrap_or(".".as_ref()))? {
        let entry = entry?;
        if let (true, Ok(name)) = (entry.file_type()?.is_file(), entry.file_name().into_string()) {
            files.insert(name, std::fs::read(entry.path())?);
        }
    }
    Ok((main.clone(), Upload { main, files: Box::new(MemoryFiles(files)) }))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| model | coordinates | level 0 | ten levels | separation, % of level 0 | empty, % of level 0 | of ten | of levels 1 to 9 |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|---|");
    for path in std::env::args().skip(1) {
        for coordinates in ["4d-rows", "4d"] {
            let (name, upload) = upload(Path::new(&path))?;
            let mut options = Options::default();
            options.set("coordinates", coordinates)?;
            let conversion = convert(&upload, &options, &Limits::default(), &Unwatched)?;
            println!("{}", row(&name, coordinates, &conversion));
        }
    }
    Ok(())
}
