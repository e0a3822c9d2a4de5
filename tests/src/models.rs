//! Real models for tests, which are not part of the repository.

use std::path::PathBuf;

use meshcolor::read::{MemoryFiles, Upload};

/// The folder with the models: `MESHCOLOR_ASSETS`, or `../shared/assets` beside the repository.
pub fn folder() -> Option<PathBuf> {
    let folder = match std::env::var_os("MESHCOLOR_ASSETS") {
        Some(folder) => PathBuf::from(folder),
        None => PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/assets"),
    };
    folder.is_dir().then_some(folder)
}

/// A model's bytes. Prints that the test was skipped where there is no folder of models.
///
/// # Panics
/// Where the folder is there and the model is not.
pub fn bytes(name: &str) -> Option<Vec<u8>> {
    let Some(folder) = folder() else {
        println!("skipped: {name} (no model folder)");
        return None;
    };
    let path = folder.join(name);
    Some(std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
}

/// The model of a figure: `Fox`, `spot` or `DamagedHelmet`. Prints that the test was skipped where there is no folder of
/// models.
///
/// # Panics
/// Where the folder is there and the model is not.
pub fn upload(model: &str) -> Option<Upload> {
    let main = if model == "spot" { "spot_control_mesh.obj".to_owned() } else { format!("{model}.glb") };
    let beside: &[&str] = if model == "spot" { &["spot.mtl", "spot_texture.png"] } else { &[] };
    let mut files = MemoryFiles::default();
    for name in std::iter::once(main.as_str()).chain(beside.iter().copied()) {
        let path = if model == "spot" { format!("spot/{name}") } else { name.to_owned() };
        files.0.insert(name.to_owned(), bytes(&path)?);
    }
    Some(Upload { main, files: Box::new(files) })
}
