//! Levels in blocks, and what that does to edges: the blocks are decoded as a GPU does it, and `measure`
//! judges what comes out as it judges any conversion.

use rayon::prelude::*;

use crate::asset::Asset;
use crate::error::Result;
use crate::finished::{Finished, FinishedTexture};
use crate::image::Transfer;
use crate::math::transfer::linear_to_srgb;
use crate::measure::{self, ChannelReport, CompressedLevel, CompressionReport};
use crate::watch::{Stage, Watch};
use crate::write::textures::{Blocks, Compressed};

use super::options::Options;

/// What `--compress` leaves.
pub struct Compression {
    pub compressed: Compressed,
    pub reports: Vec<CompressionReport>,
}

/// The levels in the formats asked for; `None` where nobody asked. `before` are the channels as measured
/// without blocks, in the order of the textures.
///
/// # Errors
/// `Canceled`; `Internal` where a library refuses a level.
pub fn compress(
    asset: &Asset,
    finished: &Finished,
    before: &[ChannelReport],
    options: &Options,
    watch: &dyn Watch,
) -> Result<Option<Compression>> {
    if options.compress.is_empty() {
        return Ok(None);
    }
    watch.stage(Stage::Write);
    watch.step(Some("compress"));
    let compressed = Compressed::of(finished, &options.compress, watch)?;
    let decoded = compressed.decoded(finished)?;
    watch.step(None);
    watch.stage(Stage::Measure);
    let after = measure::converted_file(asset, &decoded, watch)?.channels;
    let mut reports = Vec::new();
    for (number, (before, after)) in before.iter().zip(&after).enumerate() {
        let textures = [&finished.textures[number], &decoded.textures[number]];
        let level = |at: usize| {
            let blocks = compressed.level(number, at)?;
            let seams = [before, after].map(|channel| channel.levels.get(at).and_then(|level| level.seams));
            Some(described(blocks, at, textures, seams))
        };
        let levels: Vec<_> = (0..before.levels.len()).filter_map(level).collect();
        if !levels.is_empty() {
            reports.push(CompressionReport {
                material: before.material,
                material_name: before.material_name.clone(),
                slots: before.slots.clone(),
                unit: before.unit,
                levels,
            });
        }
    }
    Ok(Some(Compression { compressed, reports }))
}

fn described(
    blocks: &Blocks,
    level: usize,
    [before, after]: [&FinishedTexture; 2],
    [seams_before, seams]: [Option<measure::Figures>; 2],
) -> CompressedLevel {
    CompressedLevel {
        level: level as u32,
        format: blocks.format.name().to_owned(),
        bytes: blocks.bytes(),
        psnr_db: psnr_db(before, after, level),
        seams_before,
        seams,
    }
}

/// Decibels that stand for "no difference".
const PSNR_MOST_DB: f64 = 99.0;

/// Of one level's texels in two versions of a texture: 10 log10(255² / mean square), codes.
fn psnr_db(before: &FinishedTexture, after: &FinishedTexture, level: usize) -> f64 {
    let image = &before.levels[level];
    let stored: &[usize] = match image.components {
        1 => &[0],
        2 => &[0, 3],
        3 => &[0, 1, 2],
        _ => &[0, 1, 2, 3],
    };
    let of_row = |y: u32| -> f64 {
        let squares = (0..image.width).flat_map(|x| {
            let [before, after] = [before, after].map(|texture| codes(texture, level, x, y));
            stored.iter().map(move |&k| f64::from(before[k] - after[k]).powi(2))
        });
        squares.sum()
    };
    // Rows are summed in their order, whoever computed them.
    let rows: Vec<f64> = (0..image.height).into_par_iter().map(of_row).collect();
    let mean = rows.iter().sum::<f64>() / (image.texel_count() * stored.len()) as f64;
    (10.0 * (255.0 * 255.0 / mean).log10()).min(PSNR_MOST_DB)
}

/// A texel in 8-bit codes, not rounded: sRGB-encoded for color.
fn codes(texture: &FinishedTexture, level: usize, x: u32, y: u32) -> [f32; 4] {
    let image = &texture.levels[level];
    let values = match (texture.ranges.get(&level), texture.transfer) {
        (None, _) => image.normalized(x, y),
        (Some(range), Transfer::Linear) => range.texel(image, x, y).to_array(),
        (Some(range), Transfer::Srgb) => {
            let [red, green, blue, alpha] = range.texel(image, x, y).to_array();
            [linear_to_srgb(red), linear_to_srgb(green), linear_to_srgb(blue), alpha]
        }
    };
    values.map(|value| value * 255.0)
}
