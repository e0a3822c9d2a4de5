//! Size and soundness of an image file from its outside: PNG's first chunk, JPEG's marker segments,
//! WebP's chunks, KTX2's header and what it points at.
//!
//! The JPEG walk goes to the end mark: the decoder fills up what a truncated file lacks, and says nothing.

use super::{basis, webp_header};
use crate::error::{Error, ErrorCode, Result};

/// Scans of a progressive JPEG. Encoders write about ten; each costs a pass over the whole picture, so a
/// short file of many would take hours.
const SCANS_MAX: usize = 100;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Png,
    Jpeg,
    WebP,
    Basis,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub format: Format,
    pub width: u32,
    pub height: u32,
}

impl Header {
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

pub(super) fn format(bytes: &[u8]) -> Option<Format> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        return Some(Format::Png);
    }
    if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        return Some(Format::WebP);
    }
    if bytes.starts_with(&basis::MARK) {
        return Some(Format::Basis);
    }
    bytes.starts_with(b"\xFF\xD8\xFF").then_some(Format::Jpeg)
}

pub(super) fn read(bytes: &[u8]) -> Result<Header> {
    let header = match format(bytes) {
        Some(Format::Png) => png(bytes),
        Some(Format::Jpeg) => jpeg(bytes)?,
        Some(Format::WebP) => webp_header::read(bytes)?,
        Some(Format::Basis) => Some(basis::header(bytes)?),
        None => {
            let detail = "the image is none of PNG, JPEG, WebP and KTX2 by its first bytes";
            return Err(Error::new(ErrorCode::UnsupportedMediaType, detail));
        }
    };
    match header {
        Some(header) if header.pixels() > 0 => Ok(header),
        Some(_) => Err(Error::invalid("the image has a side of 0 pixels")),
        None => Err(truncated()),
    }
}

pub(super) fn truncated() -> Error {
    Error::invalid("the image file is truncated")
}

fn png(bytes: &[u8]) -> Option<Header> {
    let number = |at: usize| {
        let four = bytes.get(at..at + 4)?;
        Some(u32::from_be_bytes([four[0], four[1], four[2], four[3]]))
    };
    if bytes.get(12..16)? != b"IHDR" {
        return None;
    }
    Some(Header { format: Format::Png, width: number(16)?, height: number(20)? })
}

/// Walks the marker segments (ITU T.81, annex B). `None` where the file ends too early.
fn jpeg(bytes: &[u8]) -> Result<Option<Header>> {
    let mut header = None;
    let mut scan_count = 0;
    let mut at = 2;
    loop {
        // Any number of fill bytes may stand before a marker.
        while bytes.get(at) == Some(&0xFF) && bytes.get(at + 1) == Some(&0xFF) {
            at += 1;
        }
        let (Some(0xFF), Some(&marker)) = (bytes.get(at), bytes.get(at + 1)) else {
            return if at + 1 < bytes.len() {
                Err(Error::invalid(format!("the JPEG has no marker at byte {at}")))
            } else {
                Ok(None)
            };
        };
        at += 2;
        match marker {
            0xD9 => {
                return match header {
                    Some(header) => Ok(Some(header)),
                    None => Err(Error::invalid("the JPEG has no frame")),
                };
            }
            0x01 | 0xD0..=0xD8 => continue,
            _ => {}
        }
        let Some(length) = bytes.get(at..at + 2).map(|l| usize::from(u16::from_be_bytes([l[0], l[1]])))
        else {
            return Ok(None);
        };
        let Some(segment) = bytes.get(at + 2..at + length.max(2)) else { return Ok(None) };
        if is_frame(marker) && header.is_none() {
            header = Some(frame(segment)?);
        }
        at += length.max(2);
        if marker == 0xDA {
            scan_count += 1;
            if scan_count > SCANS_MAX {
                return Err(Error::invalid(format!("the JPEG has more than {SCANS_MAX} scans")));
            }
            at += scan_length(&bytes[at..]);
        }
    }
}

/// Start-of-frame markers; C4, C8 and CC mean other things.
fn is_frame(marker: u8) -> bool {
    matches!(marker, 0xC0..=0xCF) && !matches!(marker, 0xC4 | 0xC8 | 0xCC)
}

fn frame(segment: &[u8]) -> Result<Header> {
    let [precision, h1, h0, w1, w0, components, ..] = segment else {
        return Err(Error::invalid("the JPEG's frame header is too short"));
    };
    if *precision != 8 {
        return Err(Error::invalid(format!("the JPEG has {precision} bits; JPEGs of 8 bits are read")));
    }
    if !matches!(components, 1 | 3) {
        let detail =
            format!("the JPEG has {components} components (CMYK has 4); gray and color (1 or 3) are read");
        return Err(Error::invalid(detail));
    }
    let number = |high: u8, low: u8| u32::from(u16::from_be_bytes([high, low]));
    Ok(Header { format: Format::Jpeg, width: number(*w1, *w0), height: number(*h1, *h0) })
}

/// Bytes of entropy-coded data: up to a marker that is neither a restart nor a stuffed FF.
fn scan_length(bytes: &[u8]) -> usize {
    let marker = |pair: &[u8]| pair[0] == 0xFF && !matches!(pair[1], 0x00 | 0xD0..=0xD7 | 0xFF);
    bytes.windows(2).position(marker).unwrap_or(bytes.len())
}
