//! What a `.ptx` file says of each face: resolution, flags, neighbours (Ptex File Format 1.3r1, "Face Info").

use super::super::Limits;
use super::bytes::{Bytes, inflate};
use super::header::{File, Header};
use crate::error::{Error, Result};

/// Bytes of one face's entry.
const FACE_BYTES: usize = 20;
const CONSTANT: u8 = 1;
/// Sides of `2^12` texels are the largest that are read: twice as many and a few fit into an image.
const LOG2_MAX: u8 = 12;

#[derive(Clone, Copy, Debug)]
pub struct FaceInfo {
    /// Base 2 logarithms of how many texels there are along u and along v.
    pub log2: [u8; 2],
    pub is_constant: bool,
    /// By edge: the face beyond it and which of its edges that is. `None` at a border.
    pub neighbours: [Option<(u32, u8)>; 4],
}

impl FaceInfo {
    pub fn texel_count(&self) -> usize {
        1 << (self.log2[0] + self.log2[1])
    }

    /// The quarter at a corner, turned so that this is its corner 0; all of it where there is none. A side of one texel stays one.
    pub fn part(&self, quarter: Option<usize>) -> Self {
        let Some(corner) = quarter else { return *self };
        let [u, v] = self.log2.map(|log2| log2.saturating_sub(1));
        Self { log2: if corner.is_multiple_of(2) { [u, v] } else { [v, u] }, neighbours: [None; 4], ..*self }
    }

    /// Sides in texels.
    pub fn size(&self) -> [usize; 2] {
        self.log2.map(|log2| 1 << log2)
    }
}

/// One for each face, in the file's order.
pub fn read(file: &File<'_>, limits: &Limits) -> Result<Vec<FaceInfo>> {
    let header = &file.header;
    let bytes = (header.face_count * FACE_BYTES) as u64;
    let unpacked = inflate(file.faces, bytes, "face info", limits)?;
    let entries = unpacked.chunks_exact(FACE_BYTES).enumerate();
    entries.map(|(face, entry)| face_info(header, face, entry)).collect()
}

fn face_info(header: &Header, face: usize, entry: &[u8]) -> Result<FaceInfo> {
    let mut at = Bytes::new(entry, "face info");
    let log2 = [at.u8()?, at.u8()?];
    let (adjacent_edges, flags) = (at.u8()?, at.u8()?);
    let mut neighbours = [None; 4];
    for (edge, neighbour) in neighbours.iter_mut().enumerate() {
        let adjacent = at.u32()?;
        // All ones, or any other negative number, is a border; a triangle's fourth entry says nothing.
        let is_one = adjacent >> 31 == 0 && edge < header.corner_count();
        *neighbour = is_one.then_some((adjacent, adjacent_edges >> (2 * edge) & 3));
    }
    if log2.into_iter().any(|log2| log2 > LOG2_MAX) {
        let [u, v] = log2;
        let detail = format!("face {face} has 2^{u} x 2^{v} texels; sides up to 2^{LOG2_MAX} are read");
        return Err(Error::invalid(detail));
    }
    if header.is_triangles && log2[0] != log2[1] {
        let [u, v] = log2;
        return Err(Error::invalid(format!(
            "the triangle {face} has 2^{u} x 2^{v} texels and must be square"
        )));
    }
    // A single texel stands in the constant data, flagged or not.
    let is_constant = flags & CONSTANT != 0 || log2 == [0, 0];
    Ok(FaceInfo { log2, is_constant, neighbours })
}
