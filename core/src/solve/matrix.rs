//! `diag(a) + Wᵀ D W` of an island and its Cholesky factor.
//!
//! Most islands have some tens of variables, and a band along the diagonal holds their factor: rows from
//! their first entry on (A. Jennings, "A compact storage scheme for the solution of symmetric linear
//! simultaneous equations", Comput. J. 9, 1966) in the order of E. Cuthill and J. McKee (1969), reversed.
//! Where that band would be wide, `faer`'s sparse factorization takes over.

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat};

use super::island::Island;

/// Multiplications for one factorization up to which the band is the faster one.
const BAND_WORK_MAX: usize = 20_000_000;

/// The pattern of an island's matrix, with room for its factor.
pub enum Matrix {
    Band(Box<Band>),
    Sparse(Box<Sparse>),
}

impl Matrix {
    /// `None` where no memory is left for the pattern.
    pub fn new(island: &Island) -> Option<Self> {
        let order = reverse_cuthill_mckee(&neighbors(island));
        let band = Band::new(island, order);
        if band.work() <= BAND_WORK_MAX {
            return Some(Self::Band(Box::new(band)));
        }
        Some(Self::Sparse(Box::new(Sparse::new(island)?)))
    }

    /// Factors the matrix for the diagonals `a` and `d`; false where rounding leaves it without a factor.
    pub fn factor(&mut self, island: &Island, a: &[f64], d: &[f64]) -> bool {
        match self {
            Self::Band(band) => band.factor(island, a, d),
            Self::Sparse(sparse) => sparse.factor(island, a, d),
        }
    }

    /// Solves with the last factor, in place.
    pub fn solve(&mut self, right: &mut [f64]) {
        match self {
            Self::Band(band) => band.solve(right),
            Self::Sparse(sparse) => sparse.solve(right),
        }
    }
}

/// Whether two rows are about the same variables.
fn is_alike(a: &[(u32, f64)], b: &[(u32, f64)]) -> bool {
    a.iter().map(|term| term.0).eq(b.iter().map(|term| term.0))
}

/// Variables that share a row, by variable, ascending.
fn neighbors(island: &Island) -> Vec<Vec<u32>> {
    let mut neighbors: Vec<Vec<u32>> = vec![Vec::new(); island.variables().len()];
    for row in 0..island.row_count() {
        let terms = island.terms(row);
        // The texels around one face have the same corners.
        if row > 0 && is_alike(island.terms(row - 1), terms) {
            continue;
        }
        for &(a, _) in terms {
            neighbors[a as usize].extend(terms.iter().map(|term| term.0).filter(|&b| b != a));
        }
    }
    for list in &mut neighbors {
        list.sort_unstable();
        list.dedup();
    }
    neighbors
}

/// By variable its place in an order that keeps neighbors near.
fn reverse_cuthill_mckee(neighbors: &[Vec<u32>]) -> Vec<u32> {
    const UNSEEN: u32 = u32::MAX;
    let count = neighbors.len();
    let degree = |at: u32| (neighbors[at as usize].len(), at);
    let mut place = vec![UNSEEN; count];
    let mut queue: Vec<u32> = Vec::with_capacity(count);
    let mut by_degree: Vec<u32> = (0..count as u32).collect();
    by_degree.sort_unstable_by_key(|&at| degree(at));
    for start in by_degree {
        if place[start as usize] != UNSEEN {
            continue;
        }
        // The last of a search from anywhere lies at the rim.
        let from = queue.len();
        search(start, neighbors, &mut place, &mut queue);
        let rim = queue[queue.len() - 1];
        queue[from..].iter().for_each(|&at| place[at as usize] = UNSEEN);
        queue.truncate(from);
        search(rim, neighbors, &mut place, &mut queue);
    }
    for (at, &variable) in queue.iter().rev().enumerate() {
        place[variable as usize] = at as u32;
    }
    place
}

