//! The GLB container (glTF 2.0, section 4.4): a header of 12 bytes, then chunks of length, type, bytes.
//!
//! Every length is held against the bytes that are there.

use crate::error::{Error, Result};

/// First bytes of a GLB file.
pub(super) const MAGIC: &[u8] = b"glTF";

const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// The two chunks that glTF knows.
#[derive(Debug)]
pub(super) struct Glb<'a> {
    pub json: &'a [u8],
    pub bin: Option<&'a [u8]>,
}

/// `bytes` begin with [`MAGIC`].
pub(super) fn split(bytes: &[u8]) -> Result<Glb<'_>> {
    let (Some(version), Some(declared)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(Error::invalid(format!("the GLB header has 12 bytes, the file {}", bytes.len())));
    };
    if version != 2 {
        return Err(Error::invalid(format!("the GLB is of version {version}; version 2 is read")));
    }
    if u64::from(declared) != bytes.len() as u64 {
        let detail = format!("the GLB header says {declared} bytes, the file has {}", bytes.len());
        return Err(Error::invalid(detail));
    }
    let (mut json, mut bin) = (None, None);
    let mut at = 12;
    let mut number = 0;
    while at < bytes.len() {
        let (kind, data) = chunk(bytes, at, number)?;
        let refused = |what: &str| Err(Error::invalid(format!("GLB chunk {number} {what}")));
        match (kind, number) {
            (CHUNK_JSON, 0) => json = Some(data),
            (_, 0) => return refused("is not the JSON chunk, which must come first"),
            (CHUNK_JSON, _) => return refused("is a second JSON chunk; there is exactly one, the first"),
            (CHUNK_BIN, 1) => bin = Some(data),
            (CHUNK_BIN, _) => return refused("is a BIN chunk, which may only stand second"),
            // Chunks of other types are extensions; the specification says to skip them.
            _ => {}
        }
        at += 8 + data.len();
        number += 1;
    }
    match json {
        Some(json) => Ok(Glb { json, bin }),
        None => Err(Error::invalid("the GLB has no JSON chunk")),
    }
}

fn chunk(bytes: &[u8], at: usize, number: usize) -> Result<(u32, &[u8])> {
    let (Some(length), Some(kind)) = (u32_at(bytes, at), u32_at(bytes, at + 4)) else {
        return Err(Error::invalid(format!("GLB chunk {number} is cut off inside its header")));
    };
    let left = bytes.len() - at - 8;
    let length = length as usize;
    if length > left {
        let detail = format!("GLB chunk {number} says {length} bytes, the file has {left} after its header");
        return Err(Error::invalid(detail));
    }
    if !length.is_multiple_of(4) {
        let detail = format!("GLB chunk {number} is {length} bytes long, which is not a multiple of 4");
        return Err(Error::invalid(detail));
    }
    Ok((kind, &bytes[at + 8..at + 8 + length]))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
}
