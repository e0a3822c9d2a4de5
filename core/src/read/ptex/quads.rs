//! Charts of quads: a face of `N x M` texels as the `(2N + 1) x (2M + 1)` values of its bilinear function at multiples of half a texel.
//!
//! That function is bilinear between texel centers, which are such multiples, and so are corners and edges. So the
//! bilinear value between the chart's texels is the function itself, everywhere.
//! What both sides of an edge filter to is settled once for the edge: at the centers of the coarser side's texels the mean
//! over the sides of what they have there, at its ends the mean over all corners that meet, linear in
//! between. The finer side's half texels contain the coarser side's, so both can hold it exactly. With
//! equal resolutions and four faces about every vertex this is what Ptex's own bilinear filter gives.

use glam::Vec4;
use rayon::prelude::*;

use super::faces::FaceInfo;
use super::texels::Texels;
use super::topology::{Side, Topology};

/// Which corners stand at the high end of u, and of v.
const HIGH: [[bool; 4]; 2] = [[false, true, true, false], [false, false, true, true]];
/// By corner: the edge along u that it lies on, and the one along v.
const EDGES_AT: [[usize; 4]; 2] = [[0, 0, 2, 2], [3, 1, 1, 3]];

/// What edges and vertices show.
pub struct Joints {
    /// By edge: where its values begin; and the end.
    first: Vec<usize>,
    /// Where the coarsest side's texels have their centers, from the edge's low end on.
    knots: Vec<Vec4>,
    vertices: Vec<Vec4>,
}

/// All faces with what joins them.
pub struct Quads<'a> {
    pub faces: &'a [FaceInfo],
    pub texels: &'a Texels,
    pub topology: &'a Topology,
}

