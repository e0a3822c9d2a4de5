//! `diag(a) + Wᵀ D W` of an island and its Cholesky factor, front by front.
//!
//! Each front is put together of the cells whose first variable it eliminates and of what the fronts below it
//! leave, which lies on a stack. No matrix of the whole island is ever made.

use super::fronts::{Front, Fronts};
use super::island::Island;

#[cfg(test)]
mod tests;

/// The pattern of an island's matrix, with room for its factor.
pub struct Matrix {
    fronts: Fronts,
    /// By position.
    variables: Vec<u32>,
    /// Cells in the order in which they are added.
    cells: Vec<u32>,
    /// By front: one past the last of its `cells`.
    cell_ends: Vec<u32>,
    /// Where the variables of each of `cells` are in its front.
    slots: Vec<u32>,
    /// By front: where its columns start; one more at the end. Each column has the front's size.
    starts: Vec<usize>,
    columns: Vec<f64>,
    /// What fronts leave for their parents.
    updates: Vec<f64>,
    /// Products of the rows of one cell, added up.
    products: Vec<f64>,
    permuted: Vec<f64>,
    below: Vec<f64>,
}

impl Matrix {
    /// `None` where no memory is left for it.
    pub fn new(island: &Island) -> Option<Self> {
        let fronts = Fronts::new(island)?;
        let mut variables = vec![0; fronts.positions.len()];
        for (variable, &position) in fronts.positions.iter().enumerate() {
            variables[position as usize] = variable as u32;
        }
        let positions = |cell: usize| island.cell(cell).iter().map(|&place| fronts.positions[place as usize]);
        let front_of = |cell: usize| positions(cell).min().map_or(0, |first| fronts.front_of[first as usize]);
        let mut cells: Vec<(u32, u32)> =
            (0..island.cell_count()).map(|cell| (front_of(cell), cell as u32)).collect();
        cells.sort_unstable();
        let mut slots = Vec::new();
        let mut cell_ends = vec![0; fronts.fronts.len()];
        for (at, &(front, cell)) in cells.iter().enumerate() {
            cell_ends[front as usize] = at as u32 + 1;
            slots.extend(
                positions(cell as usize).map(|position| fronts.fronts[front as usize].local(position)),
            );
        }
        for front in 1..cell_ends.len() {
            cell_ends[front] = cell_ends[front].max(cell_ends[front - 1]);
        }
        let mut starts = vec![0];
        for front in &fronts.fronts {
            starts.push(starts[starts.len() - 1] + front.width * front.size());
        }
        Some(Self {
            permuted: vec![0.0; variables.len()],
            columns: vec![0.0; starts[starts.len() - 1]],
            cells: cells.into_iter().map(|(_, cell)| cell).collect(),
            fronts,
            variables,
            cell_ends,
            slots,
            starts,
            updates: Vec::new(),
            products: Vec::new(),
            below: Vec::new(),
        })
    }

    /// Factors the matrix for the diagonals `a` and `d`; false where rounding leaves it without a factor.
    pub fn factor(&mut self, island: &Island, a: &[f64], d: &[f64]) -> bool {
        self.updates.clear();
        let (mut next_cell, mut slots) = (0, self.slots.as_slice());
        for (number, front) in self.fronts.fronts.iter().enumerate() {
            let (width, size) = (front.width, front.size());
            let from = self.updates.len();
            self.updates.resize(from + front.rows.len().pow(2), 0.0);
            let (below, update) = self.updates.split_at_mut(from);
            let columns = &mut self.columns[self.starts[number]..self.starts[number + 1]];
            columns.fill(0.0);
            for (at, &variable) in self.variables[front.first..][..width].iter().enumerate() {
                columns[at * size + at] = a[variable as usize];
            }
            let mut open = OpenFront { width, size, columns, update };
            let mut to = from;
            for &child in front.children.iter().rev() {
                let child = &self.fronts.fronts[child as usize];
                let start = to - child.rows.len().pow(2);
                open.add_child(&below[start..to], child);
                to = start;
            }
            while next_cell < self.cell_ends[number] as usize {
                let cell = self.cells[next_cell] as usize;
                let (own, rest) = slots.split_at(island.cell(cell).len());
                open.add_cell(island, cell, d, own, &mut self.products);
                (slots, next_cell) = (rest, next_cell + 1);
            }
            if !open.eliminate() {
                return false;
            }
            self.updates.copy_within(from.., to);
            self.updates.truncate(to + front.rows.len().pow(2));
        }
        true
    }

    /// Solves with the last factor, in place.
    pub fn solve(&mut self, right: &mut [f64]) {
        let x = &mut self.permuted;
        for (x, &variable) in x.iter_mut().zip(&self.variables) {
            *x = right[variable as usize];
        }
        for (number, front) in self.fronts.fronts.iter().enumerate() {
            let columns = &self.columns[self.starts[number]..self.starts[number + 1]];
            self.below.clear();
            self.below.resize(front.rows.len(), 0.0);
            let own = &mut x[front.first..][..front.width];
            for (at, column) in columns.chunks_exact(front.size()).enumerate() {
                own[at] *= column[at];
                let factor = own[at];
                let (column, rows) = column.split_at(front.width);
                own[at + 1..].iter_mut().zip(&column[at + 1..]).for_each(|(x, l)| *x -= factor * l);
                self.below.iter_mut().zip(rows).for_each(|(x, l)| *x += factor * l);
            }
            for (&row, by) in front.rows.iter().zip(&self.below) {
                x[row as usize] -= by;
            }
        }
        for (number, front) in self.fronts.fronts.iter().enumerate().rev() {
            let columns = &self.columns[self.starts[number]..self.starts[number + 1]];
            self.below.clear();
            self.below.extend(front.rows.iter().map(|&row| x[row as usize]));
            let own = &mut x[front.first..][..front.width];
            for (at, column) in columns.chunks_exact(front.size()).enumerate().rev() {
                let (column, rows) = column.split_at(front.width);
                let sum = dot(&column[at + 1..], &own[at + 1..]) + dot(rows, &self.below);
                own[at] = (own[at] - sum) * column[at];
            }
        }
        for (x, &variable) in x.iter().zip(&self.variables) {
            right[variable as usize] = *x;
        }
    }
}

