//! Larger blocks: neighbors that store the same texels along their common edge stand side by side and store them once.
//!
//! Which quads go together is looked for by ruin and recreate (Schrimpf et al. 2000): a grid of quads is drawn at random and
//! cut out of the blocks that have them, what is left of those is in grids again, and each of all these joins neighbors
//! while it can. If all that takes no more texels it stays, else all is as before.

use crate::math::random::Random;

use super::Painted;
use super::neighbors::{Direction, Neighbors, Patch, Pose};
use super::turn::Turn;

/// Segments along a block's side at level 0 beyond which it does not grow.
const SEGMENTS_MAX: u32 = 64;
/// Faces that are looked at for each quad.
const WORK_OF_QUAD: u64 = 400;

/// Grids of all quads that `counts`, each to be one block.
pub fn patches(painted: &Painted<'_>, counts: impl Fn(usize) -> bool) -> Vec<Patch> {
    let is_quad = |face: usize| !painted.canvas.faces[face].is_triangle() && counts(face);
    let quads: Vec<u32> =
        (0u32..).take(painted.face_count()).filter(|&face| is_quad(face as usize)).collect();
    let mut seats = vec![Seat::default(); painted.face_count()];
    for (patch, &face) in (0u32..).zip(&quads) {
        seats[face as usize].patch = patch;
    }
    let mut joiner = Joiner {
        neighbors: Neighbors::new(painted, is_quad),
        patches: quads.iter().map(|&face| Patch::alone(face)).collect(),
        seats,
        random: Random(7),
    };
    let work_max = WORK_OF_QUAD * quads.len() as u64;
    while joiner.neighbors.work < work_max {
        joiner.attempt(&quads);
    }
    joiner.patches.into_iter().filter(|patch| !patch.faces.is_empty()).collect()
}

/// Where a face lies.
#[derive(Clone, Copy, Debug, Default)]
struct Seat {
    patch: u32,
    cell: [u32; 2],
}

struct Joiner<'a> {
    neighbors: Neighbors<'a>,
    /// Such as are no more have no faces.
    patches: Vec<Patch>,
    /// By face.
    seats: Vec<Seat>,
    random: Random,
}

/// A patch that is no more, with its number.
type Removed = (u32, Patch);

