//! A mutator that knows Ptex files: it changes what is under zlib and packs it again, as long as the file says it is.
//!
//! Of a file's levels it keeps level 0, which is all that is read.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use libfuzzer_sys::fuzzer_mutate;

/// Where a header has what decides how long all else is: the kind of mesh, the kind of numbers, the count of channels and that of
/// faces.
const MESH_AT: usize = 8;
const NUMBERS_AT: usize = 12;
const CHANNELS_AT: usize = 20;
const COUNT_AT: usize = 24;
/// The sizes of the extended header, the faces, the constant texels, the list of levels, and the levels.
const EXTENDED_AT: usize = 28;
const FACES_AT: usize = 32;
const CONSTANTS_AT: usize = 36;
const LEVELS_AT: usize = 40;
const DATA_AT: usize = 48;
const HEADER_BYTES: usize = 64;
const LEVEL_BYTES: usize = 16;
const FACE_BYTES: usize = 20;
/// Of an entry in a list; the two bits above say how data is packed.
const SIZE_BITS: u32 = 30;
const CONSTANT: u32 = 0;
const TILED: u32 = 3;
/// What is longer is left as it is.
const PART_BYTES_MOST: usize = 1 << 16;
const FACES_MOST: usize = 64;
const TILES_MOST: usize = 256;

/// Changes a file in place and says how long it is then: a quarter of the time any of its bytes.
pub fn mutate(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    let changed = if seed.is_multiple_of(4) { None } else { changed(&data[..size], seed / 4) };
    let Some(changed) = changed.filter(|changed| changed.len() <= max_size) else {
        return fuzzer_mutate(data, size, max_size);
    };
    data[..changed.len()].copy_from_slice(&changed);
    changed.len()
}

pub fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn changed(file: &[u8], seed: u32) -> Option<Vec<u8>> {
    let mut file = Unpacked::new(file)?;
    let (part, seed) = (seed % 8, seed / 8);
    let (is_fitted, seed) = (!seed.is_multiple_of(4), seed / 4);
    match part {
        0 | 1 => change(&mut file.faces),
        2 => change(&mut file.constants),
        3 => change(&mut file.header[MESH_AT..EXTENDED_AT]),
        _ => file.level.change(seed),
    }
    if is_fitted {
        file.fit();
    }
    file.pack()
}

fn change(bytes: &mut [u8]) {
    let length = bytes.len();
    if length > 0 {
        fuzzer_mutate(bytes, length, length);
    }
}

/// Data of faces or tiles.
struct Blocks {
    entries: Vec<u32>,
    data: Vec<Vec<u8>>,
}

/// A face in tiles, with base 2 logarithms of their sides.
struct Tiled {
    log2: [u8; 2],
    blocks: Blocks,
}

struct Unpacked {
    header: Vec<u8>,
    extended: Vec<u8>,
    faces: Vec<u8>,
    constants: Vec<u8>,
    level: Blocks,
    /// Whatever follows level 0.
    rest: Vec<u8>,
}

impl Blocks {
    fn new(list: &[u8], mut data: &[u8]) -> Option<(Self, Vec<u8>)> {
        let list = unzipped(list)?;
        let entries: Vec<u32> = list.chunks_exact(4).filter_map(|four| word(four, 0)).collect();
        let of = |entry: &u32| cut(&mut data, *entry & ((1 << SIZE_BITS) - 1));
        let blocks = entries.iter().map(of).collect::<Option<_>>()?;
        Some((Self { entries, data: blocks }, data.to_vec()))
    }

    /// The list, and what it lists.
    fn pack(&self) -> Option<[Vec<u8>; 2]> {
        let sized = |(entry, data): (&u32, &Vec<u8>)| entry >> SIZE_BITS << SIZE_BITS | data.len() as u32;
        let list: Vec<u8> =
            self.entries.iter().zip(&self.data).flat_map(|of| sized(of).to_le_bytes()).collect();
        Some([zipped(&list)?, self.data.concat()])
    }

    /// Changes how one is packed, or what it holds.
    fn change(&mut self, seed: u32) {
        if self.data.is_empty() {
            return;
        }
        let (number, seed) = (seed as usize % self.data.len(), seed / self.data.len() as u32);
        let (entry, data) = (&mut self.entries[number], &mut self.data[number]);
        if seed.is_multiple_of(8) {
            *entry ^= (seed / 8 % 3 + 1) << SIZE_BITS;
            return;
        }
        let changed = match *entry >> SIZE_BITS {
            CONSTANT => None,
            TILED => Tiled::new(data).and_then(|mut tiled| {
                match seed / 8 % 4 {
                    0 => change(&mut tiled.log2),
                    _ => tiled.blocks.change(seed / 32),
                }
                tiled.pack()
            }),
            _ => unzipped(data).and_then(|mut texels| {
                change(&mut texels);
                zipped(&texels)
            }),
        };
        match changed {
            Some(changed) => *data = changed,
            None => change(data),
        }
    }

    fn fit(&mut self, sides: &[[u8; 2]], texel_bytes: usize) {
        self.entries.resize(sides.len(), 1 << SIZE_BITS);
        self.data.resize(sides.len(), Vec::new());
        for ((entry, data), &log2) in self.entries.iter().zip(&mut self.data).zip(sides) {
            if let Some(fitted) = fitted(entry >> SIZE_BITS, data, log2, texel_bytes) {
                *data = fitted;
            }
        }
    }
}

