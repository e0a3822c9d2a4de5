//! The rows layout (MCT Algorithm 1): blocks from large to small, in rows from left to right.

use crate::colors::Resolutions;
use crate::error::{Error, ErrorCode, Result};
use crate::mesh::CanvasMesh;

use super::{Block, BlockKind, Layout, Placement, SEPARATION, TWIN_SHIFT};

/// Larger textures than any device takes, and samples are numbered in 32 bits, three to a normal.
const SIDE_MAX: u32 = 32_768;

/// What a layout is made from.
pub struct LayoutRequest<'a> {
    pub canvas: &'a CanvasMesh,
    pub resolutions: &'a Resolutions,
    /// By face: the edge that a lone triangle puts on its diagonal.
    pub diagonals: &'a [u8],
    pub level_count: usize,
    /// Largest side of an image.
    pub side_limit: u32,
}

/// Places every face.
///
/// # Errors
/// `TextureTooLarge` where level 0 would exceed the limit.
pub fn arrange(request: &LayoutRequest<'_>) -> Result<Layout> {
    let mut blocks = blocks(request);
    // Large to small; within a size the wide ones first, then by face, so that the order is total.
    blocks.sort_by_key(|block| {
        (std::cmp::Reverse((block.segments, block.kind.extra_columns())), block.kind.first())
    });
    let side_limit = request.side_limit.min(SIDE_MAX);
    let size_at = |blocks: &[Block], level: usize| {
        let ends = blocks.iter().map(|block| block.end(level));
        ends.fold([1, 1], |size, end| [size[0].max(end[0]), size[1].max(end[1])])
    };
    let square = square_width(&blocks);
    let mut row_starts = pack(&mut blocks, square);
    if size_at(&blocks, 0)[1] > side_limit {
        // Rows that leave much empty make a square too high; wider ones may fit.
        row_starts = pack(&mut blocks, side_limit);
    }
    check_size(size_at(&blocks, 0), side_limit)?;
    let sizes: Vec<[u32; 2]> = (0..request.level_count).map(|level| size_at(&blocks, level)).collect();
    let placements = placements(request, &blocks);
    Ok(Layout { blocks, row_starts, placements, sizes })
}

fn check_size(size: [u32; 2], limit: u32) -> Result<()> {
    let side = size[0].max(size[1]);
    if side <= limit {
        return Ok(());
    }
    let detail = format!(
        "the layout needs {} x {} texels, more than the {limit} a side that is allowed; \
         ask for less with --resolution (area:F with a smaller F, or fixed:R with a smaller R)",
        size[0], size[1]
    );
    Err(Error::new(ErrorCode::TextureTooLarge, detail).limit(limit.into(), side.into()))
}

fn blocks(request: &LayoutRequest<'_>) -> Vec<Block> {
    let LayoutRequest { canvas, resolutions, .. } = request;
    let block = |kind, exponent: u8| Block { kind, segments: 1 << exponent, origin: [0; 2], offset: [0; 2] };
    let mut blocks = Vec::new();
    let mut waiting: [Option<u32>; 32] = [None; 32];
    for (face, canvas_face) in (0u32..).zip(&canvas.faces) {
        let [exponent, _] = resolutions.faces[face as usize];
        if !canvas_face.is_triangle() {
            blocks.push(block(BlockKind::Quad(face), exponent));
            continue;
        }
        match waiting[usize::from(exponent)].take() {
            Some(first) => blocks.push(block(BlockKind::Twins([first, face]), exponent)),
            None => waiting[usize::from(exponent)] = Some(face),
        }
    }
    let left = (0u8..).zip(waiting).filter_map(|(exponent, face)| face.map(|face| (exponent, face)));
    blocks.extend(left.map(|(exponent, face)| block(BlockKind::Lone(face), exponent)));
    blocks
}

/// The side of a square that holds all blocks with their separation.
fn square_width(blocks: &[Block]) -> u32 {
    let padded = |block: &Block| {
        let side = u64::from(block.segments + SEPARATION);
        side * (side + u64::from(block.kind.extra_columns()))
    };
    (blocks.iter().map(padded).sum::<u64>() as f64).sqrt().ceil() as u32
}

/// Gives sorted blocks their origins and offsets; returns the first block of each row.
///
/// Along a row `u_s` starts where the block before ends and `u_δ` grows by the separation, so blocks stay
/// apart at every level; sides are powers of two from large to small, so `u_s` is always a multiple of the
/// block's own side.
fn pack(blocks: &mut [Block], target_width: u32) -> Vec<usize> {
    let mut row_starts = Vec::new();
    let mut origin = [0u32; 2];
    let mut offset = [0u32; 2];
    let mut row_segments = 0;
    for (number, block) in blocks.iter_mut().enumerate() {
        let width = block.segments + block.kind.extra_columns() + 1;
        if number == 0 || origin[0] + offset[0] + width > target_width && offset[0] > 0 {
            if number > 0 {
                origin = [0, origin[1] + row_segments];
                offset = [0, offset[1] + SEPARATION];
            }
            row_segments = block.segments;
            row_starts.push(number);
        }
        block.origin = origin;
        block.offset = offset;
        origin[0] += block.segments;
        offset[0] += SEPARATION + block.kind.extra_columns();
    }
    row_starts
}

fn placements(request: &LayoutRequest<'_>, blocks: &[Block]) -> Vec<Placement> {
    let mut placements = vec![Placement::default(); request.canvas.faces.len()];
    for (number, block) in (0u32..).zip(blocks) {
        let mut put = |face: u32, corners, shift| {
            placements[face as usize] = Placement { block: number, corners, shift };
        };
        match block.kind {
            BlockKind::Quad(face) => put(face, [[0, 0], [1, 0], [1, 1], [0, 1]], 0),
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
