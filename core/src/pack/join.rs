//! Larger blocks: neighbors that store the same texels along their common edge stand side by side and store them once.
//!
//! Blocks of equal size join two by two, by a matching that saves as many texels as it can, and what came of it joins
//! again. So a block has a power of two of faces along each side, and there are few classes.

use std::collections::BTreeMap;

use crate::math::matching::{WeightedEdge, maximum_weight_matching};

use super::Painted;
use super::texels::{FaceTexels, are_equal};
use super::turn::Turn;

/// Segments along a block's side at level 0 beyond which it does not grow.
const SEGMENTS_MAX: u32 = 64;

/// Quads of one shape in a grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Faces along each axis.
    pub cells: [u32; 2],
    /// Of each face as it lies in the patch, not the smaller one first.
    pub exponents: [u8; 2],
    /// Row by row.
    pub faces: Vec<(u32, Turn)>,
}

/// Where a face lies.
#[derive(Clone, Copy, Debug, Default)]
struct Seat {
    patch: u32,
    cell: [u32; 2],
    turn: Turn,
}

/// A face's end of an edge along which two faces store the same: the other face, and which of its corners meet those of
/// this one's edge `k`, the corner `k` first.
#[derive(Clone, Copy, Debug)]
struct Joint {
    other: u32,
    corners: [usize; 2],
}

struct Joiner<'a> {
    painted: &'a Painted<'a>,
    patches: Vec<Patch>,
    /// By face.
    seats: Vec<Seat>,
    /// By face and edge.
    joints: Vec<[Option<Joint>; 4]>,
}

/// How a patch comes to lie beside another: turned, and then moved by so many faces.
struct Fit {
    other: u32,
    turn: Turn,
    offset: [i32; 2],
    /// Texels at level 0 that are stored once more.
    saved: i64,
}

/// The patches of all quads that `counts`.
pub fn patches(painted: &Painted<'_>, counts: impl Fn(usize) -> bool) -> Vec<Patch> {
    let layout = painted.layout;
    let mut seats = vec![Seat::default(); layout.placements.len()];
    let mut patches = Vec::new();
    let is_quad = |face: usize| !painted.canvas.faces[face].is_triangle() && counts(face);
    for face in (0..layout.placements.len()).filter(|&face| is_quad(face)) {
        seats[face].patch = patches.len() as u32;
        patches.push(Patch {
            cells: [1, 1],
            exponents: layout.block(face).exponents,
            faces: vec![(face as u32, Turn::NONE)],
        });
    }
    let joints = joints(painted, is_quad);
    let mut joiner = Joiner { painted, patches, seats, joints };
    while joiner.join() {}
    joiner.patches
}

/// Edges along which two quads of one shape store the same texels.
fn joints(painted: &Painted<'_>, is_quad: impl Fn(usize) -> bool) -> Vec<[Option<Joint>; 4]> {
    let canvas = painted.canvas;
    let mut joints = vec![[None; 4]; canvas.faces.len()];
    for edge in &canvas.edges {
        let &[a, b] = canvas.sides(edge) else { continue };
        let faces = [a.face as usize, b.face as usize];
        if faces[0] == faces[1] || !faces.iter().all(|&face| is_quad(face)) {
            continue;
        }
        let ends = [a, b].map(|side| [0, 1].map(|end| canvas.corner_at_end(side, end)));
        if !painted.is_alike(faces, ends) {
            continue;
        }
        for [one, other] in [[0, 1], [1, 0]] {
            let side = [a, b][one];
            let k = usize::from(side.edge);
            let mut corners = ends[other];
            if ends[one][0] != k {
                corners.reverse();
            }
            joints[faces[one]][k] = Some(Joint { other: faces[other] as u32, corners });
        }
    }
    joints
}

