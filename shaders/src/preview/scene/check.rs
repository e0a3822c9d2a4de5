//! One look at every index of the finished conversion before anything is drawn by it.

use meshcolor::asset::Asset;
use meshcolor::finished::{Finished, FinishedPrimitive, faces_of};
use meshcolor::image::{Image, Pixels};

use crate::preview::PreviewError;

/// # Errors
/// `Inconsistent`, naming the first element that points past the asset or lacks its images.
pub fn check(asset: &Asset, finished: &Finished) -> Result<(), PreviewError> {
    for (number, texture) in finished.textures.iter().enumerate() {
        let is_known = |&material: &usize| material < asset.materials.len();
        ensure(texture.materials.iter().all(is_known), || format!("material of texture {number}"))?;
        ensure(!texture.levels.is_empty(), || format!("levels of texture {number}"))?;
        for (level, image) in texture.levels.iter().enumerate() {
            ensure(is_whole(image), || format!("level {level} of texture {number}"))?;
        }
        let is_deep = |level: &usize| {
            texture.levels.get(*level).is_some_and(|image| matches!(image.pixels, Pixels::U16(_)))
        };
        ensure(texture.ranges.keys().all(is_deep), || format!("ranges of texture {number}"))?;
    }
    for (number, image) in asset.images.iter().enumerate() {
        ensure(is_whole(image), || format!("source image {number}"))?;
    }
    for (number, primitive) in finished.primitives.iter().enumerate() {
        check_primitive(asset, primitive).map_err(|what| inconsistent(format!("{what} {number}")))?;
    }
    finished.check().map_err(|error| inconsistent(error.to_string()))?;
    Ok(())
}

fn check_primitive(asset: &Asset, finished: &FinishedPrimitive) -> Result<(), &'static str> {
    let mesh = asset.meshes.get(finished.mesh).ok_or("mesh of converted primitive")?;
    let primitive = mesh.primitives.get(finished.primitive).ok_or("place of converted primitive")?;
    let vertex_count = primitive.positions.len();
    if finished.triangles.iter().flat_map(|t| t.vertices).any(|v| v as usize >= vertex_count) {
        return Err("a vertex of converted primitive");
    }
    if asset.materials.get(finished.material).is_none() {
        return Err("material of converted primitive");
    }
    if faces_of(primitive, finished.triangles.iter().map(|t| t.vertices)).is_none() {
        return Err("a triangle of converted primitive");
    }
    if !finished.frames.is_empty() && finished.frames.len() != finished.triangles.len() {
        return Err("frames of converted primitive");
    }
    Ok(())
}

fn is_whole(image: &Image) -> bool {
    let code_count = match &image.pixels {
        Pixels::U8(codes) => codes.len(),
        Pixels::U16(codes) => codes.len(),
        Pixels::F32(of) => of.values.len(),
    };
    image.width > 0
        && image.height > 0
        && (1..=4).contains(&image.components)
        && code_count == image.texel_count() * image.components as usize
}

fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<(), PreviewError> {
    if holds { Ok(()) } else { Err(inconsistent(what())) }
}

fn inconsistent(what: String) -> PreviewError {
    PreviewError::Inconsistent(what)
}
