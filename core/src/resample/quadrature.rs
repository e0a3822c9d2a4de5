//! The source over the hats of a face's samples.
//!
//! Every cell of the grid is cut into `k` by `k` strata, and in each a rule of degree 2 (on a triangle's two
//! halves three points each, on a quad two Gauss points along each axis) integrates source times hat: exact
//! where the source is linear over the stratum.

use glam::Vec4;

use super::BAND;
use super::gather::weighted;
use crate::colors::LevelNumbering;
use crate::error::Result;
use crate::source::{FaceReader, SurfaceSource};
use crate::watch::{self, Watch};

/// Points of a stratum: two thirds along the medians of its lower and upper half.
const TRIANGLE_POINTS: [[f32; 2]; 6] = [
    [1.0 / 6.0, 1.0 / 6.0],
    [2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0],
    [5.0 / 6.0, 5.0 / 6.0],
    [1.0 / 3.0, 5.0 / 6.0],
    [5.0 / 6.0, 1.0 / 3.0],
];
/// `(1 ± 1/√3) / 2`.
const GAUSS: [f32; 2] = [0.211_324_87, 0.788_675_1];
const QUAD_POINTS: [[f32; 2]; 4] =
    [[GAUSS[0], GAUSS[0]], [GAUSS[1], GAUSS[0]], [GAUSS[0], GAUSS[1]], [GAUSS[1], GAUSS[1]]];

/// Sums over one cell: by its halves (a quad's cell is one half), by its corners (0, 0), (1, 0), (0, 1), (1, 1).
pub type CellSums = [[Vec4; 4]; 2];

/// A point's weight in the sums of its cell.
#[derive(Clone, Copy, Debug, Default)]
struct Hats {
    half: usize,
    corners: [f32; 4],
}

/// The points of a cell and their hats, and rooms that are reused from face to face.
#[derive(Default)]
pub struct Quadrature {
    pub reader: FaceReader,
    is_triangle: bool,
    strata: u32,
    /// By row of strata, point and stratum of the row.
    hats: Vec<Hats>,
    fetched: Vec<Vec4>,
    cells: Vec<CellSums>,
    /// Rows of points, each as wide as the face's longest.
    pub rows: Vec<Vec4>,
}

/// What is integrated.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    pub source: &'a SurfaceSource<'a>,
    pub numbering: &'a LevelNumbering<'a>,
    pub face: usize,
    /// Along a side of a cell.
    pub strata: u32,
    /// Colors enter times their alpha.
    pub by_alpha: bool,
    pub watch: &'a dyn Watch,
}

impl Quadrature {
    fn set_rule(&mut self, is_triangle: bool, strata: u32) {
        if self.strata == strata && self.is_triangle == is_triangle {
            return;
        }
        (self.is_triangle, self.strata) = (is_triangle, strata);
        self.hats.clear();
        let count = strata as f32;
        for b in 0..strata {
            for (number, &[x, y]) in points(is_triangle).iter().enumerate() {
                for a in 0..strata {
                    let (x, y) = ((a as f32 + x) / count, (b as f32 + y) / count);
                    let is_upper_stratum = number >= 3;
                    let half = usize::from(is_triangle && a + b + u32::from(is_upper_stratum) >= strata);
                    let corners = match (is_triangle, half) {
                        (false, _) => [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y],
                        (true, 0) => [1.0 - x - y, x, y, 0.0],
                        (true, _) => [0.0, 1.0 - y, 1.0 - x, x + y - 1.0],
                    };
                    let share = if is_triangle { 1.0 / 6.0 } else { 0.25 } / (count * count);
                    self.hats.push(Hats { half, corners: corners.map(|hat| hat * share) });
                }
            }
        }
    }

    /// Integrates over a face, in units of a cell, and hands out its rows of points in order. `weigh` gets
    /// each cell's place and sums and may change them.
    pub fn integrate(
        &mut self,
        subject: &Subject<'_>,
        mut weigh: impl FnMut([u32; 2], &mut CellSums),
        mut put: impl FnMut(u32, &[Vec4]),
    ) -> Result<()> {
        let shape = subject.numbering.shape(subject.face);
        let [n, m] = shape.segments;
        self.set_rule(shape.is_triangle, subject.strata);
        self.reader.open(subject.source, subject.face, shape);
        let side = n as usize + 1;
        self.rows.clear();
        self.rows.resize((BAND.min(m) as usize + 1) * side, Vec4::ZERO);
        for bottom in (0..m).step_by(BAND as usize) {
            watch::check(subject.watch)?;
            let top = (bottom + BAND).min(m);
            for left in (0..shape.cell_count(bottom)).step_by(BAND as usize) {
                let right = (left + BAND).min(n);
                let fetches = points(shape.is_triangle).len() * (subject.strata as usize).pow(2);
                let cells = ((right - left) * (top - bottom)) as usize;
                self.reader.open_window(subject.source, [left, bottom], [right, top], fetches * cells);
                for j in bottom..top {
                    self.integrate_cells(subject, j, left..right.min(shape.cell_count(j)));
                    let (low, high) = self.rows[(j - bottom) as usize * side..].split_at_mut(side);
                    for (cell, i) in self.cells.iter_mut().zip(left..) {
                        weigh([i, j], cell);
                        let i = i as usize;
                        low[i] += cell[0][0] + cell[1][0];
                        low[i + 1] += cell[0][1] + cell[1][1];
                        high[i] += cell[0][2] + cell[1][2];
                        high[i + 1] += cell[0][3] + cell[1][3];
                    }
                }
            }
            for j in bottom..top + u32::from(top == m) {
                let first = (j - bottom) as usize * side;
                put(j, &self.rows[first..first + shape.point_count(j) as usize]);
            }
            let last = (top - bottom) as usize * side;
            self.rows.copy_within(last..last + side, 0);
            self.rows[side..].fill(Vec4::ZERO);
        }
        Ok(())
    }

    /// Sums up the cells of a part of a row.
    fn integrate_cells(&mut self, subject: &Subject<'_>, j: u32, cells: std::ops::Range<u32>) {
        let strata = subject.strata;
        self.cells.clear();
        self.cells.resize(cells.len(), CellSums::default());
        let scale = 1.0 / strata as f32;
        let [segments, _] = subject.numbering.shape(subject.face).segments;
        let mut hats = self.hats.chunks_exact(strata as usize);
        for b in j * strata..(j + 1) * strata {
            for (number, (&[x, y], hats)) in points(self.is_triangle).iter().zip(&mut hats).enumerate() {
                let row_end = match self.is_triangle {
                    true => segments * strata - b - u32::from(number >= 3),
                    false => segments * strata,
                };
                let end = row_end.min(cells.end * strata);
                let count = end.saturating_sub(cells.start * strata) as usize;
                self.fetched.resize(count, Vec4::ZERO);
                let (x, y) = (cells.start as f32 + x * scale, (b as f32 + y) * scale);
                self.reader.row(subject.source, x, y, scale, &mut self.fetched);
                if subject.by_alpha {
                    self.fetched.iter_mut().for_each(|value| *value = weighted(*value, true));
                }
                for (sums, fetched) in self.cells.iter_mut().zip(self.fetched.chunks(strata as usize)) {
                    for (value, hats) in fetched.iter().zip(hats) {
                        let sums = &mut sums[hats.half];
                        for (sum, hat) in sums.iter_mut().zip(hats.corners) {
                            *sum += *value * hat;
                        }
                    }
                }
            }
        }
    }
}

fn points(is_triangle: bool) -> &'static [[f32; 2]] {
    if is_triangle { &TRIANGLE_POINTS } else { &QUAD_POINTS }
}
