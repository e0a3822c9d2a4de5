//! A lone triangle with two exponents, on the slanted half of a grid (MCT 3.6, Figure 12b).
//!
//! `n = 2^r` segments lie along its long leg (x), `m = 2^s` along its short one (y), `q = n / m`. Its diagonal is the other long edge,
//! from `(n, 0)` to `(0, m)`, and has `n` segments too: its sample `D_i` stands over column `i`, at `y = m - i/q`. So the
//! diagonal crosses `q` columns, a *strip*, between two rows `k` and `k + 1` of texels. Say `T_b` is the texel of row `k` in column `b` of
//! a strip (`b = 0 .. q`), `d_b` how much more the texel over it holds, and `f_b = 1 - b/q` the height of the diagonal there. A viewer reads
//! `D_b` at that column where
//!
//!     T_b + f_b d_b = D_b                                                             (1)
//!
//! Between two columns both the height and `d` are linear, so what it reads is quadratic, and differs from the line from
//! `D_b` to `D_(b+1)`, which is what the neighbor shows, by
//!
//!     t (1 - t) (d_(b+1) - d_b) / q                                                   (2)
//!
//! That is nothing along the whole strip exactly where all its `d_b` are one `d`. `D_0` is a texel, so `d = D_0 - T_0`, and
//! with (1) a strip has the rows
//!
//!     T_b = D_b - f_b (D_0 - T_0)     for b = 1 .. q - 1                              (3)
//!
//! of four samples each, all of which are shown already; there are `n - m` rows in all. Texels outside of the triangle are free:
//! `D_b + (1 - f_b) d`. With `q = 1` there are no rows, and that is MCT equation 1.

use glam::DVec3;
use meshcolor::colors::Shape;
use meshcolor::layout::{Coordinates, block_texels};

/// The grid of a triangle: `n` segments along x, `m` along y, `m` a divisor of `n`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    pub n: usize,
    pub m: usize,
}

impl Grid {
    /// Of exponents `r >= s`.
    pub fn new([r, s]: [u8; 2]) -> Self {
        Self { n: 1 << r, m: 1 << s }
    }

    /// Columns of a strip.
    pub fn q(self) -> usize {
        self.n / self.m
    }

    fn index(self, i: usize, j: usize) -> usize {
        j * (self.n + 1) + i
    }

    /// By how many texels the second triangle of a block, turned by 180°, is moved along x and y, so that the border texels
    /// of both have room: along the grid or across it.
    pub fn shifts(self) -> [[usize; 2]; 2] {
        [[2 * self.q() + 1, 0], [0, 3]]
    }

    /// Texels that a triangle takes at level 0 with indexed coordinates: half of a block of two, or a block of its own,
    /// whatever is less.
    pub fn texels(self) -> f64 {
        if self.n == self.m {
            return block_texels(Coordinates::Indexed, Shape::triangle(self.n as u32));
        }
        let block = |[more_x, more_y]: [usize; 2]| ((self.n + more_x + 1) * (self.m + more_y + 1)) as f64;
        let of_two = self.shifts().map(|shift| 0.5 * block(shift));
        of_two.into_iter().fold(block([0, 0]), f64::min)
    }
}

/// What a triangle shows: its texels, and the samples of its diagonal, which is what its neighbor shows there.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangle {
    pub grid: Grid,
    /// Rows of `n + 1`. Outside of the triangle only those of the border mean something.
    texels: Vec<DVec3>,
    /// From `(0, m)` to `(n, 0)`.
    pub diagonal: Vec<DVec3>,
}

impl Triangle {
    /// With the samples of `value`, a function of the place in the triangle: shares of the long and of the short leg.
    pub fn new(grid: Grid, mut value: impl FnMut([f64; 2]) -> DVec3) -> Self {
        let Grid { n, m } = grid;
        let mut texels = vec![DVec3::ZERO; (n + 1) * (m + 1)];
        let share = |i: usize| i as f64 / n as f64;
        let diagonal: Vec<DVec3> = (0..=n).map(|i| value([share(i), 1.0 - share(i)])).collect();
        for j in 0..=m {
            let last = n - grid.q() * j;
            for i in 0..last {
                texels[grid.index(i, j)] = value([share(i), j as f64 / m as f64]);
            }
            texels[grid.index(last, j)] = diagonal[last];
        }
        Self { grid, texels, diagonal }
    }

