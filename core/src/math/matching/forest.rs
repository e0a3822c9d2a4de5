//! The nested blossoms: odd cycles of nodes, or of smaller blossoms, that a search treats as one node.

use super::graph::Graph;

pub const NONE: u32 = u32::MAX;

/// What a node or blossom is to the search that is on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Label {
    /// Not in the tree, or inside a blossom.
    Free,
    /// An even number of edges from the root: its nodes' duals fall.
    Outer,
    /// An odd number of edges from the root: its nodes' duals rise.
    Inner,
}

/// A node of the graph, or a blossom. One cache line: searches wait for memory more than for anything else.
#[repr(align(64))]
pub struct Cell {
    /// The blossom that this is a child of.
    pub parent: u32,
    /// One of the children, which stand in a circle.
    pub first: u32,
    /// The next child of the same parent, and the dart from here to there.
    pub next: u32,
    pub next_dart: u32,
    /// The matched edge as a dart that leaves here. Kept for cells that have no parent, told to those inside
    /// when they are needed.
    pub mate: u32,
    /// The node that `mate` leaves; where nothing does, the node that stays alone.
    pub base: u32,
    /// Of a node: the outermost cell around it when the search began, or since it left a blossom.
    pub around: u32,
    /// Towards the outermost blossom, across those of the search that is on.
    pub join: u32,
    /// Of an inner cell: the dart towards the root.
    pub via: u32,
    /// When a walk to the root last came by.
    pub mark: u32,
    pub label: Label,
    /// To add to the duals of all nodes inside.
    pub shift: i64,
    /// The node's or the blossom's own dual, up to what the search has still to add.
    pub dual: i64,
}

impl Cell {
    fn new(at: u32) -> Self {
        Self {
            parent: NONE,
            first: NONE,
            next: NONE,
            next_dart: NONE,
            mate: NONE,
            base: at,
            around: at,
            join: at,
            via: NONE,
            mark: 0,
            label: Label::Free,
            shift: 0,
            dual: 0,
        }
    }
}

/// Cells below `node_count` are the graph's nodes, the others are blossoms.
pub struct Forest {
    pub graph: Graph,
    pub cells: Vec<Cell>,
    unused: Vec<u32>,
}

impl Forest {
    pub fn new(graph: Graph) -> Self {
        let cells = (0..graph.node_count() as u32).map(Cell::new).collect();
        Self { graph, cells, unused: Vec::new() }
    }

    pub fn cell(&self, at: u32) -> &Cell {
        &self.cells[at as usize]
    }

    pub fn cell_mut(&mut self, at: u32) -> &mut Cell {
        &mut self.cells[at as usize]
    }

    pub fn is_blossom(&self, at: u32) -> bool {
        at as usize >= self.graph.node_count()
    }

    /// The outermost cell around a node.
    pub fn outermost(&mut self, node: u32) -> u32 {
        let mut at = self.cell(node).around;
        loop {
            let up = self.cell(at).join;
            if up == at {
                return at;
            }
            let above = self.cell(up).join;
            self.cell_mut(at).join = above;
            at = above;
        }
    }

    pub fn set_mate(&mut self, at: u32, dart: u32) {
        let base = self.graph.tail(dart);
        let cell = self.cell_mut(at);
        (cell.mate, cell.base) = (dart, base);
    }

    /// Calls for every node inside, in the order of the circles.
    pub fn each_node(&mut self, top: u32, mut call: impl FnMut(&mut Self, u32)) {
        let mut at = top;
        loop {
            while self.is_blossom(at) {
                at = self.cell(at).first;
            }
            call(self, at);
            while at != top && self.cell(at).next == self.cell(self.cell(at).parent).first {
                at = self.cell(at).parent;
            }
            if at == top {
                return;
            }
            at = self.cell(at).next;
        }
    }

    /// A new outermost blossom of these cells in a circle, each with the dart to the next; its mate is the first's.
    pub fn enclose(&mut self, circle: &[(u32, u32)]) -> u32 {
        let blossom = self.unused.pop().unwrap_or_else(|| {
            self.cells.push(Cell::new(self.cells.len() as u32));
            self.cells.len() as u32 - 1
        });
        let first = self.cell(circle[0].0);
        let (mate, base) = (first.mate, first.base);
        *self.cell_mut(blossom) = Cell { first: circle[0].0, mate, base, ..Cell::new(blossom) };
        for (i, &(child, dart)) in circle.iter().enumerate() {
            let next = circle[(i + 1) % circle.len()].0;
            let cell = self.cell_mut(child);
            (cell.parent, cell.join, cell.next, cell.next_dart) = (blossom, blossom, next, dart);
            cell.label = Label::Free;
        }
        blossom
    }

    /// Its children are outermost from now on.
    pub fn dissolve(&mut self, blossom: u32) {
        let cell = self.cell_mut(blossom);
        let first = std::mem::replace(&mut cell.first, NONE);
        cell.label = Label::Free;
        let mut at = first;
        loop {
            self.release(at);
            at = self.cell(at).next;
            if at == first {
                break;
            }
        }
        self.unused.push(blossom);
    }

    fn release(&mut self, at: u32) {
        let cell = self.cell_mut(at);
        (cell.parent, cell.join) = (NONE, at);
    }

    /// The child of `blossom` that `node` is in.
    pub fn child_with(&self, blossom: u32, node: u32) -> u32 {
        let mut at = node;
        while self.cell(at).parent != blossom {
            at = self.cell(at).parent;
        }
        at
    }

    /// Turns the circles around a cell's base, inside it at all depths, so that they begin with the child that
    /// has the base.
    fn turn_to_base(&mut self, top: u32) {
        let mut at = self.cell(top).base;
        while at != top {
            let up = self.cell(at).parent;
            self.cell_mut(up).first = at;
            at = up;
        }
    }

    /// Tells the mates to the children of a blossom whose circle begins with its base.
    fn pair_children(&mut self, blossom: u32) {
        let &Cell { first, mate, base, .. } = self.cell(blossom);
        let cell = self.cell_mut(first);
        (cell.mate, cell.base) = (mate, base);
        let mut at = self.cell(first).next;
        while at != first {
            let &Cell { next, next_dart, .. } = self.cell(at);
            self.set_mate(at, next_dart);
            self.set_mate(next, next_dart ^ 1);
            at = self.cell(next).next;
        }
    }

    /// Tells the mates to the cells inside, through all blossoms that `opens` names, the outermost first. Returns
    /// these, and the cells at which it stopped.
    pub fn hand_down(&mut self, top: u32, opens: impl Fn(u32, &Cell) -> bool) -> (Vec<u32>, Vec<u32>) {
        let (mut opened, mut kept) = (Vec::new(), Vec::new());
        // With each, whether it is turned already: the child with the base is, together with its parent.
        let mut open = vec![(top, false)];
        while let Some((at, turned)) = open.pop() {
            if !self.is_blossom(at) || !opens(at, self.cell(at)) {
                kept.push(at);
                continue;
            }
            if !turned {
                self.turn_to_base(at);
            }
            self.pair_children(at);
            opened.push(at);
            let first = self.cell(at).first;
            let mut child = first;
            loop {
                open.push((child, child == first));
                child = self.cell(child).next;
                if child == first {
                    break;
                }
            }
        }
        (opened, kept)
    }
}
