//! Rules that share variables: a problem of its own.

/// `low <= W y <= high`, rows scaled to unit length: beyond vertex colors raw weights reach `4^(level - r)`.
#[derive(Default)]
pub struct Island {
    /// Numbers in the level's problem, ascending.
    variables: Vec<u32>,
    first_term: Vec<u32>,
    /// Place in `variables`, and weight.
    terms: Vec<(u32, f64)>,
    /// By row: what a texel's range was shortened to.
    scales: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    /// Whether the weights of every row sum to 1, before they are scaled.
    is_affine: bool,
}

impl Island {
    /// An island about `variables`, which are ascending, without rows yet.
    pub fn new(variables: Vec<u32>, is_affine: bool) -> Self {
        Self { variables, first_term: vec![0], is_affine, ..Self::default() }
    }

    /// Adds `0 <= constant + terms · y <= 1`; `terms` name their variables by place. The range is narrower by
    /// what the row's value may change when its samples are rounded to 64 bits: 5e-4 for weights of `4^20`.
    pub fn push(&mut self, terms: impl Iterator<Item = (u32, f64)>, constant: f64) {
        let first = self.terms.len();
        self.terms.extend(terms);
        let length = self.terms[first..].iter().map(|(_, weight)| weight * weight).sum::<f64>().sqrt();
        if length == 0.0 {
            self.terms.truncate(first);
            return;
        }
        let rounding = f64::EPSILON * self.terms[first..].iter().map(|term| term.1.abs()).sum::<f64>();
        let margin = rounding.min(0.25);
        self.terms[first..].iter_mut().for_each(|term| term.1 /= length);
        self.first_term.push(self.terms.len() as u32);
        self.scales.push(1.0 / length);
        self.low.push((margin - constant) / length);
        self.high.push((1.0 - margin - constant) / length);
    }

    pub fn variables(&self) -> &[u32] {
        &self.variables
    }

    pub fn row_count(&self) -> usize {
        self.low.len()
    }

    pub fn terms(&self, row: usize) -> &[(u32, f64)] {
        &self.terms[self.first_term[row] as usize..self.first_term[row + 1] as usize]
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
        out.extend((0..self.row_count()).map(|row| self.row_of(row, y)));
    }

    /// A row of `W y`; in differences to its first variable, where weights are known to sum to 1: large
    /// weights of opposite signs then multiply what is small.
    pub fn row_of(&self, row: usize, y: &[f64]) -> f64 {
        let terms = self.terms(row);
        if !self.is_affine {
            return terms.iter().map(|&(v, weight)| weight * y[v as usize]).sum();
        }
        let base = y[terms[0].0 as usize];
        let changes = terms[1..].iter().map(|&(v, weight)| weight * (y[v as usize] - base));
        changes.sum::<f64>() + base * self.scales[row]
    }

    /// `out += Wᵀ z`.
    pub fn add_transposed(&self, z: impl Iterator<Item = f64>, out: &mut [f64]) {
        for (row, z) in z.enumerate() {
            self.terms(row).iter().for_each(|&(v, weight)| out[v as usize] += weight * z);
        }
    }
}
