//! What the searches begin with: duals that are feasible, and tight edges matched by them.

use super::forest::{Forest, NONE};
use super::graph::Arc;

/// Degrees from here on count as one.
const HIGH: usize = 3;

/// Feasible duals of all nodes; the matching that the forest gets is tight by them.
pub fn start(forest: &mut Forest) {
    let count = forest.graph.node_count() as u32;
    // Half of the heaviest edge at both its ends; weights are doubled.
    let half = |node| forest.graph.arcs(node).iter().map(|arc| arc.weight / 2).max().unwrap_or(0);
    let mut duals: Vec<i64> = (0..count).map(half).collect();
    match_tight(forest, &duals);
    lower(forest, &mut duals);
    for (node, dual) in (0..).zip(duals) {
        forest.cell_mut(node).dual = dual;
    }
}

/// Matches tight edges, always at a node that has fewest left (Karp and Sipser 1981): hardly a node stays alone that
/// need not, even where all edges are tight.
fn match_tight(forest: &mut Forest, duals: &[i64]) {
    let count = forest.graph.node_count() as u32;
    let is_tight = |tail: u32, arc: &Arc| duals[tail as usize] + duals[arc.head as usize] == arc.weight;
    let degree = |node| forest.graph.arcs(node).iter().filter(|arc| is_tight(node, arc)).count();
    let mut degrees: Vec<u32> = (0..count).map(|node| degree(node) as u32).collect();
    let mut waiting: [Vec<u32>; HIGH + 1] = Default::default();
    for node in (0..count).rev() {
        waiting[HIGH.min(degrees[node as usize] as usize)].push(node);
    }
    while let Some(lowest) = (1..=HIGH).find(|&degree| !waiting[degree].is_empty()) {
        let Some(node) = waiting[lowest].pop() else { break };
        if forest.cell(node).mate != NONE || HIGH.min(degrees[node as usize] as usize) != lowest {
            continue;
        }
        let arcs = forest.graph.arcs(node).iter();
        let free = arcs.filter(|arc| is_tight(node, arc) && forest.cell(arc.head).mate == NONE);
        let Some(&Arc { head, dart, .. }) = free.min_by_key(|arc| degrees[arc.head as usize]) else {
            continue;
        };
        forest.set_mate(node, dart);
        forest.set_mate(head, dart ^ 1);
        for end in [node, head] {
            for arc in forest.graph.arcs(end) {
                let neighbor = arc.head as usize;
                if is_tight(end, arc) && forest.cell(arc.head).mate == NONE {
                    degrees[neighbor] -= 1;
                    waiting[HIGH.min(degrees[neighbor] as usize)].push(arc.head);
                }
            }
        }
    }
}

/// Lowers the duals of nodes still alone, one by one, until an edge is tight; where that makes a pair it is matched.
fn lower(forest: &mut Forest, duals: &mut [i64]) {
    for node in 0..forest.graph.node_count() as u32 {
        if forest.cell(node).mate != NONE {
            continue;
        }
        let arcs = forest.graph.arcs(node);
        let need = |arc: &Arc| arc.weight - duals[arc.head as usize];
        let dual = arcs.iter().map(need).max().unwrap_or(0).max(0);
        let tight = arcs.iter().find(|arc| need(arc) == dual && forest.cell(arc.head).mate == NONE).copied();
        duals[node as usize] = dual;
        if let Some(Arc { head, dart, .. }) = tight {
            forest.set_mate(node, dart);
            forest.set_mate(head, dart ^ 1);
        }
    }
}
