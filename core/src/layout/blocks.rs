//! Which blocks there are, before they have places.

use super::{Block, BlockKind, LONE_EXPONENT_MAX, LayoutRequest, Place, Placement, TWIN_SHIFT};

/// Quads, and lone triangles of one exponent two by two in face order, but where they do better alone.
pub(super) fn blocks(request: &LayoutRequest<'_>, place: Place) -> Vec<Block> {
    let block = |kind, [r, s]: [u8; 2]| Block { kind, exponents: [r.max(s), r.min(s)], place };
    let mut blocks = Vec::new();
    let mut waiting: [Option<u32>; 32] = [None; 32];
    for (face, canvas_face) in (0u32..).zip(&request.canvas.faces) {
        let exponents = request.resolutions.faces[face as usize];
        if !canvas_face.is_triangle() {
            blocks.push(block(BlockKind::Quad(face), exponents));
            continue;
        }
        if matches!(place, Place::Indexed { .. }) && exponents[0] <= LONE_EXPONENT_MAX {
            blocks.push(block(BlockKind::Lone(face), exponents));
            continue;
        }
        let waiting = &mut waiting[usize::from(exponents[0])];
        match waiting.take() {
            Some(first) => blocks.push(block(BlockKind::Twins([first, face]), exponents)),
            None => *waiting = Some(face),
        }
    }
    let left = (0u8..).zip(waiting).filter_map(|(exponent, face)| face.map(|face| (exponent, face)));
    blocks.extend(left.map(|(exponent, face)| block(BlockKind::Lone(face), [exponent; 2])));
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
