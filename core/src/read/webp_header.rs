//! Size and soundness of a WebP file from its chunks (RFC 9649). The decoder takes memory by what the picture's own
//! chunk says, so that is what counts, and it must agree with the canvas of an extended file.

use super::image_header::{Format, Header};
use crate::error::{Error, Result};

/// A side is stored in 14 bits.
const SIDE_MASK: u32 = 0x3FFF;

/// `None` where the file ends too early.
pub(super) fn read(bytes: &[u8]) -> Result<Option<Header>> {
    let Some(riff_bytes) = number(bytes, 4, 4) else { return Ok(None) };
    if riff_bytes as usize > bytes.len() - 8 {
        return Ok(None);
    }
    let (mut canvas, mut picture) = (None, None);
    let mut at = 12;
    while let (Some(name), Some(length)) = (bytes.get(at..at + 4), number(bytes, at + 4, 4)) {
        let start = at + 8;
        let Some(chunk) = start.checked_add(length as usize).and_then(|end| bytes.get(start..end)) else {
            return Ok(None);
        };
        let size = match name {
            b"VP8X" => {
                let canvas_size = number(chunk, 4, 3).zip(number(chunk, 7, 3));
                canvas = canvas.or(canvas_size.map(|(width, height)| (width + 1, height + 1)));
                None
            }
            b"VP8 " => Some(lossy(chunk)?),
            b"VP8L" => Some(lossless(chunk)?),
            b"ANIM" | b"ANMF" => return Err(Error::invalid("the WebP is animated; still pictures are read")),
            _ => None,
        };
        if let Some(size) = size
            && picture.replace(size).is_some()
        {
            return Err(Error::invalid("the WebP has more than one picture"));
        }
        // Chunks are padded to even lengths.
        at = start + (length as usize).next_multiple_of(2);
    }
    let Some(size) = picture else { return Err(Error::invalid("the WebP has no picture")) };
    if canvas.is_some_and(|canvas| canvas != size) {
        return Err(Error::invalid("the WebP's canvas and picture differ in size"));
    }
    Ok(Some(Header { format: Format::WebP, width: size.0, height: size.1 }))
}

/// A key frame begins with three bytes, a mark and both sides.
fn lossy(chunk: &[u8]) -> Result<(u32, u32)> {
    let sides = number(chunk, 6, 2).zip(number(chunk, 8, 2));
    match sides {
        Some((width, height)) if chunk.get(3..6) == Some(&[0x9D, 0x01, 0x2A]) => {
            Ok((width & SIDE_MASK, height & SIDE_MASK))
        }
        _ => Err(Error::invalid("the WebP's lossy picture has no sound header")),
    }
}

/// One byte as a mark, then both sides less one.
fn lossless(chunk: &[u8]) -> Result<(u32, u32)> {
    match number(chunk, 1, 4) {
        Some(bits) if chunk[0] == 0x2F => Ok(((bits & SIDE_MASK) + 1, ((bits >> 14) & SIDE_MASK) + 1)),
        _ => Err(Error::invalid("the WebP's lossless picture has no sound header")),
    }
}

fn number(bytes: &[u8], at: usize, length: usize) -> Option<u32> {
    let digits = bytes.get(at..at.checked_add(length)?)?;
    Some(digits.iter().rev().fold(0, |number, &digit| (number << 8) | u32::from(digit)))
}
