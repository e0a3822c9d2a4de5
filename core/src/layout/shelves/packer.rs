//! One packing within its bounds: row by row from the highest blocks to the lowest, and what stands beside each.

use super::{Bounds, Place1D, Shelf, Stock};

pub(super) struct Packer<'a> {
    pub(super) stocks: &'a [Stock],
    /// By stock.
    pub(super) left: Vec<u32>,
    pub(super) bounds: Bounds,
}

impl Packer<'_> {
    /// Shelves one below the other, the highest first: at most `rows_max` rows, and all together no more segments
    /// high than `2^height_max`. Without that, all blocks that are left.
    pub(super) fn shelves(&mut self, at: Place1D, height_max: Option<u8>, rows_max: u32) -> Vec<Shelf> {
        let mut shelves: Vec<Shelf> = Vec::new();
        let mut free = height_max.map_or(u32::MAX, |height| 1 << height);
        let mut row_count = 0;
        while row_count < rows_max {
            let can_begin = |&number: &usize| {
                let stock = &self.stocks[number];
                let is_low = 1 << stock.exponents[1] <= free;
                self.left[number] > 0 && is_low && self.fits(at.aligned(stock.exponents[0]).and(stock, 1))
            };
            // Stocks go from high to low.
            let Some(first) = (0..self.stocks.len()).find(can_begin) else { break };
            let height = self.stocks[first].exponents[1];
            let before = self.left.clone();
            let mut shelf = self.shelf(at, height, rows_max - row_count);
            if height_max.is_none() {
                shelf.repeat_count += self.repeat(&before);
            } else {
                free -= 1 << height;
            }
            row_count += shelf.row_count() * shelf.repeat_count;
            shelves.push(shelf);
        }
        shelves
    }

    /// Takes what was taken since then as often as there is enough of it.
    fn repeat(&mut self, before: &[u32]) -> u32 {
        let taken: Vec<u32> = before.iter().zip(&self.left).map(|(before, left)| before - left).collect();
        let enough = self.left.iter().zip(&taken).filter(|(_, taken)| **taken > 0);
        let count = enough.map(|(left, taken)| left / taken).min().unwrap_or(0);
        self.left.iter_mut().zip(&taken).for_each(|(left, taken)| *left -= taken * count);
        count
    }

    fn fits(&self, end: Place1D) -> bool {
        end.segments + end.steps <= self.bounds.width && end.steps <= self.bounds.steps
    }

    /// How many blocks of each stock of one height fit into a row, of all the same share, rounded down.
    fn shares(&self, at: Place1D, height: u8) -> Vec<(usize, u32)> {
        let is_of_row = |&number: &usize| self.stocks[number].exponents[1] == height && self.left[number] > 0;
        // The widest first.
        let numbers: Vec<usize> = (0..self.stocks.len()).filter(is_of_row).collect();
        let start = numbers.first().map_or(at, |&widest| at.aligned(self.stocks[widest].exponents[0]));
        let free_steps = u64::from(self.bounds.steps.saturating_sub(start.steps));
        let free_texels = u64::from(self.bounds.width.saturating_sub(start.segments + start.steps));
        let mut all = [0u64; 2];
        for &number in &numbers {
            let (stock, left) = (&self.stocks[number], u64::from(self.left[number]));
            all[0] += left * u64::from(stock.steps);
            all[1] += left * u64::from((1 << stock.exponents[0]) + stock.steps);
        }
        let count = |number: usize| {
            let left = u64::from(self.left[number]);
            left.min(left * free_steps / all[0]).min(left * free_texels / all[1]) as u32
        };
        numbers.into_iter().map(|number| (number, count(number))).collect()
    }

    /// A row of one height, of all its stocks about the same share as long as any fits, and what stands beside it.
    fn shelf(&mut self, at: Place1D, height: u8, rows_max: u32) -> Shelf {
        let mut items = self.shares(at, height);
        let mut sum = Place1D::default();
        let mut widest = 0;
        for &(number, count) in items.iter().filter(|item| item.1 > 0) {
            sum = sum.and(&self.stocks[number], count);
            widest = widest.max(self.stocks[number].exponents[0]);
        }
        let end = |sum: Place1D, widest: u8| Place1D {
            segments: at.aligned(widest).segments + sum.segments,
            steps: at.steps + sum.steps,
        };
        let share = |&(number, count): &(usize, u32)| f64::from(count) / f64::from(self.left[number]);
        loop {
            let can_come = |&k: &usize| {
                let (number, count) = items[k];
                let stock = &self.stocks[number];
                let with = end(sum.and(stock, 1), widest.max(stock.exponents[0]));
                count < self.left[number] && self.fits(with)
            };
            let least = |a: &usize, b: &usize| share(&items[*a]).total_cmp(&share(&items[*b]));
            let Some(k) = (0..items.len()).filter(can_come).min_by(least) else { break };
            let stock = &self.stocks[items[k].0];
            items[k].1 += 1;
            sum = sum.and(stock, 1);
            widest = widest.max(stock.exponents[0]);
        }
        let is_all = items.iter().all(|&(number, count)| count == self.left[number]);
        items.iter().for_each(|&(number, count)| self.left[number] -= count);
        items.retain(|(_, count)| *count > 0);
        // A row that could go on has little free at its end: not worth a step of the whole row.
        let stack = if is_all { self.bounds.stack } else { 1 };
        let beside = self.shelves(end(sum, widest), Some(height), stack.min(rows_max));
        Shelf { height, items, beside, repeat_count: 1 }
    }
}
