//! OpenEXR images of attributes: numbers of any size, gray or with up to four components.
//!
//! Format: <https://openexr.com/en/latest/OpenEXRFileLayout.html>. Blocks are unpacked by the `exr` library, after sizes
//! were checked; what a block says of its place is checked here.

mod blocks;

use std::io::Cursor;

use exr::block::chunk::CompressedBlock;
use exr::block::reader::ChunksReader;
use exr::block::{self, UncompressedBlock};
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{Vec2, f16};

use super::Limits;
use super::images::check_size;
use super::text::quoted;
use crate::asset::VALUE_SCALES;
use crate::error::{Error, Result};
use crate::image::{Image, Pixels, Values};

/// A tile may always have as many texels, however small the image is.
const TILE_TEXELS_LEAST: usize = 1 << 18;
const MARK: [u8; 4] = [0x76, 0x2F, 0x31, 0x01];

/// Components by the names of channels as files have them, which is in alphabetical order; and where each goes.
const CHANNELS: [(&[&str], &[usize]); 6] = [
    (&["A", "Y"], &[1, 0]),
    (&["G", "R"], &[1, 0]),
    (&["X", "Y"], &[0, 1]),
    (&["B", "G", "R"], &[2, 1, 0]),
    (&["X", "Y", "Z"], &[0, 1, 2]),
    (&["A", "B", "G", "R"], &[3, 2, 1, 0]),
];

pub(super) fn is_openexr(bytes: &[u8]) -> bool {
    bytes.starts_with(&MARK)
}

/// The size of a file that [`decode`] takes, within the limits.
///
/// # Errors
/// `InvalidModel` where the file is broken, or has more than one flat image with 1 to 4 channels of half or float numbers
/// that fill its window; `ImageTooLarge`.
pub(super) fn size(bytes: &[u8], limits: &Limits, pointer: &str) -> Result<[u32; 2]> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    let [header] = meta.headers.as_slice() else {
        return Err(Error::invalid(format!(
            "the OpenEXR file has {} parts; give it one",
            meta.headers.len()
        )));
    };
    let whole = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    let Vec2(width, height) = header.layer_size;
    let size = [whole(width), whole(height)];
    check_size(size, limits, pointer)?;
    check(header)?;
    Ok(size)
}

fn broken(error: exr::error::Error) -> Error {
    Error::invalid(format!("the OpenEXR file cannot be decoded: {error}"))
}

fn check(header: &Header) -> Result<()> {
    if header.deep {
        return Err(Error::invalid("the OpenEXR file holds deep data; flat images are read"));
    }
    let window = header.shared_attributes.display_window;
    if window.size != header.layer_size || window.position != header.own_attributes.layer_position {
        return Err(Error::invalid(
            "the OpenEXR file's data window is not its display window, so texture coordinates have no certain meaning; crop or \
             fill it",
        ));
    }
    if let BlockDescription::Tiles(tiles) = header.blocks {
        // Memory for a tile is taken before it is clipped to the image.
        let Vec2(width, height) = tiles.tile_size;
        if width.saturating_mul(height) > header.layer_size.area().max(TILE_TEXELS_LEAST) {
            return Err(Error::invalid(format!(
                "the OpenEXR file has tiles of {width}x{height}, which is more than its image; write it with smaller ones"
            )));
        }
    }
    let channels = &header.channels.list;
    placement(&channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>())?;
    for channel in channels {
        let name = quoted(&channel.name.to_string());
        if channel.sample_type == SampleType::U32 {
            return Err(Error::invalid(format!(
                "channel {name} holds whole numbers; half and float are read"
            )));
        }
        if channel.sampling != Vec2(1, 1) {
            return Err(Error::invalid(format!(
                "channel {name} is subsampled; give it a value for each pixel"
            )));
        }
    }
    Ok(())
}

/// Where the components of channels go.
fn placement(names: &[String]) -> Result<&'static [usize]> {
    if names.len() == 1 {
        return Ok(&[0]);
    }
    let known = CHANNELS.iter().find(|(known, _)| known.iter().eq(names));
    known.map(|(_, places)| *places).ok_or_else(|| {
        let listed: Vec<String> = names.iter().take(8).map(|name| quoted(name)).collect();
        Error::invalid(format!(
            "the OpenEXR file has {} channels ({}); read are one of any name, Y A, R G, X Y, R G B, X Y Z and R G B A",
            names.len(),
            listed.join(", ")
        ))
    })
}

/// Decodes a file whose [`size`] was found. Two components that are no gray with alpha get a blue of 0.
///
/// # Errors
/// `InvalidModel` where the file is broken or holds what is not a number within ±2^100.
pub(super) fn decode(bytes: &[u8]) -> Result<Image> {
    let mut chunks =
        block::read(Cursor::new(bytes), false).and_then(|reader| reader.all_chunks(false)).map_err(broken)?;
    let meta = chunks.meta_data().clone();
    let [header] = meta.headers.as_slice() else { return Err(Error::internal("an unchecked OpenEXR file")) };
    let mut canvas = Canvas::new(header)?;
    while let Some(chunk) = chunks.read_next_chunk() {
        let chunk = chunk.map_err(broken)?;
        // Whatever the table of chunks says, coarser levels are not wanted.
        let is_finest = match &chunk.compressed_block {
            CompressedBlock::Tile(tile) => tile.coordinates.is_largest_resolution_level(),
            _ => true,
        };
        if is_finest {
            blocks::check(&chunk.compressed_block, header)?;
            canvas.put(UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(broken)?)?;
        }
    }
    canvas.image()
}

