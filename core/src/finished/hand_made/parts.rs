//! Conversions spread over two parts.

use crate::finished::{Finished, FinishedPrimitive, FinishedTexture, FinishedTriangle, PrimitiveCuts};

/// The triangles that `is_second` names read textures of their own, with the same texels. Primitives of one part alone
/// stay one.
pub fn split(finished: &Finished, is_second: impl Fn(&FinishedTriangle) -> bool) -> Finished {
    let again = finished.textures.iter().map(|texture| FinishedTexture { part: 1, ..texture.clone() });
    let textures: Vec<_> = finished.textures.iter().cloned().chain(again).collect();
    let count = finished.textures.len();
    let piece_of = |piece: &FinishedPrimitive, part: usize| {
        let is_here = |number: &usize| usize::from(is_second(&piece.triangles[*number])) == part;
        let numbers: Vec<usize> = (0..piece.triangles.len()).filter(is_here).collect();
        let cuts = piece.cuts.iter().map(|cuts| PrimitiveCuts {
            texture: cuts.texture + part * count,
            bits: numbers.iter().map(|&number| cuts.bits[number]).collect(),
        });
        let is_framed = !piece.frames.is_empty();
        FinishedPrimitive {
            part,
            triangles: numbers.iter().map(|&number| piece.triangles[number]).collect(),
            frames: numbers.iter().filter(|_| is_framed).map(|&number| piece.frames[number]).collect(),
            cuts: cuts.filter(|cuts| cuts.bits.iter().any(|&bits| bits != 0)).collect(),
            ..piece.clone()
        }
    };
    let pieces = finished.primitives.iter().flat_map(|piece| [0, 1].map(|part| piece_of(piece, part)));
    let primitives = pieces.filter(|piece| !piece.triangles.is_empty()).collect();
    Finished { textures, primitives, vertex_colors: finished.vertex_colors.clone() }
}
