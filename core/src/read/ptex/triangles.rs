//! Charts of triangles. A face of resolution `n` has `n²` triangular texels: in each cell `(a, b)` of the grid with sides `1 / n`
//! an even one at its low corner, and, where `a + b <= n - 2`, an odd one beyond the cell's diagonal. The even one is stored at
//! `(a, b)`, the odd one at `(n - 1 - b, n - 1 - a)`, which fills the square.
//!
//! The function: at each vertex of the grid the mean of the texels that meet there (six inside of a face, over all faces at its
//! edges and corners), linear in between. Where sides of an edge differ in resolution, the edge has the coarsest side's vertices.
//! Ptex itself has only a Gaussian for triangles, of half a texel's side at its sharpest: its second moment is 1/2 of a texel's
//! side squared, this function's 7/12 in the mean (1/3 from the six texels, 1/4 from the interpolation).
//!
//! The chart holds the vertices as texels. A fetch beside the face's slanted edge reads one texel beyond it, which is set so that the
//! bilinear value is the linear one: `c(i, j) = c(i - 1, j) + c(i, j - 1) - c(i - 1, j - 1)`.

use glam::Vec4;
use rayon::prelude::*;

use super::faces::FaceInfo;
use super::quads::vertex_means;
use super::texels::Texels;
use super::topology::Topology;

/// What edges and vertices show.
pub struct Joints {
    /// By edge: where its values begin; and the end.
    first: Vec<usize>,
    /// At the coarsest side's vertices, from the low end to the high end, both ends included.
    vertices: Vec<Vec4>,
}

pub struct Triangles<'a> {
    pub faces: &'a [FaceInfo],
    pub texels: &'a Texels,
    pub topology: &'a Topology,
}

