//! The texels of level 0 of all faces, unpacked (Ptex File Format 1.3r1, "Constant Data" and "Level Data").

use std::borrow::Cow;

use glam::Vec4;
use rayon::prelude::*;

use super::super::Limits;
use super::Part;
use super::bytes::{Bytes, block, inflate};
use super::channels::{Channels, Decoder, Places, Range};
use super::faces::FaceInfo;
use super::header::{DataType, File};
use crate::error::{Error, ErrorCode, Result};
use crate::watch::{self, Watch};

/// How a face's or a tile's data is packed: the upper two bits of its entry; the others are its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Constant,
    Zipped,
    DiffZipped,
    Tiled,
}

const SIZE_BITS: u32 = 30;

/// What the faces store, as values that enter a filter.
#[derive(Debug)]
pub struct Texels {
    pub components: usize,
    values: Vec<f32>,
    faces: Vec<Face>,
}

/// Where a face's texels are, in texels.
#[derive(Clone, Copy, Debug)]
struct Face {
    first: isize,
    /// From one to the next along u and along v; 0 where one stands for all.
    steps: [isize; 2],
}

/// What is needed to unpack a face.
struct Unpacker<'a> {
    file: &'a File<'a>,
    channels: &'a Channels,
    decoder: Decoder,
    is_color: bool,
    limits: &'a Limits,
}

impl Texels {
    /// Unpacks all faces; how many texels they have together was checked. Also what the values reached.
    pub fn read(
        file: &File<'_>,
        faces: &[FaceInfo],
        (channels, is_color): (&Channels, bool),
        limits: &Limits,
        watch: &dyn Watch,
    ) -> Result<(Self, Range)> {
        let unpacker =
            Unpacker { file, channels, decoder: Decoder::new(file.header.data, is_color), is_color, limits };
        let constants = (faces.len() * file.header.texel_bytes()) as u64;
        let constants = inflate(file.constants, constants, "constant data", limits)?;
        let data = face_data(file, faces.len(), limits)?;
        check_total(file, faces, limits)?;
        let components = channels.taken.len();
        let stored = |face: &FaceInfo| if face.is_constant { 1 } else { face.texel_count() };
        let mut values = vec![0.0; faces.iter().map(stored).sum::<usize>() * components];
        let mut placed = Vec::with_capacity(faces.len());
        let mut jobs = Vec::with_capacity(faces.len());
        let (mut rest, mut first) = (&mut values[..], 0);
        for (number, face) in faces.iter().enumerate() {
            let (own, others) = rest.split_at_mut(stored(face) * components);
            let width = face.size()[0] as isize;
            placed.push(Face { first, steps: if face.is_constant { [0, 0] } else { [1, width] } });
            first += stored(face) as isize;
            rest = others;
            jobs.push((number, own));
        }
        let texel_bytes = file.header.texel_bytes();
        let ranges = jobs.into_par_iter().with_min_len(64).map(|(number, own)| {
            watch::check(watch)?;
            let mut range = Range::default();
            let face = &faces[number];
            if face.is_constant {
                let bytes = &constants[number * texel_bytes..][..texel_bytes];
                let one = Rectangle { size: [1, 1], face_width: 1, first: 0 };
                unpacker.rectangle(Packed { encoding: Encoding::Constant, bytes }, &one, &mut range, own)?;
            } else {
                let whole = Rectangle { size: face.size(), face_width: face.size()[0], first: 0 };
                unpacker
                    .face(data[number], face.log2, &whole, &mut range, own)
                    .map_err(|error| Error { detail: format!("face {number}: {}", error.detail), ..error })?;
            }
            Ok(range)
        });
        let ranges: Vec<Range> = ranges.collect::<Result<_>>()?;
        let range = ranges.into_iter().fold(Range::default(), Range::join);
        Ok((Self { components, values, faces: placed }, range))
    }

    /// A texel's components; the rest is 0.
    #[inline]
    pub fn at(&self, face: usize, u: usize, v: usize) -> Vec4 {
        let Face { first, steps } = self.faces[face];
        let texel = first + u as isize * steps[0] + v as isize * steps[1];
        let mut value = Vec4::ZERO;
        let at = texel as usize * self.components;
        for (component, stored) in self.values[at..at + self.components].iter().enumerate() {
            value[component] = *stored;
        }
        value
    }
}

impl Texels {
    /// The same texels seen by parts of faces.
    pub fn parts(self, faces: &[FaceInfo], parts: &[Part]) -> Self {
        let of = |part: &Part| {
            let Face { first, steps: [right, up] } = self.faces[part.face];
            let Some(corner) = part.quarter else { return self.faces[part.face] };
            let [last_u, last_v] = faces[part.face].size().map(|side| side as isize - 1);
            let (corner_at, steps) = match corner {
                0 => (0, [right, up]),
                1 => (last_u * right, [up, -right]),
                2 => (last_u * right + last_v * up, [-right, -up]),
                _ => (last_v * up, [-up, right]),
            };
            Face { first: first + corner_at, steps }
        };
        let faces = parts.iter().map(of).collect();
        Self { faces, ..self }
    }
}

/// What all faces unpack to together, since several are unpacked at a time.
fn check_total(file: &File<'_>, faces: &[FaceInfo], limits: &Limits) -> Result<()> {
    let texels: usize = faces.iter().filter(|face| !face.is_constant).map(FaceInfo::texel_count).sum();
    let (bytes, limit) = ((texels * file.header.texel_bytes()) as u64, limits.archive_bytes);
    if bytes <= limit {
        return Ok(());
    }
    let detail = format!(
        "{} channels of {texels} texels unpack to {bytes} bytes; the limit is {limit} (limit `archive_bytes`)",
        file.header.channel_count
    );
    Err(Error::new(ErrorCode::ModelTooLarge, detail).limit(limit, bytes))
}

