//! No more classes of blocks than a shader's table is meant to take.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use crate::layout::Class;

use super::Block;

/// Blocks whose shapes save least by being larger come apart in halves, until there are no more than so many classes of a shader's
/// table. (Single faces of so many pairs of exponents stay as they are.)
pub fn with_few_classes(blocks: Vec<Block>, count_max: usize) -> Vec<Block> {
    // What blocks come apart to in the end, and what they save until then.
    let mut single: BTreeMap<Key, usize> = BTreeMap::new();
    let mut saved: BTreeMap<Key, u64> = BTreeMap::new();
    for block in &blocks {
        let class = block.class();
        let alone = Class { cells: [1, 1], ..class };
        single.insert(key(&alone), alone.entry_count());
        if class.cells != alone.cells {
            let count = u64::from(class.cells[0] * class.cells[1]);
            *saved.entry(key(&class)).or_default() += count * alone.texels(0) - class.texels(0);
        }
    }
    let single_count: usize = single.values().sum();
    let mut larger: Vec<(Reverse<u64>, Key)> =
        saved.into_iter().map(|(key, saved)| (Reverse(saved), key)).collect();
    larger.sort_unstable();
    larger.truncate(count_max.saturating_sub(single_count));
    let kept: BTreeSet<Key> = larger.into_iter().map(|(_, key)| key).collect();
    let mut waiting = blocks;
    let mut done = Vec::with_capacity(waiting.len());
    while let Some(block) = waiting.pop() {
        let class = block.class();
        if class.cells == [1, 1] || kept.contains(&key(&class)) {
            done.push(block);
        } else {
            waiting.extend(block.halves());
        }
    }
    done
}

/// What blocks of one class have in common.
type Key = (u8, [u32; 2], [u8; 2]);

fn key(class: &Class) -> Key {
    (class.lone_count, class.cells, class.exponents)
}

impl Block {
    /// Cut across the side of more faces.
    fn halves(self) -> [Self; 2] {
        let cells = self.patch.cells;
        let axis = usize::from(cells[1] > cells[0]);
        let (mut end, mut from) = (cells, [0, 0]);
        end[axis] = cells[axis].div_ceil(2);
        from[axis] = end[axis];
        let parts = [self.patch.part([0, 0], end), self.patch.part(from, cells)];
        parts.map(|patch| Self::new(self.material, patch, self.exponents, self.lone_count))
    }
}
