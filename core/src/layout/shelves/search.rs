//! Which packing takes the fewest texels: many are worked out and counted.

use rayon::prelude::*;

use super::packer::Packer;
use super::{Bounds, Place1D, SEPARATION, Shelf, Stock};

/// Lengths of rows that are tried, as shares of the side of a square that holds all: the first, the last, how many.
const WIDTHS: ([f64; 2], u32) = ([0.7, 1.3], 40);
/// Steps of a row that are tried, as shares of those in a row of the square that holds all blocks at one texel each.
const STEPS: [f64; 8] = [0.6, 0.75, 0.95, 1.2, 1.5, 1.9, 2.4, 3.0];
/// Rows above each other, beside another.
const STACKS: [u32; 3] = [1, 2, 4];
/// Level 0 is what most viewers load: packings that leave more of it empty come last.
const EMPTY_SHARE_MAX: f64 = 0.04;
/// Around the best of these: shares of its figures.
const NEAR_WIDTHS: ([f64; 2], u32) = ([0.98, 1.02], 17);
const NEAR_STEPS: [f64; 5] = [0.85, 0.92, 1.0, 1.08, 1.17];

pub(super) struct Search<'a> {
    pub(super) stocks: &'a [Stock],
    pub(super) level_count: usize,
    pub(super) side_limit: u32,
}

impl Search<'_> {
    /// The packing of fewest texels over all levels.
    pub(super) fn best(&self) -> Vec<Shelf> {
        let side = self.filled_texels().sqrt();
        let block_count: usize = self.stocks.iter().map(|stock| stock.blocks.len()).sum();
        let steps = f64::from(SEPARATION) * (block_count as f64).sqrt();
        let coarse = pairs(WIDTHS, &STEPS)
            .flat_map(|[width, share]| STACKS.map(|stack| self.bounds([side * width, steps * share], stack)));
        let best = self.least(coarse.collect());
        let near = pairs(NEAR_WIDTHS, &NEAR_STEPS).map(|[width, share]| {
            self.bounds([f64::from(best.width) * width, f64::from(best.steps) * share], best.stack)
        });
        let best = self.least(near.chain([best]).collect());
        self.pack(best)
    }

    /// Of level 0, with the separation.
    fn filled_texels(&self) -> f64 {
        let area = |stock: &Stock| {
            let [n, m] = stock.exponents.map(|exponent| f64::from(1 << exponent));
            (n + f64::from(stock.steps)) * (m + f64::from(SEPARATION)) * stock.blocks.len() as f64
        };
        self.stocks.iter().map(area).sum()
    }

    /// Bounds within which every block has a place.
    fn bounds(&self, [width, steps]: [f64; 2], stack: u32) -> Bounds {
        let widths = self.stocks.iter().map(|stock| (1 << stock.exponents[0]) + stock.steps);
        let widest = widths.max().unwrap_or(1);
        let most_steps = self.stocks.iter().map(|stock| stock.steps).max().unwrap_or(1);
        let width = (width as u32).min(self.side_limit + 1).max(widest);
        Bounds { width, steps: (steps as u32).max(most_steps), stack }
    }

    fn least(&self, mut tried: Vec<Bounds>) -> Bounds {
        tried.sort_unstable();
        tried.dedup();
        let key = |bounds: &Bounds| (self.cost(&self.pack(*bounds)), *bounds);
        let least = tried.into_par_iter().min_by_key(key);
        least.unwrap_or(Bounds { width: 1, steps: 1, stack: 1 })
    }

    fn pack(&self, bounds: Bounds) -> Vec<Shelf> {
        let left = self.stocks.iter().map(|stock| stock.blocks.len() as u32).collect();
        Packer { stocks: self.stocks, left, bounds }.shelves(Place1D::default(), None, u32::MAX)
    }

    /// Whether level 0 is over the limit, whether it is too empty, and texels of all levels.
    fn cost(&self, shelves: &[Shelf]) -> (bool, bool, u64) {
        let mut ends = Vec::new();
        let mut height = [0u64; 2];
        for shelf in shelves {
            shelf.ends(Place1D::default(), self.stocks, &mut ends);
            let repeat_count = u64::from(shelf.repeat_count);
            height[0] += repeat_count << shelf.height;
            height[1] += repeat_count * u64::from(shelf.row_count() * SEPARATION);
        }
        let size = |level: usize| {
            let width = ends.iter().map(|end| end.texels(level)).max().unwrap_or(1);
            [width, height[0].div_ceil(1 << level) + height[1] - 1]
        };
        let is_over = size(0).into_iter().max() > Some(u64::from(self.side_limit));
        let texels = |level: usize| size(level).into_iter().product::<u64>();
        let is_empty = self.filled_texels() < (1.0 - EMPTY_SHARE_MAX) * texels(0) as f64;
        (is_over, is_empty, (0..self.level_count).map(texels).sum())
    }
}

/// Every share of the first with every one of the second.
fn pairs(
    ([first, last], count): ([f64; 2], u32),
    others: &[f64],
) -> impl Iterator<Item = [f64; 2]> + use<'_> {
    let share = move |k: u32| first + (last - first) * f64::from(k) / f64::from(count - 1);
    (0..count).flat_map(move |k| others.iter().map(move |&other| [share(k), other]))
}
