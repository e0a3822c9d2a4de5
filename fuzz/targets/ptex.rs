//! A Ptex file beside a mesh that has as many faces of its kind.
#![no_main]

use std::collections::BTreeMap;
use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use meshcolor::read::{MemoryFiles, Upload};
use meshcolor_fuzz::libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

/// Where a header has the kind of mesh (1: quads), the count of faces, and the sizes of what follows it.
const QUADS_AT: usize = 8;
const COUNT_AT: usize = 24;
const EXTRA_AT: usize = 28;
const FACES_AT: usize = 32;
const CONSTANTS_AT: usize = 36;
const HEADER_BYTES: usize = 64;
/// Files that say more end in an error about their counts.
const FACES_MOST: u32 = 16;
/// Of what unpacks to more, the mutator lets go.
const PART_BYTES_MOST: u64 = 1 << 16;

fuzz_target!(|file: &[u8]| {
    let is_quads = word(file, QUADS_AT) != Some(0);
    let count = word(file, COUNT_AT).unwrap_or(1).clamp(1, FACES_MOST);
    let files = [("m.obj", strip(is_quads, count).into_bytes()), ("m.ptx", file.to_vec())];
    let files: BTreeMap<_, _> = files.map(|(name, bytes)| (name.to_owned(), bytes)).into();
    let upload = Upload { main: "m.obj".to_owned(), files: Box::new(MemoryFiles(files)) };
    meshcolor_fuzz::read_with(&upload, &[]);
});

// Half of the time what is under zlib: the faces, or their constant texels.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let changed = match seed % 4 {
        0 => repacked(&data[..size], FACES_AT, 0),
        1 => repacked(&data[..size], CONSTANTS_AT, word(data, FACES_AT).unwrap_or(0)),
        _ => None,
    };
    let Some(changed) = changed.filter(|changed| changed.len() <= max_size) else {
        return fuzzer_mutate(data, size, max_size);
    };
    data[..changed.len()].copy_from_slice(&changed);
    changed.len()
});

fn word(file: &[u8], at: usize) -> Option<u32> {
    let four = file.get(at..at + 4)?;
    Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
}

/// A row of faces in an OBJ file.
fn strip(is_quads: bool, count: u32) -> String {
    let mut text: String = (0..=count).map(|x| format!("v {x} 0 0\nv {x} 1 0\n")).collect();
    for face in 0..count {
        let [a, b, c, d] = [1, 3, 4, 2].map(|corner| corner + 2 * face);
        text += &if is_quads { format!("f {a} {b} {c} {d}\n") } else { format!("f {a} {b} {c}\n") };
    }
    text
}

/// The file with one part unpacked, changed and packed again, and its size in the header set right. `before` bytes
/// stand between what follows the header and the part.
fn repacked(file: &[u8], size_at: usize, before: u32) -> Option<Vec<u8>> {
    let start = HEADER_BYTES + (word(file, EXTRA_AT)?.checked_add(before)?) as usize;
    let end = start.checked_add(word(file, size_at)? as usize)?;
    let mut part = Vec::new();
    ZlibDecoder::new(file.get(start..end)?).take(PART_BYTES_MOST).read_to_end(&mut part).ok()?;
    let length = part.len();
    fuzzer_mutate(&mut part, length, length);
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(&part).ok()?;
    let packed = packed.finish().ok()?;
    let mut changed = [&file[..start], &packed, &file[end..]].concat();
    changed[size_at..size_at + 4].copy_from_slice(&(packed.len() as u32).to_le_bytes());
    Some(changed)
}
