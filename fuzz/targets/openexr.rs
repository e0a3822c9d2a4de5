//! An OpenEXR image as a channel of a triangle.
#![no_main]

use std::collections::BTreeMap;

use meshcolor::pipeline::Options;
use meshcolor::read::{MemoryFiles, Upload};
use meshcolor_fuzz::libfuzzer_sys::fuzz_target;

const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

fuzz_target!(|image: &[u8]| {
    let files = [("model.obj", TRIANGLE), ("image.exr", image)];
    let files: BTreeMap<_, _> = files.map(|(name, bytes)| (name.to_owned(), bytes.to_vec())).into();
    let upload = Upload { main: "model.obj".to_owned(), files: Box::new(MemoryFiles(files)) };
    let mut options = Options::default();
    options.set("channel", "light=image.exr").expect("a channel");
    meshcolor_fuzz::read_with(&upload, &options.channels);
});
