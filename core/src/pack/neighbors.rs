//! Which quads store the same texels along a common edge, and the grids that such quads are in.

use super::Painted;
use super::texels::{FaceTexels, are_equal};
use super::turn::Turn;

/// A face and how it lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pose {
    pub face: u32,
    pub turn: Turn,
}

/// From a face of a grid to the next: along an axis, up or down.
#[derive(Clone, Copy, Debug)]
pub struct Direction {
    pub axis: usize,
    pub is_up: bool,
}

/// Faces in a grid, row by row.
#[derive(Clone, Debug, Default)]
pub struct Patch {
    /// Faces along each axis.
    pub cells: [u32; 2],
    pub faces: Vec<Pose>,
}

/// The quads beyond the edges along which both store the same.
pub struct Neighbors<'a> {
    painted: &'a Painted<'a>,
    /// By face and side of its texels' unit square: the face there as it lies beside this one. Sides: left, right, and those
    /// of the first and the last row.
    beyond: Vec<[Option<Pose>; 4]>,
    /// By face: the last grid that it was looked at for.
    seen: Vec<u64>,
    grid_count: u64,
    /// Faces that were looked at.
    pub work: u64,
}

impl Direction {
    pub const ALL: [Self; 4] =
        [Self::new(0, false), Self::new(0, true), Self::new(1, false), Self::new(1, true)];
    const ALONG_ROW: Self = Self::new(0, true);
    const TO_NEXT_ROW: Self = Self::new(1, true);

    const fn new(axis: usize, is_up: bool) -> Self {
        Self { axis, is_up }
    }

    fn number(self) -> usize {
        2 * self.axis + usize::from(self.is_up)
    }

    /// What a turn makes this of.
    fn before(self, turn: Turn) -> Self {
        let axis = if turn.is_swapped { 1 - self.axis } else { self.axis };
        Self { axis, is_up: self.is_up != turn.is_flipped[self.axis] }
    }
}

impl<'a> Neighbors<'a> {
    pub fn new(painted: &'a Painted<'a>, is_quad: impl Fn(usize) -> bool) -> Self {
        let canvas = painted.canvas;
        let mut beyond = vec![[None; 4]; canvas.faces.len()];
        for edge in &canvas.edges {
            let &[a, b] = canvas.sides(edge) else { continue };
            let faces = [a.face as usize, b.face as usize];
            if faces[0] == faces[1] || !faces.iter().all(|&face| is_quad(face)) {
                continue;
            }
            let corners = [a, b].map(|side| [0, 1].map(|end| canvas.corner_at_end(side, end)));
            let ends = [0, 1].map(|k| corners[k].map(|corner| painted.unit(faces[k], corner)));
            if painted.is_alike(faces, ends) {
                for [one, other] in [[0, 1], [1, 0]] {
                    let (direction, turn) = beside(ends[one], ends[other]);
                    beyond[faces[one]][direction.number()] =
                        turn.map(|turn| Pose { face: faces[other] as u32, turn });
                }
            }
        }
        let seen = vec![0; beyond.len()];
        Self { painted, beyond, seen, grid_count: 0, work: 0 }
    }

    /// Of a face as it lies.
    pub fn exponents(&self, pose: Pose) -> [u8; 2] {
        self.painted.exponents(pose)
    }

    /// The face beyond a side of one as it lies.
    pub fn step(&self, pose: Pose, direction: Direction) -> Option<Pose> {
        let own = direction.before(pose.turn);
        let next = self.beyond[pose.face as usize][own.number()]?;
        Some(Pose { face: next.face, turn: next.turn.then(pose.turn) })
    }

    /// How many faces follow each other from one on along x, up to a number.
    pub fn run(&self, first: Pose, most: u32) -> u32 {
        let next =
            |pose: &Pose| self.step(*pose, Direction::ALONG_ROW).filter(|next| next.face != first.face);
        std::iter::successors(Some(first), next).take(most as usize).count() as u32
    }

    /// The grid of a width from a corner on, of as many rows as there are, up to a number; no face is in it twice.
    pub fn grid(&mut self, corner: Pose, width: u32, rows_max: u32) -> Patch {
        self.grid_count += 1;
        let mut patch = Patch { cells: [width, 0], faces: Vec::new() };
        while patch.cells[1] < rows_max {
            let length = patch.faces.len();
            if !self.add_row(corner, &mut patch) {
                patch.faces.truncate(length);
                break;
            }
            patch.cells[1] += 1;
        }
        patch
    }

