//! Fewer blocks: what was painted block by block is set out anew, without what stands there twice.
//!
//! Everything is decided by stored codes. Faces whose texels are equal in every channel at every level use one block
//! (`share`); neighbors that store the same along their common edge become one larger block (`join`). So nothing that a
//! viewer reads changes, whatever the source was: a texel is only read from another place.
//!
//! This needs blocks that have their corners on texel centers at every level, wherever they stand: indexed coordinates.

mod join;
mod share;
#[cfg(test)]
mod tests;
mod texels;
mod turn;

use rayon::prelude::*;

use crate::image::{Image, Pixels};
use crate::layout::{Class, Layout, Page};
use crate::mesh::CanvasMesh;

use join::patches;
use share::{Twin, twins};
use texels::FaceTexels;
use turn::Turn;

/// A material's finished level images with a layout for indexed coordinates.
pub struct Painted<'a> {
    pub canvas: &'a CanvasMesh,
    pub layout: &'a Layout,
    /// By channel, level 0 first.
    pub images: Vec<&'a [Image]>,
}

/// Where a face stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spot {
    pub class: u32,
    /// Of its block in the class.
    pub number: u32,
    /// By corner: the place in the block, counted in faces.
    pub corners: [[u32; 2]; 4],
    /// Whether it is the second of two lone triangles.
    pub is_second: bool,
}

/// Blocks set out anew.
#[derive(Clone, Debug, Default)]
pub struct Packed {
    pub page: Page,
    /// By face.
    pub spots: Vec<Spot>,
    /// Faces that have no texels of their own.
    pub shared_count: u64,
    /// Faces in blocks of several.
    pub joined_count: u64,
    pieces: Vec<Piece>,
}

/// A face's texels on their way.
#[derive(Clone, Copy, Debug)]
struct Piece {
    face: u32,
    turn: Turn,
    class: u32,
    number: u32,
    cell: [u32; 2],
    is_second: bool,
}

/// Faces in one block: one, two lone triangles, or a grid of quads.
struct Block {
    class: Class,
    faces: Vec<(u32, Turn)>,
}

/// Sets out what was painted. `shares`: whether equal faces use one block.
pub fn pack(painted: &Painted<'_>, shares: bool, side_limit: u32) -> Packed {
    let face_count = painted.layout.placements.len();
    let twins = if shares { twins(painted) } else { vec![None; face_count] };
    let mut blocks = blocks(painted, &twins);
    blocks.sort_by_key(|block| {
        (block.class.is_lone, block.class.cells, block.class.exponents, block.faces[0].0)
    });
    let (classes, places) = Class::number(blocks.iter().map(|block| block.class));
    let mut packed = Packed {
        page: Page::new(classes, painted.layout.level_count(), side_limit),
        spots: vec![Spot::default(); face_count],
        shared_count: twins.iter().flatten().count() as u64,
        ..Packed::default()
    };
    for (block, [class, number]) in blocks.iter().zip(places) {
        packed.joined_count +=
            if block.class.is_lone || block.faces.len() == 1 { 0 } else { block.faces.len() as u64 };
        for (place, &(face, turn)) in (0u32..).zip(&block.faces) {
            let is_second = block.class.is_lone && place == 1;
            let width = block.class.cells[0];
            let cell = if is_second { [0, 0] } else { [place % width, place / width] };
            packed.pieces.push(Piece { face, turn, class, number, cell, is_second });
        }
    }
    for piece in &packed.pieces {
        packed.spots[piece.face as usize] = piece.spot(painted, piece.face as usize, Turn::NONE);
    }
    // Those of faces without texels by the pieces of the faces that stand for them.
    let mut piece_of = vec![0; face_count];
    for (number, piece) in packed.pieces.iter().enumerate() {
        piece_of[piece.face as usize] = number;
    }
    for (face, twin) in twins.iter().enumerate().filter_map(|(face, twin)| Some((face, twin.as_ref()?))) {
        let piece = &packed.pieces[piece_of[twin.of as usize]];
        packed.spots[face] = piece.spot(painted, face, twin.turn);
    }
    packed
}

