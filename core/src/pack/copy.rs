//! Level images set out anew, texel by texel as they are.

use rayon::prelude::*;

use super::texels::FaceTexels;
use super::{Packed, Piece};
use crate::image::{Image, Pixels};
use crate::layout::Layout;

/// What a channel of one material was painted to.
pub struct Channel<'a> {
    pub layout: &'a Layout,
    pub levels: &'a [Image],
}

impl Channel<'_> {
    /// A material that has fewer levels than others goes on with its last: its faces are down to their corners.
    fn level(&self, level: usize) -> (usize, &Image) {
        let level = level.min(self.levels.len() - 1);
        (level, &self.levels[level])
    }
}

impl Packed {
    /// The level images of one part of a channel. `materials`: what was painted of it for each material, images of equal
    /// components and bits.
    pub fn images(&self, part: usize, materials: &[Channel<'_>]) -> Vec<Image> {
        let levels = 0..self.pages[part].sizes.len();
        levels.into_par_iter().map(|level| self.image(part, level, materials)).collect()
    }

    fn image(&self, part: usize, level: usize, materials: &[Channel<'_>]) -> Image {
        let [width, height] = self.pages[part].sizes[level];
        let (_, like) = materials[0].level(level);
        let code_count = width as usize * height as usize * usize::from(like.components);
        let mut pixels = match &like.pixels {
            Pixels::U8(_) => Pixels::U8(vec![0; code_count]),
            Pixels::U16(_) | Pixels::F32(_) => Pixels::U16(vec![0; code_count]),
        };
        let components = usize::from(like.components);
        for piece in &self.pieces[part] {
            let channel = &materials[piece.material];
            let (old_level, image) = channel.level(level);
            let from = FaceTexels::of_face(channel.layout, piece.pose.face as usize, old_level)
                .turned(piece.pose.turn);
            let texels = [from, self.texels(piece, level)];
            match (&image.pixels, &mut pixels) {
                (Pixels::U8(from), Pixels::U8(to)) => copy(texels, components, from, to),
                (Pixels::U16(from), Pixels::U16(to)) => copy(texels, components, from, to),
                _ => {}
            }
        }
        Image { width, height, components: like.components, pixels }
    }

    fn texels(&self, piece: &Piece, level: usize) -> FaceTexels {
        let page = &self.pages[piece.part as usize];
        let class = &page.classes[piece.class as usize];
        let segments = class.segments(level);
        let [x, y] = page.grids[level][piece.class as usize].first_texel(class, level, piece.number);
        let first = [x + piece.cell[0] * segments[0], y + piece.cell[1] * segments[1]];
        FaceTexels::new(first, segments, page.sizes[level][0], class.lone_count > 0, piece.is_second)
    }
}

fn copy<T: Copy>([from, to]: [FaceTexels; 2], components: usize, codes: &[T], copied: &mut [T]) {
    for (from, to) in from.rows().zip(to.rows()) {
        for (from, to) in from.zip(to) {
            let [from, to] = [from, to].map(|texel| texel * components..(texel + 1) * components);
            copied[to].copy_from_slice(&codes[from]);
        }
    }
}
