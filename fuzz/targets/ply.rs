//! PLY, in text and in bytes, beside the image that it may name.
#![no_main]

use std::collections::BTreeMap;

use meshcolor::read::{MemoryFiles, Upload};
use meshcolor_fuzz::libfuzzer_sys::fuzz_target;

/// 2 x 2 texels.
const TEXTURE: &[u8] = include_bytes!("texture.png");

fuzz_target!(|model: &[u8]| {
    let files = [("m.ply", model), ("t.png", TEXTURE)];
    let files: BTreeMap<_, _> = files.map(|(name, bytes)| (name.to_owned(), bytes.to_vec())).into();
    meshcolor_fuzz::read_with(&Upload { main: "m.ply".to_owned(), files: Box::new(MemoryFiles(files)) }, &[]);
});
