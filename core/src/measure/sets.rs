//! The channels of one material, each over all parts of it, and how many texels are theirs.

use crate::asset::Slot;
use crate::finished::{Finished, FinishedPrimitive, FinishedTexture, FinishedTriangle};
use crate::image::Image;

/// One channel of a material.
pub struct Channel<'a> {
    /// By part: their numbers in `Finished::textures`.
    pub numbers: Vec<usize>,
    /// By part; at least one.
    pub textures: Vec<&'a FinishedTexture>,
    /// Texels of level 0, all parts together; of textures that materials share the material's own share.
    pub texel_count: u64,
}

impl<'a> Channel<'a> {
    /// The channels of a material, in the order of its first part's textures.
    pub fn all(finished: &'a Finished, material: usize) -> Vec<Self> {
        let channel = |numbers: Vec<usize>| {
            let textures: Vec<_> = numbers.iter().map(|&number| &finished.textures[number]).collect();
            let texel_count = textures.iter().map(|texture| texel_count(finished, texture, material)).sum();
            Self { numbers, textures, texel_count }
        };
        finished.channels(material).into_iter().map(channel).collect()
    }

    pub fn slots(&self) -> &'a [Slot] {
        self.textures.first().map_or(&[], |texture| &texture.slots)
    }

    pub fn level_count(&self) -> usize {
        self.textures.iter().map(|texture| texture.levels.len()).min().unwrap_or(0)
    }

    /// Level 0 of the first part.
    pub fn finest(&self) -> Option<&'a Image> {
        self.textures.first()?.levels.first()
    }
}

/// A material's share of a texture's level 0: all of it, or as its triangles' areas in texels are to all that the
/// texture holds.
fn texel_count(finished: &Finished, texture: &FinishedTexture, material: usize) -> u64 {
    let all = texture.levels.first().map_or(0, Image::texel_count) as u64;
    if texture.materials.len() < 2 {
        return all;
    }
    let pieces = || finished.primitives.iter().filter(|piece| texture.is_of(piece.material, piece.part));
    let own = || pieces().filter(|piece| piece.material == material);
    let [own, total] = [own().map(area_texels).sum::<f64>(), pieces().map(area_texels).sum()];
    if total > 0.0 { (all as f64 * own / total).round() as u64 } else { all }
}

fn area_texels(piece: &FinishedPrimitive) -> f64 {
    let area = |triangle: &FinishedTriangle| -> f64 {
        let [a, b, c] = piece.coordinates.texels(triangle).map(|place| place.as_dvec2());
        0.5 * (b - a).perp_dot(c - a).abs()
    };
    piece.triangles.iter().map(area).filter(|area| area.is_finite()).sum()
}