    /// First column, and lower row, of each strip.
    fn strips(grid: Grid) -> impl Iterator<Item = (usize, usize)> {
        (0..grid.m).map(move |strip| (strip * grid.q(), grid.m - 1 - strip))
    }

    /// The paper's rule: every pair of texels about the diagonal meets (1), with the inner texel the face's own sample. The texel over
    /// a strip's last column, which (1) says nothing of, goes on with the gradient before it (MCT equation 1). With a range, a
    /// pair that would leave it changes the diagonal's sample instead, as the paper has it; texels of equation 1 may leave it, as
    /// they may with one exponent.
    pub fn paper(mut self, range: Option<[f64; 2]>) -> Self {
        let grid = self.grid;
        let q = grid.q();
        for (first, row) in Self::strips(grid) {
            let mut gradient = self.diagonal[first] - self.texels[grid.index(first, row)];
            for b in 1..q {
                let height = 1.0 - b as f64 / q as f64;
                let inner = self.texels[grid.index(first + b, row)];
                let sample = &mut self.diagonal[first + b];
                let mut outer = inner + (*sample - inner) / height;
                if let Some([least, most]) = range {
                    outer = outer.clamp(DVec3::splat(least), DVec3::splat(most));
                    *sample = inner.lerp(outer, height);
                }
                self.texels[grid.index(first + b, row + 1)] = outer;
                gradient = outer - inner;
            }
            self.texels[grid.index(first + q, row + 1)] = self.diagonal[first + q] + gradient;
        }
        self
    }

    /// With the least change of the face's samples, all counting the same, that meets the rows (3). No two strips
    /// have a sample in common. In one, with `e_b = D_b - T_b`, the rows are `e_b = f_b d`: the nearest is `d = Σ f e / Σ f²`, and what
    /// lacks is taken half from `D_b` and half from `T_b`.
    pub fn exact(mut self) -> Self {
        let grid = self.grid;
        let q = grid.q();
        let height = |b: usize| 1.0 - b as f64 / q as f64;
        let mut gradients = Vec::with_capacity(grid.m);
        for (first, row) in Self::strips(grid) {
            let lack = |b: usize| self.diagonal[first + b] - self.texels[grid.index(first + b, row)];
            let sum: DVec3 = (0..q).map(|b| lack(b) * height(b)).sum();
            let gradient = sum / (0..q).map(|b| height(b).powi(2)).sum::<f64>();
            for b in 0..q {
                let inner = &mut self.texels[grid.index(first + b, row)];
                let change = (gradient * height(b) - (self.diagonal[first + b] - *inner)) * 0.5;
                *inner -= change;
                self.diagonal[first + b] += change;
            }
            gradients.push(gradient);
        }
        // All that is outside, now that every sample is what it will be.
        for ((first, row), gradient) in Self::strips(grid).zip(gradients) {
            for b in 0..=q {
                let outer = self.diagonal[first + b] + gradient * (1.0 - height(b));
                self.texels[grid.index(first + b, row + 1)] = outer;
            }
        }
        self
    }

    /// What a viewer reads, in texels from the first corner.
    pub fn shown(&self, [x, y]: [f64; 2]) -> DVec3 {
        let Grid { n, m } = self.grid;
        let [i, j] = [(x as usize).min(n - 1), (y as usize).min(m - 1)];
        let row = |j: usize| {
            let [left, right] = [i, i + 1].map(|i| self.texels[self.grid.index(i, j)]);
            left.lerp(right, x - i as f64)
        };
        row(j).lerp(row(j + 1), y - j as f64)
    }

    /// At `i + t` columns along the diagonal: what this triangle shows, and what its neighbor does.
    pub fn both_sides(&self, i: usize, t: f64) -> [DVec3; 2] {
        let Grid { n, m } = self.grid;
        let x = i as f64 + t;
        let y = (n as f64 - x) / n as f64 * m as f64;
        [self.shown([x, y]), self.diagonal[i].lerp(self.diagonal[i + 1], t)]
    }

    /// All samples, each once: those inside and on the legs, then the diagonal's.
    pub fn samples(&self) -> impl Iterator<Item = DVec3> {
        let inner = (0..=self.grid.m).flat_map(move |j| {
            let last = self.grid.n - self.grid.q() * j;
            (0..last).map(move |i| self.texels[self.grid.index(i, j)])
        });
        inner.chain(self.diagonal.iter().copied())
    }
}

#[cfg(test)]
mod tests;
