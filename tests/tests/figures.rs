//! The tables of `docs/figures.md`, and one of the README, are what conversions give today.

use std::fs;
use std::process::Command;

use meshcolor::measure::{LevelReport, Report};
use meshcolor::pipeline::{Options, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_tests::repository::{hold, markdown, root};
use meshcolor_tests::{models, requires_tools};

/// Converts, has the script print the report's tables, and holds the page against them.
fn compare(name: &str, upload: &Upload) -> Report {
    let conversion = convert(upload, &Options::default(), &Limits::default(), &Unwatched).unwrap();
    let report = conversion.files.iter().find(|file| file.path == "report.json").unwrap();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("report.json"), &report.bytes).unwrap();
    let printed = Command::new("python3").arg(root().join("docs/figures.py")).arg(folder.path()).output();
    match printed {
        Ok(printed) => {
            assert!(printed.status.success(), "{}", String::from_utf8_lossy(&printed.stderr));
            hold("docs/figures.md", &format!("figures {name}"), &String::from_utf8(printed.stdout).unwrap());
        }
        Err(_) => {
            assert!(!requires_tools(), "python3 is missing");
            println!("skipped: {name} (no python3)");
        }
    }
    conversion.report
}

#[test]
fn the_sample() {
    compare("sample", &Upload::single("sample.glb", meshcolor_service::sample::model()));
}

#[test]
fn fox() {
    let Some(upload) = models::upload("Fox") else { return };
    compare("Fox", &upload);
}

#[test]
fn spot_with_quads() {
    let Some(upload) = models::upload("spot") else { return };
    compare("spot", &upload);
}

#[test]
fn damaged_helmet() {
    let Some(upload) = models::upload("DamagedHelmet") else { return };
    let report = compare("DamagedHelmet", &upload);
    let color = report.channels.iter().find(|channel| channel.slots == ["baseColorTexture"]).unwrap();
    let row = |title: &str, figure: &dyn Fn(&LevelReport) -> Option<f64>| {
        let figures =
            color.levels.iter().map(|level| figure(level).map_or_else(String::new, |f| format!("{f:.1}")));
        std::iter::once(title.to_owned()).chain(figures).collect::<Vec<_>>()
    };
    let source = |level: &LevelReport| level.source.and_then(|source| source.drift);
    let rows = [row("ordinary mip maps", &source), row("converted", &|level| level.drift)];
    let levels = color.levels.iter().map(|level| level.level.to_string());
    let heading: Vec<String> = std::iter::once("level".to_owned()).chain(levels).collect();
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    hold("README.md", "helmet", &markdown(&heading, rows.into_iter()));
}
