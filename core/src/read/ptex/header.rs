//! The fixed header of a `.ptx` file and where its blocks stand (Ptex File Format 1.3r1, "Header" and "Extended
//! Header"). All numbers are little-endian; blocks follow each other without padding.

use super::bytes::{Bytes, block};
use crate::error::{Error, Result};

/// Bytes of the header; what follows is the extended header.
pub const HEADER_BYTES: usize = 64;
const MAGIC: &[u8; 4] = b"Ptex";
/// Bytes of one level's entry.
const LEVEL_BYTES: usize = 16;
/// What the extended header has up to the sizes of the edits.
const EDITS_AT: usize = 24;
/// The "no alpha channel" of the format.
const NO_ALPHA: u32 = u32::MAX;
/// More channels than any use of textures has. They bound what one texel takes.
const CHANNELS_MAX: u16 = 1024;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    U8,
    U16,
    Half,
    Float,
}

impl DataType {
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::Half => 2,
            Self::Float => 4,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Header {
    pub is_triangles: bool,
    pub data: DataType,
    pub channel_count: usize,
    pub alpha: Option<usize>,
    pub face_count: usize,
}

/// A file whose blocks all lie inside of it.
#[derive(Debug)]
pub struct File<'a> {
    pub header: Header,
    pub faces: &'a [u8],
    pub constants: &'a [u8],
    /// Of level 0: the list of face sizes, packed, and the data of its faces.
    pub sizes: &'a [u8],
    pub data: &'a [u8],
    /// Whether edits were appended to the file.
    pub has_edits: bool,
}

impl Header {
    pub fn texel_bytes(&self) -> usize {
        self.channel_count * self.data.bytes()
    }

    pub fn corner_count(&self) -> usize {
        if self.is_triangles { 3 } else { 4 }
    }

    fn read(bytes: &[u8]) -> Result<(Self, Bytes<'_>)> {
        let mut at = Bytes::new(bytes, "header");
        if at.take(4)? != MAGIC {
            return Err(Error::invalid("the file is no Ptex file: it does not begin with \"Ptex\""));
        }
        let version = at.u32()?;
        if version != 1 {
            return Err(Error::invalid(format!("the file has Ptex version {version}; version 1 is read")));
        }
        let mesh = at.u32()?;
        let is_triangles = match mesh {
            0 => true,
            1 => false,
            _ => return Err(Error::invalid(format!("mesh type {mesh} is none of 0 (triangles), 1 (quads)"))),
        };
        let data = match at.u32()? {
            0 => DataType::U8,
            1 => DataType::U16,
            2 => DataType::Half,
            3 => DataType::Float,
            other => return Err(Error::invalid(format!("data type {other} is none of 0 to 3"))),
        };
        let alpha = at.u32()?;
        let channels = at.u16()?;
        let _level_count = at.u16()?;
        if !(1..=CHANNELS_MAX).contains(&channels) {
            let detail = format!("the file has {channels} channels; 1 to {CHANNELS_MAX} are read");
            return Err(Error::invalid(detail));
        }
        if alpha != NO_ALPHA && alpha >= u32::from(channels) {
            let detail = format!("the alpha channel is number {alpha} of {channels}, counted from 0");
            return Err(Error::invalid(detail));
        }
        let face_count = at.u32()? as usize;
        let header = Self {
            is_triangles,
            data,
            channel_count: channels.into(),
            alpha: (alpha != NO_ALPHA).then_some(alpha as usize),
            face_count,
        };
        Ok((header, at))
    }
}

/// Splits a file into its blocks. Nothing is unpacked or allocated.
pub fn split(bytes: &[u8]) -> Result<File<'_>> {
    let (header, mut sizes) = Header::read(bytes)?;
    let [extended, faces, constants, levels] = [sizes.u32()?, sizes.u32()?, sizes.u32()?, sizes.u32()?];
    let _minor_version = sizes.u32()?;
    let level_data = sizes.u64()?;
    let [metadata, _unpacked_metadata] = [sizes.u32()?, sizes.u32()?];
    let mut rest = &bytes[HEADER_BYTES..];
    let extended = block(&mut rest, extended.into(), "extended header")?;
    let faces = block(&mut rest, faces.into(), "face info")?;
    let constants = block(&mut rest, constants.into(), "constant data")?;
    let levels = block(&mut rest, levels.into(), "level info")?;
    let mut level_data = block(&mut rest, level_data, "level data")?;
    if levels.len() < LEVEL_BYTES {
        return Err(Error::invalid("the file has no level 0"));
    }
    let mut level = Bytes::new(levels, "level info");
    let (level_bytes, list_bytes, listed) = (level.u64()?, level.u32()?, level.u32()?);
    if listed as usize != header.face_count {
        let detail = format!("level 0 lists {listed} faces, the file has {}", header.face_count);
        return Err(Error::invalid(detail));
    }
    let mut data = block(&mut level_data, level_bytes, "level 0")?;
    let sizes = block(&mut data, list_bytes.into(), "level 0's list of faces")?;
    let has_edits = has_edits(extended, &rest[rest.len().min(metadata as usize)..]);
    Ok(File { header, faces, constants, sizes, data, has_edits })
}

/// The extended header says how many bytes of edits there are; before version 1.3 they simply stood behind the metadata,
/// where later files have eight zeros.
fn has_edits(extended: &[u8], behind: &[u8]) -> bool {
    match extended.get(EDITS_AT..EDITS_AT + 16) {
        Some(edits) => edits[..8].iter().any(|&byte| byte != 0),
        None => behind.get(1..5).is_some_and(|size| size.iter().any(|&byte| byte != 0)),
    }
}
