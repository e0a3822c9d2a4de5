//! Parts that fit into textures of a largest side.

use super::Block;
use crate::error::Result;
use crate::layout::{self, Class, Page};

/// Blocks stay in the order of their faces, so that neighbors mostly stand together and few primitives are in several
/// parts.
///
/// # Errors
/// `TextureTooLarge` where one block alone is.
pub fn split(mut blocks: Vec<Block>, max_side: u32) -> Result<Vec<Vec<Block>>> {
    blocks.sort_by_key(|block| (block.material, block.patch.faces[0].face));
    let size = |block: &Block| block.class().footprint(0);
    layout::split(blocks, max_side, size, |parts| parts.iter().all(|blocks| fits(blocks, max_side)))
}

fn fits(blocks: &[&Block], max_side: u32) -> bool {
    let mut sorted = blocks.to_vec();
    sorted.sort_by_key(|block| block.order());
    let (classes, _) = Class::number(sorted.iter().map(|block| block.class()));
    Page::fits(&classes, max_side)
}