impl Triangles<'_> {
    fn resolution(&self, face: usize) -> usize {
        self.faces[face].size()[0]
    }

    fn coarsest(&self, edge: usize) -> usize {
        let sides = self.topology.sides(edge).iter();
        sides.map(|side| self.resolution(side.face)).fold(usize::MAX, usize::min)
    }

    /// The texel of cell `(a, b)` of a face read with `n` texels along a side, the mean of those that make it up; none
    /// where the cell has no such texel.
    fn texel(&self, face: usize, n: usize, is_odd: bool, [a, b]: [isize; 2]) -> Option<Vec4> {
        let most = n as isize - 1 - isize::from(is_odd);
        if a < 0 || b < 0 || a + b > most {
            return None;
        }
        let full = self.resolution(face);
        let block = full / n;
        let (first_a, first_b) = (a as usize * block, b as usize * block);
        let even = |a: usize, b: usize| self.texels.at(face, a, b);
        let odd = |a: usize, b: usize| self.texels.at(face, full - 1 - b, full - 1 - a);
        let mut sum = Vec4::ZERO;
        for x in 0..block {
            for y in 0..block {
                let (a, b) = (first_a + x, first_b + y);
                // The cells' texels that lie below or beyond the diagonal of the block.
                if (x + y < block) != is_odd {
                    sum += even(a, b);
                }
                if (x + y + 1 < block) != is_odd {
                    sum += odd(a, b);
                }
            }
        }
        Some(sum / (block * block) as f32)
    }

    /// The mean of a face's texels that meet at vertex `(i, j)` of its grid of `n`.
    fn mean(&self, face: usize, n: usize, [i, j]: [usize; 2]) -> Vec4 {
        let (i, j) = (i as isize, j as isize);
        let around = [
            (false, [i, j]),
            (false, [i - 1, j]),
            (false, [i, j - 1]),
            (true, [i - 1, j - 1]),
            (true, [i - 1, j]),
            (true, [i, j - 1]),
        ];
        let texels = around.into_iter().filter_map(|(is_odd, cell)| self.texel(face, n, is_odd, cell));
        let (sum, count) = texels.fold((Vec4::ZERO, 0), |(sum, count), texel| (sum + texel, count + 1));
        sum / count.max(1) as f32
    }

    pub fn joints(&self) -> Joints {
        let corner_mean = |face: usize, corner: usize| {
            // Read as coarsely as the coarsest side of its two edges there.
            let edges = [corner, (corner + 2) % 3].map(|edge| self.topology.edge(face, edge));
            let n = self.coarsest(edges[0]).min(self.coarsest(edges[1]));
            self.mean(face, n, corner_vertex(n, corner))
        };
        let corners: Vec<Vec4> = (0..self.faces.len())
            .into_par_iter()
            .with_min_len(64)
            .flat_map_iter(|face| (0..3).map(move |corner| corner_mean(face, corner)))
            .collect();
        let ends = vertex_means(self.topology, &corners);
        let edges = 0..self.topology.edge_count();
        let by_edge: Vec<Vec<Vec4>> =
            edges.into_par_iter().with_min_len(64).map(|edge| self.edge_vertices(edge, &ends)).collect();
        let mut first = Vec::with_capacity(by_edge.len() + 1);
        first.push(0);
        for vertices in &by_edge {
            first.push(first[first.len() - 1] + vertices.len());
        }
        Joints { first, vertices: by_edge.concat() }
    }

    fn edge_vertices(&self, edge: usize, ends: &[Vec4]) -> Vec<Vec4> {
        let sides = self.topology.sides(edge);
        let n = self.coarsest(edge);
        let [low, high] = self.topology.edge_ends(edge).map(|vertex| ends[vertex as usize]);
        let inner = (1..n).map(|k| {
            let of_side = sides.iter().map(|side| {
                let along = if side.is_reversed { n - k } else { k };
                self.mean(side.face, n, edge_vertex(n, side.edge, along))
            });
            of_side.sum::<Vec4>() / sides.len() as f32
        });
        std::iter::once(low).chain(inner).chain([high]).collect()
    }

    /// The function at vertex `(i, j)` of a face's own grid.
    fn vertex(&self, joints: &Joints, face: usize, [i, j]: [usize; 2]) -> Vec4 {
        let n = self.resolution(face);
        let (edge, along) = match [i, j] {
            [i, 0] => (0, i),
            [i, j] if i + j == n => (1, j),
            [0, j] => (2, n - j),
            _ => return self.mean(face, n, [i, j]),
        };
        let along = if self.topology.is_reversed(face, edge) { n - along } else { along };
        let number = self.topology.edge(face, edge);
        let vertices = &joints.vertices[joints.first[number]..joints.first[number + 1]];
        let segments = vertices.len() - 1;
        let place = along as f32 * segments as f32 / n as f32;
        let first = (place as usize).min(segments - 1);
        vertices[first].lerp(vertices[first + 1], place - first as f32)
    }

    /// The face's chart: `n + 1` rows of as many texels, from corner 0 on. Beyond the texels that are read it is a mirror image.
    pub fn chart(&self, joints: &Joints, face: usize) -> Vec<Vec4> {
        let n = self.resolution(face);
        let side = n + 1;
        let mut chart = vec![Vec4::ZERO; side * side];
        for j in 0..side {
            for i in 0..side - j {
                chart[j * side + i] = self.vertex(joints, face, [i, j]);
            }
        }
        for j in 1..side {
            let i = side - j;
            chart[j * side + i] =
                chart[j * side + i - 1] + chart[(j - 1) * side + i] - chart[(j - 1) * side + i - 1];
            for i in side - j + 1..side {
                chart[j * side + i] = chart[(n - i) * side + n - j];
            }
        }
        chart
    }
}

fn corner_vertex(n: usize, corner: usize) -> [usize; 2] {
    [[0, 0], [n, 0], [0, n]][corner]
}

/// The grid's vertex `along` an edge from its first corner.
fn edge_vertex(n: usize, edge: usize, along: usize) -> [usize; 2] {
    match edge {
        0 => [along, 0],
        1 => [n - along, along],
        _ => [0, n - along],
    }
}
