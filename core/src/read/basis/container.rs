//! A KTX2 file (Khronos KTX 2.0) from its outside: header, index of levels, data format descriptor, key/value data, global
//! data of its supercompression. Every length and offset is held against the bytes that are there.
//!
//! The transcoder never sees the file: it trusts containers. It gets one made here, of nothing but what was checked.

use super::super::image_header::truncated;
use crate::error::{Error, Result};

pub(in super::super) const MARK: [u8; 12] = *b"\xABKTX 20\xBB\r\n\x1A\n";

/// Larger sides would leave the transcoder's numbers of blocks.
const SIDE_MAX: u32 = 1 << 15;
/// A pyramid over that side.
const LEVELS_MAX: u32 = 16;
const HEADER_BYTES: usize = 80;
const LEVEL_BYTES: usize = 24;
/// Of the global data: two counts and four lengths.
const GLOBAL_BYTES: usize = 20;
/// Of an image in the global data: flags, and offset and length of both slices.
const IMAGE_BYTES: usize = 20;
const IMAGE_IS_P_FRAME: u32 = 2;
/// A descriptor of one sample; a second one takes 16 more.
const DESCRIPTOR_BYTES: usize = 44;
const MODEL_ETC1S: u8 = 163;
const MODEL_UASTC: u8 = 166;
const FLAG_PREMULTIPLIED: u8 = 1;
const BLOCK_BYTES: u64 = 16;

/// Supercompression schemes.
const PLAIN: u32 = 0;
const BASIS_LZ: u32 = 1;
const ZSTANDARD: u32 = 2;

/// Level 0 of a picture that was found sound from its outside.
pub(super) struct Container<'a> {
    pub width: u32,
    pub height: u32,
    pub has_alpha: bool,
    payload: Payload<'a>,
}

enum Payload<'a> {
    Etc1s {
        /// Counts, lengths, and the image at level 0 with what follows the list of images.
        counts: &'a [u8],
        image: [u32; 4],
        codebooks: &'a [u8],
        level: &'a [u8],
    },
    Uastc {
        level: &'a [u8],
        is_packed: bool,
        block_bytes: usize,
    },
}