/// Data as long as a face or tile needs it.
fn fitted(packing: u32, data: &[u8], log2: [u8; 2], texel_bytes: usize) -> Option<Vec<u8>> {
    if packing == CONSTANT {
        return Some(resized(data.to_vec(), texel_bytes));
    }
    if packing == TILED {
        let mut tiled = Tiled::new(data)?;
        tiled.log2 = [0, 1].map(|axis| tiled.log2[axis].min(log2[axis]));
        let count = count([0, 1].map(|axis| log2[axis] - tiled.log2[axis]))?;
        tiled.blocks.fit(&vec![tiled.log2; Some(count).filter(|&count| count <= TILES_MOST)?], texel_bytes);
        return tiled.pack();
    }
    let bytes = count(log2)?.checked_mul(texel_bytes).filter(|&bytes| bytes <= PART_BYTES_MOST)?;
    zipped(&resized(unzipped(data).unwrap_or_default(), bytes))
}

/// Of a grid with these base 2 logarithms of its sides.
fn count(log2: [u8; 2]) -> Option<usize> {
    1usize.checked_shl(log2.map(u32::from).iter().sum())
}

impl Tiled {
    fn new(face: &[u8]) -> Option<Self> {
        let (&log2, mut rest) = face.split_first_chunk::<2>()?;
        let list_bytes = word(rest, 0)?;
        rest = &rest[4..];
        let list = cut(&mut rest, list_bytes)?;
        Some(Self { log2, blocks: Blocks::new(&list, rest)?.0 })
    }

    fn pack(&self) -> Option<Vec<u8>> {
        let [list, data] = self.blocks.pack()?;
        Some([&self.log2[..], &(list.len() as u32).to_le_bytes(), &list, &data].concat())
    }
}

impl Unpacked {
    fn new(file: &[u8]) -> Option<Self> {
        let (header, mut rest) = file.split_at_checked(HEADER_BYTES)?;
        let mut block = |size_at: usize| cut(&mut rest, word(header, size_at)?);
        let [extended, faces, constants, levels] =
            [block(EXTENDED_AT)?, block(FACES_AT)?, block(CONSTANTS_AT)?, block(LEVELS_AT)?];
        let list = cut(&mut rest, word(&levels, 8)?)?;
        let (level, rest) = Blocks::new(&list, rest)?;
        Some(Self {
            header: header.to_vec(),
            extended,
            faces: unzipped(&faces)?,
            constants: unzipped(&constants)?,
            level,
            rest,
        })
    }

    /// Gives every part the length that the header and the faces say.
    fn fit(&mut self) {
        let half = |at: usize| usize::from(u16::from_le_bytes([self.header[at], self.header[at + 1]]));
        let number_bytes = match half(NUMBERS_AT) {
            0 => 1,
            1 | 2 => 2,
            _ => 4,
        };
        let texel_bytes = half(CHANNELS_AT) * number_bytes;
        let count = word(&self.header, COUNT_AT).map_or(usize::MAX, |count| count as usize);
        if count > FACES_MOST || count * texel_bytes > PART_BYTES_MOST {
            return;
        }
        self.faces.resize(count * FACE_BYTES, 0);
        self.constants.resize(count * texel_bytes, 0);
        let sides: Vec<[u8; 2]> =
            self.faces.chunks_exact(FACE_BYTES).map(|face| [face[0], face[1]]).collect();
        self.level.fit(&sides, texel_bytes);
    }

    fn pack(&self) -> Option<Vec<u8>> {
        let [faces, constants] = [zipped(&self.faces)?, zipped(&self.constants)?];
        let [list, data] = self.level.pack()?;
        let level_bytes = ((list.len() + data.len()) as u64).to_le_bytes();
        let mut header = self.header.clone();
        for (at, size) in [(FACES_AT, faces.len()), (CONSTANTS_AT, constants.len()), (LEVELS_AT, LEVEL_BYTES)]
        {
            header[at..at + 4].copy_from_slice(&(size as u32).to_le_bytes());
        }
        header[DATA_AT..DATA_AT + 8].copy_from_slice(&level_bytes);
        let list_bytes = (list.len() as u32).to_le_bytes();
        let level = [&level_bytes[..], &list_bytes, &self.header[COUNT_AT..COUNT_AT + 4]].concat();
        Some(
            [&header, &self.extended, &faces, &constants, &level, &list, &data, &self.rest]
                .map(Vec::as_slice)
                .concat(),
        )
    }
}

/// Cuts bytes off the front.
fn cut(rest: &mut &[u8], bytes: u32) -> Option<Vec<u8>> {
    let (taken, behind) = rest.split_at_checked(bytes as usize)?;
    *rest = behind;
    Some(taken.to_vec())
}

fn resized(mut bytes: Vec<u8>, length: usize) -> Vec<u8> {
    bytes.resize(length, 0);
    bytes
}

fn unzipped(packed: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    ZlibDecoder::new(packed).take(PART_BYTES_MOST as u64).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

fn zipped(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(bytes).ok()?;
    packed.finish().ok()
}