impl Quads<'_> {
    /// Texels of a face along an edge and across it.
    fn extent(&self, face: usize, edge: usize) -> [usize; 2] {
        let [u, v] = self.faces[face].size();
        if edge.is_multiple_of(2) { [u, v] } else { [v, u] }
    }

    /// The fewest texels that any side of an edge has along it and across it.
    fn coarsest(&self, edge: usize) -> [usize; 2] {
        let extents = self.topology.sides(edge).iter().map(|side| self.extent(side.face, side.edge));
        extents.fold([usize::MAX; 2], |a, b| [a[0].min(b[0]), a[1].min(b[1])])
    }

    /// A texel of a face, counted along an edge in its direction, and into the face.
    fn texel_at(&self, face: usize, edge: usize, [along, depth]: [usize; 2]) -> Vec4 {
        let [u, v] = self.faces[face].size();
        let [u, v] = match edge {
            0 => [along, depth],
            1 => [u - 1 - depth, along],
            2 => [u - 1 - along, v - 1 - depth],
            _ => [depth, v - 1 - along],
        };
        self.texels.at(face, u, v)
    }

    /// What a side has at the `knot`-th of `counts` texels along the edge, from its low end on: the mean of its own texels there.
    fn side_mean(&self, side: Side, counts: [usize; 2], knot: usize) -> Vec4 {
        let extent = self.extent(side.face, side.edge);
        let block = [extent[0] / counts[0], extent[1] / counts[1]];
        let knot = if side.is_reversed { counts[0] - 1 - knot } else { knot };
        let mut sum = Vec4::ZERO;
        for depth in 0..block[1] {
            for along in knot * block[0]..(knot + 1) * block[0] {
                sum += self.texel_at(side.face, side.edge, [along, depth]);
            }
        }
        sum / (block[0] * block[1]) as f32
    }

    /// What a face has at a corner: the mean of as many of its texels as stand for one of the coarsest beyond its edges there.
    fn corner_mean(&self, face: usize, corner: usize) -> Vec4 {
        let size = self.faces[face].size();
        let ranges = [0, 1].map(|axis| {
            let edge = EDGES_AT[axis][corner];
            let block = size[axis] / self.coarsest(self.topology.edge(face, edge))[0];
            if HIGH[axis][corner] { size[axis] - block..size[axis] } else { 0..block }
        });
        let mut sum = Vec4::ZERO;
        let count = ranges[0].len() * ranges[1].len();
        for v in ranges[1].clone() {
            for u in ranges[0].clone() {
                sum += self.texels.at(face, u, v);
            }
        }
        sum / count as f32
    }

    pub fn joints(&self) -> Joints {
        let edges = 0..self.topology.edge_count();
        let by_edge: Vec<Vec<Vec4>> =
            edges.into_par_iter().with_min_len(64).map(|edge| self.knots(edge)).collect();
        let mut first = Vec::with_capacity(by_edge.len() + 1);
        first.push(0);
        for knots in &by_edge {
            first.push(first[first.len() - 1] + knots.len());
        }
        let corners: Vec<Vec4> = (0..self.faces.len())
            .into_par_iter()
            .with_min_len(64)
            .flat_map_iter(|face| (0..4).map(move |corner| self.corner_mean(face, corner)))
            .collect();
        Joints { first, knots: by_edge.concat(), vertices: vertex_means(self.topology, &corners) }
    }

    fn knots(&self, edge: usize) -> Vec<Vec4> {
        let sides = self.topology.sides(edge);
        let counts = self.coarsest(edge);
        let mean = |knot: usize| {
            let sum: Vec4 = sides.iter().map(|&side| self.side_mean(side, counts, knot)).sum();
            sum / sides.len() as f32
        };
        (0..counts[0]).map(mean).collect()
    }

    /// The chart's value at `p, q` half texels from corner 0 along u and v.
    fn value(&self, joints: &Joints, face: usize, [p, q]: [usize; 2]) -> Vec4 {
        let [n, m] = self.faces[face].size();
        let edge = match [p, q] {
            [p, 0] => Some((0, p)),
            [p, q] if p == 2 * n => Some((1, q)),
            [p, q] if q == 2 * m => Some((2, 2 * n - p)),
            [0, q] => Some((3, 2 * m - q)),
            _ => None,
        };
        if let Some((edge, along)) = edge {
            return self.edge_value(joints, face, edge, along);
        }
        // The texels on both sides of an even place, or the one at an odd place.
        let around = |at: usize| [at.div_ceil(2) - 1, at / 2];
        let ([low_u, high_u], [low_v, high_v]) = (around(p), around(q));
        let at = |u: usize, v: usize| self.texels.at(face, u, v);
        0.25 * ((at(low_u, low_v) + at(high_u, low_v)) + (at(low_u, high_v) + at(high_u, high_v)))
    }

    /// What an edge shows `along` of the face's half texels from the beginning of its side.
    fn edge_value(&self, joints: &Joints, face: usize, edge: usize, along: usize) -> Vec4 {
        let length = 2 * self.extent(face, edge)[0];
        let along = if self.topology.is_reversed(face, edge) { length - along } else { along };
        let number = self.topology.edge(face, edge);
        let knots = &joints.knots[joints.first[number]..joints.first[number + 1]];
        let ends = self.topology.edge_ends(number).map(|vertex| joints.vertices[vertex as usize]);
        // In half texels of the coarsest side, whose centers are at odd numbers.
        let place = along as f32 * (2 * knots.len()) as f32 / length as f32;
        let last = knots.len() - 1;
        if place <= 1.0 {
            return ends[0].lerp(knots[0], place);
        }
        if place >= (2 * last + 1) as f32 {
            return knots[last].lerp(ends[1], place - (2 * last + 1) as f32);
        }
        let knot = ((place - 1.0) * 0.5) as usize;
        knots[knot].lerp(knots[knot + 1], (place - 1.0) * 0.5 - knot as f32)
    }

    /// A row of a face's chart: its values at `q` half texels from corner 0 along v.
    pub fn row(&self, joints: &Joints, face: usize, q: usize) -> impl Iterator<Item = Vec4> {
        (0..=2 * self.faces[face].size()[0]).map(move |p| self.value(joints, face, [p, q]))
    }
}

/// By vertex the mean over the corners that meet there; `corners` by face and corner.
pub fn vertex_means(topology: &Topology, corners: &[Vec4]) -> Vec<Vec4> {
    let mut means = vec![Vec4::ZERO; topology.vertex_count];
    let mut counts = vec![0u32; topology.vertex_count];
    for (&vertex, &corner) in topology.vertices.iter().zip(corners) {
        means[vertex as usize] += corner;
        counts[vertex as usize] += 1;
    }
    means.iter().zip(counts).map(|(sum, count)| *sum / count.max(1) as f32).collect()
}
