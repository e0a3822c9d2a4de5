//! What every packing for 4D coordinates does with a block, `u_level = u_s / 2^level + u_δ` (MCT equation 2).
//!
//! One block is beside another at every level where its `u_s` begins at the other's end or later and its `u_δ` is
//! larger by what the other takes at every level, [`steps`]: the lone triangles' distance and the separation. A block
//! begins at a multiple of its own side along each axis. Up to vertex colors that puts its samples on texel centers;
//! beyond them the whole side lies between two neighboring multiples of `2^level`, so that a footprint is two texels wide
//! (three where it ends on the second one's center), which the separation leaves room for.

use super::blocks::placements;
use super::{Band, Block, BlockKind, Layout, LayoutRequest, Place, SEPARATION, TWIN_SHIFT};

/// Before anything is packed.
pub(super) const NOWHERE: Place = Place::Scaled { origin: [0; 2], offset: [0; 2] };

/// Extra columns beyond `n + 1`.
pub(super) fn extra_columns(kind: BlockKind) -> u32 {
    match kind {
        BlockKind::Quad(_) | BlockKind::Lone(_) => 0,
        BlockKind::Twins(_) => TWIN_SHIFT,
    }
}

/// Texels that a block takes along x at every level, whatever is left of its segments.
pub(super) fn steps(kind: BlockKind) -> u32 {
    SEPARATION + extra_columns(kind)
}

/// Segments along both sides.
pub(super) fn segments(block: &Block) -> [u32; 2] {
    block.exponents.map(|exponent| 1 << exponent)
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
    let segments = segments(block);
    [0, 1].map(|k| {
        let last = (origin[k] + segments[k]) >> level;
        // Beyond vertex colors the corner lies between texels, or on one with a spare texel beside it.
        let spare = u32::from(segments[k] >> level == 0);
        last + offset[k] + extra[k] + spare + 1
    })
}

/// Level 0, or another one.
pub(super) fn size(blocks: &[Block], level: usize) -> [u32; 2] {
    let ends = blocks.iter().map(|block| end(block, level));
    ends.fold([1, 1], |size, end| [size[0].max(end[0]), size[1].max(end[1])])
}

/// Places of packed blocks. Blocks of one row follow each other; `row_starts` are the first ones, and no row begins
/// above the end of the one before.
pub(super) fn layout(request: &LayoutRequest<'_>, blocks: Vec<Block>, row_starts: &[usize]) -> Layout {
    let ends = || row_starts.iter().skip(1).copied().chain([blocks.len()]);
    let levels = 0..request.level_count;
    let sizes = levels.clone().map(|level| size(&blocks, level)).collect();
    let band = |level: usize, (&start, end): (&usize, usize)| {
        let [origin, offset] = origin_offset(&blocks[start]);
        Band { first_row: (origin[1] >> level) + offset[1], blocks: std::iter::once(start..end).collect() }
    };
    let bands =
        levels.map(|level| row_starts.iter().zip(ends()).map(|row| band(level, row)).collect()).collect();
    let placements = placements(request, &blocks);
    Layout { blocks, placements, sizes, bands, ..Layout::default() }
}
