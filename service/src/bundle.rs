//! The bundle: the conversion's files, what only the service knows (clocks, picture), and the manifest
//! that lists them; then as a zip file or a folder. `manifest.json` comes first, so a reader of a stream
//! knows what follows.

use std::fs;
use std::io::{Seek, Write};
use std::path::{Component, Path};

use meshcolor::pipeline::ENGINE_VERSION;
use meshcolor::write::BundleFile;
use serde_json::{Map, Value, json};
use zip::write::SimpleFileOptions;

/// The version of the contract with engines; changes with the meaning or the place of any file.
pub const BUNDLE_VERSION: u32 = 1;

/// Puts the manifest before the files.
pub fn with_manifest(files: Vec<BundleFile>, options: &Map<String, Value>) -> Vec<BundleFile> {
    let entries: Vec<_> = files
        .iter()
        .map(|file| {
            json!({
                "path": file.path,
                "bytes": file.bytes.len(),
                "blake3": blake3::hash(&file.bytes).to_hex().as_str(),
            })
        })
        .collect();
    let manifest = json!({
        "bundle_version": BUNDLE_VERSION,
        "engine_version": ENGINE_VERSION,
        "options": options,
        "files": entries,
    });
    let mut all = vec![json_file("manifest.json", &manifest)];
    all.extend(files);
    all
}

/// A JSON file of a bundle: indented, with a newline at its end.
pub fn json_file(path: &str, value: &Value) -> BundleFile {
    BundleFile { path: path.to_owned(), bytes: format!("{value:#}\n").into_bytes() }
}

/// Writes the files as a zip: stored (images are compressed already), in their order, with fixed times.
pub fn write_zip(files: &[BundleFile], out: impl Write + Seek) -> anyhow::Result<()> {
    let mut zip = zip::ZipWriter::new(out);
    for file in files {
        let options = SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::default())
            .unix_permissions(0o644)
            .large_file(u32::try_from(file.bytes.len()).is_err());
        zip.start_file(file.path.as_str(), options)?;
        zip.write_all(&file.bytes)?;
    }
    zip.finish()?.flush()?;
    Ok(())
}

/// Writes the files below a folder, which is made where it is missing.
pub fn write_folder(files: &[BundleFile], folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder)?;
    for file in files {
        let relative = Path::new(&file.path);
        anyhow::ensure!(
            relative.components().all(|part| matches!(part, Component::Normal(_))),
            "the bundle names a file outside itself: {}",
            file.path
        );
        let path = folder.join(relative);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        fs::write(path, &file.bytes)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Read};

    use super::*;

    fn files() -> Vec<BundleFile> {
        let plain = vec![
            BundleFile { path: "asset.glb".into(), bytes: vec![1, 2, 3] },
            BundleFile { path: "shaders/a.wgsl".into(), bytes: b"fn".to_vec() },
        ];
        with_manifest(plain, &Map::from_iter([("solver".to_owned(), "global".into())]))
    }

    #[test]
    fn the_manifest_names_every_other_file() {
        let files = files();
        let manifest: Value = serde_json::from_slice(&files[0].bytes).unwrap();
        assert_eq!(files[0].path, "manifest.json");
        assert_eq!(manifest["bundle_version"], 1);
        assert_eq!(manifest["options"]["solver"], "global");
        assert_eq!(manifest["files"][1]["path"], "shaders/a.wgsl");
        assert_eq!(manifest["files"][0]["bytes"], 3);
        let hash = manifest["files"][0]["blake3"].as_str().unwrap();
        assert_eq!(hash, blake3::hash(&[1, 2, 3]).to_hex().as_str());
    }

    #[test]
    fn zips_are_equal_to_the_byte_and_keep_the_order() {
        let zip = |files: &[BundleFile]| {
            let mut out = Cursor::new(Vec::new());
            write_zip(files, &mut out).unwrap();
            out.into_inner()
        };
        let first = zip(&files());
        assert_eq!(first, zip(&files()));
        let mut archive = zip::ZipArchive::new(Cursor::new(first)).unwrap();
        let names: Vec<_> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
        assert_eq!(names, ["manifest.json", "asset.glb", "shaders/a.wgsl"]);
        let mut text = String::new();
        archive.by_name("shaders/a.wgsl").unwrap().read_to_string(&mut text).unwrap();
        assert_eq!(text, "fn");
    }

    #[test]
    fn a_folder_never_gets_a_file_outside_itself() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        write_folder(&files(), folder).unwrap();
        assert_eq!(fs::read(folder.join("shaders/a.wgsl")).unwrap(), b"fn");
        let evil = [BundleFile { path: "../evil".into(), bytes: vec![] }];
        assert!(write_folder(&evil, folder).is_err());
    }
}