/// The blocks of all faces that have texels of their own.
fn blocks(painted: &Painted<'_>, twins: &[Option<Twin>]) -> Vec<Block> {
    let class = |cells, exponents, is_lone| Class { cells, exponents, is_lone, block_count: 0 };
    let quads = patches(painted, |face| twins[face].is_none());
    let mut blocks: Vec<Block> = quads
        .into_iter()
        .map(|patch| Block { class: class(patch.cells, patch.exponents, false), faces: patch.faces })
        .collect();
    // Lone triangles of one exponent two by two.
    let mut waiting: [Option<u32>; 32] = [None; 32];
    let lone = |exponent: u8, faces: &[u32]| Block {
        class: class([1, 1], [exponent; 2], true),
        faces: faces.iter().map(|&face| (face, Turn::NONE)).collect(),
    };
    for face in
        (0..twins.len()).filter(|&face| painted.canvas.faces[face].is_triangle() && twins[face].is_none())
    {
        let [exponent, _] = painted.layout.block(face).exponents;
        let waiting = &mut waiting[usize::from(exponent)];
        match waiting.take() {
            Some(first) => blocks.push(lone(exponent, &[first, face as u32])),
            None => *waiting = Some(face as u32),
        }
    }
    let left = (0u8..).zip(waiting).filter_map(|(exponent, face)| Some(lone(exponent, &[face?])));
    blocks.extend(left);
    blocks
}

impl Piece {
    /// Where a face stands that `turn` lays on this piece's.
    fn spot(&self, painted: &Painted<'_>, face: usize, turn: Turn) -> Spot {
        let all = turn.then(self.turn);
        let corners = [0, 1, 2, 3].map(|corner| {
            let unit = all.point(painted.unit(face, corner), [1, 1]);
            if self.is_second { unit.map(|at| 1 - at) } else { [0, 1].map(|k| self.cell[k] + unit[k]) }
        });
        Spot { class: self.class, number: self.number, corners, is_second: self.is_second }
    }
}

impl Packed {
    /// A channel's level images as they are set out anew.
    pub fn images(&self, layout: &Layout, levels: &[Image]) -> Vec<Image> {
        levels.par_iter().enumerate().map(|(level, image)| self.image(layout, level, image)).collect()
    }

    fn image(&self, layout: &Layout, level: usize, image: &Image) -> Image {
        let [width, height] = self.page.sizes[level];
        let code_count = width as usize * height as usize * usize::from(image.components);
        let pixels = match &image.pixels {
            Pixels::U8(codes) => Pixels::U8(self.codes(layout, level, image, codes, code_count)),
            Pixels::U16(codes) => Pixels::U16(self.codes(layout, level, image, codes, code_count)),
        };
        Image { width, height, components: image.components, pixels }
    }

    fn codes<T: Copy + Default>(
        &self,
        layout: &Layout,
        level: usize,
        image: &Image,
        codes: &[T],
        code_count: usize,
    ) -> Vec<T> {
        let mut copied = vec![T::default(); code_count];
        let count = usize::from(image.components);
        for piece in &self.pieces {
            let from = FaceTexels::of_face(layout, piece.face as usize, level).turned(piece.turn);
            let to = self.texels(piece, level);
            for (from, to) in from.rows().zip(to.rows()) {
                for (from, to) in from.zip(to) {
                    copied[to * count..(to + 1) * count]
                        .copy_from_slice(&codes[from * count..(from + 1) * count]);
                }
            }
        }
        copied
    }

    fn texels(&self, piece: &Piece, level: usize) -> FaceTexels {
        let class = &self.page.classes[piece.class as usize];
        let segments = class.segments(level);
        let [x, y] = self.page.grids[level][piece.class as usize].first_texel(class, level, piece.number);
        let first = [x + piece.cell[0] * segments[0], y + piece.cell[1] * segments[1]];
        FaceTexels::new(first, segments, self.page.sizes[level][0], class.is_lone, piece.is_second)
    }
}
