//! Pairs of joined nodes, no node in two of them, that together weigh as much as possible: maximum-weight matching
//! in a sparse graph that need not be bipartite.
//!
//! Edmonds' blossom method (1965, "Maximum matching and a polyhedron with 0,1-vertices"): beside the pairs go
//! duals, one for each node and one for each blossom, which prove in the end that no other choice weighs more:
//!
//! * every edge's two node duals and the duals of the blossoms around both are together at least its weight;
//! * of a matched edge they are its weight; a node that stays alone has dual zero; and a blossom with a dual has
//!   all its nodes but one matched inside.
//!
//! It begins with lowered duals and pairs by degree (Karp and Sipser 1981). Then one alternating tree grows at a
//! time, as Cook and Rohe (1999) and Kolmogorov (2009, "Blossom V") describe it: its duals move together and are
//! stored without that, so that a search costs as much as it reaches, not as the graph has nodes. That a node may
//! stay alone follows Galil (1986): a tree also ends where a dual comes to zero.

mod blossom;
mod forest;
mod graph;
mod search;
mod start;
#[cfg(test)]
mod tests;

use forest::{Forest, NONE};
use graph::Graph;
use search::Matcher;

/// An edge that may be matched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WeightedEdge {
    /// Two nodes, from zero. Several edges may join the same two; one that joins a node to itself is never matched.
    pub nodes: [u32; 2],
    /// What matching gains, below 2^60. An edge that gains nothing is never matched.
    pub weight: i64,
}

/// For each of `node_count` nodes its partner, if it has one, such that the matched edges' total weight is the
/// greatest there is. Depends on the order of nodes and edges where several matchings weigh as much, and on nothing
/// else. All edges' nodes are below `node_count`, and there are fewer than 2^31 nodes and 2^31 edges.
pub fn maximum_weight_matching(node_count: usize, edges: &[WeightedEdge]) -> Vec<Option<u32>> {
    let mut matcher = solved(node_count, edges);
    partners(&mut matcher.forest)
}

/// The optimum, with the duals that prove it.
fn solved(node_count: usize, edges: &[WeightedEdge]) -> Matcher {
    let mut forest = Forest::new(Graph::new(node_count, edges));
    start::start(&mut forest);
    let mut matcher = Matcher::new(forest);
    for node in 0..node_count as u32 {
        // A node with a parent has its mate by that blossom.
        let cell = matcher.forest.cell(node);
        if cell.mate == NONE && cell.parent == NONE && cell.dual > 0 {
            matcher.search(node);
        }
    }
    matcher
}

/// For each node its partner, told through all blossoms.
fn partners(forest: &mut Forest) -> Vec<Option<u32>> {
    for top in 0..forest.cells.len() as u32 {
        if forest.cell(top).parent == NONE && forest.cell(top).first != NONE {
            forest.hand_down(top, |_, _| true);
        }
    }
    let count = forest.graph.node_count();
    forest.cells[..count]
        .iter()
        .map(|cell| (cell.mate != NONE).then(|| forest.graph.head(cell.mate)))
        .collect()
}
