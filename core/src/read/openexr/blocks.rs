//! Packed blocks of OpenEXR, before the library unpacks them: whether they unpack to no more than a block can have. The library
//! finds out afterwards.

use std::io::Read;

use exr::block::chunk::CompressedBlock;
use exr::compression::Compression;
use exr::meta::header::Header;
use flate2::read::ZlibDecoder;

use super::broken;
use crate::error::{Error, Result};

#[cfg(test)]
mod tests;

/// A DWA block begins with eleven numbers of 64 bits (OpenEXR, `internal_dwa_compressor.h`). Five say how much its parts are
/// when they are unpacked, and four how long they are in the file.
const NUMBER_BYTES: usize = 8;
const NUMBER_COUNT: usize = 11;
const VERSION: usize = 0;
const UNKNOWN_BYTES: usize = 1;
const PACKED_BYTES: [usize; 3] = [2, 3, 4];
const RUNS_PACKED_BYTES: usize = 5;
const RUNS_BYTES: usize = 6;
const RUNS_UNPACKED_BYTES: usize = 7;
const AC_COUNT: usize = 8;
const DC_COUNT: usize = 9;
/// From this version on, rules about channels follow, behind their size in 16 bits, which counts itself.
const VERSION_WITH_RULES: u64 = 2;
/// Texels along a side of what a cosine transform takes at once.
const SIDE: usize = 8;

/// # Errors
/// `InvalidModel` where a block is to become more than its texels take.
pub fn check(block: &CompressedBlock, header: &Header) -> Result<()> {
    let packed = match block {
        CompressedBlock::Tile(tile) => &tile.compressed_pixels_le,
        CompressedBlock::ScanLine(lines) => &lines.compressed_pixels_le,
        _ => return Err(Error::invalid("the OpenEXR file holds deep data; flat images are read")),
    };
    let place = header.get_block_data_indices(block).map_err(broken)?;
    let size = header.get_absolute_block_pixel_coordinates(place).map_err(broken)?.size;
    let bytes = size.area() * header.channels.bytes_per_pixel;
    if packed.len() == bytes {
        // What did not become smaller stands there as it is.
        return Ok(());
    }
    match header.compression {
        Compression::RLE => check_runs(packed, bytes as u64),
        Compression::DWAA(_) | Compression::DWAB(_) => {
            let transform_count = size.0.div_ceil(SIDE) * size.1.div_ceil(SIDE) * header.channels.list.len();
            check_dwa(packed, bytes as u64, transform_count as u64)
        }
        _ => Ok(()),
    }
}

/// Runs are a byte to be repeated, behind a length from 0 on, or as many bytes as a negative length says.
fn check_runs(mut runs: &[u8], most: u64) -> Result<()> {
    let mut unpacked = 0;
    while let Some((&length, rest)) = runs.split_first() {
        let (taken, given) = match length as i8 {
            length @ 0.. => (1, length as u64 + 1),
            length => (length.unsigned_abs().into(), length.unsigned_abs().into()),
        };
        unpacked += given;
        runs = rest.get(taken..).unwrap_or_default();
    }
    fits("runs", unpacked, most)
}

fn check_dwa(packed: &[u8], bytes: u64, transform_count: u64) -> Result<()> {
    let Some((numbers, mut rest)) = packed.split_at_checked(NUMBER_COUNT * NUMBER_BYTES) else {
        return Err(Error::invalid("a block of the OpenEXR file is cut short"));
    };
    let numbers = numbers.as_chunks::<NUMBER_BYTES>().0;
    let number = |place: usize| u64::from_le_bytes(numbers[place]);
    fits("other numbers", number(UNKNOWN_BYTES), bytes)?;
    // A run of one byte takes two.
    fits("packed runs", number(RUNS_BYTES), 2 * bytes)?;
    fits("runs", number(RUNS_UNPACKED_BYTES), bytes)?;
    fits("AC coefficients", number(AC_COUNT), transform_count * (SIDE * SIDE) as u64)?;
    fits("DC coefficients", number(DC_COUNT), transform_count)?;
    if number(RUNS_UNPACKED_BYTES) == 0 {
        return Ok(());
    }
    let mut cut = |bytes: u64| {
        let split = usize::try_from(bytes).ok().and_then(|bytes| rest.split_at_checked(bytes));
        let (taken, behind) =
            split.ok_or_else(|| Error::invalid("a block of the OpenEXR file is cut short"))?;
        rest = behind;
        Ok::<_, Error>(taken)
    };
    if number(VERSION) >= VERSION_WITH_RULES {
        let size = cut(2)?.iter().rev().fold(0, |size, &byte| size << 8 | u64::from(byte));
        cut(size.saturating_sub(2))?;
    }
    for place in PACKED_BYTES {
        cut(number(place))?;
    }
    let mut runs = Vec::new();
    let packed_runs = ZlibDecoder::new(cut(number(RUNS_PACKED_BYTES))?);
    // What is no zlib stream is the library's to refuse; so is what does not have the announced length.
    let _ = packed_runs.take(number(RUNS_BYTES)).read_to_end(&mut runs);
    check_runs(&runs, number(RUNS_UNPACKED_BYTES))
}

fn fits(what: &str, announced: u64, most: u64) -> Result<()> {
    if announced <= most {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "a block of the OpenEXR file is to unpack to {announced} of {what}, where it can have {most}"
    )))
}
