//! Elements in disjoint sets that only ever grow together (union-find).

/// Every set is named by its lowest element, so the outcome does not depend on the order of joining.
#[derive(Clone, Debug)]
pub struct Partition {
    parent: Vec<u32>,
}

impl Partition {
    /// `count` elements, each in a set of its own.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// The lowest element of the set that `at` is in.
    pub fn root(&mut self, mut at: u32) -> u32 {
        while self.parent[at as usize] != at {
            let up = self.parent[at as usize];
            self.parent[at as usize] = self.parent[up as usize];
            at = up;
        }
        at
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
