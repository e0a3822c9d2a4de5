//! Which blocks there are, before they have places.

use super::{Block, BlockKind, Coordinates, LayoutRequest, Place, Placement, TWIN_SHIFT};

/// Lone triangles on their way into blocks: those of one exponent two by two, but where they do better alone.
pub struct LoneTriangles {
    coordinates: Coordinates,
    /// By exponent.
    waiting: [Option<u32>; 32],
}

impl LoneTriangles {
    pub fn new(coordinates: Coordinates) -> Self {
        Self { coordinates, waiting: [None; 32] }
    }

    /// The block that a triangle completes: its own, or that of one that has waited for it.
    pub fn add(&mut self, face: u32, exponent: u8) -> Option<BlockKind> {
        if self.coordinates.leaves_alone(exponent) {
            return Some(BlockKind::Lone(face));
        }
        let waiting = &mut self.waiting[usize::from(exponent)];
        match waiting.take() {
            Some(first) => Some(BlockKind::Twins([first, face])),
            None => {
                *waiting = Some(face);
                None
            }
        }
    }

    /// Blocks of those that still wait, and their exponents.
    pub fn left(self) -> impl Iterator<Item = (BlockKind, u8)> {
        let all = self.waiting.into_iter().zip(0u8..);
        all.filter_map(|(face, exponent)| Some((BlockKind::Lone(face?), exponent)))
    }
}

/// Quads, and lone triangles.
pub(super) fn blocks(request: &LayoutRequest<'_>, place: Place) -> Vec<Block> {
    let block = |kind, [r, s]: [u8; 2]| Block { kind, exponents: [r.max(s), r.min(s)], place };
    let mut lone = LoneTriangles::new(request.coordinates);
    let mut blocks = Vec::new();
    for (face, canvas_face) in (0u32..).zip(&request.canvas.faces) {
        let exponents = request.resolutions.faces[face as usize];
        let kind = match canvas_face.is_triangle() {
            true => lone.add(face, exponents[0]),
            false => Some(BlockKind::Quad(face)),
        };
        blocks.extend(kind.map(|kind| block(kind, exponents)));
    }
    blocks.extend(lone.left().map(|(kind, exponent)| block(kind, [exponent; 2])));
    blocks
}

/// By face, given all blocks in their order.
pub(super) fn placements(request: &LayoutRequest<'_>, blocks: &[Block]) -> Vec<Placement> {
    let mut placements = vec![Placement::default(); request.canvas.faces.len()];
    for (number, block) in (0u32..).zip(blocks) {
        let mut put = |face: u32, corners, shift| {
            placements[face as usize] = Placement { block: number, corners, shift };
        };
        match block.kind {
            BlockKind::Quad(face) => {
                let [r, s] = request.resolutions.faces[face as usize];
                let upright = [[0, 0], [1, 0], [1, 1], [0, 1]];
                put(face, if r < s { upright.map(|[x, y]| [y, x]) } else { upright }, 0);
            }
            BlockKind::Lone(face) => put(face, half(request.diagonals[face as usize]), 0),
            BlockKind::Twins([first, second]) => {
                put(first, half(request.diagonals[first as usize]), 0);
                put(second, turned(half(request.diagonals[second as usize])), TWIN_SHIFT);
            }
        }
    }
    placements
}

/// A triangle on the half square at (0, 0), with edge `diagonal` on the diagonal.
fn half(diagonal: u8) -> [[u8; 2]; 4] {
    let mut corners = [[0; 2]; 4];
    let first = usize::from(diagonal);
    corners[first] = [1, 0];
    corners[(first + 1) % 3] = [0, 1];
    corners
}

fn turned(corners: [[u8; 2]; 4]) -> [[u8; 2]; 4] {
    corners.map(|[x, y]| [1 - x, 1 - y])
}
