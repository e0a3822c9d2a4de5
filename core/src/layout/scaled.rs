//! What every packing for 4D coordinates does with a block, `u_level = u_s / 2^level + u_δ` (MCT equation 2).
//!
//! One block is beside another at every level where its `u_s` begins at the other's end or later and its `u_δ` is
//! larger by what the other takes at every level, [`steps`]: the lone triangles' distance and the separation. A block
//! begins at a multiple of its own side along each axis. Up to vertex colors that puts its samples on texel centers;
//! beyond them the whole side lies between two neighboring multiples of `2^level`, so that a footprint is two texels wide
//! (three where it ends on the second one's center), which the separation leaves room for.

use std::ops::Range;

use super::blocks::{blocks, placements};
use super::{Band, Block, BlockKind, Layout, LayoutRequest, Part, Place, SEPARATION, TWIN_SHIFT, split};
use crate::error::Result;

/// Before anything is packed.
const NOWHERE: Place = Place::Scaled { part: 0, origin: [0; 2], offset: [0; 2] };

/// Blocks at their places in one part. Those of one row follow each other.
pub(super) struct Sheet {
    pub blocks: Vec<Block>,
    /// The first block of each row. No row begins above the end of the one before.
    pub row_starts: Vec<usize>,
}

/// What a packing keeps to.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackLimits {
    pub level_count: usize,
    /// Largest side, where that can be.
    pub side: u32,
}

/// Places every face of all materials, in as many parts as it takes.
///
/// # Errors
/// `TextureTooLarge` where one block alone is.
pub(super) fn arrange(
    requests: &[LayoutRequest<'_>],
    pack: impl Fn(Vec<Block>, PackLimits) -> Sheet,
) -> Result<Vec<Layout>> {
    let level_count = requests.iter().map(|request| request.level_count).max().unwrap_or(0);
    let side = requests.iter().map(|request| request.part_side).min().unwrap_or(0);
    let limits = PackLimits { level_count, side };
    // Faces are numbered through over all materials.
    let mut first = 0;
    let mut all = Vec::new();
    let faces_of: Vec<Range<u32>> = (requests.iter())
        .map(|request| {
            let faces = first..first + request.canvas.faces.len() as u32;
            let of_all = |block: Block| Block { kind: block.kind.renumbered(|face| first + face), ..block };
            all.extend(blocks(request, NOWHERE).into_iter().map(of_all));
            first = faces.end;
            faces
        })
        .collect();
    // In the order of faces, so that neighbors mostly stand together and few primitives are in several parts.
    all.sort_by_key(|block| block.kind.first());
    let alone = |block: &Block| {
        let [n, m] = segments(block);
        [n + extra_columns(block.kind) + 1, m + 1]
    };
    let mut sheets: Vec<Sheet> = Vec::new();
    split(all, side, alone, |parts| {
        sheets = parts.iter().map(|blocks| pack(blocks.iter().copied().copied().collect(), limits)).collect();
        sheets.iter().all(|sheet| size(&sheet.blocks, 0).into_iter().all(|side| side <= limits.side))
    })?;
    let stack = Stack::new(sheets, level_count);
    Ok(requests.iter().zip(faces_of).map(|(request, faces)| stack.layout(request, faces)).collect())
}

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
        Place::Scaled { origin, offset, .. } => [origin, offset],
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

/// Sheets one below the other.
struct Stack {
    sheets: Vec<Sheet>,
    parts: Vec<Part>,
    /// By level.
    sizes: Vec<[u32; 2]>,
}

impl Stack {
    fn new(sheets: Vec<Sheet>, level_count: usize) -> Self {
        let mut parts: Vec<Part> = sheets.iter().map(|_| Part::default()).collect();
        let mut sizes = vec![[0; 2]; level_count];
        for (level, whole) in sizes.iter_mut().enumerate() {
            for (sheet, part) in sheets.iter().zip(&mut parts) {
                let [width, height] = size(&sheet.blocks, level);
                part.sizes.push([width, height]);
                part.first_rows.push(whole[1]);
                *whole = [whole[0].max(width), whole[1] + height];
            }
        }
        Self { sheets, parts, sizes }
    }

    /// That of one material.
    fn layout(&self, request: &LayoutRequest<'_>, faces: Range<u32>) -> Layout {
        let mut layout = Layout { sizes: self.sizes.clone(), parts: self.parts.clone(), ..Layout::default() };
        layout.bands.resize_with(self.sizes.len(), Vec::new);
        for (number, (sheet, part)) in (0u32..).zip(self.sheets.iter().zip(&self.parts)) {
            let ends = sheet.row_starts.iter().skip(1).copied().chain([sheet.blocks.len()]);
            for row in sheet.row_starts.iter().zip(ends).map(|(&start, end)| &sheet.blocks[start..end]) {
                let first = layout.blocks.len();
                let own = row.iter().filter(|block| faces.contains(&block.kind.first()));
                layout.blocks.extend(own.map(|block| {
                    let [origin, offset] = origin_offset(block);
                    let place = Place::Scaled { part: number, origin, offset };
                    Block { kind: block.kind.renumbered(|face| face - faces.start), place, ..*block }
                }));
                let blocks = first..layout.blocks.len();
                let [origin, offset] = origin_offset(&row[0]);
                for (level, bands) in layout.bands.iter_mut().enumerate() {
                    let first_row = part.first_rows[level] + (origin[1] >> level) + offset[1];
                    bands.push(Band { first_row, blocks: std::iter::once(blocks.clone()).collect() });
                }
            }
        }
        layout.placements = placements(request, &layout.blocks);
        layout
    }
}
