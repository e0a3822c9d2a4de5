//! Fewer blocks: what was painted block by block is set out anew, without what stands there twice.
//!
//! Everything is decided by stored codes. Faces whose texels are equal in every channel at every level use one block
//! (`share`); neighbors that store the same along their common edge become one larger block (`join`). So nothing that a
//! viewer reads changes, whatever the source was: a texel is only read from another place.
//!
//! This needs blocks that have their corners on texel centers at every level, wherever they stand: indexed coordinates.

mod copy;
mod join;
mod share;
mod split;
#[cfg(test)]
mod tests;
mod texels;
mod turn;

use crate::error::Result;
use crate::image::Image;
use crate::layout::{Class, LONE_EXPONENT_MAX, Layout, Packing, Page, parted};
use crate::mesh::CanvasMesh;

pub use copy::Channel;
use join::patches;
use share::{Twin, twins};
use split::split;
use turn::Turn;

/// A material's finished level images with a layout for indexed coordinates.
pub struct Painted<'a> {
    pub canvas: &'a CanvasMesh,
    pub layout: &'a Layout,
    /// By channel, level 0 first.
    pub images: Vec<&'a [Image]>,
}

#[derive(Clone, Copy, Debug)]
pub struct PackOptions {
    /// Whether equal faces use one block.
    pub shares: bool,
    /// Largest side of an image. What needs more becomes several parts.
    pub max_side: u32,
    pub packing: Packing,
}

/// Where a face stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spot {
    pub part: u32,
    pub class: u32,
    /// Of its block in the class.
    pub number: u32,
    /// By corner: the place in the block, counted in faces.
    pub corners: [[u32; 2]; 4],
    /// Whether it is the second of two lone triangles.
    pub is_second: bool,
}

/// Blocks of one or several materials set out anew.
#[derive(Clone, Debug, Default)]
pub struct Packed {
    /// By part: one, but where an image would be too large.
    pub pages: Vec<Page>,
    /// By material and face.
    pub spots: Vec<Vec<Spot>>,
    pub savings: Savings,
    /// By part.
    pieces: Vec<Vec<Piece>>,
}

/// What is stored once instead of several times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Savings {
    /// Faces that have no texels of their own, and what they would take: at level 0, and at all levels.
    pub shared_count: u64,
    pub shared_texels: [u64; 2],
    /// Faces in larger blocks, and what standing alone would take more.
    pub joined_count: u64,
    pub joined_texels: [u64; 2],
}

/// A face's texels on their way.
#[derive(Clone, Copy, Debug)]
struct Piece {
    material: usize,
    face: u32,
    turn: Turn,
    part: u32,
    class: u32,
    number: u32,
    cell: [u32; 2],
    is_second: bool,
}

/// Faces in one block: one, two lone triangles, or a grid of quads.
struct Block {
    material: usize,
    class: Class,
    faces: Vec<(u32, Turn)>,
}