/// Numbers on their way to an image.
struct Canvas<'a> {
    header: &'a Header,
    places: &'static [usize],
    components: usize,
    values: Vec<f32>,
    /// By texel: how many of its channels have come.
    counts: Vec<u8>,
}

impl<'a> Canvas<'a> {
    fn new(header: &'a Header) -> Result<Self> {
        let names: Vec<String> =
            header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
        let places = placement(&names)?;
        let is_pair = places.len() == 2 && names != ["A", "Y"];
        let components = if is_pair { 3 } else { places.len() };
        let texel_count = header.layer_size.area();
        Ok(Self {
            header,
            places,
            components,
            values: vec![0.0; texel_count * components],
            counts: vec![0; texel_count],
        })
    }

    /// Copies a block whose place and length nobody has checked.
    fn put(&mut self, block: UncompressedBlock) -> Result<()> {
        let lie = || Error::invalid("the OpenEXR file has a block that is not within the image");
        let (Vec2(x, y), Vec2(width, height)) = (block.index.pixel_position, block.index.pixel_size);
        let Vec2(columns, rows) = self.header.layer_size;
        let is_inside =
            |from: usize, size: usize, end: usize| from.checked_add(size).is_some_and(|to| to <= end);
        let channels = &self.header.channels.list;
        let texel_bytes: usize = channels.iter().map(|channel| channel.sample_type.bytes_per_sample()).sum();
        if !is_inside(x, width, columns)
            || !is_inside(y, height, rows)
            || block.data.len() != width * height * texel_bytes
        {
            return Err(lie());
        }
        let mut rest = block.data.as_slice();
        for row in y..y + height {
            for (channel, place) in channels.iter().zip(self.places) {
                let sample_bytes = channel.sample_type.bytes_per_sample();
                let (line, after) = rest.split_at(width * sample_bytes);
                rest = after;
                for (texel, sample) in (row * columns + x..).zip(line.chunks_exact(sample_bytes)) {
                    // In the machine's own order of bytes.
                    self.values[texel * self.components + place] = match *sample {
                        [a, b] => f16::from_ne_bytes([a, b]).to_f32(),
                        [a, b, c, d] => f32::from_ne_bytes([a, b, c, d]),
                        _ => return Err(lie()),
                    };
                    self.counts[texel] = self.counts[texel].saturating_add(1);
                }
            }
        }
        Ok(())
    }

    fn image(mut self) -> Result<Image> {
        let Vec2(width, height) = self.header.layer_size;
        if let Some(texel) = self.counts.iter().position(|count| usize::from(*count) != self.places.len()) {
            return Err(Error::invalid(format!(
                "the OpenEXR file has not exactly one value for each pixel: row {} from the top has others",
                texel / width.max(1)
            )));
        }
        let scale = scale_of(&self.values, width * self.components)?;
        self.values.iter_mut().for_each(|value| *value /= scale);
        let values = Values { values: self.values, bits: 16, texels_per_painted: 1, scale: Some(scale) };
        let side =
            |side: usize| u32::try_from(side).map_err(|_| Error::invalid("the OpenEXR file is too large"));
        Ok(Image {
            width: side(width)?,
            height: side(height)?,
            components: self.components as u8,
            pixels: Pixels::F32(values),
        })
    }
}

/// The least power of two that is not under any number's size, or under 2^-100.
fn scale_of(values: &[f32], row_count: usize) -> Result<f32> {
    let [least, most] = VALUE_SCALES;
    let is_sound = |value: &f32| value.abs() <= most;
    if let Some(place) = values.iter().position(|value| !is_sound(value)) {
        return Err(Error::invalid(format!(
            "the OpenEXR file holds {} in row {} from the top; allowed are numbers within ±{most:e}",
            values[place],
            place / row_count.max(1)
        )));
    }
    let largest = values.iter().fold(least, |largest, value| largest.max(value.abs()));
    // A float's lower 23 bits are 0 where it is a power of two; its exponent is above them.
    let power = f32::from_bits(largest.to_bits() & 0xFF80_0000);
    Ok(if values.iter().all(|value| *value == 0.0) {
        1.0
    } else if power == largest {
        power
    } else {
        (2.0 * power).min(most)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_is_the_least_power_of_two_over_all_numbers() {
        let [least, most] = VALUE_SCALES;
        let cases: [(&[f32], f32); 7] = [
            (&[0.0, 0.0], 1.0),
            (&[0.3, -0.2], 0.5),
            (&[0.5, 0.2], 0.5),
            (&[-64.1, 3.0], 128.0),
            (&[1e-38, 0.0], least),
            (&[most], most),
            (&[1.0], 1.0),
        ];
        for (values, scale) in cases {
            assert_eq!(scale_of(values, 1).unwrap(), scale, "{values:?}");
        }
        for bad in [f32::NAN, f32::INFINITY, 2e30] {
            let detail = scale_of(&[0.0, 1.0, bad], 2).unwrap_err().detail;
            assert!(detail.contains("in row 1 from the top"), "{detail}");
        }
    }
}
