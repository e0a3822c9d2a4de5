//! Real models from the model folder.

use crate::asset::Asset;
use crate::error::{ErrorCode, Result};
use crate::read::{Limits, MemoryFiles, Upload, read};
use crate::watch::Unwatched;
use std::path::PathBuf;

fn folder() -> PathBuf {
    match std::env::var_os("MESHCOLOR_ASSETS") {
        Some(folder) => PathBuf::from(folder),
        None => PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/assets"),
    }
}

/// A model with the files beside it; `None` (said aloud) without the model folder.
fn model(name: &str) -> Option<Result<Asset>> {
    let path = folder().join(name);
    let (Some(parent), true) = (path.parent(), path.exists()) else {
        println!("skipped: {name} (no model folder)");
        return None;
    };
    let mut files = MemoryFiles::default();
    for entry in std::fs::read_dir(parent).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            files.0.insert(name, std::fs::read(&path).unwrap());
        }
    }
    let main = path.file_name().unwrap().to_string_lossy().into_owned();
    Some(read(&Upload { main, files: Box::new(files) }, &Limits::default(), &Unwatched))
}

fn face_counts(asset: &Asset) -> [usize; 2] {
    let faces = || asset.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| &p.faces);
    [faces().filter(|f| f.count == 3).count(), faces().filter(|f| f.count == 4).count()]
}

#[test]
fn damaged_helmet() {
    let Some(asset) = model("DamagedHelmet.glb") else { return };
    let asset = asset.unwrap();
    assert_eq!(face_counts(&asset), [15452, 0]);
    assert_eq!(asset.images.len(), 5);
    assert!(asset.images.iter().all(|image| image.size() == [2048, 2048]));
    assert!(asset.materials[0].slots.iter().all(Option::is_some));
    assert_eq!(asset.instances.len(), 1);
}

#[test]
fn fox() {
    let Some(asset) = model("Fox.glb") else { return };
    let asset = asset.unwrap();
    assert_eq!(face_counts(&asset), [576, 0]);
    let names: Vec<&str> =
        asset.meshes[0].primitives[0].attributes.iter().map(|a| a.semantic.as_str()).collect();
    assert_eq!(names, ["JOINTS_0", "WEIGHTS_0"]);
}

#[test]
fn pirate_needs_extensions_that_are_not_understood() {
    let Some(asset) = model("pirate.glb") else { return };
    let error = asset.unwrap_err();
    assert_eq!(error.code, ErrorCode::UnsupportedExtension);
    assert!(error.detail.contains("KHR_mesh_quantization"), "{error}");
}
