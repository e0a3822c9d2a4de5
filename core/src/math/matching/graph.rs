//! Who is joined to whom: for each node its edges, one after the other.

use super::WeightedEdge;

/// An edge as its tail sees it. The two darts of edge `e` are `2 e` and `2 e + 1`; `dart ^ 1` is the way back.
#[derive(Clone, Copy)]
pub struct Arc {
    pub head: u32,
    pub dart: u32,
    /// Twice the edge's weight. So tight edges join duals that are both even or both odd, as are all in a tree, and
    /// half of what lacks between two of them is a whole number.
    pub weight: i64,
}

pub struct Graph {
    /// The arcs of `node` are `first[node]..first[node + 1]`.
    first: Vec<u32>,
    arcs: Vec<Arc>,
    tails: Vec<u32>,
    weights: Vec<i64>,
}

impl Graph {
    pub fn new(node_count: usize, edges: &[WeightedEdge]) -> Self {
        let used = || edges.iter().filter(|edge| edge.weight > 0 && edge.nodes[0] != edge.nodes[1]);
        let tails: Vec<u32> = used().flat_map(|edge| edge.nodes).collect();
        let weights: Vec<i64> = used().map(|edge| 2 * edge.weight).collect();
        let mut first = vec![0; node_count + 1];
        for &tail in &tails {
            first[tail as usize] += 1;
        }
        let mut end = 0;
        for count in &mut first {
            end += *count;
            *count = end;
        }
        let mut arcs = vec![Arc { head: 0, dart: 0, weight: 0 }; tails.len()];
        for (dart, &tail) in tails.iter().enumerate().rev() {
            let slot = &mut first[tail as usize];
            *slot -= 1;
            arcs[*slot as usize] =
                Arc { head: tails[dart ^ 1], dart: dart as u32, weight: weights[dart / 2] };
        }
        Self { first, arcs, tails, weights }
    }

    pub fn node_count(&self) -> usize {
        self.first.len() - 1
    }

    pub fn arcs(&self, node: u32) -> &[Arc] {
        &self.arcs[self.range(node)]
    }

    /// Where the node's arcs stand, for [`Graph::arc`].
    pub fn range(&self, node: u32) -> std::ops::Range<usize> {
        self.first[node as usize] as usize..self.first[node as usize + 1] as usize
    }

    pub fn arc(&self, at: usize) -> Arc {
        self.arcs[at]
    }

    pub fn tail(&self, dart: u32) -> u32 {
        self.tails[dart as usize]
    }

    pub fn head(&self, dart: u32) -> u32 {
        self.tails[dart as usize ^ 1]
    }

    /// Twice the weight.
    pub fn weight(&self, dart: u32) -> i64 {
        self.weights[dart as usize / 2]
    }
}
