//! The rows layout (MCT Algorithm 1) for 4D coordinates: blocks from large to small, in rows from left to right.

use super::blocks::{blocks, placements};
use super::{Band, Block, BlockKind, Layout, LayoutRequest, Place, SEPARATION, SIDE_MAX, TWIN_SHIFT};

/// Places every face, within the largest side where that can be.
pub(super) fn arrange(request: &LayoutRequest<'_>) -> Layout {
    let mut blocks = blocks(request, Place::Scaled { origin: [0; 2], offset: [0; 2] });
    // Large to small; within a size the wide ones first, then by face, so that the order is total.
    blocks.sort_by_key(|block| {
        (std::cmp::Reverse((block.exponents[0], extra_columns(block.kind))), block.kind.first())
    });
    let side_limit = request.side_limit.min(SIDE_MAX);
    let size_at = |blocks: &[Block], level: usize| {
        let ends = blocks.iter().map(|block| end(block, level));
        ends.fold([1, 1], |size, end| [size[0].max(end[0]), size[1].max(end[1])])
    };
    let square = square_width(&blocks);
    let mut row_starts = pack(&mut blocks, square);
    if size_at(&blocks, 0)[1] > side_limit {
        // Rows that leave much empty make a square too high; wider ones may fit.
        row_starts = pack(&mut blocks, side_limit);
    }
    let levels = 0..request.level_count;
    let sizes: Vec<[u32; 2]> = levels.clone().map(|level| size_at(&blocks, level)).collect();
    let bands = levels.map(|level| bands(&blocks, &row_starts, level)).collect();
    let placements = placements(request, &blocks);
    Layout { blocks, placements, sizes, bands, ..Layout::default() }
}

/// Extra columns beyond `n + 1`.
fn extra_columns(kind: BlockKind) -> u32 {
    match kind {
        BlockKind::Quad(_) | BlockKind::Lone(_) => 0,
        BlockKind::Twins(_) => TWIN_SHIFT,
    }
}

/// Segments along a side.
fn segments(block: &Block) -> u32 {
    1 << block.exponents[0]
}

fn origin_offset(block: &Block) -> [[u32; 2]; 2] {
    match block.place {
        Place::Scaled { origin, offset } => [origin, offset],
        Place::Indexed { .. } => [[0; 2]; 2],
    }
}

/// One past the last texel that the block may touch at a level.
pub(super) fn end(block: &Block, level: usize) -> [u32; 2] {
    let extra = [extra_columns(block.kind), 0];
    let [origin, offset] = origin_offset(block);
    [0, 1].map(|k| {
        let last = (origin[k] + segments(block)) >> level;
        // Beyond vertex colors the corner lies between texels, or on one with a spare texel beside it.
        let spare = u32::from(segments(block) >> level == 0);
        last + offset[k] + extra[k] + spare + 1
    })
}

/// Each row of blocks is a band.
fn bands(blocks: &[Block], row_starts: &[usize], level: usize) -> Vec<Band> {
    let ends = row_starts.iter().skip(1).copied().chain([blocks.len()]);
    let band = |(&start, end): (&usize, usize)| {
        let [origin, offset] = origin_offset(&blocks[start]);
        Band { first_row: (origin[1] >> level) + offset[1], blocks: std::iter::once(start..end).collect() }
    };
    row_starts.iter().zip(ends).map(band).collect()
}

/// The side of a square that holds all blocks with their separation.
fn square_width(blocks: &[Block]) -> u32 {
    let padded = |block: &Block| {
        let side = u64::from(segments(block) + SEPARATION);
        side * (side + u64::from(extra_columns(block.kind)))
    };
    (blocks.iter().map(padded).sum::<u64>() as f64).sqrt().ceil() as u32
}

/// Gives sorted blocks their places; returns the first block of each row.
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
        let width = segments(block) + extra_columns(block.kind) + 1;
        if number == 0 || origin[0] + offset[0] + width > target_width && offset[0] > 0 {
            if number > 0 {
                origin = [0, origin[1] + row_segments];
                offset = [0, offset[1] + SEPARATION];
            }
            row_segments = segments(block);
            row_starts.push(number);
        }
        block.place = Place::Scaled { origin, offset };
        origin[0] += segments(block);
        offset[0] += SEPARATION + extra_columns(block.kind);
    }
    row_starts
}
