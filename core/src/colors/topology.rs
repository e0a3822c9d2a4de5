//! Who shares a sample: fans of corners around vertices, strips along edges.

use crate::math::partition::Partition;
use crate::mesh::{CanvasMesh, Side};

use super::{Cuts, Resolutions};

/// The shared samples of one channel. Level-independent.
///
/// A *fan* is a set of corners at one vertex that uncut edges connect: it has one vertex sample. A *strip*
/// holds the samples along an edge: one for all sides of an uncut edge, one for each side of a cut.
#[derive(Clone, Debug)]
pub struct ChannelTopology {
    /// By face and corner.
    pub fan_of: Vec<[u32; 4]>,
    /// By face and edge.
    pub strip_of: Vec<[u32; 4]>,
    pub strips: Vec<Strip>,
    strip_sides: Vec<Side>,
    fan_first: Vec<u32>,
    fan_corners: Vec<(u32, u8)>,
}

/// The samples along one edge, from its low end to its high end.
#[derive(Clone, Copy, Debug)]
pub struct Strip {
    /// The smallest exponent that its faces have along it (MCT 3.2).
    pub exponent: u8,
    /// Fans at the low and the high end.
    pub fans: [u32; 2],
    first_side: u32,
    side_count: u32,
}

impl ChannelTopology {
    pub fn new(canvas: &CanvasMesh, resolutions: &Resolutions, cuts: &Cuts) -> Self {
        let (fan_of, fan_first, fan_corners) = fans(canvas, cuts);
        let mut strip_of = vec![[0; 4]; canvas.faces.len()];
        let mut strips = Vec::new();
        let mut strip_sides = Vec::new();
        for (number, edge) in canvas.edges.iter().enumerate() {
            let sides = canvas.sides(edge);
            let group_size = if cuts.edges[number] { 1 } else { sides.len() };
            for group in sides.chunks(group_size) {
                let exponents =
                    group.iter().map(|side| resolutions.along(side.face as usize, side.edge.into()));
                let fan_at = |end| {
                    let corner = canvas.corner_at_end(group[0], end);
                    fan_of[group[0].face as usize][corner]
                };
                for side in group {
                    strip_of[side.face as usize][usize::from(side.edge)] = strips.len() as u32;
                }
                strips.push(Strip {
                    exponent: exponents.min().unwrap_or(0),
                    fans: [fan_at(0), fan_at(1)],
                    first_side: strip_sides.len() as u32,
                    side_count: group.len() as u32,
                });
                strip_sides.extend_from_slice(group);
            }
        }
        Self { fan_of, strip_of, strips, strip_sides, fan_first, fan_corners }
    }

    pub fn fan_count(&self) -> usize {
        self.fan_first.len() - 1
    }

    /// Corners of a fan as (face, corner), in face order.
    pub fn corners(&self, fan: usize) -> &[(u32, u8)] {
        &self.fan_corners[self.fan_first[fan] as usize..self.fan_first[fan + 1] as usize]
    }

    pub fn sides(&self, strip: &Strip) -> &[Side] {
        let first = strip.first_side as usize;
        &self.strip_sides[first..first + strip.side_count as usize]
    }
}

type Fans = (Vec<[u32; 4]>, Vec<u32>, Vec<(u32, u8)>);

/// Joins the corners that uncut edges connect (union by lowest number, so the outcome has one order).
fn fans(canvas: &CanvasMesh, cuts: &Cuts) -> Fans {
    let mut partition = Partition::new(canvas.faces.len() * 4);
    let corner_id = |side: Side, end: usize| side.face * 4 + canvas.corner_at_end(side, end) as u32;
    for (edge, _) in canvas.edges.iter().zip(&cuts.edges).filter(|(_, cut)| !**cut) {
        let sides = canvas.sides(edge);
        for &other in &sides[1..] {
            for end in 0..2 {
                partition.join(corner_id(sides[0], end), corner_id(other, end));
            }
        }
    }
    let mut fan_of = vec![[0; 4]; canvas.faces.len()];
    let mut number_of_root = vec![u32::MAX; canvas.faces.len() * 4];
    let mut sizes = Vec::new();
    for (number, face) in canvas.faces.iter().enumerate() {
        for (corner, fan) in fan_of[number][..face.count()].iter_mut().enumerate() {
            let root = partition.root(number as u32 * 4 + corner as u32) as usize;
            if number_of_root[root] == u32::MAX {
                number_of_root[root] = sizes.len() as u32;
                sizes.push(0);
            }
            *fan = number_of_root[root];
            sizes[number_of_root[root] as usize] += 1;
        }
    }
    let mut first = vec![0];
    for size in sizes {
        first.push(first[first.len() - 1] + size);
    }
    let mut filled = first.clone();
    let mut corners = vec![(0, 0); first[first.len() - 1] as usize];
    for (number, face) in canvas.faces.iter().enumerate() {
        for (corner, &fan) in fan_of[number][..face.count()].iter().enumerate() {
            let slot = &mut filled[fan as usize];
            corners[*slot as usize] = (number as u32, corner as u8);
            *slot += 1;
        }
    }
    (fan_of, first, corners)
}
