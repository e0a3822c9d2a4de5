//! The shelf layout for 4D coordinates: rows of blocks of one height, and in what a row leaves free at its end, shelves of
//! lower blocks (guillotine shelf packing, where the paper has one row after the other).
//!
//! Every extent is a sum of segments, which halve from level to level, and of steps, which do not
//! ([`super::scaled`]). So a packing that is tight at level 0 need not be at any other: rows of small blocks have few
//! segments and many steps, and stick out more with each level. Three figures shape a packing, and those with the fewest
//! texels over all levels are searched for: how long a row may be at level 0, how many steps it may have (a
//! row of small blocks ends early then, which costs little at level 0), and how many rows may stand above each
//! other beside a row that has run out of blocks. Blocks of one height but different widths are mixed evenly, so that
//! their rows have as many steps.
//!
//! Packings are worked out for counts of equal blocks and for rows that repeat, not block by block.

mod packer;
mod search;

use std::cmp::Reverse;
use std::ops::Range;

use super::scaled::{PackLimits, Sheet, steps};
use super::{Block, Place, SEPARATION};
use search::Search;

/// Packs blocks, within the largest side where that can be.
pub(super) fn pack(mut blocks: Vec<Block>, limits: PackLimits) -> Sheet {
    blocks.sort_by_key(|block| {
        let [r, s] = block.exponents;
        (Reverse((s, r, steps(block.kind))), block.kind.first())
    });
    let stocks = stocks(&blocks);
    let search = Search { stocks: &stocks, level_count: limits.level_count, side_limit: limits.side };
    let next = stocks.iter().map(|stock| stock.blocks.start).collect();
    let mut places = Places { sorted: &blocks, next, placed: Vec::with_capacity(blocks.len()) };
    let row_starts = places.put_all(&search.best());
    Sheet { blocks: places.placed, row_starts }
}

/// Blocks that are as large as each other.
struct Stock {
    exponents: [u8; 2],
    /// Along x.
    steps: u32,
    /// Of the sorted blocks.
    blocks: Range<usize>,
}

fn stocks(sorted: &[Block]) -> Vec<Stock> {
    let mut stocks: Vec<Stock> = Vec::new();
    for (number, block) in sorted.iter().enumerate() {
        let steps = steps(block.kind);
        match stocks.last_mut().filter(|last| (last.exponents, last.steps) == (block.exponents, steps)) {
            Some(last) => last.blocks.end = number + 1,
            None => {
                stocks.push(Stock { exponents: block.exponents, steps, blocks: number..number + 1 });
            }
        }
    }
    stocks
}

/// What shapes a packing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Bounds {
    /// Texels of level 0, with the separation behind the last block.
    width: u32,
    steps: u32,
    stack: u32,
}

/// A place along a row.
#[derive(Clone, Copy, Debug, Default)]
struct Place1D {
    segments: u32,
    steps: u32,
}

impl Place1D {
    /// At the next multiple of `2^exponent`.
    fn aligned(self, exponent: u8) -> Self {
        Self { segments: self.segments.next_multiple_of(1 << exponent), ..self }
    }

    fn and(self, stock: &Stock, count: u32) -> Self {
        Self {
            segments: self.segments + (count << stock.exponents[0]),
            steps: self.steps + count * stock.steps,
        }
    }

    /// Texels at a level up to here, without the separation from what would follow.
    fn texels(self, level: usize) -> u64 {
        u64::from(self.segments).div_ceil(1 << level) + u64::from(self.steps) - 1
    }
}

/// A row of blocks of one height, and what stands beside it.
#[derive(Debug)]
struct Shelf {
    /// Exponent of its height.
    height: u8,
    /// Of each stock so many, the widest first.
    items: Vec<(usize, u32)>,
    /// One below the other, together at most as many segments high.
    beside: Vec<Shelf>,
    /// How often it is there.
    repeat_count: u32,
}

impl Shelf {
    /// Rows above each other: each is a step along y.
    fn row_count(&self) -> u32 {
        self.beside.iter().map(Shelf::row_count).sum::<u32>().max(1)
    }

    /// Where its blocks begin.
    fn start(&self, at: Place1D, stocks: &[Stock]) -> Place1D {
        self.items.first().map_or(at, |&(widest, _)| at.aligned(stocks[widest].exponents[0]))
    }

    /// Where its rows end.
    fn ends(&self, at: Place1D, stocks: &[Stock], ends: &mut Vec<Place1D>) {
        let put = |at: Place1D, &(stock, count): &(usize, u32)| at.and(&stocks[stock], count);
        let end = self.items.iter().fold(self.start(at, stocks), put);
        ends.push(end);
        self.beside.iter().for_each(|shelf| shelf.ends(end, stocks, ends));
    }
}

/// Gives blocks their places, shelf by shelf.
struct Places<'a> {
    sorted: &'a [Block],
    /// By stock, the next of the sorted blocks.
    next: Vec<usize>,
    placed: Vec<Block>,
}

impl Places<'_> {
    /// The first block of each row of shelves.
    fn put_all(&mut self, shelves: &[Shelf]) -> Vec<usize> {
        let mut row_starts = Vec::new();
        let (mut origin, mut offset) = ([0; 2], [0; 2]);
        for shelf in shelves {
            for _ in 0..shelf.repeat_count {
                row_starts.push(self.placed.len());
                self.put(shelf, origin, offset);
                origin[1] += 1 << shelf.height;
                offset[1] += shelf.row_count() * SEPARATION;
            }
        }
        row_starts
    }

    fn put(&mut self, shelf: &Shelf, mut origin: [u32; 2], mut offset: [u32; 2]) {
        for &(stock, count) in &shelf.items {
            for _ in 0..count {
                let block = self.sorted[self.next[stock]];
                self.next[stock] += 1;
                let n = 1 << block.exponents[0];
                origin[0] = u32::next_multiple_of(origin[0], n);
                self.placed.push(Block { place: Place::Scaled { part: 0, origin, offset }, ..block });
                origin[0] += n;
                offset[0] += steps(block.kind);
            }
        }
        for inner in &shelf.beside {
            self.put(inner, origin, offset);
            origin[1] += 1 << inner.height;
            offset[1] += inner.row_count() * SEPARATION;
        }
    }
}
