//! One level as KTX2 (<https://registry.khronos.org/KTX/specs/2.0/ktxspec.v2.html>): one texture of one
//! level with a basic data format descriptor, its texels under Zstandard.
//!
//! Keys of our own, all text that ends in NUL as the format's are: `MCTlevel` is the level's number. A
//! level in a range of its own has the range's name as `MCTrange`; `scaled16` has `MCTscale` and `MCTbias`
//! too, one number for each stored component: `value = unorm · scale + bias`.

use ktx2::dfd::{Basic, Block};
use ktx2::{Header, Index, LevelIndex, SupercompressionScheme};

use crate::error::{Error, Result};
use crate::image::Transfer;

use super::Level;
use super::gpu::Texels;

const WRITER: &str = concat!("meshcolor ", env!("CARGO_PKG_VERSION"));
const ZSTD_LEVEL: i32 = 5;
/// Sections start at multiples of this.
const ALIGNMENT_BYTES: usize = 4;

/// The level with its texels as a GPU takes them.
///
/// # Errors
/// `Internal` where a section gets larger than the format allows.
pub fn file(level: &Level<'_>, texels: &Texels) -> Result<Vec<u8>> {
    let failed = |what: &dyn std::fmt::Display| Error::internal(format!("a KTX2 file: {what}"));
    let (mut basic, type_size) =
        Basic::from_format(texels.format).map_err(|error| failed(&format!("{error:?}")))?;
    if level.transfer == Transfer::Linear {
        // Data has no colors, so it has no primaries.
        basic.color_primaries = None;
    }
    let descriptor = descriptor(basic);
    let pairs = key_values(level, texels);
    let packed = zstd::bulk::compress(&texels.bytes, ZSTD_LEVEL).map_err(|error| failed(&error))?;

    let descriptor_at = Header::LENGTH + LevelIndex::LENGTH;
    let pairs_at = descriptor_at + descriptor.len();
    let data_at = pairs_at + pairs.len();
    let small = |bytes: usize| u32::try_from(bytes).map_err(|error| failed(&error));
    let header = Header {
        format: Some(texels.format),
        type_size,
        pixel_width: texels.size[0],
        pixel_height: texels.size[1],
        pixel_depth: 0,
        layer_count: 0,
        face_count: 1,
        level_count: 1,
        supercompression_scheme: Some(SupercompressionScheme::Zstandard),
        index: Index {
            dfd_byte_offset: small(descriptor_at)?,
            dfd_byte_length: small(descriptor.len())?,
            kvd_byte_offset: small(pairs_at)?,
            kvd_byte_length: small(pairs.len())?,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let index = LevelIndex {
        byte_offset: data_at as u64,
        byte_length: packed.len() as u64,
        uncompressed_byte_length: texels.bytes.len() as u64,
    };
    Ok([&header.as_bytes()[..], &index.as_bytes(), &descriptor, &pairs, &packed].concat())
}

/// The section with its own length in front.
fn descriptor(basic: Basic) -> Vec<u8> {
    let block = Block::Basic(basic).to_vec();
    let length = size_of::<u32>() + block.len();
    [&(length as u32).to_le_bytes()[..], &block].concat()
}

/// In the order of the keys, as the format wants them.
fn key_values(level: &Level<'_>, texels: &Texels) -> Vec<u8> {
    let mut pairs = texels.keys.clone();
    pairs.push(("KTXorientation", "rd".to_owned()));
    pairs.push(("KTXwriter", WRITER.to_owned()));
    pairs.push(("MCTlevel", level.number.to_string()));
    pairs.extend(level.range.map(|range| ("MCTrange", range.name().to_owned())));
    pairs.sort_unstable();
    let mut section = Vec::new();
    for (key, value) in pairs {
        let length = key.len() + value.len() + 2;
        section.extend((length as u32).to_le_bytes());
        section.extend([key.as_bytes(), b"\0", value.as_bytes(), b"\0"].concat());
        section.resize(section.len().next_multiple_of(ALIGNMENT_BYTES), 0);
    }
    section
}
