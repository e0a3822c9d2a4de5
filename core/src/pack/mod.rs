//! Fewer blocks: what was painted block by block is set out anew, without what stands there twice.
//!
//! Everything is decided by stored codes. Faces whose texels are equal in every channel at every level use one block
//! (`share`); neighbors that store the same along their common edge become one larger block (`join`). So nothing that a
//! viewer reads changes, whatever the source was: a texel is only read from another place.
//!
//! This needs blocks that have their corners on texel centers at every level, wherever they stand: indexed coordinates.

mod classes;
mod copy;
mod join;
mod neighbors;
mod share;
mod split;
#[cfg(test)]
mod tests;
mod texels;
mod turn;

use crate::error::Result;
use crate::image::Image;
use crate::layout::{
    BlockKind, CLASS_COUNT_MAX, Class, Coordinates, Layout, LoneTriangles, Packing, Page, parted,
};
use crate::mesh::CanvasMesh;

use classes::with_few_classes;
pub use copy::Channel;
use join::patches;
use neighbors::{Patch, Pose};
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
    pose: Pose,
    part: u32,
    class: u32,
    number: u32,
    cell: [u32; 2],
    is_second: bool,
}

/// Faces in one block: one, two lone triangles in one cell, or a grid of quads.
struct Block {
    material: usize,
    patch: Patch,
    /// Of each of its faces as it lies.
    exponents: [u8; 2],
    /// As [`Class::lone_count`].
    lone_count: u8,
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
    let blocks = each.flat_map(|(material, (painted, twins))| blocks(material, painted, twins)).collect();
    let blocks = with_few_classes(blocks, CLASS_COUNT_MAX);
    let mut packed = Packed {
        spots: group.iter().map(|painted| vec![Spot::default(); painted.face_count()]).collect(),
        savings: savings(group, &twins, &blocks),
        ..Packed::default()
    };
    for (part, mut blocks) in (0u32..).zip(split(blocks, options.max_side)?) {
        blocks.sort_by_key(Block::order);
        let (classes, _) = Class::number(blocks.iter().map(Block::class));
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
    let block = |patch: Patch, lone_count| {
        let exponents = painted.exponents(patch.faces[0]);
        Block::new(material, patch, exponents, lone_count)
    };
    let joined = patches(painted, |face| twins[face].is_none());
    let mut blocks: Vec<Block> = joined.into_iter().map(|patch| block(patch, 0)).collect();
    let is_lone =
        |face: &u32| painted.canvas.faces[*face as usize].is_triangle() && twins[*face as usize].is_none();
    let mut lone = LoneTriangles::new(Coordinates::Indexed);
    let lone_faces = (0u32..).take(painted.face_count()).filter(is_lone);
    let completed: Vec<BlockKind> =
        lone_faces.filter_map(|face| lone.add(face, painted.exponents(Pose::upright(face))[0])).collect();
    let kinds = completed.into_iter().chain(lone.left().map(|(kind, _)| kind));
    blocks.extend(kinds.map(|kind| {
        let faces = kind.faces().map(|face| Pose::upright(face as u32)).collect();
        block(Patch { cells: [1, 1], faces }, kind.lone_count())
    }));
    blocks
}

fn savings(group: &[Painted<'_>], twins: &[Vec<Option<Twin>>], blocks: &[Block]) -> Savings {
    let mut savings = Savings::default();
    let texels = |painted: &Painted<'_>, class: &Class| {
        [class.texels(0), (0..painted.layout.level_count()).map(|level| class.texels(level)).sum()]
    };
    for (painted, twins) in group.iter().zip(twins) {
        for face in (0..twins.len()).filter(|&face| twins[face].is_some()) {
            let block = painted.layout.block(face);
            let lone_count = match block.kind.is_lone() {
                false => 0,
                true if Coordinates::Indexed.leaves_alone(block.exponents[0]) => 1,
                true => 2,
            };
            let alone = Class { cells: [1, 1], exponents: block.exponents, lone_count, block_count: 0 };
            let saved =
                texels(painted, &alone).map(|texels| if alone.has_two() { texels / 2 } else { texels });
            savings.shared_count += 1;
            savings.shared_texels = [0, 1].map(|k| savings.shared_texels[k] + saved[k]);
        }
    }
    for block in blocks.iter().filter(|block| block.patch.cells != [1, 1]) {
        let painted = &group[block.material];
        let joined = block.class();
        let [alone, joined] =
            [Class { cells: [1, 1], ..joined }, joined].map(|class| texels(painted, &class));
        let count = block.patch.faces.len() as u64;
        savings.joined_count += count;
        savings.joined_texels = [0, 1].map(|k| savings.joined_texels[k] + count * alone[k] - joined[k]);
    }
    savings
}

impl Painted<'_> {
    fn face_count(&self) -> usize {
        self.layout.placements.len()
    }

    /// Of a face as it lies.
    fn exponents(&self, pose: Pose) -> [u8; 2] {
        pose.turn.pair(self.layout.block(pose.face as usize).exponents)
    }
}

impl Block {
    /// The longer side along x. `exponents`: of each face as it lies.
    fn new(material: usize, patch: Patch, exponents: [u8; 2], lone_count: u8) -> Self {
        let ([r, s], [width, height]) = (exponents, patch.cells);
        if (r, width) >= (s, height) {
            Self { material, patch, exponents, lone_count }
        } else {
            Self { material, patch: patch.turned(Turn::SWAP), exponents: [s, r], lone_count }
        }
    }

    fn class(&self) -> Class {
        let Self { exponents, lone_count, .. } = *self;
        Class { cells: self.patch.cells, exponents, lone_count, block_count: 0 }
    }

    /// In which blocks of a part stand: as [`Page::new`] and the table want it.
    fn order(&self) -> (u8, [u32; 2], [u8; 2], usize, u32) {
        (self.lone_count, self.patch.cells, self.exponents, self.material, self.patch.faces[0].face)
    }

    fn pieces(&self, part: u32, [class, number]: [u32; 2]) -> impl Iterator<Item = Piece> {
        let material = self.material;
        let piece =
            move |pose, cell, is_second| Piece { material, pose, part, class, number, cell, is_second };
        let second = self.patch.faces.get(1).filter(|_| self.class().has_two());
        let cells = self.patch.cells_in_order().zip(&self.patch.faces);
        cells
            .map(move |(cell, &pose)| piece(pose, cell, false))
            .chain(second.map(|&pose| piece(pose, [0, 0], true)))
    }
}

impl Packed {
    fn find_spots(&mut self, group: &[Painted<'_>], twins: &[Vec<Option<Twin>>]) {
        let mut piece_of: Vec<Vec<Option<&Piece>>> =
            group.iter().map(|painted| vec![None; painted.face_count()]).collect();
        for piece in self.pieces.iter().flatten() {
            piece_of[piece.material][piece.pose.face as usize] = Some(piece);
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
        let all = turn.then(self.pose.turn);
        let corners = [0, 1, 2, 3].map(|corner| {
            let unit = all.point(painted.unit(face, corner), [1, 1]);
            if self.is_second { unit.map(|at| 1 - at) } else { [0, 1].map(|k| self.cell[k] + unit[k]) }
        });
        Spot { part: self.part, class: self.class, number: self.number, corners, is_second: self.is_second }
    }
}
