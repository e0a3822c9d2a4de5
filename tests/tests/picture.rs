//! The README's picture is what the demo draws today: its sheet by the CPU renderer, made smaller.
//!
//! With `MESHCOLOR_WRITE_DOCS=1` it is written anew.

use std::env;
use std::fs;
use std::process::Command;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::imageops;
use image::{ImageEncoder, RgbImage};
use meshcolor::pipeline::{Options, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_tests::repository::{root, writes_documents};

const PATH: &str = "docs/sheet.png";
const WIDTH: u32 = 880;
const TITLE: &str = "sample";
const LARGEST_BYTES: usize = 600_000;
/// What another processor's arithmetic may change.
const MEAN_CODES: f64 = 0.05;
const OUTLIER_CODES: u8 = 32;
const OUTLIERS_MAX: usize = 20;

/// A process of its own, because the driver is chosen by its environment.
#[test]
fn the_readme_shows_what_the_demo_draws() {
    let ended = Command::new(env::current_exe().unwrap())
        .args(["--exact", "draw_and_compare", "--ignored", "--nocapture"])
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .output()
        .unwrap();
    let said =
        [ended.stdout, ended.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(ended.status.success() && said.contains("1 passed"), "{said}");
}

#[test]
#[ignore = "run by the_readme_shows_what_the_demo_draws without a Vulkan driver"]
fn draw_and_compare() {
    let upload = Upload::single("sample.glb", meshcolor_service::sample::model());
    let conversion = convert(&upload, &Options::default(), &Limits::default(), &Unwatched).unwrap();
    // The service titles it by the file that the demo sends.
    let sheet = meshcolor_service::sheet::draw(&conversion, TITLE).unwrap();
    assert!(sheet.renderer.starts_with("CPU renderer"), "{} drew it", sheet.renderer);
    let full = image::load_from_memory(&sheet.png).unwrap().to_rgb8();
    let height = full.height() * WIDTH / full.width();
    let drawn = imageops::resize(&full, WIDTH, height, imageops::FilterType::Lanczos3);
    let path = root().join(PATH);
    if writes_documents() {
        fs::write(&path, png(&drawn)).unwrap();
    }
    let committed = fs::read(&path).unwrap();
    assert!(committed.len() <= LARGEST_BYTES, "{PATH} has {} bytes", committed.len());
    let committed = image::load_from_memory(&committed).unwrap().to_rgb8();
    assert_eq!(committed.dimensions(), drawn.dimensions(), "{PATH} has another size than the demo's sheet");
    let [mean, outliers] = differences(&committed, &drawn);
    assert!(
        mean <= MEAN_CODES && outliers <= OUTLIERS_MAX as f64,
        "{PATH} is not what the demo draws: mean difference {mean:.3} codes, {outliers} pixels far off; \
         look at it and write it anew (see this file's head)"
    );
}

/// The mean difference in codes, and the number of pixels that are far off.
fn differences(a: &RgbImage, b: &RgbImage) -> [f64; 2] {
    let pairs = a.pixels().zip(b.pixels());
    let largest = pairs.map(|(a, b)| (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap_or(0));
    let (sum, outliers) = largest.fold((0.0, 0), |(sum, outliers), difference| {
        (sum + f64::from(difference), outliers + u32::from(difference > OUTLIER_CODES))
    });
    [sum / f64::from(a.width() * a.height()), f64::from(outliers)]
}

fn png(picture: &RgbImage) -> Vec<u8> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(picture.as_raw(), picture.width(), picture.height(), image::ExtendedColorType::Rgb8)
        .unwrap();
    bytes
}
