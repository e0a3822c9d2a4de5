//! Rules that share variables: a problem of its own.

/// `low <= W y <= high`, rows scaled to unit length: beyond vertex colors raw weights reach `4^(level - r)`.
#[derive(Default)]
pub struct Island {
    /// Numbers in the level's problem, ascending.
    variables: Vec<u32>,
    first_term: Vec<u32>,
    /// Place in `variables`, and weight.
    terms: Vec<(u32, f64)>,
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Island {
    /// An island about `variables`, which are ascending, without rows yet.
    pub fn new(variables: Vec<u32>) -> Self {
        Self { variables, first_term: vec![0], ..Self::default() }
    }

    /// Adds `0 <= constant + terms · y <= 1`; `terms` name their variables by place.
    pub fn push(&mut self, terms: impl Iterator<Item = (u32, f64)>, constant: f64) {
        let first = self.terms.len();
        self.terms.extend(terms);
        let length = self.terms[first..].iter().map(|(_, weight)| weight * weight).sum::<f64>().sqrt();
        if length == 0.0 {
            self.terms.truncate(first);
            return;
        }
        self.terms[first..].iter_mut().for_each(|term| term.1 /= length);
        self.first_term.push(self.terms.len() as u32);
        self.low.push(-constant / length);
        self.high.push((1.0 - constant) / length);
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

    fn row_of(&self, row: usize, y: &[f64]) -> f64 {
        self.terms(row).iter().map(|&(v, weight)| weight * y[v as usize]).sum()
    }

    /// `out += Wᵀ z`.
    pub fn add_transposed(&self, z: impl Iterator<Item = f64>, out: &mut [f64]) {
        for (row, z) in z.enumerate() {
            self.terms(row).iter().for_each(|&(v, weight)| out[v as usize] += weight * z);
        }
    }
}
