//! What the fuzz targets share: whole files go through the public reader with small limits, and a mutator that knows GLB.

pub mod ptex;

pub use libfuzzer_sys;
use libfuzzer_sys::fuzzer_mutate;
use meshcolor::asset::Asset;
use meshcolor::error::ErrorCode;
use meshcolor::read::{self, AttributeSource, Limits, Upload};
use meshcolor::watch::Unwatched;

const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// Small enough that a sound reader stays far below the limit of memory.
pub fn limits() -> Limits {
    Limits {
        image_side: 4096,
        image_pixels: 1 << 20,
        job_pixels: 1 << 21,
        triangles: 20_000,
        vertices: 20_000,
        nodes: 1_000,
        json_bytes: 1 << 20,
        archive_bytes: 16 << 20,
        ..Limits::default()
    }
}

pub fn upload(file: &[u8]) -> Upload {
    Upload::single("model", file.to_vec())
}

/// Reads a file. An internal error is a fault of the reader like a panic.
pub fn read(file: &[u8]) -> Option<Asset> {
    read_with(&upload(file), &[])
}

/// The same with files beside the model.
pub fn read_with(upload: &Upload, channels: &[AttributeSource]) -> Option<Asset> {
    match read::read_with(upload, channels, &limits(), &Unwatched) {
        Ok(asset) => Some(asset),
        Err(error) => {
            assert_ne!(error.code, ErrorCode::Internal, "{error}");
            None
        }
    }
}

/// Changes a file in place and says how long it is then. Half of the time a GLB's binary chunk alone changes at its length,
/// since otherwise most inputs end in the JSON; a quarter of the time its JSON, with all lengths set right.
pub fn mutate(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    let Some((json, bin)) = split(&data[..size]) else { return fuzzer_mutate(data, size, max_size) };
    let changed = match seed % 4 {
        0 | 1 => glb(&json, &mutated(&bin, bin.len(), bin.len())),
        2 => {
            let room = max_size.saturating_sub(size).min(256);
            glb(&mutated(&json, json.len(), json.len() + room), &bin)
        }
        _ => return fuzzer_mutate(data, size, max_size),
    };
    if changed.len() > max_size {
        return fuzzer_mutate(data, size, max_size);
    }
    data[..changed.len()].copy_from_slice(&changed);
    changed.len()
}

/// At least `least` bytes, filled up with zeros.
fn mutated(part: &[u8], least: usize, most: usize) -> Vec<u8> {
    let mut bytes = part.to_vec();
    bytes.resize(most, 0);
    let length = fuzzer_mutate(&mut bytes, part.len(), most);
    bytes.truncate(length);
    bytes.resize(length.max(least), 0);
    bytes
}

/// JSON and binary chunk of a GLB that has both.
fn split(file: &[u8]) -> Option<(Vec<u8>, Vec<u8>)> {
    let chunk = |at: usize| {
        let length = file.get(at..at + 4)?;
        let length = u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let start = at + CHUNK_HEADER_BYTES;
        Some((file.get(start..start.checked_add(length)?)?.to_vec(), start + length))
    };
    file.starts_with(b"glTF").then_some(())?;
    let (json, end) = chunk(HEADER_BYTES)?;
    let (bin, _) = chunk(end)?;
    (!json.is_empty() && !bin.is_empty()).then_some((json, bin))
}

fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, pad, data) in [(b"JSON", b' ', json), (b"BIN\0", 0, bin)] {
        let length = data.len().next_multiple_of(4);
        body.extend((length as u32).to_le_bytes());
        body.extend_from_slice(kind);
        body.extend_from_slice(data);
        body.resize(body.len() + length - data.len(), pad);
    }
    let length = (HEADER_BYTES + body.len()) as u32;
    [b"glTF\x02\0\0\0", &length.to_le_bytes()[..], &body].concat()
}

/// A target that reads, and nothing else.
#[macro_export]
macro_rules! reads {
    () => {
        $crate::libfuzzer_sys::fuzz_target!(|file: &[u8]| drop($crate::read(file)));
        $crate::mutates!();
    };
}

#[macro_export]
macro_rules! mutates {
    () => {
        $crate::libfuzzer_sys::fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
            $crate::mutate(data, size, max_size, seed)
        });
    };
}
