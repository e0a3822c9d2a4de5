//! Levels as loose files, for engines that load textures by themselves:
//! `textures/SET/CHANNEL/level_LL.png | .ktx2 | .exr`.
//!
//! Every level is a file of its own. KTX2 fixes the size of level `p` at `max(1, size >> p)`, and ours are
//! not exact halves: blocks shrink, the distance between them does not. JPEG is not among the formats,
//! because it changes the texels on the two sides of an edge differently.

mod blocks;
mod compressed;
mod encoders;
mod exr;
mod gpu;
mod ktx2;
mod refit;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use glam::Vec4;
use rayon::prelude::*;

use crate::asset::Asset;
use crate::error::{Error, Result};
use crate::finished::{Finished, FinishedTexture};
use crate::image::{Image, LevelRange, Transfer};
use crate::watch::{Watch, check};

use super::{BundleFile, Pngs};

pub use blocks::{BlockFormat, Blocks};
pub use compressed::Compressed;
pub use refit::refit;

/// What a loose level can be stored as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TextureFormat {
    /// The bytes that `asset.glb` has.
    Png,
    /// Texels as a GPU takes them, under Zstandard.
    Ktx2,
    /// Linear values: half floats where they give the codes back, 32 bits elsewhere.
    Exr,
}

impl TextureFormat {
    /// The ending of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Ktx2 => "ktx2",
            Self::Exr => "exr",
        }
    }
}

/// One level of one channel, with what its codes mean.
#[derive(Clone, Copy)]
struct Level<'a> {
    number: usize,
    image: &'a Image,
    transfer: Transfer,
    range: Option<&'a LevelRange>,
    is_normal: bool,
    value_scale: Option<f32>,
}

impl<'a> Level<'a> {
    fn of(texture: &'a FinishedTexture, number: usize) -> Self {
        Self {
            number,
            image: &texture.levels[number],
            transfer: texture.transfer,
            range: texture.ranges.get(&number),
            is_normal: texture.is_normal(),
            value_scale: texture.value_scale,
        }
    }

    /// The value that is filtered, as red, green, blue, alpha: linear light for color.
    fn value(&self, (x, y): (u32, u32)) -> Vec4 {
        self.image.value(x, y, self.transfer, self.range)
    }

    /// The value of every texel, row by row.
    fn values(&self) -> Vec<Vec4> {
        let rows = 0..self.image.height;
        rows.flat_map(|y| (0..self.image.width).map(move |x| (x, y))).map(|at| self.value(at)).collect()
    }
}

/// What files are made of.
pub struct Source<'a> {
    pub asset: &'a Asset,
    pub finished: &'a Finished,
    /// The encoded levels of `finished`.
    pub pngs: &'a Pngs,
    /// What KTX2 files hold instead of texels, level by level.
    pub compressed: Option<&'a Compressed>,
}

/// Every level of every channel in every format asked for, in order of texture, level and format: the same
/// bytes for any number of threads.
///
/// # Errors
/// `Canceled`; `Internal` where an image breaks its own guarantees or two channels of a material have
/// the same slots.
pub fn files(
    source: &Source<'_>,
    formats: &BTreeSet<TextureFormat>,
    watch: &dyn Watch,
) -> Result<Vec<BundleFile>> {
    if formats.is_empty() {
        return Ok(Vec::new());
    }
    let folders = folders(source.asset, source.finished)?;
    watch.step(Some("textures"));
    let textures = source.finished.textures.par_iter().enumerate();
    let all: Result<Vec<Vec<BundleFile>>> = textures
        .flat_map(|(number, texture)| {
            let levels = (0..texture.levels.len()).into_par_iter();
            let folder = &folders[number];
            levels.map(move |level| {
                check(watch)?;
                let file = |format: &TextureFormat| source.file(folder, [number, level], *format);
                formats.iter().map(file).collect()
            })
        })
        .collect();
    watch.step(None);
    Ok(all?.into_iter().flatten().collect())
}

impl Source<'_> {
    fn file(&self, folder: &str, [texture, number]: [usize; 2], format: TextureFormat) -> Result<BundleFile> {
        let level = Level::of(&self.finished.textures[texture], number);
        let bytes = match format {
            TextureFormat::Png => self.pngs[texture][number].clone(),
            TextureFormat::Exr => exr::file(&level)?,
            TextureFormat::Ktx2 => match self.compressed.and_then(|all| all.level(texture, number)) {
                Some(blocks) => ktx2::file(&level, &blocks.texels)?,
                None => ktx2::file(&level, &gpu::texels(&level)?)?,
            },
        };
        Ok(BundleFile { path: format!("{folder}/level_{number:02}.{}", format.extension()), bytes })
    }
}

/// `textures/SET/CHANNEL` of each texture.
fn folders(asset: &Asset, finished: &Finished) -> Result<Vec<String>> {
    let mut known = BTreeSet::new();
    let mut folders = Vec::with_capacity(finished.textures.len());
    for texture in &finished.textures {
        let material = texture.materials.first().copied().unwrap_or_default();
        let name = asset.materials.get(material).map_or("", |material| material.name.as_str());
        let set = match texture.part {
            0 => set_name(material, name),
            part => format!("{}_part_{}", set_name(material, name), part + 1),
        };
        let folder = format!("textures/{set}/{}", channel_name(texture));
        if !known.insert(folder.clone()) {
            return Err(Error::internal(format!("two channels would be stored in {folder}")));
        }
        folders.push(folder);
    }
    Ok(folders)
}

/// Characters of a material's name that its folder has.
const NAME_CHARS: usize = 40;

/// The material's number, which is unique, and what of its name every file system takes.
fn set_name(material: usize, name: &str) -> String {
    let mut safe = String::new();
    for character in name.chars() {
        if character.is_ascii_alphanumeric() || character == '-' {
            safe.push(character);
        } else if !safe.is_empty() && !safe.ends_with('_') {
            safe.push('_');
        }
        if safe.len() == NAME_CHARS {
            break;
        }
    }
    match safe.trim_end_matches('_') {
        "" => format!("{material:02}"),
        safe => format!("{material:02}_{safe}"),
    }
}

/// The slots that read the channel, as glTF names them without `Texture`.
fn channel_name(texture: &FinishedTexture) -> String {
    let slots = texture.slots.iter().map(|slot| slot.gltf_name().trim_end_matches("Texture"));
    slots.collect::<Vec<_>>().join("-")
}