/// Breadth first, neighbors of few neighbors first; `place` only marks what was seen.
fn search(start: u32, neighbors: &[Vec<u32>], place: &mut [u32], queue: &mut Vec<u32>) {
    let mut at = queue.len();
    queue.push(start);
    place[start as usize] = 0;
    while at < queue.len() {
        let from = queue.len();
        for &next in &neighbors[queue[at] as usize] {
            if place[next as usize] != 0 {
                place[next as usize] = 0;
                queue.push(next);
            }
        }
        queue[from..].sort_unstable_by_key(|&next| (neighbors[next as usize].len(), next));
        at += 1;
    }
}

/// Rows of the lower half, each from its first entry to the diagonal.
pub struct Band {
    /// By variable.
    place: Vec<u32>,
    /// By place: first column.
    first: Vec<u32>,
    /// By place: where the row starts in `entries`; one more at the end.
    starts: Vec<usize>,
    entries: Vec<f64>,
    /// Rows about the same variables, as the texels around one face are: one past the last row of each.
    run_ends: Vec<u32>,
    /// Where each product of two terms of the rows of a run goes.
    slots: Vec<u32>,
    /// Products of the rows of one run, added up.
    products: Vec<f64>,
    /// The weights of one row.
    weights: Vec<f64>,
    permuted: Vec<f64>,
}

impl Band {
    fn new(island: &Island, place: Vec<u32>) -> Self {
        let count = place.len();
        let mut first: Vec<u32> = (0..count as u32).collect();
        for row in 0..island.row_count() {
            let places = || island.terms(row).iter().map(|term| place[term.0 as usize]);
            let least = places().min().unwrap_or(0);
            places().for_each(|at| first[at as usize] = first[at as usize].min(least));
        }
        let mut starts = vec![0];
        for (at, &first) in first.iter().enumerate() {
            starts.push(starts[at] + at + 1 - first as usize);
        }
        Self {
            permuted: vec![0.0; count],
            place,
            first,
            starts,
            entries: Vec::new(),
            run_ends: Vec::new(),
            slots: Vec::new(),
            products: Vec::new(),
            weights: Vec::new(),
        }
    }

    fn work(&self) -> usize {
        self.starts.windows(2).map(|ends| (ends[1] - ends[0]).pow(2)).sum()
    }

    fn slot(&self, a: u32, b: u32) -> usize {
        let (high, low) = (a.max(b), a.min(b));
        self.starts[high as usize] + (low - self.first[high as usize]) as usize
    }

    fn fill_slots(&mut self, island: &Island) {
        for row in 0..island.row_count() {
            let terms = island.terms(row);
            if row > 0 && is_alike(island.terms(row - 1), terms) {
                self.run_ends.pop();
                self.run_ends.push(row as u32 + 1);
                continue;
            }
            self.run_ends.push(row as u32 + 1);
            for (at, a) in terms.iter().enumerate() {
                for b in &terms[..=at] {
                    let slot = self.slot(self.place[a.0 as usize], self.place[b.0 as usize]);
                    self.slots.push(slot as u32);
                }
            }
        }
    }

    fn factor(&mut self, island: &Island, a: &[f64], d: &[f64]) -> bool {
        if self.slots.is_empty() {
            self.fill_slots(island);
        }
        self.entries.clear();
        self.entries.resize(self.starts[self.place.len()], 0.0);
        for (variable, a) in a.iter().enumerate() {
            let at = self.place[variable] as usize;
            self.entries[self.starts[at + 1] - 1] = *a;
        }
        let mut slots = self.slots.iter();
        let mut row = 0;
        for &end in &self.run_ends {
            let count = island.terms(row).len();
            self.products.clear();
            self.products.resize(count * count, 0.0);
            while row < end as usize {
                self.weights.clear();
                self.weights.extend(island.terms(row).iter().map(|term| term.1));
                for (line, a) in self.products.chunks_exact_mut(count).zip(&self.weights) {
                    let scaled = d[row] * a;
                    line.iter_mut().zip(&self.weights).for_each(|(sum, b)| *sum += scaled * b);
                }
                row += 1;
            }
            for (at, line) in self.products.chunks_exact(count).enumerate() {
                for (product, &slot) in line[..=at].iter().zip(&mut slots) {
                    self.entries[slot as usize] += product;
                }
            }
        }
        self.decompose()
    }

