//! A face's grid of samples, row by row: which point is where.

use glam::Vec4;

use crate::colors::LevelNumbering;

/// Rows of cells that are in work at once, and columns of one window of texels.
pub const BAND: u32 = 32;

/// The grid of one face: rows of constant `j` from 0, `i` from 0. The border is numbered edge by edge, each
/// from its first corner (included) to its second (left to the next edge).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    pub is_triangle: bool,
    pub segments: u32,
}

impl Shape {
    pub fn of(numbering: &LevelNumbering<'_>, face: usize) -> Self {
        let is_triangle = numbering.canvas.faces[face].is_triangle();
        Self { is_triangle, segments: numbering.segments(face) }
    }

    pub fn edge_count(self) -> usize {
        if self.is_triangle { 3 } else { 4 }
    }

    pub fn border_count(self) -> usize {
        self.edge_count() * self.segments as usize
    }

    /// Cells of a row; a triangle's last one is half a cell.
    pub fn cell_count(self, j: u32) -> u32 {
        if self.is_triangle { self.segments - j } else { self.segments }
    }

    /// Points of a row.
    pub fn point_count(self, j: u32) -> u32 {
        self.cell_count(j) + 1
    }

    /// The two ends of a row in the border; they are one on a triangle's last row.
    fn ends(self, j: u32) -> [usize; 2] {
        let n = self.segments as usize;
        let j = j as usize;
        let left = if j == 0 { 0 } else { (self.edge_count() - 1) * n + (n - j) };
        let left = if self.is_triangle && j == n { 2 * n } else { left };
        [left, n + j]
    }

    fn is_inside(self, j: u32) -> bool {
        j > 0 && j < self.segments
    }

    /// Puts a whole row where it belongs: its ends, or all of it, to the border, the rest inside.
    pub fn put_row(
        self,
        j: u32,
        row: &[Vec4],
        interior: &mut std::slice::IterMut<'_, Vec4>,
        border: &mut [Vec4],
    ) {
        let n = self.segments as usize;
        let last = row.len() - 1;
        if self.is_inside(j) {
            for (value, slot) in row[1..last.max(1)].iter().zip(interior) {
                *slot = *value;
            }
        } else if j == 0 {
            border[..last].copy_from_slice(&row[..last]);
        } else if !self.is_triangle {
            row.iter().enumerate().for_each(|(i, value)| border[3 * n - i] = *value);
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
        let n = self.segments as usize;
        let last = row.len() - 1;
        if self.is_inside(j) {
            for (slot, value) in row[1..last.max(1)].iter_mut().zip(interior) {
                *slot = *value;
            }
        } else if j == 0 {
            row[..last].copy_from_slice(&border[..last]);
        } else if !self.is_triangle {
            for (i, slot) in row.iter_mut().enumerate() {
                *slot = border[3 * n - i];
            }
        }
        let [first, second] = self.ends(j);
        row[0] = border[first];
        row[last] = border[second];
    }

    /// What the hats of a border point cover of the face, in cells.
    pub fn hat_area(self, border: usize) -> f32 {
        match (self.is_triangle, border.is_multiple_of(self.segments as usize)) {
            (true, true) => 1.0 / 6.0,
            (false, true) => 0.25,
            _ => 0.5,
        }
    }
}