impl Joiner<'_> {
    /// Draws a grid of quads and has it as a block, if that takes no more texels.
    fn attempt(&mut self, quads: &[u32]) {
        let face = quads[self.random.below(quads.len() as u32) as usize];
        let corner = Pose { face, turn: Turn::numbered(self.random.below(Turn::COUNT)) };
        let [run_max, rows_max] =
            self.neighbors.exponents(corner).map(|exponent| (SEGMENTS_MAX >> exponent).max(1));
        let run = self.neighbors.run(corner, run_max);
        let width = 1 + self.random.below(run);
        let rows_max = 1 + self.random.below(rows_max);
        let patch = self.neighbors.grid(corner, width, rows_max);
        let first_new = self.patches.len();
        let Some(mut removed) = self.claim(patch) else { return };
        self.join(first_new, &mut removed);
        // What came and went on the way was never there.
        removed.retain(|(number, _)| (*number as usize) < first_new);
        let was: u64 = removed.iter().map(|(_, patch)| self.cost(patch)).sum();
        let is: u64 = self.patches[first_new..].iter().map(|patch| self.cost(patch)).sum();
        if is > was {
            self.patches.truncate(first_new);
            for (number, patch) in removed {
                self.seat(number, &patch);
                self.patches[number as usize] = patch;
            }
        }
    }

    /// Texels at level 0 beyond those of one corner, two sides and the inside of each face, which it takes in any case.
    fn cost(&self, patch: &Patch) -> u64 {
        let Some(&first) = patch.faces.first() else { return 0 };
        let exponents = self.neighbors.exponents(first);
        (0..2).map(|k| u64::from(patch.cells[k]) << exponents[k]).sum::<u64>() + 1
    }

    fn add(&mut self, patch: Patch) {
        let number = self.patches.len() as u32;
        self.seat(number, &patch);
        self.patches.push(patch);
    }

    fn seat(&mut self, number: u32, patch: &Patch) {
        for (cell, pose) in patch.cells_in_order().zip(&patch.faces) {
            self.seats[pose.face as usize] = Seat { patch: number, cell };
        }
    }

    fn remove(&mut self, number: u32) -> Removed {
        (number, std::mem::take(&mut self.patches[number as usize]))
    }

    /// Cuts a grid out of the patches that have its faces; none where it is one already, or takes a piece of one that is no
    /// grid.
    fn claim(&mut self, patch: Patch) -> Option<Vec<Removed>> {
        let mut taken: Vec<Seat> = patch.faces.iter().map(|pose| self.seats[pose.face as usize]).collect();
        taken.sort_unstable_by_key(|seat| (seat.patch, seat.cell));
        let of_one = || taken.chunk_by(|a, b| a.patch == b.patch);
        let is_there =
            |seats: &[Seat]| self.patches[seats[0].patch as usize].faces.len() == patch.faces.len();
        if of_one().take(2).count() == 1 && is_there(&taken) {
            return None;
        }
        let mut left = Vec::new();
        for seats in of_one() {
            left.extend(self.without(seats)?);
        }
        let numbers: Vec<u32> = of_one().map(|seats| seats[0].patch).collect();
        let removed = numbers.into_iter().map(|number| self.remove(number)).collect();
        self.add(patch);
        left.into_iter().for_each(|patch| self.add(patch));
        Some(removed)
    }

    /// What is left of a patch, in up to four grids, without a grid in it.
    fn without(&self, seats: &[Seat]) -> Option<Vec<Patch>> {
        let patch = &self.patches[seats[0].patch as usize];
        let along = |axis: usize| seats.iter().map(move |seat| seat.cell[axis]);
        let [from_x, from_y] = [0, 1].map(|axis| along(axis).min().unwrap_or(0));
        let [end_x, end_y] = [0, 1].map(|axis| along(axis).max().unwrap_or(0) + 1);
        if (end_x - from_x) * (end_y - from_y) != seats.len() as u32 {
            return None;
        }
        let [width, height] = patch.cells;
        let in_rows = [
            ([0, 0], [width, from_y]),
            ([0, end_y], [width, height]),
            ([0, from_y], [from_x, end_y]),
            ([end_x, from_y], [width, end_y]),
        ];
        let in_columns = [
            ([0, 0], [from_x, height]),
            ([end_x, 0], [width, height]),
            ([from_x, 0], [end_x, from_y]),
            ([from_x, end_y], [end_x, height]),
        ];
        let ways = [in_rows, in_columns].map(|way| -> Vec<Patch> {
            let parts = way.into_iter().filter(|(from, end)| from[0] < end[0] && from[1] < end[1]);
            parts.map(|(from, end)| patch.part(from, end)).collect()
        });
        ways.into_iter().min_by_key(|way| way.iter().map(|patch| self.cost(patch)).sum::<u64>())
    }

    /// Joins patches from a number on with neighbors while there are any, first those that save most.
    fn join(&mut self, first_new: usize, removed: &mut Vec<Removed>) {
        let mut waiting: Vec<u32> = (first_new as u32..self.patches.len() as u32).collect();
        while let Some(number) = waiting.pop() {
            let unions = Direction::ALL.map(|direction| self.union(number, direction));
            let saved = |union: &(u32, Patch)| {
                let [one, other] = [number, union.0].map(|number| self.cost(&self.patches[number as usize]));
                one + other - self.cost(&union.1)
            };
            if let Some((other, union)) = unions.into_iter().flatten().max_by_key(saved) {
                removed.extend([number, other].map(|number| self.remove(number)));
                waiting.push(self.patches.len() as u32);
                self.add(union);
            }
        }
    }

    /// A patch and the one beside it, with its number, if both together are a grid that is not too large.
    fn union(&mut self, number: u32, direction: Direction) -> Option<(u32, Patch)> {
        let patch = &self.patches[number as usize];
        let (Some(&first), Some(&last)) = (patch.faces.first(), patch.faces.last()) else { return None };
        let pose = self.neighbors.step(if direction.is_up { last } else { first }, direction)?;
        let seat = self.seats[pose.face as usize];
        let other = &self.patches[seat.patch as usize];
        // How the other patch lies beside this one: as its face there does.
        let own = other.faces[(seat.cell[1] * other.cells[0] + seat.cell[0]) as usize].turn;
        let is_swapped = own.is_swapped != pose.turn.is_swapped;
        let other_cells = if is_swapped { [other.cells[1], other.cells[0]] } else { other.cells };
        let Direction { axis, is_up } = direction;
        let mut cells = patch.cells;
        cells[axis] += other_cells[axis];
        let is_small = cells[axis] << self.neighbors.exponents(first)[axis] <= SEGMENTS_MAX;
        if seat.patch == number || other_cells[1 - axis] != cells[1 - axis] || !is_small {
            return None;
        }
        let mut corner = first;
        for _ in 0..if is_up { 0 } else { other_cells[axis] } {
            corner = self.neighbors.step(corner, direction)?;
        }
        let union = self.neighbors.grid(corner, cells[0], cells[1]);
        let is_of_both = |pose: &Pose| [number, seat.patch].contains(&self.seats[pose.face as usize].patch);
        (union.cells == cells && union.faces.iter().all(is_of_both)).then_some((seat.patch, union))
    }
}
