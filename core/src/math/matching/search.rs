//! Searches: an alternating tree from one exposed node, until that node is matched or its tree ends at a node
//! whose dual is zero.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use super::forest::{Forest, Label, NONE};

/// What happens when the search has moved its duals so far.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    /// An edge from an outer cell, by its dart, has no slack left.
    Tight(u32),
    /// An inner blossom has no dual left.
    Spent(u32),
}

/// How a search ends.
#[derive(Clone, Copy)]
enum End {
    /// By the dart from an outer cell to an exposed one.
    Exposed(u32),
    /// At a node inside an outer cell whose dual is zero: it may stay alone.
    Zero(u32),
}

/// The duals of the nodes, and the tree that is growing. Within a search, the tree's duals have moved by `moved`:
/// those of nodes inside outer cells fell, of nodes inside inner cells rose, of outer blossoms rose by twice as
/// much, of inner blossoms fell. What is stored leaves that out, so that moving costs nothing:
/// nodes: `dual - moved` (outer), `dual + shift + moved` (inner), `dual + shift` (free);
/// blossoms: `dual + 2 moved` (outer), `dual - 2 moved` (inner), `dual` (others).
pub struct Matcher {
    pub forest: Forest,
    pub(super) moved: i64,
    /// Where `moved` can go at most, and the node whose dual is zero then.
    limit: (i64, u32),
    /// What happens without moving, the earliest planned first: trees stay shallow.
    now: VecDeque<Event>,
    later: BinaryHeap<Reverse<(i64, Event)>>,
    /// Every cell that came in, also those that are inside a blossom by now or have left.
    pub(super) tree: Vec<u32>,
    /// Kept for its memory.
    nodes: Vec<u32>,
    end: Option<End>,
    pub(super) mark: u32,
}

impl Matcher {
    /// The forest's duals are feasible, and its pairs' edges tight by them.
    pub fn new(forest: Forest) -> Self {
        Self {
            forest,
            moved: 0,
            limit: (0, NONE),
            now: VecDeque::new(),
            later: BinaryHeap::new(),
            tree: Vec::new(),
            nodes: Vec::new(),
            end: None,
            mark: 0,
        }
    }

    /// Matches an exposed node, or leaves exposed one whose dual is zero.
    pub fn search(&mut self, root: u32) {
        self.moved = 0;
        self.limit = (i64::MAX, NONE);
        self.end = None;
        self.now.clear();
        self.later.clear();
        self.enter_outer(root);
        match self.grow() {
            End::Exposed(dart) => {
                let (tail, head) = (self.forest.graph.tail(dart), self.forest.graph.head(dart));
                let exposed = self.forest.outermost(head);
                self.forest.set_mate(exposed, dart ^ 1);
                self.flip(tail, dart);
            }
            End::Zero(node) => self.flip(node, NONE),
        }
        self.leave();
    }

    fn grow(&mut self) -> End {
        loop {
            if let Some(end) = self.end {
                return end;
            }
            if self.limit.0 <= self.moved {
                return End::Zero(self.limit.1);
            }
            let event = if let Some(event) = self.now.pop_front() {
                event
            } else {
                match self.later.pop() {
                    Some(Reverse((at, event))) if at < self.limit.0 => {
                        self.moved = at;
                        event
                    }
                    _ => {
                        self.moved = self.limit.0;
                        return End::Zero(self.limit.1);
                    }
                }
            };
            match event {
                Event::Tight(dart) => self.cross(dart),
                Event::Spent(blossom) => {
                    let cell = self.forest.cell(blossom);
                    if cell.label == Label::Inner && cell.dual == 2 * self.moved {
                        self.open_inner(blossom);
                    }
                }
            }
        }
    }

    fn plan(&mut self, at: i64, event: Event) {
        if at <= self.moved {
            self.now.push_back(event);
        } else if at < self.limit.0 {
            self.later.push(Reverse((at, event)));
        }
    }

    /// The dual of a node inside the outermost cell `around`.
    fn dual(&self, node: u32, around: u32) -> i64 {
        let dual = self.forest.cell(node).dual;
        let cell = self.forest.cell(around);
        match cell.label {
            Label::Outer => dual - self.moved,
            Label::Inner => dual + cell.shift + self.moved,
            Label::Free => dual + cell.shift,
        }
    }

    /// Follows an edge from an outer cell, if it still is tight and leads anywhere.
    fn cross(&mut self, dart: u32) {
        let (tail, head) = (self.forest.graph.tail(dart), self.forest.graph.head(dart));
        let (from, to) = (self.forest.outermost(tail), self.forest.outermost(head));
        let label = self.forest.cell(to).label;
        if from == to || label == Label::Inner {
            return;
        }
        if self.dual(tail, from) + self.dual(head, to) > self.forest.graph.weight(dart) {
            return;
        }
        if label == Label::Outer {
            self.close(dart, from, to);
        } else if self.forest.cell(to).mate == NONE {
            self.end = Some(End::Exposed(dart));
        } else {
            self.enter_inner(to, dart ^ 1);
            let mate = self.forest.graph.head(self.forest.cell(to).mate);
            let mate = self.forest.outermost(mate);
            self.enter_outer(mate);
        }
    }