impl<'a> Container<'a> {
    pub fn read(file: &'a [u8]) -> Result<Self> {
        let bytes = Bytes(file);
        let [format, _, width, height, depth, layers, faces, levels, scheme] = bytes.words(MARK.len())?;
        if format != 0 {
            let detail =
                format!("the KTX2 has pixels of vkFormat {format}; Basis Universal (vkFormat 0) is read");
            return Err(Error::invalid(detail));
        }
        if depth != 0 || layers > 1 || faces != 1 {
            return Err(Error::invalid("the KTX2 is no single 2D picture"));
        }
        if width == 0 || height == 0 {
            return Err(Error::invalid("the image has a side of 0 pixels"));
        }
        if width.max(height) > SIDE_MAX || !(1..=LEVELS_MAX).contains(&levels) {
            let detail = format!(
                "the KTX2 is {width}x{height} with {levels} levels; read are sides of {SIDE_MAX} at most and 1 to \
                 {LEVELS_MAX} levels"
            );
            return Err(Error::invalid(detail));
        }
        bytes.part(HEADER_BYTES as u64, (LEVEL_BYTES * levels as usize) as u64)?;
        let [descriptor, descriptor_length, pairs, pairs_length] = bytes.words(48)?.map(u64::from);
        let (model, has_alpha) = channels(bytes.part(descriptor, descriptor_length)?)?;
        check_pairs(bytes.part(pairs, pairs_length)?)?;
        let level = bytes.part(bytes.long(80)?, bytes.long(88)?)?;
        let payload = match (model, scheme) {
            (MODEL_ETC1S, BASIS_LZ) => {
                let global = bytes.part(bytes.long(64)?, bytes.long(72)?)?;
                etc1s(global, level, levels as usize, has_alpha)?
            }
            (MODEL_UASTC, PLAIN | ZSTANDARD) => {
                let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4)) * BLOCK_BYTES;
                let is_packed = scheme == ZSTANDARD;
                let length = if is_packed { bytes.long(96)? } else { level.len() as u64 };
                if length != blocks {
                    let detail = format!(
                        "level 0 of the KTX2 has {length} bytes; {width}x{height} in UASTC are {blocks}"
                    );
                    return Err(Error::invalid(detail));
                }
                Payload::Uastc { level, is_packed, block_bytes: blocks as usize }
            }
            _ => {
                let detail = format!(
                    "the KTX2 has the color model {model} with supercompression {scheme}; read are ETC1S ({MODEL_ETC1S} \
                     with {BASIS_LZ}) and UASTC ({MODEL_UASTC} with {PLAIN} or {ZSTANDARD})"
                );
                return Err(Error::invalid(detail));
            }
        };
        Ok(Self { width, height, has_alpha, payload })
    }

    /// A KTX2 file of level 0 alone, without key/value data and Zstandard. It takes memory by the picture's size.
    pub fn alone(&self) -> Result<Vec<u8>> {
        let is_etc1s = matches!(self.payload, Payload::Etc1s { .. });
        let descriptor = self.descriptor(is_etc1s);
        let start = HEADER_BYTES + LEVEL_BYTES + descriptor.len();
        let (global_length, level_length) = match &self.payload {
            Payload::Etc1s { codebooks, level, .. } => {
                (GLOBAL_BYTES + IMAGE_BYTES + codebooks.len(), level.len())
            }
            Payload::Uastc { block_bytes, .. } => (0, *block_bytes),
        };
        let mut file = Vec::with_capacity(start + global_length + level_length);
        file.extend(MARK);
        let scheme = if is_etc1s { BASIS_LZ } else { PLAIN };
        let at = (HEADER_BYTES + LEVEL_BYTES) as u32;
        let words = [0, 1, self.width, self.height, 0, 0, 1, 1, scheme, at, descriptor.len() as u32, 0, 0];
        file.extend(words.iter().flat_map(|word: &u32| word.to_le_bytes()));
        let global_start = if is_etc1s { start } else { 0 };
        // BasisLZ has no size of its own for a level.
        let unpacked = if is_etc1s { 0 } else { level_length };
        let longs = [global_start, global_length, start + global_length, level_length, unpacked];
        file.extend(longs.iter().flat_map(|long| (*long as u64).to_le_bytes()));
        file.extend(descriptor);
        match &self.payload {
            Payload::Etc1s { counts, image, codebooks, level } => {
                file.extend_from_slice(counts);
                // Neither more global data nor a frame of a film.
                file.extend([0; 8]);
                file.extend(image.iter().flat_map(|word| word.to_le_bytes()));
                file.extend_from_slice(codebooks);
                file.extend_from_slice(level);
            }
            Payload::Uastc { level, is_packed: false, .. } => file.extend_from_slice(level),
            Payload::Uastc { level, is_packed: true, block_bytes } => {
                let start = file.len();
                file.resize(start + block_bytes, 0);
                let written = zstd::bulk::decompress_to_buffer(level, &mut file[start..]);
                let written = written.map_err(|error| {
                    Error::invalid(format!("the KTX2's Zstandard data is broken: {error}"))
                })?;
                if written != *block_bytes {
                    return Err(Error::invalid("the KTX2's Zstandard data ends too early"));
                }
            }
        }
        Ok(file)
    }

    fn descriptor(&self, is_etc1s: bool) -> Vec<u8> {
        // ETC1S tells alpha by a second sample, UASTC by the first one's channel.
        let length = if is_etc1s && self.has_alpha { DESCRIPTOR_BYTES + 16 } else { DESCRIPTOR_BYTES };
        let mut descriptor = vec![0; length];
        descriptor[0] = length as u8;
        descriptor[12] = if is_etc1s { MODEL_ETC1S } else { MODEL_UASTC };
        // Linear: the material's slot says what the numbers are.
        descriptor[14] = 1;
        descriptor[16..18].fill(3);
        if !is_etc1s && self.has_alpha {
            descriptor[31] = 3;
        }
        descriptor
    }
}

