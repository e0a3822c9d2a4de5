//! The rows layout (MCT Algorithm 1) for 4D coordinates, the paper's: blocks from large to small, in rows from left to
//! right.

use super::scaled::{PackLimits, Sheet, extra_columns, segments, size, steps};
use super::{Block, Place, SEPARATION};

/// Packs blocks, within the largest side where that can be.
pub(super) fn pack(mut blocks: Vec<Block>, limits: PackLimits) -> Sheet {
    // Large to small: by height, then by width, then by face, so that the order is total.
    blocks.sort_by_key(|block| {
        let [r, s] = block.exponents;
        (std::cmp::Reverse((s, r, extra_columns(block.kind))), block.kind.first())
    });
    let square = square_width(&blocks);
    let mut row_starts = pack_rows(&mut blocks, square);
    if size(&blocks, 0)[1] > limits.side {
        // Rows that leave much empty make a square too high; wider ones may fit.
        row_starts = pack_rows(&mut blocks, limits.side);
    }
    Sheet { blocks, row_starts }
}

/// The side of a square that holds all blocks with their separation.
fn square_width(blocks: &[Block]) -> u32 {
    let padded = |block: &Block| {
        let [n, m] = segments(block).map(u64::from);
        (n + u64::from(steps(block.kind))) * (m + u64::from(SEPARATION))
    };
    (blocks.iter().map(padded).sum::<u64>() as f64).sqrt().ceil() as u32
}

/// Gives sorted blocks their places; returns the first block of each row.
fn pack_rows(blocks: &mut [Block], target_width: u32) -> Vec<usize> {
    let mut row_starts = Vec::new();
    let mut origin = [0u32; 2];
    let mut offset = [0u32; 2];
    let mut row_segments = 0;
    for (number, block) in blocks.iter_mut().enumerate() {
        let [n, m] = segments(block);
        // After narrow blocks a wide one may have to skip some texels; heights only fall.
        origin[0] = origin[0].next_multiple_of(n);
        let width = n + extra_columns(block.kind) + 1;
        if number == 0 || origin[0] + offset[0] + width > target_width && offset[0] > 0 {
            if number > 0 {
                origin = [0, origin[1] + row_segments];
                offset = [0, offset[1] + SEPARATION];
            }
            row_segments = m;
            row_starts.push(number);
        }
        block.place = Place::Scaled { part: 0, origin, offset };
        origin[0] += n;
        offset[0] += steps(block.kind);
    }
    row_starts
}
