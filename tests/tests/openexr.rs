//! OpenEXR images that OpenEXR's own library packed: they are read as it reads them.

use std::collections::BTreeMap;

use meshcolor::asset::AttributeName;
use meshcolor::image::{Image, Pixels};
use meshcolor::read::{AttributeSource, Limits, MemoryFiles, Upload, read_with};
use meshcolor::watch::Unwatched;
use meshcolor_tests::openimageio;

const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

fn read(image: &[u8]) -> Image {
    let files = [("m.obj", TRIANGLE), ("a.exr", image)];
    let files = BTreeMap::from(files.map(|(name, bytes)| (name.to_owned(), bytes.to_vec())));
    let upload = Upload { main: "m.obj".to_owned(), files: Box::new(MemoryFiles(files)) };
    let name = AttributeName::new("a").unwrap();
    let source = AttributeSource { name, material: None, file: "a.exr".to_owned(), texcoord: 0 };
    read_with(&upload, &[source], &Limits::default(), &Unwatched).unwrap().images.swap_remove(0)
}

#[test]
fn every_packing_is_read_as_its_own_library_reads_it() {
    let Some(files) = openimageio::written_by("exr.py") else {
        println!("skipped: OpenEXR's own library (no OpenImageIO; tests/run installs it)");
        return;
    };
    assert_eq!(files.len(), 42, "halves and floats: ten packings in lines and tiles, and levels");
    let expected = openimageio::read("exr", &files.values().cloned().collect::<Vec<_>>()).unwrap();
    for ((name, bytes), parts) in files.iter().zip(&expected) {
        let image = read(bytes);
        assert_eq!(
            (image.size().map(|side| side as usize), image.components as usize),
            (parts[0].size, 3),
            "{name}"
        );
        let Pixels::F32(pixels) = &image.pixels else { panic!("{name}: numbers") };
        let scale = pixels.scale.unwrap_or(1.0);
        // DWA is cosines, whose sums a library may round its own way: to a step of a half.
        let rounding = if name.contains("dwa") { 1.0 / 1024.0 } else { 0.0 };
        let is_same = |(found, expected): (&f32, &Option<f32>)| {
            expected.is_some_and(|expected| {
                (found * scale - expected).abs() <= rounding * expected.abs().max(1.0)
            })
        };
        assert_eq!(pixels.values.len(), parts[0].values.len(), "{name}");
        assert!(pixels.values.iter().zip(&parts[0].values).all(is_same), "{name}");
    }
}