    /// `L Lᵀ`, row by row; diagonals are kept as their inverses.
    fn decompose(&mut self) -> bool {
        for i in 0..self.place.len() {
            let (done, rest) = self.entries.split_at_mut(self.starts[i]);
            let first = self.first[i] as usize;
            let row = &mut rest[..=i - first];
            for j in first..i {
                let other = &done[self.starts[j]..self.starts[j + 1]];
                let other_first = self.first[j] as usize;
                let from = first.max(other_first);
                let sum = dot(&row[from - first..j - first], &other[from - other_first..j - other_first]);
                row[j - first] = (row[j - first] - sum) * other[j - other_first];
            }
            let (row, diagonal) = row.split_at_mut(i - first);
            let square = diagonal[0] - dot(row, row);
            // Not a number is not above zero either.
            if !(square > 0.0 && square.is_finite()) {
                return false;
            }
            diagonal[0] = 1.0 / square.sqrt();
        }
        true
    }

    fn solve(&mut self, right: &mut [f64]) {
        let x = &mut self.permuted;
        for (&place, value) in self.place.iter().zip(right.iter()) {
            x[place as usize] = *value;
        }
        for i in 0..x.len() {
            let (row, inverse) =
                self.entries[self.starts[i]..self.starts[i + 1]].split_at(i - self.first[i] as usize);
            x[i] = (x[i] - dot(row, &x[self.first[i] as usize..i])) * inverse[0];
        }
        for i in (0..x.len()).rev() {
            let (row, inverse) =
                self.entries[self.starts[i]..self.starts[i + 1]].split_at(i - self.first[i] as usize);
            let (before, at) = x.split_at_mut(i);
            at[0] *= inverse[0];
            let factor = at[0];
            before[self.first[i] as usize..].iter_mut().zip(row).for_each(|(x, l)| *x -= factor * l);
        }
        for (&place, value) in self.place.iter().zip(right.iter_mut()) {
            *value = x[place as usize];
        }
    }
}

/// In eight sums, which the processor takes side by side, added in one order.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (a_chunks, b_chunks) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let [a, b, c, d, e, f, g, h] = sums;
    rest + (((a + b) + (c + d)) + ((e + f) + (g + h)))
}

/// Pattern and order of elimination found once, the factor anew for every step.
pub struct Sparse {
    pattern: SymbolicSparseColMat<u32>,
    order: Argsort<u32>,
    elimination: SymbolicLlt<u32>,
    factor: Option<Llt<u32, f64>>,
}

impl Sparse {
    fn new(island: &Island) -> Option<Self> {
        let n = island.variables().len();
        let mut entries: Vec<Pair<u32, u32>> = (0..n as u32).map(|v| Pair { row: v, col: v }).collect();
        for row in 0..island.row_count() {
            let terms = island.terms(row);
            for &(a, _) in terms {
                entries.extend(terms.iter().filter(|b| b.0 <= a).map(|b| Pair { row: a, col: b.0 }));
            }
        }
        let (pattern, order) = SymbolicSparseColMat::try_new_from_indices(n, n, &entries).ok()?;
        let elimination = SymbolicLlt::try_new(pattern.as_ref(), Side::Lower).ok()?;
        Some(Self { pattern, order, elimination, factor: None })
    }

    fn factor(&mut self, island: &Island, a: &[f64], d: &[f64]) -> bool {
        let mut values = a.to_vec();
        for (row, d) in d.iter().enumerate() {
            let terms = island.terms(row);
            for &(a, weight_a) in terms {
                values.extend(terms.iter().filter(|b| b.0 <= a).map(|b| d * weight_a * b.1));
            }
        }
        let matrix = SparseColMat::new_from_argsort(self.pattern.clone(), &self.order, &values).ok();
        self.factor = matrix.and_then(|matrix| {
            Llt::try_new_with_symbolic(self.elimination.clone(), matrix.as_ref(), Side::Lower).ok()
        });
        self.factor.is_some()
    }

    fn solve(&self, right: &mut [f64]) {
        let Some(factor) = &self.factor else { return };
        let solved = factor.solve(&faer::Col::from_fn(right.len(), |at| right[at]));
        right.iter_mut().enumerate().for_each(|(at, value)| *value = solved[at]);
    }
}
