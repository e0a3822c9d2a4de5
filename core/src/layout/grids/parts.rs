//! Classes in parts, so that blocks of one shape can stand at several places of a level.
//!
//! A class is halved, one half is halved again, and so on down to one block: parts of a half, a quarter, an eighth. A level may
//! put any of them together in one grid, so it can cut a class in two at any number of blocks.

use std::cmp::Reverse;

use super::Class;

/// Classes are parted while there are no more than so many in all ([`Class::entry_count`]). A shader's table takes 32 bytes for each
/// and 16 for each of its levels: with twenty levels that is less than 64 KiB, as uniforms may take everywhere.
pub const CLASS_COUNT_MAX: usize = 160;

/// Classes, some of them in parts that follow each other; those of the most texels at level 0 first.
pub fn parted(classes: &[Class]) -> Vec<Class> {
    let texels = |class: &Class| class.texels(0) * u64::from(class.block_count);
    let mut order: Vec<usize> = (0..classes.len()).collect();
    order.sort_by_key(|&class| (Reverse(texels(&classes[class])), class));
    let mut parts: Vec<Vec<Class>> = classes.iter().map(|&class| vec![class]).collect();
    let mut count: usize = classes.iter().map(Class::entry_count).sum();
    for class in order {
        let of_class: Vec<Class> = (halves(classes[class].block_count))
            .map(|block_count| Class { block_count, ..classes[class] })
            .collect();
        let more = classes[class].entry_count() * of_class.len().saturating_sub(1);
        if count + more <= CLASS_COUNT_MAX {
            count += more;
            parts[class] = of_class;
        }
    }
    parts.into_iter().flatten().collect()
}

/// The larger half of a number, the larger half of what is left, and so on: their sum is the number.
fn halves(number: u32) -> impl Iterator<Item = u32> {
    let mut left = number;
    std::iter::from_fn(move || {
        let half = left.div_ceil(2);
        left -= half;
        (half > 0).then_some(half)
    })
}