    /// Whether there is one.
    fn add_row(&mut self, corner: Pose, patch: &mut Patch) -> bool {
        let [width, y] = patch.cells.map(|count| count as usize);
        for x in 0..width {
            let from = |step: usize, direction: Direction| {
                self.step(patch.faces[patch.faces.len() - step], direction)
            };
            let before = (x > 0).then(|| from(1, Direction::ALONG_ROW));
            let below = (y > 0).then(|| from(width, Direction::TO_NEXT_ROW));
            let pose = match (before, below) {
                (None, None) => Some(corner),
                (Some(pose), None) | (None, Some(pose)) => pose,
                (Some(pose), Some(same)) => pose.filter(|_| pose == same),
            };
            self.work += 1;
            let Some(pose) = pose else { return false };
            let last_seen = std::mem::replace(&mut self.seen[pose.face as usize], self.grid_count);
            if last_seen == self.grid_count {
                return false;
            }
            patch.faces.push(pose);
        }
        true
    }
}

/// Where a face lies that has an edge in common with another's unit square, and how. Both ends of the edge, as each has
/// them.
fn beside(own: [[u32; 2]; 2], other: [[u32; 2]; 2]) -> (Direction, Option<Turn>) {
    let axis = usize::from(own[0][0] != own[1][0]);
    let meets = |turn: &Turn| {
        own.iter().zip(other).all(|(own, other)| {
            let other = turn.point(other, [1, 1]);
            other[axis] == 1 - own[axis] && other[1 - axis] == own[1 - axis]
        })
    };
    (Direction::new(axis, own[0][axis] == 1), Turn::all().find(meets))
}

impl Painted<'_> {
    /// Whether two quads have equal segments along a common edge and across it, and store the same along it. `ends`: of the
    /// edge, on each one's unit square.
    fn is_alike(&self, faces: [usize; 2], ends: [[[u32; 2]; 2]; 2]) -> bool {
        let exponents = [0, 1].map(|k| {
            let along_x = ends[k][0][1] == ends[k][1][1];
            let [r, s] = self.layout.block(faces[k]).exponents;
            if along_x { [r, s] } else { [s, r] }
        });
        exponents[0] == exponents[1]
            && self.images.iter().all(|levels| {
                levels.iter().enumerate().all(|(level, image)| {
                    let side = |k: usize| {
                        let [from, to] = ends[k];
                        FaceTexels::of_face(self.layout, faces[k], level).side(from, to)
                    };
                    are_equal(image, side(0).zip(side(1)))
                })
            })
    }

    /// A face's corner on the unit square of its texels.
    pub fn unit(&self, face: usize, corner: usize) -> [u32; 2] {
        let placement = &self.layout.placements[face];
        let unit = placement.corners[corner].map(u32::from);
        // The second of two lone triangles lies upside down.
        if placement.shift > 0 { unit.map(|at| 1 - at) } else { unit }
    }
}

impl Pose {
    pub fn upright(face: u32) -> Self {
        Self { face, turn: Turn::NONE }
    }
}

impl Patch {
    pub fn alone(face: u32) -> Self {
        Self { cells: [1, 1], faces: vec![Pose::upright(face)] }
    }

    pub fn cells_in_order(&self) -> impl Iterator<Item = [u32; 2]> {
        let [width, height] = self.cells;
        (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]))
    }

    /// What is in it from one cell up to before another, in both axes.
    pub fn part(&self, from: [u32; 2], end: [u32; 2]) -> Self {
        let width = self.cells[0];
        let row = |y: u32| &self.faces[(y * width + from[0]) as usize..(y * width + end[0]) as usize];
        Self {
            cells: [0, 1].map(|k| end[k] - from[k]),
            faces: (from[1]..end[1]).flat_map(row).copied().collect(),
        }
    }

    /// The same grid turned.
    pub fn turned(&self, turn: Turn) -> Self {
        let cells = turn.pair(self.cells);
        let mut faces = self.faces.clone();
        for (cell, pose) in self.cells_in_order().zip(&self.faces) {
            let [x, y] = turn.point(cell, self.cells.map(|count| count - 1));
            faces[(y * cells[0] + x) as usize] = Pose { turn: pose.turn.then(turn), ..*pose };
        }
        Self { cells, faces }
    }
}
