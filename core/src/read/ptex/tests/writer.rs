//! Small `.ptx` files for tests, written from the format's description (version 1.3r1) and by nothing that reads them.

use std::collections::BTreeMap;
use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

/// The header's numbers for data types.
pub const U8: u32 = 0;
pub const U16: u32 = 1;
pub const HALF: u32 = 2;
pub const FLOAT: u32 = 3;

/// How a face is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stored {
    /// Flagged as constant: its first texel stands in the constant data alone.
    Flagged,
    Constant,
    Zipped,
    DiffZipped,
    /// Base 2 logarithms of a tile's sides. Tiles with equal texels are constants.
    Tiled([u8; 2]),
}

#[derive(Clone, Debug)]
pub struct Face {
    pub log2: [u8; 2],
    /// Faces beyond the edges with their edges there.
    pub neighbours: [Option<(u32, u8)>; 4],
    pub is_subface: bool,
    pub stored: Stored,
    /// Numbers as they are stored (codes, or floats), by texel in rows along u, and channel.
    pub numbers: Vec<f32>,
}

#[derive(Clone, Debug)]
pub struct Ptex {
    pub is_triangles: bool,
    pub data: u32,
    pub channels: usize,
    pub alpha: Option<u32>,
    pub faces: Vec<Face>,
}

pub fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A number as bytes of a data type.
fn number(data: u32, value: f32) -> Vec<u8> {
    match data {
        U8 => vec![value as u8],
        U16 => (value as u16).to_le_bytes().to_vec(),
        HALF => half::f16::from_f32(value).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    }
}

impl Ptex {
    fn texel(&self, face: &Face, texel: usize) -> Vec<u8> {
        let numbers = &face.numbers[texel * self.channels..][..self.channels];
        numbers.iter().flat_map(|&value| number(self.data, value)).collect()
    }

    /// Planes of the texels in a rectangle, channel by channel.
    fn planes(&self, face: &Face, first: [usize; 2], size: [usize; 2]) -> Vec<u8> {
        let width = 1 << face.log2[0];
        let mut bytes = Vec::new();
        for channel in 0..self.channels {
            for v in first[1]..first[1] + size[1] {
                for u in first[0]..first[0] + size[0] {
                    bytes.extend(number(self.data, face.numbers[(v * width + u) * self.channels + channel]));
                }
            }
        }
        bytes
    }

    fn differences(&self, mut bytes: Vec<u8>) -> Vec<u8> {
        match self.data {
            U8 => (1..bytes.len()).rev().for_each(|at| bytes[at] = bytes[at].wrapping_sub(bytes[at - 1])),
            U16 => {
                let word = |bytes: &[u8], at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
                for at in (2..bytes.len()).step_by(2).rev() {
                    let difference = word(&bytes, at).wrapping_sub(word(&bytes, at - 2));
                    bytes[at..at + 2].copy_from_slice(&difference.to_le_bytes());
                }
            }
            _ => {}
        }
        bytes
    }

    /// A face's bytes, and its entry in the list: size and encoding.
    fn face(&self, face: &Face) -> (Vec<u8>, u32) {
        let size = face.log2.map(|log2| 1usize << log2);
        let entry = |bytes: &[u8], encoding: u32| bytes.len() as u32 | encoding << 30;
        match face.stored {
            Stored::Flagged => (Vec::new(), 0),
            Stored::Constant => {
                let bytes = self.texel(face, 0);
                let entry = entry(&bytes, 0);
                (bytes, entry)
            }
            Stored::Zipped => {
                let bytes = zipped(&self.planes(face, [0, 0], size));
                let entry = entry(&bytes, 1);
                (bytes, entry)
            }
            Stored::DiffZipped => {
                let bytes = zipped(&self.differences(self.planes(face, [0, 0], size)));
                let entry = entry(&bytes, 2);
                (bytes, entry)
            }
            Stored::Tiled(tile_log2) => {
                let tile = tile_log2.map(|log2| 1usize << log2);
                let (mut list, mut data) = (Vec::new(), Vec::new());
                for (number, v) in (0..size[1]).step_by(tile[1]).enumerate() {
                    for u in (0..size[0]).step_by(tile[0]) {
                        let texels = |k: usize| (v + k / tile[0]) * size[0] + u + k % tile[0];
                        let all = || (0..tile[0] * tile[1]).map(|k| self.texel(face, texels(k)));
                        let planes = self.planes(face, [u, v], tile);
                        // All three encodings that a tile may have.
                        let (bytes, encoding) = if all().all(|texel| texel == self.texel(face, texels(0))) {
                            (self.texel(face, texels(0)), 0)
                        } else if number % 2 == 0 {
                            (zipped(&planes), 1)
                        } else {
                            (zipped(&self.differences(planes)), 2)
                        };
                        list.extend(entry(&bytes, encoding).to_le_bytes());
                        data.extend(bytes);
                    }
                }
                let list = zipped(&list);
                let mut bytes = tile_log2.to_vec();
                bytes.extend((list.len() as u32).to_le_bytes());
                bytes.extend(list);
                bytes.extend(data);
                let entry = entry(&bytes, 3);
                (bytes, entry)
            }
        }
    }

