//! The part of `docs/storage.md` that is quick to take: a dense mesh under a small texture, the case that costs mesh colors
//! most, since every face has corners of its own. The rest is `docs/storage.sh`.

use image::RgbImage;
use image::imageops::thumbnail;
use meshcolor::image::{Image, Pixels};
use meshcolor::measure::Report;
use meshcolor::pipeline::{Options, convert};
use meshcolor::read::{Limits, MemoryFiles, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_tests::models;
use meshcolor_tests::repository::{hold, markdown};

/// Of the small texture, a quarter of what spot comes with.
const SIDE_TEXELS: u32 = 256;
/// What a conversion may take of the source's texels at level 0.
const MOST_OF_SOURCE: f64 = 1.5;

const RUNS: [(&str, &[(&str, &str)]); 5] = [
    ("`--coordinates 4d`", &[("coordinates", "4d")]),
    ("none", &[]),
    ("`--max-error 2`", &[("max-error", "2")]),
    ("`--texels 65536`", &[("texels", "65536")]),
    ("`--texels 65536 --sampling fitted`", &[("texels", "65536"), ("sampling", "fitted")]),
];

/// Spot, subdivided twice, under a picture of 256 texels a side.
fn dense() -> Option<Upload> {
    let file = |name: &str| models::bytes(&format!("spot/{name}"));
    let picture = image::load_from_memory(&file("spot_texture.png")?).unwrap().to_rgb8();
    let small: RgbImage = thumbnail(&picture, SIDE_TEXELS, SIDE_TEXELS);
    let small = Image {
        width: SIDE_TEXELS,
        height: SIDE_TEXELS,
        components: 3,
        pixels: Pixels::U8(small.into_raw()),
    };
    let mut files = MemoryFiles::default();
    files.0.insert("spot_fine.obj".to_owned(), file("spot_fine.obj")?);
    files.0.insert("spot.mtl".to_owned(), file("spot.mtl")?);
    files.0.insert("spot_texture.png".to_owned(), meshcolor::write::png(&small).unwrap());
    Some(Upload { main: "spot_fine.obj".to_owned(), files: Box::new(files) })
}

fn report(upload: &Upload, changes: &[(&str, &str)]) -> Report {
    let mut options = Options::default();
    changes.iter().for_each(|(name, value)| options.set(name, value).unwrap());
    convert(upload, &options, &Limits::default(), &Unwatched).unwrap().report
}

#[test]
fn a_dense_mesh_takes_at_most_half_as_much_again_as_its_small_texture() {
    let Some(upload) = dense() else { return };
    let source = u64::from(SIDE_TEXELS * SIDE_TEXELS);
    let row = |(name, changes): (&str, &[(&str, &str)])| {
        let report = report(&upload, changes);
        let fidelity = report.channels[0].fidelity.unwrap();
        let texels = report.growth.converted_texels;
        let of_source = texels as f64 / source as f64;
        assert_eq!(report.growth.source_texels, source);
        assert!(of_source <= MOST_OF_SOURCE, "{name}: {of_source:.2}");
        vec![
            name.to_owned(),
            texels.to_string(),
            format!("{of_source:.2}"),
            format!("{:.2}", texels as f64 / report.layouts[0].face_count as f64),
            format!("{:.1} ({:.1})", fidelity.psnr_db, fidelity.yardstick_psnr_db.unwrap()),
        ]
    };
    let heading = ["options", "texels, level 0", "of the source's", "a triangle", "base color"];
    hold("docs/storage.md", "dense", &markdown(&heading, RUNS.iter().copied().map(row)));
}
