//! Blocks in several parts, where one image would be too large.

use crate::error::{Error, ErrorCode, Result};

/// The fewest parts that fit, found by trying: each has the next blocks, up to about as many texels as the others. `size`:
/// what a block takes along x and y. `fit` is asked about all parts at once, none of them empty, until it agrees; it has to
/// where each block is alone.
///
/// # Errors
/// `TextureTooLarge` where one block alone is over `max_side`.
pub fn split<B>(
    blocks: Vec<B>,
    max_side: u32,
    size: impl Fn(&B) -> [u32; 2],
    mut fit: impl FnMut(&[Vec<&B>]) -> bool,
) -> Result<Vec<Vec<B>>> {
    let longest = blocks.iter().flat_map(&size).max().unwrap_or(0);
    if longest > max_side {
        let detail = format!(
            "one face alone needs {longest} texels along a side, more than the {max_side} of max-size; raise --max-size \
             (up to 16384), or ask for less with --resolution or --texels"
        );
        return Err(Error::new(ErrorCode::TextureTooLarge, detail).limit(max_side.into(), longest.into()));
    }
    let texels = |block: &B| size(block).map(u64::from).into_iter().product::<u64>();
    let total: u64 = blocks.iter().map(texels).sum();
    let mut count = total.div_ceil(u64::from(max_side) * u64::from(max_side)).max(1);
    loop {
        let mut before = 0;
        let parts = blocks.iter().map(|block| {
            let part = before * count / total.max(1);
            before += texels(block);
            part
        });
        let numbers: Vec<u64> = parts.collect();
        if fit(&in_parts(blocks.iter(), &numbers)) {
            return Ok(in_parts(blocks.into_iter(), &numbers));
        }
        count += 1;
    }
}

/// By ascending number. A block larger than a part's share leaves numbers out.
fn in_parts<B>(mut blocks: impl Iterator<Item = B>, numbers: &[u64]) -> Vec<Vec<B>> {
    numbers.chunk_by(u64::eq).map(|part| blocks.by_ref().take(part.len()).collect()).collect()
}
