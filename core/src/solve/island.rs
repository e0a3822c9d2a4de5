//! Rules that share variables: a problem of its own.

/// `low <= W y <= high`, rows scaled to unit length: beyond vertex colors raw weights reach `4^(level - r)`.
///
/// Rows that follow each other and are about the same variables, as the texels around one face are, form a
/// cell, a small dense matrix: its variables are fetched and stored once for all its rows.
#[derive(Default)]
pub struct Island {
    /// Numbers in the level's problem, ascending.
    variables: Vec<u32>,
    cells: Vec<Cell>,
    /// Places in `variables`, cell by cell.
    places: Vec<u32>,
    /// Rows of every cell, one after the other.
    weights: Vec<f64>,
    /// By row.
    cell_of: Vec<u32>,
    /// By row: what a texel's range was shortened to.
    scales: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    /// Whether the weights of every row sum to 1, before they are scaled.
    is_affine: bool,
}

/// Where a cell starts; it ends where the next one starts.
#[derive(Clone, Copy)]
struct Cell {
    row: u32,
    place: u32,
    weight: u32,
}

impl Island {
    /// An island about `variables`, which are ascending, without rows yet.
    pub fn new(variables: Vec<u32>, is_affine: bool) -> Self {
        Self { variables, is_affine, ..Self::default() }
    }

    /// Adds `low <= constant + terms · y <= high`; `terms` name their variables by place. The range is narrower by
    /// what the row's value may change when its samples are rounded to 64 bits: 5e-4 for weights of `4^20`.
    pub fn push(
        &mut self,
        terms: impl Iterator<Item = (u32, f64)> + Clone,
        constant: f64,
        [low, high]: [f64; 2],
    ) {
        let square: f64 = terms.clone().map(|(_, weight)| weight * weight).sum();
        let length = square.sqrt();
        if length == 0.0 {
            return;
        }
        let is_alike = self.cells.last().is_some_and(|last| {
            terms.clone().map(|term| term.0).eq(self.places[last.place as usize..].iter().copied())
        });
        if !is_alike {
            let place = self.places.len() as u32;
            self.cells.push(Cell { row: self.low.len() as u32, place, weight: self.weights.len() as u32 });
            self.places.extend(terms.clone().map(|term| term.0));
        }
        let rounding = f64::EPSILON * terms.clone().map(|term| term.1.abs()).sum::<f64>();
        let margin = rounding.min(0.25 * (high - low));
        self.weights.extend(terms.map(|term| term.1 / length));
        self.cell_of.push(self.cells.len() as u32 - 1);
        self.scales.push(1.0 / length);
        self.low.push((low + margin - constant) / length);
        self.high.push((high - margin - constant) / length);
    }

    pub fn variables(&self) -> &[u32] {
        &self.variables
    }

    pub fn row_count(&self) -> usize {
        self.low.len()
    }

    pub fn cell_count(&self) -> usize {
        self.cells.len()
    }

    /// The places of a cell's variables.
    pub fn cell(&self, cell: usize) -> &[u32] {
        let end = self.cells.get(cell + 1).map_or(self.places.len(), |next| next.place as usize);
        &self.places[self.cells[cell].place as usize..end]
    }

    /// The rows of a cell, and their weights, row after row.
    pub fn cell_rows(&self, cell: usize) -> (std::ops::Range<usize>, &[f64]) {
        let start = self.cells[cell];
        let next = self.cells.get(cell + 1);
        let rows = start.row as usize..next.map_or(self.low.len(), |next| next.row as usize);
        let end = next.map_or(self.weights.len(), |next| next.weight as usize);
        (rows, &self.weights[start.weight as usize..end])
    }

    /// `(place, weight)` of a row.
    pub fn terms(&self, row: usize) -> impl Iterator<Item = (u32, f64)> {
        let (places, weights) = self.row(row);
        places.iter().copied().zip(weights.iter().copied())
    }

    fn row(&self, row: usize) -> (&[u32], &[f64]) {
        let cell = self.cell_of[row] as usize;
        let places = self.cell(cell);
        let (rows, weights) = self.cell_rows(cell);
        let first = (row - rows.start) * places.len();
        (places, &weights[first..first + places.len()])
    }

    /// What a difference of 1 of a texel's values is in units of a row.
    pub fn scale(&self, row: usize) -> f64 {
        self.scales[row]
    }

    pub fn is_affine(&self) -> bool {
        self.is_affine
    }

    pub fn low(&self) -> &[f64] {
        &self.low
    }

    pub fn high(&self) -> &[f64] {
        &self.high
    }

    /// `out = W y`.
    pub fn apply(&self, y: &[f64], out: &mut Vec<f64>) {
        out.clear();
        for cell in 0..self.cells.len() {
            let places = self.cell(cell);
            match places.len() {
                3 => self.apply_cell::<3>(cell, y, out),
                4 => self.apply_cell::<4>(cell, y, out),
                9 => self.apply_cell::<9>(cell, y, out),
                12 => self.apply_cell::<12>(cell, y, out),
                _ => out.extend(self.cell_rows(cell).0.map(|row| self.row_of(row, y))),
            }
        }
    }

    fn apply_cell<const N: usize>(&self, cell: usize, y: &[f64], out: &mut Vec<f64>) {
        let places = self.cell(cell);
        let (rows, weights) = self.cell_rows(cell);
        let base = if self.is_affine { y[places[0] as usize] } else { 0.0 };
        let mut changes = [0.0; N];
        for (change, &place) in changes.iter_mut().zip(places) {
            *change = y[place as usize] - base;
        }
        for (weights, row) in weights.chunks_exact(N).zip(rows) {
            let mut sum = base * self.scales[row];
            for (weight, change) in weights.iter().zip(&changes) {
                sum += weight * change;
            }
            out.push(sum);
        }
    }

    /// A row of `W y`; in differences to its first variable, where weights are known to sum to 1: large
    /// weights of opposite signs then multiply what is small.
    pub fn row_of(&self, row: usize, y: &[f64]) -> f64 {
        let (places, weights) = self.row(row);
        let base = if self.is_affine { y[places[0] as usize] } else { 0.0 };
        let changes = places.iter().zip(weights).map(|(&place, weight)| weight * (y[place as usize] - base));
        changes.sum::<f64>() + base * self.scales[row]
    }

    /// `out += Wᵀ z`.
    pub fn add_transposed(&self, z: &[f64], out: &mut [f64]) {
        for cell in 0..self.cells.len() {
            match self.cell(cell).len() {
                3 => self.add_cell::<3>(cell, z, out),
                4 => self.add_cell::<4>(cell, z, out),
                9 => self.add_cell::<9>(cell, z, out),
                12 => self.add_cell::<12>(cell, z, out),
                _ => {
                    for row in self.cell_rows(cell).0 {
                        self.terms(row).for_each(|(place, weight)| out[place as usize] += weight * z[row]);
                    }
                }
            }
        }
    }

    fn add_cell<const N: usize>(&self, cell: usize, z: &[f64], out: &mut [f64]) {
        let (rows, weights) = self.cell_rows(cell);
        let mut sums = [0.0; N];
        for (weights, z) in weights.chunks_exact(N).zip(&z[rows]) {
            sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight * z);
        }
        for (sum, &place) in sums.iter().zip(self.cell(cell)) {
            out[place as usize] += sum;
        }
    }
}