/// Sets out anew what was painted of materials that have the same channels, all together.
///
/// # Errors
/// `TextureTooLarge` where one block alone is.
pub fn pack(group: &[Painted<'_>], options: PackOptions) -> Result<Packed> {
    let level_count = group.iter().map(|painted| painted.layout.level_count()).max().unwrap_or(0);
    let twins: Vec<Vec<Option<Twin>>> = (group.iter())
        .map(|painted| if options.shares { twins(painted) } else { vec![None; painted.face_count()] })
        .collect();
    let each = group.iter().zip(&twins).enumerate();
    let blocks: Vec<Block> =
        each.flat_map(|(material, (painted, twins))| blocks(material, painted, twins)).collect();
    let mut packed = Packed {
        spots: group.iter().map(|painted| vec![Spot::default(); painted.face_count()]).collect(),
        savings: savings(group, &twins, &blocks),
        ..Packed::default()
    };
    for (part, mut blocks) in (0u32..).zip(split(blocks, options.max_side)?) {
        blocks.sort_by_key(Block::order);
        let (classes, _) = Class::number(blocks.iter().map(|block| block.class));
        let classes = match options.packing {
            Packing::Quick => classes,
            Packing::Tight => parted(&classes),
        };
        // Blocks stand in the order of their classes, and so of the parts.
        let places = (0u32..)
            .zip(&classes)
            .flat_map(|(class, of)| (0..of.block_count).map(move |number| [class, number]));
        let pieces = blocks.iter().zip(places).flat_map(|(block, place)| block.pieces(part, place));
        packed.pieces.push(pieces.collect());
        packed.pages.push(Page::new(classes, level_count, options.max_side, options.packing));
    }
    packed.find_spots(group, &twins);
    Ok(packed)
}

/// The blocks of all faces of a material that have texels of their own.
fn blocks(material: usize, painted: &Painted<'_>, twins: &[Option<Twin>]) -> Vec<Block> {
    let class = |cells, exponents, lone_count| Class { cells, exponents, lone_count, block_count: 0 };
    let quads = patches(painted, |face| twins[face].is_none());
    let mut blocks: Vec<Block> = quads
        .into_iter()
        .map(|patch| {
            let class = class(patch.cells, patch.exponents, 0);
            Block { material, class, faces: patch.faces }
        })
        .collect();
    // Lone triangles of one exponent two by two, but where they do better alone.
    let mut waiting: [Option<u32>; 32] = [None; 32];
    let lone = |exponent: u8, faces: &[u32]| Block {
        material,
        class: class([1, 1], [exponent; 2], faces.len() as u8),
        faces: faces.iter().map(|&face| (face, Turn::NONE)).collect(),
    };
    let is_lone = |face: &usize| painted.canvas.faces[*face].is_triangle() && twins[*face].is_none();
    for face in (0..twins.len()).filter(is_lone) {
        let [exponent, _] = painted.layout.block(face).exponents;
        if exponent <= LONE_EXPONENT_MAX {
            blocks.push(lone(exponent, &[face as u32]));
            continue;
        }
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

fn savings(group: &[Painted<'_>], twins: &[Vec<Option<Twin>>], blocks: &[Block]) -> Savings {
    let mut savings = Savings::default();
    let texels = |painted: &Painted<'_>, class: &Class| {
        let of_level = |level: usize| class.footprint(level).into_iter().map(u64::from).product::<u64>();
        [of_level(0), (0..painted.layout.level_count()).map(of_level).sum()]
    };
    for (painted, twins) in group.iter().zip(twins) {
        for face in (0..twins.len()).filter(|&face| twins[face].is_some()) {
            let block = painted.layout.block(face);
            let lone_count = match block.kind.is_lone() {
                false => 0,
                true if block.exponents[0] <= LONE_EXPONENT_MAX => 1,
                true => 2,
            };
            let alone = Class { cells: [1, 1], exponents: block.exponents, lone_count, block_count: 0 };
            let saved =
                texels(painted, &alone).map(|texels| if alone.has_two() { texels / 2 } else { texels });
            savings.shared_count += 1;
            savings.shared_texels = [0, 1].map(|k| savings.shared_texels[k] + saved[k]);
        }
    }
    for block in blocks.iter().filter(|block| block.class.cells != [1, 1]) {
        let painted = &group[block.material];
        let [alone, joined] =
            [Class { cells: [1, 1], ..block.class }, block.class].map(|class| texels(painted, &class));
        let count = block.faces.len() as u64;
        savings.joined_count += count;
        savings.joined_texels = [0, 1].map(|k| savings.joined_texels[k] + count * alone[k] - joined[k]);
    }
    savings
}

impl Painted<'_> {
    fn face_count(&self) -> usize {
        self.layout.placements.len()
    }
}

impl Block {
    /// In which blocks of a part stand: as [`Page::new`] and the table want it.
    fn order(&self) -> (u8, [u32; 2], [u8; 2], usize, u32) {
        (self.class.lone_count, self.class.cells, self.class.exponents, self.material, self.faces[0].0)
    }

    fn pieces(&self, part: u32, [class, number]: [u32; 2]) -> impl Iterator<Item = Piece> {
        (0u32..).zip(&self.faces).map(move |(place, &(face, turn))| {
            let is_second = self.class.has_two() && place == 1;
            let width = self.class.cells[0];
            let cell = if is_second { [0, 0] } else { [place % width, place / width] };
            Piece { material: self.material, face, turn, part, class, number, cell, is_second }
        })
    }
}

impl Packed {
    fn find_spots(&mut self, group: &[Painted<'_>], twins: &[Vec<Option<Twin>>]) {
        let mut piece_of: Vec<Vec<Option<&Piece>>> =
            group.iter().map(|painted| vec![None; painted.face_count()]).collect();
        for piece in self.pieces.iter().flatten() {
            piece_of[piece.material][piece.face as usize] = Some(piece);
        }
        for (material, (painted, spots)) in group.iter().zip(&mut self.spots).enumerate() {
            for (face, spot) in spots.iter_mut().enumerate() {
                let (of, turn) = match twins[material][face] {
                    Some(twin) => (twin.of as usize, twin.turn),
                    None => (face, Turn::NONE),
                };
                if let Some(piece) = piece_of[material][of] {
                    *spot = piece.spot(painted, face, turn);
                }
            }
        }
    }
}

impl Piece {
    /// Where a face stands that `turn` lays on this piece's.
    fn spot(&self, painted: &Painted<'_>, face: usize, turn: Turn) -> Spot {
        let all = turn.then(self.turn);
        let corners = [0, 1, 2, 3].map(|corner| {
            let unit = all.point(painted.unit(face, corner), [1, 1]);
            if self.is_second { unit.map(|at| 1 - at) } else { [0, 1].map(|k| self.cell[k] + unit[k]) }
        });
        Spot { part: self.part, class: self.class, number: self.number, corners, is_second: self.is_second }
    }
}
