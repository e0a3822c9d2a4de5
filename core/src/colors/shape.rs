//! A face's grid of samples: which point is where.

use glam::Vec4;

/// The grid of a face at a level: rows of constant `j` from 0, `i` from 0. The border is numbered edge by edge, each
/// from its first corner (included) to its second (left to the next edge).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shape {
    pub is_triangle: bool,
    /// Along `i` and along `j`; a triangle's are equal.
    pub segments: [u32; 2],
}

impl Shape {
    pub fn triangle(segments: u32) -> Self {
        Self { is_triangle: true, segments: [segments; 2] }
    }

    pub fn quad(segments: [u32; 2]) -> Self {
        Self { is_triangle: false, segments }
    }

    pub fn edge_count(self) -> usize {
        if self.is_triangle { 3 } else { 4 }
    }

    /// Segments along an edge.
    pub fn edge_segments(self, edge: usize) -> u32 {
        self.segments[edge % 2]
    }

    /// Segments across an edge: how many rows of cells lie between it and what is opposite.
    pub fn depth(self, edge: usize) -> u32 {
        self.segments[(edge + 1) % 2]
    }

    /// Whether it has no samples but at its corners.
    pub fn is_vertex_colors(self) -> bool {
        self.segments == [1, 1]
    }

    /// Squares of cells, a triangle's cell being half of one: what a face's area is shared by.
    pub fn square_count(self) -> f32 {
        let squares = self.segments[0] as f32 * self.segments[1] as f32;
        if self.is_triangle { 0.5 * squares } else { squares }
    }

    /// Cells of a row; a triangle's last one is half a cell.
    pub fn cell_count(self, j: u32) -> u32 {
        if self.is_triangle { self.segments[0] - j } else { self.segments[0] }
    }

    /// Points of a row.
    pub fn point_count(self, j: u32) -> u32 {
        self.cell_count(j) + 1
    }

    /// Points of the rows inside: `i` from 1 to before [`Self::cell_count`].
    pub fn inner_rows(self) -> std::ops::Range<u32> {
        1..self.segments[1]
    }

    /// Samples inside a face (MC equation 3).
    pub fn interior_count(self) -> u32 {
        let [n, m] = self.segments.map(|segments| segments - 1);
        if self.is_triangle { n * n.saturating_sub(1) / 2 } else { n * m }
    }

    /// The number of an inner point among those inside: rows of constant `j`, from 1, `i` from 1.
    pub fn interior_index(self, i: u32, j: u32) -> u32 {
        let inner = self.segments[0] - 1;
        let before = if self.is_triangle { (j - 1) * inner - (j - 1) * j / 2 } else { (j - 1) * inner };
        before + i - 1
    }

    pub fn border_count(self) -> usize {
        (0..self.edge_count()).map(|edge| self.edge_segments(edge) as usize).sum()
    }

    /// The number of an edge's first corner among the points of the border.
    pub fn edge_first(self, edge: usize) -> usize {
        (0..edge).map(|edge| self.edge_segments(edge) as usize).sum()
    }

    /// The edge that a point lies on, and its distance from the edge's first corner.
    pub fn on_edge(self, i: u32, j: u32) -> Option<(usize, u32)> {
        let [n, m] = self.segments;
        if j == 0 {
            Some((0, i))
        } else if self.is_triangle {
            if i + j == n {
                Some((1, j))
            } else if i == 0 {
                Some((2, n - j))
            } else {
                None
            }
        } else if i == n {
            Some((1, j))
        } else if j == m {
            Some((2, n - i))
        } else if i == 0 {
            Some((3, m - j))
        } else {
            None
        }
    }

    /// The point at distance `along` from the first corner of an edge.
    pub fn edge_point(self, edge: usize, along: u32) -> (u32, u32) {
        let [n, m] = self.segments;
        match (self.is_triangle, edge) {
            (_, 0) => (along, 0),
            (true, 1) => (n - along, along),
            (true, _) => (0, n - along),
            (false, 1) => (n, along),
            (false, 2) => (n - along, m),
            (false, _) => (0, m - along),
        }
    }

    /// `(s, t)` on the face's unit domain.
    pub fn unit(self, i: u32, j: u32) -> [f32; 2] {
        [i as f32 / self.segments[0] as f32, j as f32 / self.segments[1] as f32]
    }

    /// The two ends of a row in the border; they are one on a triangle's last row.
    fn ends(self, j: u32) -> [usize; 2] {
        let [n, m] = self.segments.map(|segments| segments as usize);
        let j = j as usize;
        if self.is_triangle {
            let left = if j == 0 {
                0
            } else if j == n {
                2 * n
            } else {
                3 * n - j
            };
            [left, n + j]
        } else {
            let left = if j == 0 { 0 } else { 2 * n + 2 * m - j };
            [left, n + j]
        }
    }

    fn is_inside(self, j: u32) -> bool {
        j > 0 && j < self.segments[1]
    }

    /// Puts a whole row where it belongs: its ends, or all of it, to the border, the rest inside.
    pub fn put_row(
        self,
        j: u32,
        row: &[Vec4],
        interior: &mut std::slice::IterMut<'_, Vec4>,
        border: &mut [Vec4],
    ) {
        let last = row.len() - 1;
        if self.is_inside(j) {
            for (value, slot) in row[1..last.max(1)].iter().zip(interior) {
                *slot = *value;
            }
        } else if j == 0 {
            border[..last].copy_from_slice(&row[..last]);
        } else if !self.is_triangle {
            let end = self.edge_first(3);
            row.iter().enumerate().for_each(|(i, value)| border[end - i] = *value);
        }
        let [first, second] = self.ends(j);
        border[first] = row[0];
        border[second] = row[last];
    }

    /// The inverse of [`put_row`](Self::put_row).
    pub fn take_row(
        self,
        j: u32,
        row: &mut [Vec4],
        interior: &mut std::slice::Iter<'_, Vec4>,
        border: &[Vec4],
    ) {
        let last = row.len() - 1;
        if self.is_inside(j) {
            for (slot, value) in row[1..last.max(1)].iter_mut().zip(interior) {
                *slot = *value;
            }
        } else if j == 0 {
            row[..last].copy_from_slice(&border[..last]);
        } else if !self.is_triangle {
            let end = self.edge_first(3);
            row.iter_mut().enumerate().for_each(|(i, slot)| *slot = border[end - i]);
        }
        let [first, second] = self.ends(j);
        row[0] = border[first];
        row[last] = border[second];
    }

    /// Whether a point of the border is a corner.
    pub fn is_corner(self, border: usize) -> bool {
        (0..self.edge_count()).any(|edge| self.edge_first(edge) == border)
    }

    /// What the hats of a border point cover of the face, in cells.
    pub fn hat_area(self, border: usize) -> f32 {
        match (self.is_triangle, self.is_corner(border)) {
            (true, true) => 1.0 / 6.0,
            (false, true) => 0.25,
            _ => 0.5,
        }
    }
}