/// An entry of a list of faces or tiles.
#[derive(Clone, Copy)]
struct Packed<'a> {
    encoding: Encoding,
    bytes: &'a [u8],
}

/// Each face's data, cut out of level 0.
fn face_data<'a>(file: &File<'a>, count: usize, limits: &Limits) -> Result<Vec<Packed<'a>>> {
    let list = inflate(file.sizes, 4 * count as u64, "list of faces", limits)?;
    packed(&list, &mut { file.data })
}

/// Cuts what a list names off the front of `data`.
fn packed<'a>(list: &[u8], data: &mut &'a [u8]) -> Result<Vec<Packed<'a>>> {
    let entry = |&four: &[u8; 4]| {
        let entry = u32::from_le_bytes(four);
        let encoding = match entry >> SIZE_BITS {
            0 => Encoding::Constant,
            1 => Encoding::Zipped,
            2 => Encoding::DiffZipped,
            _ => Encoding::Tiled,
        };
        let size = entry & ((1 << SIZE_BITS) - 1);
        Ok(Packed { encoding, bytes: block(data, size.into(), "data of a face")? })
    };
    list.as_chunks::<4>().0.iter().map(entry).collect()
}

/// A part of a face, in texels.
struct Rectangle {
    size: [usize; 2],
    face_width: usize,
    first: usize,
}

impl Unpacker<'_> {
    fn face(
        &self,
        packed: Packed<'_>,
        log2: [u8; 2],
        whole: &Rectangle,
        range: &mut Range,
        to: &mut [f32],
    ) -> Result<()> {
        if packed.encoding != Encoding::Tiled {
            return self.rectangle(packed, whole, range, to);
        }
        let mut at = Bytes::new(packed.bytes, "tiled face");
        let tile = [at.u8()?, at.u8()?];
        if tile.iter().zip(log2).any(|(&tile, face)| tile > face) {
            let [u, v] = tile;
            return Err(Error::invalid(format!("its tiles of 2^{u} x 2^{v} texels are larger than itself")));
        }
        let list_bytes = at.u32()?;
        let mut data = at.rest();
        let list = block(&mut data, list_bytes.into(), "list of tiles")?;
        let counts = [0, 1].map(|axis| 1usize << (log2[axis] - tile[axis]));
        let size = tile.map(|log2| 1usize << log2);
        let list = inflate(list, 4 * (counts[0] * counts[1]) as u64, "list of tiles", self.limits)?;
        for (number, packed) in packed_tiles(&list, data)?.into_iter().enumerate() {
            let [column, row] = [number % counts[0], number / counts[0]];
            let first = row * size[1] * whole.face_width + column * size[0];
            self.rectangle(packed, &Rectangle { size, face_width: whole.face_width, first }, range, to)?;
        }
        Ok(())
    }

    fn rectangle(
        &self,
        packed: Packed<'_>,
        part: &Rectangle,
        range: &mut Range,
        to: &mut [f32],
    ) -> Result<()> {
        let texel_bytes = self.file.header.texel_bytes();
        let texel_count = part.size[0] * part.size[1];
        match packed.encoding {
            Encoding::Tiled => Err(Error::invalid("a tile is tiled itself")),
            Encoding::Constant => {
                let Some(texel) = packed.bytes.get(..texel_bytes) else {
                    let detail =
                        format!("its constant has {} bytes and needs {texel_bytes}", packed.bytes.len());
                    return Err(Error::invalid(detail));
                };
                let size = self.file.header.data.bytes();
                let plane = |channel: usize| Cow::Owned(texel[channel * size..][..size].repeat(texel_count));
                self.planes(plane, part, range, to);
                Ok(())
            }
            Encoding::Zipped | Encoding::DiffZipped => {
                let bytes = (texel_count * texel_bytes) as u64;
                let mut unpacked = inflate(packed.bytes, bytes, "data", self.limits)?;
                if packed.encoding == Encoding::DiffZipped {
                    undo_differences(&mut unpacked, self.file.header.data);
                }
                let size = unpacked.len() / self.file.header.channel_count;
                let plane = |channel: usize| Cow::Borrowed(&unpacked[channel * size..][..size]);
                self.planes(plane, part, range, to);
                Ok(())
            }
        }
    }

    /// Decodes the channels that are taken; `plane` gives the numbers of one.
    fn planes<'p>(
        &self,
        plane: impl Fn(usize) -> Cow<'p, [u8]>,
        part: &Rectangle,
        range: &mut Range,
        to: &mut [f32],
    ) {
        let components = self.channels.taken.len();
        for (component, &channel) in self.channels.taken.iter().enumerate() {
            let is_alpha = self.channels.has_alpha && component + 1 == components;
            let places = Places {
                face: to,
                components,
                component,
                widths: [part.face_width, part.size[0]],
                first: part.first,
            };
            self.decoder.plane(&plane(channel), self.is_color && !is_alpha, range, places);
        }
    }
}

fn packed_tiles<'a>(list: &[u8], mut data: &'a [u8]) -> Result<Vec<Packed<'a>>> {
    packed(list, &mut data)
}

/// Each number was stored as its difference to the one before, over all channels. Floats are never stored so.
fn undo_differences(bytes: &mut [u8], data: DataType) {
    match data {
        DataType::U8 => {
            let mut sum = 0u8;
            for byte in bytes {
                sum = sum.wrapping_add(*byte);
                *byte = sum;
            }
        }
        DataType::U16 => {
            let mut sum = 0u16;
            for number in bytes.as_chunks_mut::<2>().0 {
                sum = sum.wrapping_add(u16::from_le_bytes(*number));
                *number = sum.to_le_bytes();
            }
        }
        DataType::Half | DataType::Float => {}
    }
}
