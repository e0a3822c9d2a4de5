//! What happens to the tree's blossoms and paths: circles close, inner blossoms fall apart, paths are swapped.

use super::forest::{Cell, Label, NONE};
use super::search::Matcher;

impl Matcher {
    /// The darts by which an outer cell's path to the root begins: to its mate and from there on.
    fn up(&mut self, outer: u32) -> Option<[(u32, u32); 2]> {
        let mate = self.forest.cell(outer).mate;
        if mate == NONE {
            return None;
        }
        let inner = self.forest.graph.head(mate);
        let inner = self.forest.outermost(inner);
        Some([(outer, mate), (inner, self.forest.cell(inner).via)])
    }

    fn above(&mut self, outer: u32) -> u32 {
        match self.up(outer) {
            Some([_, (_, via)]) => {
                let node = self.forest.graph.head(via);
                self.forest.outermost(node)
            }
            None => NONE,
        }
    }

    /// Where the paths of two outer cells to the root meet. Both are walked in turn, so that it costs no more
    /// than the blossom will have cells.
    fn meet(&mut self, a: u32, b: u32) -> u32 {
        self.mark += 1;
        let (mut at, mut other) = (a, b);
        loop {
            if at != NONE {
                let mark = self.mark;
                let cell = self.forest.cell_mut(at);
                if cell.mark == mark {
                    return at;
                }
                cell.mark = mark;
                at = self.above(at);
            }
            (at, other) = (other, at);
        }
    }

    /// The cells from an outer one up to `top`, without it, each with the dart to the next.
    fn path(&mut self, outer: u32, top: u32) -> Vec<(u32, u32)> {
        let mut path = Vec::new();
        let mut at = outer;
        while at != top {
            path.extend(self.up(at).into_iter().flatten());
            at = self.above(at);
        }
        path
    }

    /// A tight edge between two outer cells closes an odd circle: a blossom from now on, and outer.
    pub(super) fn close(&mut self, dart: u32, from: u32, to: u32) {
        let top = self.meet(from, to);
        let mut circle = self.path(from, top);
        // Collected upwards; wanted downwards from `top`, each with the dart to the next.
        circle.push((top, NONE));
        let mut down = dart;
        for step in &mut circle {
            (step.1, down) = (down, step.1 ^ 1);
        }
        circle.reverse();
        circle.extend(self.path(to, top));
        let mut inner = Vec::new();
        let moved = self.moved;
        for &(child, _) in &circle {
            let is_blossom = self.forest.is_blossom(child);
            let cell = self.forest.cell_mut(child);
            let sign = if cell.label == Label::Inner { -1 } else { 1 };
            if is_blossom {
                cell.dual += sign * 2 * moved;
            }
            if cell.label == Label::Inner {
                inner.push(child);
                let rise = cell.shift + 2 * moved;
                cell.shift = 0;
                self.fall(child, rise);
            }
        }
        let blossom = self.forest.enclose(&circle);
        let cell = self.forest.cell_mut(blossom);
        cell.label = Label::Outer;
        cell.dual = -2 * moved;
        self.tree.push(blossom);
        for child in inner {
            self.scan_outer(child);
        }
    }

    /// An inner blossom without a dual falls apart: its children between the tree's two edges stay in the tree,
    /// the others leave it.
    pub(super) fn open_inner(&mut self, blossom: u32) {
        let &Cell { via, base, shift, .. } = self.forest.cell(blossom);
        let entry = self.forest.child_with(blossom, self.forest.graph.tail(via));
        let exit = self.forest.child_with(blossom, base);
        self.forest.hand_down(blossom, |at, _| at == blossom);
        let moved = self.moved;
        let mut circle = Vec::new();
        let mut at = entry;
        loop {
            let cell = self.forest.cell_mut(at);
            cell.shift = shift + moved;
            circle.push((at, cell.next_dart));
            at = cell.next;
            if at == entry {
                break;
            }
        }
        self.forest.dissolve(blossom);
        for &(child, _) in &circle {
            self.forest.each_node(child, |forest, node| forest.cell_mut(node).around = child);
        }
        // The circle in the direction in which it is an even number of edges from `entry` to `exit`, each child
        // with the dart to the one before.
        let count = circle.len();
        let steps = circle.iter().position(|step| step.0 == exit).unwrap_or(0);
        let (steps, order): (usize, Vec<(u32, u32)>) = if steps.is_multiple_of(2) {
            (steps, (0..count).map(|i| (circle[i].0, circle[(i + count - 1) % count].1 ^ 1)).collect())
        } else {
            (count - steps, (0..count).map(|i| circle[(count - i) % count]).collect())
        };
        for (i, &(child, back)) in order[..=steps].iter().enumerate().step_by(2) {
            self.enter_inner(child, if i == 0 { via } else { back });
        }
        for &(child, _) in order[..steps].iter().skip(1).step_by(2) {
            self.enter_outer(child);
        }
        for &(child, _) in &order[steps + 1..] {
            self.scan_free(child);
        }
    }

    /// Swaps matched and unmatched edges along the path to the root from the outer cell around `node`. The node is
    /// matched by `mate` then, a dart from it, or stays alone.
    pub(super) fn flip(&mut self, node: u32, mate: u32) {
        let (mut node, mut mate) = (node, mate);
        loop {
            let at = self.forest.outermost(node);
            let up = self.up(at);
            let cell = self.forest.cell_mut(at);
            (cell.mate, cell.base) = (mate, node);
            let Some([_, (inner, via)]) = up else { return };
            self.forest.set_mate(inner, via);
            (node, mate) = (self.forest.graph.head(via), via ^ 1);
        }
    }
}