    pub fn bytes(&self) -> Vec<u8> {
        let mut infos = Vec::new();
        let mut constants = Vec::new();
        let (mut list, mut data) = (Vec::new(), Vec::new());
        for face in &self.faces {
            infos.extend(face.log2);
            let edges = face.neighbours.iter().enumerate();
            infos.push(
                edges.fold(0, |bits, (k, neighbour)| bits | neighbour.map_or(0, |(_, edge)| edge) << (2 * k)),
            );
            let is_flagged = face.stored == Stored::Flagged;
            infos.push(u8::from(is_flagged) | u8::from(face.is_subface) << 3);
            for neighbour in face.neighbours {
                infos.extend(neighbour.map_or(u32::MAX, |(face, _)| face).to_le_bytes());
            }
            constants.extend(self.texel(face, 0));
            let (bytes, entry) = self.face(face);
            list.extend(entry.to_le_bytes());
            data.extend(bytes);
        }
        let [infos, constants, list] = [infos, constants, list].map(|block| zipped(&block));
        let level_bytes = (list.len() + data.len()) as u64;
        let face_count = self.faces.len() as u32;
        const EXTENDED: u32 = 40;
        let mut bytes = b"Ptex".to_vec();
        let mesh_type = u32::from(!self.is_triangles);
        for word in [1, mesh_type, self.data, self.alpha.unwrap_or(u32::MAX)] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend((self.channels as u16).to_le_bytes());
        bytes.extend(1u16.to_le_bytes());
        for word in [face_count, EXTENDED, infos.len() as u32, constants.len() as u32, 16, 4] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(level_bytes.to_le_bytes());
        // No metadata.
        bytes.extend([0; 8]);
        bytes.extend([0; EXTENDED as usize]);
        bytes.extend(infos);
        bytes.extend(constants);
        bytes.extend(level_bytes.to_le_bytes());
        bytes.extend((list.len() as u32).to_le_bytes());
        bytes.extend(face_count.to_le_bytes());
        bytes.extend(list);
        bytes.extend(data);
        // The compatibility barrier.
        bytes.extend([0; 8]);
        bytes
    }
}

/// By face and edge, what lies beyond; of several the first.
pub fn neighbours(faces: &[Vec<u32>]) -> Vec<[Option<(u32, u8)>; 4]> {
    let mut sides: BTreeMap<[u32; 2], Vec<(u32, u8)>> = BTreeMap::new();
    let ends = |face: &[u32], edge: usize| {
        let [a, b] = [face[edge], face[(edge + 1) % face.len()]];
        [a.min(b), a.max(b)]
    };
    for (number, face) in faces.iter().enumerate() {
        for edge in 0..face.len() {
            sides.entry(ends(face, edge)).or_default().push((number as u32, edge as u8));
        }
    }
    let beyond = |(number, face): (usize, &Vec<u32>)| {
        let mut found = [None; 4];
        for (edge, found) in found.iter_mut().enumerate().take(face.len()) {
            let others = &sides[&ends(face, edge)];
            *found = others.iter().copied().find(|&(other, _)| other as usize != number);
        }
        found
    };
    faces.iter().enumerate().map(beyond).collect()
}