/// Color model, and whether there is alpha, of a basic descriptor of one or two samples (Khronos Data Format).
fn channels(descriptor: &[u8]) -> Result<(u8, bool)> {
    if descriptor.len() != DESCRIPTOR_BYTES && descriptor.len() != DESCRIPTOR_BYTES + 16 {
        return Err(Error::invalid("the KTX2's data format descriptor has neither one nor two samples"));
    }
    let (model, flags) = (descriptor[12], descriptor[15]);
    let channel = |sample: usize| descriptor.get(31 + 16 * sample).map(|channel| channel & 15);
    let has_alpha = match (model, channel(0), channel(1)) {
        // RGB or R; alpha is a sample of its own.
        (MODEL_ETC1S, Some(0 | 3), None) => false,
        (MODEL_ETC1S, Some(0 | 3), Some(15)) => true,
        // RGB or R, then RGBA.
        (MODEL_UASTC, Some(0 | 4), None) => false,
        (MODEL_UASTC, Some(3), None) => true,
        (MODEL_ETC1S | MODEL_UASTC, ..) => {
            return Err(Error::invalid("the KTX2 has other channels than R, RGB or RGBA (two, say)"));
        }
        _ => false,
    };
    if has_alpha && flags & FLAG_PREMULTIPLIED != 0 {
        return Err(Error::invalid("the KTX2's colors are multiplied by alpha, which glTF does not allow"));
    }
    Ok((model, has_alpha))
}

/// Pictures of glTF stand upright and keep their channels where they are.
fn check_pairs(pairs: &[u8]) -> Result<()> {
    let mut rest = Bytes(pairs);
    while !rest.0.is_empty() {
        let [length] = rest.words(0)?.map(u64::from);
        let pair = rest.part(4, length)?;
        for (key, allowed) in [(&b"KTXorientation\0"[..], &b"rd\0"[..]), (b"KTXswizzle\0", b"rgba\0")] {
            if let Some(value) = pair.strip_prefix(key)
                && !value.eq_ignore_ascii_case(allowed)
            {
                let [key, value] = [key, value].map(|text| String::from_utf8_lossy(text).replace('\0', ""));
                let value = super::super::text::quoted(&value);
                return Err(Error::invalid(format!(
                    "the KTX2's {key} is {value}, which glTF does not allow"
                )));
            }
        }
        // The last pair may lack its padding.
        rest = Bytes(rest.0.get(4 + pair.len().next_multiple_of(4)..).unwrap_or_default());
    }
    Ok(())
}

fn etc1s<'a>(global: &'a [u8], level: &'a [u8], levels: usize, has_alpha: bool) -> Result<Payload<'a>> {
    let bytes = Bytes(global);
    let lengths: [u32; 3] = bytes.words(4)?;
    let codebooks = bytes.part(
        (GLOBAL_BYTES + IMAGE_BYTES * levels) as u64,
        lengths.iter().map(|&length| u64::from(length)).sum(),
    )?;
    let [flags, mut image @ ..]: [u32; 5] = bytes.words(GLOBAL_BYTES)?;
    if flags & IMAGE_IS_P_FRAME != 0 {
        return Err(Error::invalid("the KTX2 is a film"));
    }
    if !has_alpha {
        image[2..].fill(0);
    }
    for slice in image.chunks(2) {
        Bytes(level).part(slice[0].into(), slice[1].into())?;
    }
    Ok(Payload::Etc1s { counts: &global[..GLOBAL_BYTES - 4], image, codebooks, level })
}

/// Little-endian fields; what is not there is a truncated file.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn part(&self, offset: u64, length: u64) -> Result<&'a [u8]> {
        let end = offset.checked_add(length).ok_or_else(truncated)?;
        let (offset, end) = (usize::try_from(offset), usize::try_from(end));
        let (Ok(offset), Ok(end)) = (offset, end) else { return Err(truncated()) };
        self.0.get(offset..end).ok_or_else(truncated)
    }

    fn words<const N: usize>(&self, at: usize) -> Result<[u32; N]> {
        let part = self.part(at as u64, 4 * N as u64)?;
        let mut words = [0; N];
        for (word, four) in words.iter_mut().zip(part.chunks_exact(4)) {
            *word = u32::from_le_bytes([four[0], four[1], four[2], four[3]]);
        }
        Ok(words)
    }

    fn long(&self, at: usize) -> Result<u64> {
        let [low, high] = self.words(at)?;
        Ok(u64::from(high) << 32 | u64::from(low))
    }
}
