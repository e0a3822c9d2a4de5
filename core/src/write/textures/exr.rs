//! One level as OpenEXR: its values as they enter a filter, linear light for color, whatever range they
//! are stored in. Gray is `Y`, color `R`, `G`, `B`; alpha is `A` and not multiplied into the others.
//! Normals are what glTF stores, in `R`, `G`, `B` around 1/2.
//!
//! Half floats give back every 8-bit code, and half-float levels are their own; what has 16-bit codes, or a scale for
//! numbers of any size, which multiplies them here, is stored in 32 bits. Compression is lossless.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SmallVec, WritableImage, f16,
};

use glam::Vec4;

use crate::error::{Error, Result};
use crate::image::{LevelRange, Pixels};

use super::Level;

/// # Errors
/// `Internal` where the library refuses the image, which none of ours is to blame for.
pub fn file(level: &Level<'_>) -> Result<Vec<u8>> {
    let values: Vec<Vec4> = level.values();
    let scale = level.value_scale.unwrap_or(1.0);
    // A scale may lift half floats over what they hold.
    let is_half = matches!(level.image.pixels, Pixels::U8(_))
        || level.range == Some(&LevelRange::Float16) && scale == 1.0;
    let channels: &[(&str, usize)] = match level.image.components {
        1 => &[("Y", 0)],
        2 => &[("Y", 0), ("A", 3)],
        3 => &[("R", 0), ("G", 1), ("B", 2)],
        _ => &[("R", 0), ("G", 1), ("B", 2), ("A", 3)],
    };
    let channel = |&(name, component): &(&str, usize)| {
        let plane = values.iter().map(|value| value[component] * scale);
        let samples = match is_half {
            true => FlatSamples::F16(plane.map(f16::from_f32).collect()),
            false => FlatSamples::F32(plane.collect()),
        };
        AnyChannel::new(name, samples)
    };
    let channels: SmallVec<_> = channels.iter().map(channel).collect();
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: exr::prelude::Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (level.image.width as usize, level.image.height as usize);
    let layer = Layer::new(size, LayerAttributes::default(), encoding, AnyChannels::sort(channels));
    let mut bytes = Vec::new();
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(Cursor::new(&mut bytes));
    written.map_err(|error| Error::internal(format!("a level could not be encoded as EXR: {error}")))?;
    Ok(bytes)
}
