//! Levels in blocks, and what that does to edges: the blocks are decoded as a GPU does it, and `measure`
//! judges what comes out as it judges any conversion. Then they are fitted again, and whatever makes the
//! mean jump of a level less is kept.

mod shared;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::asset::Asset;
use crate::error::Result;
use crate::finished::{Finished, FinishedTexture};
use crate::image::{Image, Transfer};
use crate::math::transfer::linear_to_srgb;
use crate::measure::{self, ChannelReport, CompressedLevel, CompressionReport, Figures};
use crate::watch::{Stage, Watch, check};
use crate::write::textures::{BlockFormat, Blocks, Compressed, refit};

use super::options::Options;
use shared::Edges;

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
    let mut compressed = Compressed::of(finished, &options.compress, watch)?;
    watch.step(None);
    let plain = judged(asset, finished, &compressed, watch)?;
    watch.stage(Stage::Write);
    watch.step(Some("refit"));
    let mut refits = refits(asset, finished, &compressed, watch)?;
    watch.step(None);
    refits.iter_mut().for_each(|(at, blocks)| compressed.swap(*at, blocks));
    let fitted = judged(asset, finished, &compressed, watch)?;
    let mean = |channels: &[ChannelReport], at: [usize; 2]| seams(channels, at).map(|figures| figures.mean);
    refits.retain_mut(|(at, blocks)| {
        let is_better = mean(&fitted, *at) < mean(&plain, *at);
        if !is_better {
            compressed.swap(*at, blocks);
        }
        is_better
    });
    let decoded = compressed.decoded(finished)?;
    let mut reports = Vec::new();
    for (texture, channel) in before.iter().enumerate() {
        let level = |level: usize| {
            let (at, blocks) = ([texture, level], compressed.level(texture, level)?);
            let is_refitted = refits.iter().any(|(refitted, _)| *refitted == at);
            Some(CompressedLevel {
                level: level as u32,
                format: blocks.format.name().to_owned(),
                bytes: blocks.bytes(),
                psnr_db: psnr_db(
                    [&finished.textures[texture], &decoded.textures[texture]],
                    level,
                    blocks.format,
                ),
                seams_before: seams(before, at),
                seams_unfitted: seams(&plain, at),
                seams: seams(if is_refitted { &fitted } else { &plain }, at),
                is_refitted,
            })
        };
        let levels: Vec<_> = (0..channel.levels.len()).filter_map(level).collect();
        if !levels.is_empty() {
            reports.push(CompressionReport {
                material: channel.material,
                material_name: channel.material_name.clone(),
                slots: channel.slots.clone(),
                unit: channel.unit,
                levels,
            });
        }
    }
    Ok(Some(Compression { compressed, reports }))
}

fn seams(channels: &[ChannelReport], [texture, level]: [usize; 2]) -> Option<Figures> {
    channels.get(texture)?.levels.get(level)?.seams
}

/// The channels of what a GPU reads.
fn judged(
    asset: &Asset,
    finished: &Finished,
    compressed: &Compressed,
    watch: &dyn Watch,
) -> Result<Vec<ChannelReport>> {
    watch.stage(Stage::Measure);
    let decoded = compressed.decoded(finished)?;
    Ok(measure::converted_file(asset, &decoded, watch)?.channels)
}

/// Blocks that differ less across edges, by texture and level.
fn refits(
    asset: &Asset,
    finished: &Finished,
    compressed: &Compressed,
    watch: &dyn Watch,
) -> Result<Vec<([usize; 2], Blocks)>> {
    let mut refits = Vec::new();
    for (texture, source) in finished.textures.iter().enumerate() {
        let edges = Edges::of(asset, finished, texture);
        let of_level = |(level, image): (usize, &Image)| {
            check(watch)?;
            let Some(blocks) = compressed.level(texture, level) else { return Ok(None) };
            let groups = edges.groups(level, image.size());
            let refitted = refit(finished, [texture, level], blocks, &groups)?;
            Ok(refitted.map(|blocks| ([texture, level], blocks)))
        };
        let levels: Result<Vec<_>> = source.levels.par_iter().enumerate().map(of_level).collect();
        refits.extend(levels?.into_iter().flatten());
    }
    Ok(refits)
}

/// Decibels that stand for "no difference".
const PSNR_MOST_DB: f64 = 99.0;

/// Of one level's texels in two versions of a texture: 10 log10(255² / mean square), codes.
fn psnr_db([before, after]: [&FinishedTexture; 2], level: usize, format: BlockFormat) -> f64 {
    let image = &before.levels[level];
    let stored: &[usize] = match image.components {
        1 => &[0],
        2 => &[0, 3],
        3 if format == BlockFormat::Bc5 => &[0, 1],
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