impl Painted<'_> {
    /// Whether two quads have equal segments along a common edge and across it, and store the same along it. `ends`: by
    /// face its corners at both ends.
    fn is_alike(&self, faces: [usize; 2], ends: [[usize; 2]; 2]) -> bool {
        let places = [0, 1].map(|k| ends[k].map(|corner| self.unit(faces[k], corner)));
        let exponents = [0, 1].map(|k| {
            let along_x = places[k][0][1] == places[k][1][1];
            let [r, s] = self.layout.block(faces[k]).exponents;
            if along_x { [r, s] } else { [s, r] }
        });
        exponents[0] == exponents[1]
            && self.images.iter().all(|levels| {
                levels.iter().enumerate().all(|(level, image)| {
                    let side = |k: usize| {
                        let [from, to] = places[k];
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

impl Joiner<'_> {
    /// Joins patches two by two; whether there were any.
    fn join(&mut self) -> bool {
        let mut fits: BTreeMap<[u32; 2], Fit> = BTreeMap::new();
        for (face, joints) in self.joints.iter().enumerate() {
            for (edge, joint) in
                joints.iter().enumerate().filter_map(|(edge, joint)| Some((edge, joint.as_ref()?)))
            {
                let patches = [face, joint.other as usize].map(|face| self.seats[face].patch);
                if patches[0] < patches[1] && !fits.contains_key(&patches) {
                    fits.extend(self.fit(face, edge, joint).map(|fit| (patches, fit)));
                }
            }
        }
        let edges: Vec<WeightedEdge> =
            fits.iter().map(|(&nodes, fit)| WeightedEdge { nodes, weight: fit.saved }).collect();
        let partners = maximum_weight_matching(self.patches.len(), &edges);
        if partners.iter().all(Option::is_none) {
            return false;
        }
        let old = std::mem::take(&mut self.patches);
        for ((number, patch), partner) in (0u32..).zip(&old).zip(partners) {
            let fit = partner.and_then(|partner| Some((partner, fits.get(&[number, partner])?)));
            match (fit, partner) {
                (Some((partner, fit)), _) => self.patches.push(patch.beside(&old[partner as usize], fit)),
                (None, None) => self.patches.push(patch.clone()),
                // The lower of the two has taken it.
                (None, Some(_)) => {}
            }
        }
        self.sit();
        true
    }

    /// Tells all faces where they lie now.
    fn sit(&mut self) {
        for (number, patch) in (0u32..).zip(&self.patches) {
            for (cell, &(face, turn)) in patch.cells_in_order().zip(&patch.faces) {
                self.seats[face as usize] = Seat { patch: number, cell, turn };
            }
        }
    }

    /// A face's corner in its patch.
    fn corner(&self, face: usize, corner: usize) -> [i32; 2] {
        let seat = &self.seats[face];
        let unit = seat.turn.point(self.painted.unit(face, corner), [1, 1]);
        [0, 1].map(|k| (seat.cell[k] + unit[k]) as i32)
    }

    fn patch_of(&self, face: usize) -> &Patch {
        &self.patches[self.seats[face].patch as usize]
    }

    /// How the patch beyond a joint lies beside this face's, if both together are a rectangle that is not too large.
    fn fit(&self, face: usize, edge: usize, joint: &Joint) -> Option<Fit> {
        let (one, two) = (self.patch_of(face), self.patch_of(joint.other as usize));
        let turns = Turn::all()
            .filter(|turn| turn.pair(two.exponents) == one.exponents && turn.pair(two.cells) == one.cells);
        turns.into_iter().find_map(|turn| {
            let [offset, end_offset] = [0, 1].map(|end| {
                let own = self.corner(face, (edge + end) % 4);
                let other = turned(self.corner(joint.other as usize, joint.corners[end]), turn, two.cells);
                [0, 1].map(|k| own[k] - other[k])
            });
            let axis = (0..2).find(|&axis| offset[axis].unsigned_abs() == one.cells[axis])?;
            let across = 1 - axis;
            let side = one.cells[across];
            let other = self.seats[joint.other as usize].patch;
            let fit = Fit { other, turn, offset, saved: i64::from(side << one.exponents[across]) + 1 };
            let is_small = (2 * one.cells[axis]) << one.exponents[axis] <= SEGMENTS_MAX;
            let is_rectangle = offset == end_offset && offset[across] == 0;
            (is_small && is_rectangle && (0..side).all(|place| self.meets(one, axis, place, &fit)))
                .then_some(fit)
        })
    }

    /// Whether the face of a patch that is `place` faces along the side towards `axis` meets a face of the other patch
    /// there, both ends being the same.
    fn meets(&self, patch: &Patch, axis: usize, place: u32, fit: &Fit) -> bool {
        let is_after = fit.offset[axis] > 0;
        let mut cell = [place; 2];
        cell[axis] = if is_after { patch.cells[axis] - 1 } else { 0 };
        let border = if is_after { patch.cells[axis] as i32 } else { 0 };
        let face = patch.faces[(cell[1] * patch.cells[0] + cell[0]) as usize].0 as usize;
        let is_there = |corner: usize| self.corner(face, corner)[axis] == border;
        let Some(edge) = (0..4).find(|&edge| is_there(edge) && is_there((edge + 1) % 4)) else {
            return false;
        };
        let Some(joint) = &self.joints[face][edge] else { return false };
        let other = self.patch_of(joint.other as usize);
        let is_same = |end: usize| {
            let at = turned(self.corner(joint.other as usize, joint.corners[end]), fit.turn, other.cells);
            self.corner(face, (edge + end) % 4) == [0, 1].map(|k| at[k] + fit.offset[k])
        };
        self.seats[joint.other as usize].patch == fit.other && is_same(0) && is_same(1)
    }
}

fn turned(at: [i32; 2], turn: Turn, size: [u32; 2]) -> [i32; 2] {
    turn.point(at.map(|at| at as u32), size).map(|at| at as i32)
}

impl Patch {
    fn cells_in_order(&self) -> impl Iterator<Item = [u32; 2]> {
        let [width, height] = self.cells;
        (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]))
    }

    /// The same rectangle turned.
    fn turned(&self, turn: Turn) -> Self {
        let cells = turn.pair(self.cells);
        let mut faces = vec![(0, Turn::NONE); self.faces.len()];
        for (cell, &(face, own)) in self.cells_in_order().zip(&self.faces) {
            let [x, y] = turn.point(cell, self.cells.map(|count| count - 1));
            faces[(y * cells[0] + x) as usize] = (face, own.then(turn));
        }
        Self { cells, exponents: turn.pair(self.exponents), faces }
    }

    /// This patch and another of its size as one; the longer sides along x.
    fn beside(&self, other: &Self, fit: &Fit) -> Self {
        let other = other.turned(fit.turn);
        let axis = usize::from(fit.offset[0] == 0);
        let (first, second) = if fit.offset[axis] > 0 { (self, &other) } else { (&other, self) };
        let faces = if axis == 0 {
            let width = self.cells[0] as usize;
            let rows = first.faces.chunks(width).zip(second.faces.chunks(width));
            rows.flat_map(|(one, two)| one.iter().chain(two)).copied().collect()
        } else {
            first.faces.iter().chain(&second.faces).copied().collect()
        };
        let mut cells = self.cells;
        cells[axis] *= 2;
        let both = Self { cells, exponents: self.exponents, faces };
        let is_upright = (both.exponents[0], both.cells[0]) >= (both.exponents[1], both.cells[1]);
        if is_upright { both } else { both.turned(Turn::SWAP) }
    }
}