    /// A free cell joins the tree by the dart from it towards the root.
    pub(super) fn enter_inner(&mut self, at: u32, via: u32) {
        let moved = self.moved;
        let is_blossom = self.forest.is_blossom(at);
        let cell = self.forest.cell_mut(at);
        cell.label = Label::Inner;
        cell.via = via;
        cell.shift -= moved;
        if is_blossom {
            cell.dual += 2 * moved;
            let spent = cell.dual / 2;
            self.plan(spent, Event::Spent(at));
        }
        self.tree.push(at);
    }

    /// A free cell joins the tree as the mate of an inner one, or as the root.
    pub(super) fn enter_outer(&mut self, at: u32) {
        let moved = self.moved;
        let is_blossom = self.forest.is_blossom(at);
        let cell = self.forest.cell_mut(at);
        cell.label = Label::Outer;
        if is_blossom {
            cell.dual -= 2 * moved;
        }
        let rise = cell.shift + moved;
        cell.shift = 0;
        self.tree.push(at);
        self.fall(at, rise);
        self.scan_outer(at);
    }

    /// Stores the duals of nodes that fall from now on.
    pub(super) fn fall(&mut self, at: u32, rise: i64) {
        let limit = &mut self.limit;
        self.forest.each_node(at, |forest, node| {
            let dual = &mut forest.cell_mut(node).dual;
            *dual += rise;
            *limit = (*limit).min((*dual, node));
        });
    }

    /// The nodes inside, to be put back into `self.nodes`.
    fn nodes(&mut self, at: u32) -> Vec<u32> {
        let mut nodes = std::mem::take(&mut self.nodes);
        nodes.clear();
        self.forest.each_node(at, |_, node| nodes.push(node));
        nodes
    }

    /// Plans what the edges of nodes lead to that have just become outer.
    pub(super) fn scan_outer(&mut self, at: u32) {
        let nodes = self.nodes(at);
        for &node in &nodes {
            let from = self.forest.outermost(node);
            let dual = self.dual(node, from);
            for arc in self.forest.graph.range(node) {
                let arc = self.forest.graph.arc(arc);
                let to = self.forest.outermost(arc.head);
                if to == from {
                    continue;
                }
                let slack = dual + self.dual(arc.head, to) - arc.weight;
                let cell = self.forest.cell(to);
                match cell.label {
                    Label::Inner => {}
                    Label::Outer => self.plan(self.moved + slack / 2, Event::Tight(arc.dart)),
                    Label::Free if slack == 0 && cell.mate == NONE => self.end = Some(End::Exposed(arc.dart)),
                    Label::Free => self.plan(self.moved + slack, Event::Tight(arc.dart)),
                }
            }
        }
        self.nodes = nodes;
    }

    /// Plans when the tree comes back to nodes that have just left it.
    pub(super) fn scan_free(&mut self, at: u32) {
        let nodes = self.nodes(at);
        for &node in &nodes {
            let dual = self.dual(node, at);
            for arc in self.forest.graph.range(node) {
                let arc = self.forest.graph.arc(arc);
                let to = self.forest.outermost(arc.head);
                if self.forest.cell(to).label == Label::Outer {
                    let slack = dual + self.dual(arc.head, to) - arc.weight;
                    self.plan(self.moved + slack, Event::Tight(arc.dart ^ 1));
                }
            }
        }
        self.nodes = nodes;
    }

    /// Writes the tree's duals and lets its cells go. Blossoms without a dual fall apart: they would only be in
    /// the way of later searches.
    fn leave(&mut self) {
        let moved = self.moved;
        for at in std::mem::take(&mut self.tree) {
            let is_blossom = self.forest.is_blossom(at);
            let cell = self.forest.cell_mut(at);
            let label = std::mem::replace(&mut cell.label, Label::Free);
            match label {
                // Inside a blossom by now, or one that fell apart.
                Label::Free => {}
                Label::Inner => {
                    cell.shift += moved;
                    if is_blossom {
                        cell.dual -= 2 * moved;
                    }
                }
                Label::Outer => {
                    if is_blossom {
                        cell.dual += 2 * moved;
                    }
                    self.forest.each_node(at, |forest, node| forest.cell_mut(node).dual -= moved);
                    if !is_blossom {
                        continue;
                    }
                    let (opened, kept) = self.forest.hand_down(at, |_, cell| cell.dual == 0);
                    for blossom in opened {
                        self.forest.dissolve(blossom);
                    }
                    for top in kept {
                        self.forest.each_node(top, |forest, node| forest.cell_mut(node).around = top);
                    }
                }
            }
        }
    }
}