/// A front that is put together: the lower halves of its columns, and of what it leaves for its parent.
struct OpenFront<'a> {
    width: usize,
    size: usize,
    columns: &'a mut [f64],
    update: &'a mut [f64],
}

impl OpenFront<'_> {
    /// From `column` down to the last row.
    fn column(&mut self, column: usize) -> &mut [f64] {
        match column.checked_sub(self.width) {
            None => &mut self.columns[column * self.size..][column..self.size],
            Some(at) => {
                let count = self.size - self.width;
                &mut self.update[at * count..][at..count]
            }
        }
    }

    fn add_child(&mut self, update: &[f64], child: &Front) {
        let count = child.rows.len();
        for (at, &target) in child.targets.iter().enumerate() {
            let column = self.column(target as usize);
            // The targets ascend as the child's rows do.
            for (&row, value) in child.targets[at..].iter().zip(&update[at * count + at..]) {
                column[(row - target) as usize] += value;
            }
        }
    }

    fn add_cell(&mut self, island: &Island, cell: usize, d: &[f64], slots: &[u32], products: &mut Vec<f64>) {
        let (rows, weights) = island.cell_rows(cell);
        let d = &d[rows];
        match slots.len() {
            3 => self.add_products::<3>(weights, d, slots),
            4 => self.add_products::<4>(weights, d, slots),
            9 => self.add_products::<9>(weights, d, slots),
            12 => self.add_products::<12>(weights, d, slots),
            count => {
                products.clear();
                products.resize(count * count, 0.0);
                for (weights, d) in weights.chunks_exact(count).zip(d) {
                    for (line, a) in products.chunks_exact_mut(count).zip(weights) {
                        let scaled = d * a;
                        line.iter_mut().zip(weights).for_each(|(sum, b)| *sum += scaled * b);
                    }
                }
                products
                    .chunks_exact(count)
                    .enumerate()
                    .for_each(|(at, line)| self.add_line(slots, at, line));
            }
        }
    }

    fn add_products<const N: usize>(&mut self, weights: &[f64], d: &[f64], slots: &[u32]) {
        let mut products = [[0.0; N]; N];
        for (weights, d) in weights.as_chunks::<N>().0.iter().zip(d) {
            for (line, a) in products.iter_mut().zip(weights) {
                let scaled = d * a;
                line.iter_mut().zip(weights).for_each(|(sum, b)| *sum += scaled * b);
            }
        }
        products.iter().enumerate().for_each(|(at, line)| self.add_line(slots, at, line));
    }

    /// Adds a line of products up to its diagonal.
    fn add_line(&mut self, slots: &[u32], at: usize, line: &[f64]) {
        for (&slot, product) in slots[..=at].iter().zip(line) {
            let (low, high) = (slot.min(slots[at]), slot.max(slots[at]));
            self.column(low as usize)[(high - low) as usize] += product;
        }
    }

    /// `L` of the columns, diagonals as their inverses, and what is left of the rest.
    fn eliminate(&mut self) -> bool {
        let (width, size) = (self.width, self.size);
        for at in 0..width {
            let (done, rest) = self.columns.split_at_mut(at * size);
            let column = &mut rest[at..size];
            subtract(column, done, size);
            let square = column[0];
            // Not a number is not above zero either.
            if !(square > 0.0 && square.is_finite()) {
                return false;
            }
            let inverse = 1.0 / square.sqrt();
            column[0] = inverse;
            column[1..].iter_mut().for_each(|entry| *entry *= inverse);
        }
        let count = size - width;
        for at in 0..count {
            subtract(&mut self.update[at * count..][at..count], self.columns, size);
        }
        true
    }
}

/// `target -= Σ column · its first entry`, over the ends of columns that are as long as `target`; four columns
/// at a time, so that the target is read and written a quarter as often.
fn subtract(target: &mut [f64], columns: &[f64], size: usize) {
    let count = target.len();
    let mut fours = columns.chunks_exact(4 * size);
    for four in &mut fours {
        let end = |at: usize| &four[(at + 1) * size - count..(at + 1) * size];
        let (a, b, c, d) = (end(0), end(1), end(2), end(3));
        let (by_a, by_b, by_c, by_d) = (a[0], b[0], c[0], d[0]);
        for ((((x, a), b), c), d) in target.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *x -= (by_a * a + by_b * b) + (by_c * c + by_d * d);
        }
    }
    for column in fours.remainder().chunks_exact(size) {
        let end = &column[size - count..];
        let by = end[0];
        target.iter_mut().zip(end).for_each(|(x, l)| *x -= by * l);
    }
}

/// In four sums, which the processor takes side by side, added in one order.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_fours, a_rest) = a.as_chunks::<4>();
    let (b_fours, b_rest) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in a_fours.iter().zip(b_fours) {
        for lane in 0..4 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    rest + ((sums[0] + sums[1]) + (sums[2] + sums[3]))
}
