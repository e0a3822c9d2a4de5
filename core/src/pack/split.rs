//! Parts that fit into textures of a largest side.

use super::Block;
use crate::error::{Error, ErrorCode, Result};
use crate::layout::{Class, Page};

/// The fewest parts whose level 0 fits, found by trying. Blocks stay in the order of their faces, so that neighbors mostly
/// stand together and few primitives are in several parts.
pub fn split(mut blocks: Vec<Block>, max_side: u32) -> Result<Vec<Vec<Block>>> {
    let texels = |block: &Block| block.class.footprint(0).map(u64::from).into_iter().product::<u64>();
    let longest = blocks.iter().flat_map(|block| block.class.footprint(0)).max().unwrap_or(0);
    if longest > max_side {
        let detail = format!(
            "one face alone needs {longest} texels along a side, more than the {max_side} of max-size; raise --max-size \
             (up to 16384), or ask for less with --resolution or --texels"
        );
        return Err(Error::new(ErrorCode::TextureTooLarge, detail).limit(max_side.into(), longest.into()));
    }
    blocks.sort_by_key(|block| (block.material, block.faces[0].0));
    let total: u64 = blocks.iter().map(texels).sum();
    let mut count = total.div_ceil(u64::from(max_side) * u64::from(max_side)).max(1);
    loop {
        let mut before = 0;
        let parts: Vec<u64> = (blocks.iter())
            .map(|block| {
                let part = before * count / total.max(1);
                before += texels(block);
                part
            })
            .collect();
        let mut classes: Vec<Vec<&Block>> = Vec::new();
        for (block, part) in blocks.iter().zip(&parts) {
            classes.resize_with(classes.len().max(*part as usize + 1), Vec::new);
            classes[*part as usize].push(block);
        }
        if classes.iter().all(|blocks| fits(blocks, max_side)) {
            let mut split: Vec<Vec<Block>> = Vec::new();
            for (block, part) in blocks.into_iter().zip(parts) {
                split.resize_with(split.len().max(part as usize + 1), Vec::new);
                split[part as usize].push(block);
            }
            // A block larger than a part's share leaves one empty.
            split.retain(|blocks| !blocks.is_empty());
            return Ok(split);
        }
        // Ends: one block alone fits.
        count += 1;
    }
}

fn fits(blocks: &[&Block], max_side: u32) -> bool {
    let mut sorted = blocks.to_vec();
    sorted.sort_by_key(|block| block.order());
    let (classes, _) = Class::number(sorted.iter().map(|block| block.class));
    Page::fits(&classes, max_side)
}
