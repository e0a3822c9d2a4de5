//! Sparse symmetric positive definite systems whose pattern outlasts their values: the order of elimination is
//! found once, and costs as much as a few systems.

use faer::Side;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat};

/// Where a system has entries, and in which order its variables are eliminated.
pub struct Pattern {
    pattern: SymbolicSparseColMat<u32>,
    order: Argsort<u32>,
    elimination: SymbolicLlt<u32>,
}

impl Pattern {
    /// Of `size` variables; `entries` are of the lower triangle, and values of one place are summed. `None` where
    /// one is not, or where memory does not last.
    pub fn new(size: usize, entries: &[Pair<u32, u32>]) -> Option<Self> {
        let (pattern, order) = SymbolicSparseColMat::try_new_from_indices(size, size, entries).ok()?;
        let elimination = SymbolicLlt::try_new(pattern.as_ref(), Side::Lower).ok()?;
        Some(Self { pattern, order, elimination })
    }

    /// The factor of the matrix with these values, in the order of the entries; `None` where it is not positive
    /// definite.
    pub fn factor(&self, values: &[f64]) -> Option<Llt<u32, f64>> {
        let matrix = SparseColMat::new_from_argsort(self.pattern.clone(), &self.order, values).ok()?;
        Llt::try_new_with_symbolic(self.elimination.clone(), matrix.as_ref(), Side::Lower).ok()
    }
}
