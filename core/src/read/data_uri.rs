//! `data:` URIs (RFC 2397): bytes inside the URI itself, as base64 or percent-encoded.

use super::uri::percent_decode;
use crate::error::{Error, Result};

/// The bytes of a `data:` URI with its media type.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct DataUri {
    pub media_type: String,
    pub bytes: Vec<u8>,
}

pub(super) fn is_data_uri(uri: &str) -> bool {
    uri.as_bytes().get(..5).is_some_and(|head| head.eq_ignore_ascii_case(b"data:"))
}

/// The caller has checked [`is_data_uri`] and that the budget bears `uri.len()` bytes.
pub(super) fn decode(uri: &str, pointer: &str) -> Result<DataUri> {
    let Some((head, data)) = uri.get(5..).and_then(|rest| rest.split_once(',')) else {
        return Err(Error::invalid("the data URI has no comma before its data").at(pointer));
    };
    let (media_type, base64) = match head.rsplit_once(';') {
        Some((media_type, last)) if last.eq_ignore_ascii_case("base64") => (media_type, true),
        _ => (head, false),
    };
    let media_type = media_type.split(';').next().unwrap_or_default().to_ascii_lowercase();
    let data = percent_decode(data.as_bytes());
    let bytes = if base64 {
        decode_base64(&data).ok_or_else(|| Error::invalid("the data URI is not valid base64").at(pointer))?
    } else {
        data
    };
    Ok(DataUri { media_type, bytes })
}

/// Standard and URL-safe alphabets, padding optional, white space skipped (files are wrapped by hand).
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let mut bits = 0u32;
    let mut bit_count = 0u32;
    let mut digit_count = 0usize;
    let mut padding_count = 0usize;
    for &c in text {
        let digit = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => {
                padding_count += 1;
                continue;
            }
            b' ' | b'\t' | b'\r' | b'\n' => continue,
            _ => return None,
        };
        if padding_count > 0 {
            return None;
        }
        digit_count += 1;
        bits = (bits << 6) | u32::from(digit);
        bit_count += 6;
        if bit_count >= 8 {
            bit_count -= 8;
            bytes.push((bits >> bit_count) as u8);
            bits &= (1 << bit_count) - 1;
        }
    }
    let complete = digit_count % 4 != 1 && bits == 0;
    let padded = padding_count == 0 || (digit_count + padding_count).is_multiple_of(4) && padding_count <= 2;
    (complete && padded).then_some(bytes)
}
