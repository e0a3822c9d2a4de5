//! The tables of `docs/figures.md` are what a conversion gives today.

use std::fs;
use std::process::Command;

use meshcolor::pipeline::{Options, convert};
use meshcolor::read::{Limits, MemoryFiles, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_tests::repository::{file, root};
use meshcolor_tests::{models, requires_tools};

/// Converts, has the script print the report's tables, and compares them with the page.
fn compare(name: &str, upload: &Upload) {
    let conversion = convert(upload, &Options::default(), &Limits::default(), &Unwatched).unwrap();
    let report = conversion.files.iter().find(|file| file.path == "report.json").unwrap();
    let folder = std::env::temp_dir().join(format!("meshcolor-figures-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("report.json"), &report.bytes).unwrap();
    let script = root().join("docs/figures.py");
    let printed = Command::new("python3").arg(script).arg(format!("{name}={}", folder.display())).output();
    fs::remove_dir_all(&folder).unwrap();
    let Ok(printed) = printed else {
        assert!(!requires_tools(), "python3 is missing");
        return println!("skipped: {name} (no python3)");
    };
    assert!(printed.status.success(), "{}", String::from_utf8_lossy(&printed.stderr));
    let printed = String::from_utf8(printed.stdout).unwrap();
    let page = file("docs/figures.md");
    let [start, end] = [format!("<!-- figures {name} -->\n\n"), format!("\n<!-- end {name} -->\n")];
    let shown = page.split_once(&start).and_then(|(_, rest)| rest.split_once(&end)).map(|(shown, _)| shown);
    let shown = shown.unwrap_or_else(|| panic!("docs/figures.md has no marks for {name}"));
    let first = (shown.trim_end().lines().zip(printed.trim_end().lines())).find(|(shown, now)| shown != now);
    assert!(
        shown.trim_end() == printed.trim_end(),
        "docs/figures.md is stale for {name}, first at (there, now) {first:#?}; \
         write it anew with the commands at its head"
    );
}

#[test]
fn the_sample() {
    compare("sample", &Upload::single("sample.glb", meshcolor_service::sample::model()));
}

#[test]
fn fox() {
    let Some(bytes) = models::bytes("Fox.glb") else { return };
    compare("Fox", &Upload::single("Fox.glb", bytes));
}

#[test]
fn spot_with_quads() {
    let names = ["spot_control_mesh.obj", "spot.mtl", "spot_texture.png"];
    let mut files = MemoryFiles::default();
    for name in names {
        let Some(bytes) = models::bytes(&format!("spot/{name}")) else { return };
        files.0.insert(name.to_owned(), bytes);
    }
    compare("spot", &Upload { main: names[0].to_owned(), files: Box::new(files) });
}

#[test]
fn damaged_helmet() {
    let Some(bytes) = models::bytes("DamagedHelmet.glb") else { return };
    compare("DamagedHelmet", &Upload::single("DamagedHelmet.glb", bytes));
}
