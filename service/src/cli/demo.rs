//! `meshcolor demo`: a conversion through the real service, from a model to a picture.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;

use super::Outcome;
use crate::demo::{self, Plan, SentFile};
use crate::sample;
use crate::work::processor_count;

#[derive(clap::Args)]
pub struct Arguments {
    /// The model; without one, a sample that the program makes
    #[arg(value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Where the bundle and the picture go
    #[arg(short = 'o', long, env = "MESHCOLOR_OUT", value_name = "FOLDER", default_value = "meshcolor-demo")]
    out: PathBuf,
}

pub fn run(arguments: Arguments) -> anyhow::Result<Outcome> {
    crate::logging::start("warn");
    let files = match &arguments.model {
        Some(path) => model_files(path)?,
        None => vec![SentFile { path: "sample.glb".to_owned(), bytes: sample::model() }],
    };
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let plan = Plan { files, out: arguments.out, threads: processor_count() };
    runtime.block_on(demo::run(plan))?;
    Ok(Outcome::Fine)
}

/// Endings of files that a model may name.
const SIDECAR_ENDINGS: [&str; 7] = ["bin", "mtl", "png", "jpg", "jpeg", "webp", "ktx2"];

/// The model, and beside a model of text what stands in its folder and may belong to it.
fn model_files(path: &PathBuf) -> anyhow::Result<Vec<SentFile>> {
    let bytes = fs::read(path).with_context(|| path.display().to_string())?;
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let mut files = vec![SentFile { path: name, bytes }];
    if matches!(ending.as_str(), "gltf" | "obj" | "ply") {
        let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        collect(folder.unwrap_or(&PathBuf::from(".")), "", &mut files)?;
    }
    Ok(files)
}

fn collect(folder: &std::path::Path, prefix: &str, files: &mut Vec<SentFile>) -> anyhow::Result<()> {
    let mut entries: Vec<_> = fs::read_dir(folder)?.collect::<Result<_, _>>()?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let Ok(name) = entry.file_name().into_string() else { continue };
        let path = entry.path();
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        if entry.file_type()?.is_dir() && prefix.is_empty() {
            collect(&path, &format!("{name}/"), files)?;
        } else if SIDECAR_ENDINGS.contains(&ending.as_str()) {
            files.push(SentFile { path: format!("{prefix}{name}"), bytes: fs::read(&path)? });
        }
    }
    Ok(())
}
