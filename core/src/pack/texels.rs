//! The texels of one face in a level image.

use crate::image::{Image, Pixels};
use crate::layout::{Layout, twin_shift};

use super::turn::Turn;

/// The points of a face's grid on the texels of an image: point `(i, j)` is texel `start + i · along[0] + j · along[1]`.
#[derive(Clone, Copy, Debug)]
pub struct FaceTexels {
    pub start: usize,
    pub along: [isize; 2],
    pub segments: [u32; 2],
    /// Of a lone triangle there are the points up to the line of border texels.
    pub is_lone: bool,
}

impl FaceTexels {
    /// Those of a block whose first texel is `first`, in an image of `width`. `is_turned`: the second of two lone
    /// triangles.
    pub fn new([x, y]: [u32; 2], segments: [u32; 2], width: u32, is_lone: bool, is_turned: bool) -> Self {
        let along = [1, width as isize];
        let texel = |x: u32, y: u32| y as usize * width as usize + x as usize;
        if is_turned {
            let start = texel(x + segments[0] + twin_shift(segments[0]), y + segments[1]);
            return Self { start, along: along.map(|step| -step), segments, is_lone };
        }
        Self { start: texel(x, y), along, segments, is_lone }
    }

    /// A face where a layout painted it, as its block lies.
    pub fn of_face(layout: &Layout, face: usize, level: usize) -> Self {
        let block = layout.block(face);
        let segments = block.exponents.map(|exponent| 1 << usize::from(exponent).saturating_sub(level));
        let is_turned = layout.placements[face].shift > 0;
        Self::new(
            layout.first_texel(block, level),
            segments,
            layout.sizes[level][0],
            block.kind.is_lone(),
            is_turned,
        )
    }

    /// The same points as a turned rectangle has them.
    pub fn turned(self, turn: Turn) -> Self {
        let mut turned = Self { along: turn.pair(self.along), segments: turn.pair(self.segments), ..self };
        for k in 0..2 {
            if turn.is_flipped[k] {
                let length = turned.along[k] * turned.segments[k] as isize;
                turned.start = turned.start.wrapping_add_signed(length);
                turned.along[k] = -turned.along[k];
            }
        }
        turned
    }

    pub fn texel(&self, i: u32, j: u32) -> usize {
        self.start.wrapping_add_signed(self.along[0] * i as isize + self.along[1] * j as isize)
    }

    /// The texels of each row of points.
    pub fn rows(self) -> impl Iterator<Item = impl Iterator<Item = usize>> {
        let [n, m] = self.segments;
        (0..=m).map(move |j| {
            let last = if self.is_lone { n.min(n + 1 - j) } else { n };
            (0..=last).map(move |i| self.texel(i, j))
        })
    }

    /// The texels between two corners of the unit square that a side joins, in this order.
    pub fn side(self, from: [u32; 2], to: [u32; 2]) -> impl Iterator<Item = usize> {
        let [n, m] = self.segments;
        let count = if from[0] == to[0] { m } else { n };
        let at = move |k: usize, step: u32| match (from[k], to[k]) {
            (0, 0) => 0,
            (0, _) => step,
            (_, 0) => count - step,
            _ => self.segments[k],
        };
        (0..=count).map(move |step| self.texel(at(0, step), at(1, step)))
    }
}

/// Whether texels hold the same codes.
pub fn are_equal(image: &Image, mut pairs: impl Iterator<Item = (usize, usize)>) -> bool {
    let count = usize::from(image.components);
    fn codes<T>(all: &[T], texel: usize, count: usize) -> &[T] {
        &all[texel * count..(texel + 1) * count]
    }
    match &image.pixels {
        Pixels::U8(all) => pairs.all(|(a, b)| codes(all, a, count) == codes(all, b, count)),
        Pixels::U16(all) => pairs.all(|(a, b)| codes(all, a, count) == codes(all, b, count)),
        Pixels::F32(all) => pairs.all(|(a, b)| codes(&all.values, a, count) == codes(&all.values, b, count)),
    }
}
