//! What coarser exponents would cost each face in error, and save in texels.
//!
//! The source is read once on the finest grid that a face may have. There every coarser grid is judged at some of the
//! points: its samples are every so many-th of the finest's, and between them it is bilinear (on a triangle linear). The finest itself is
//! judged in the middles of its cells. Errors are in 8-bit codes. What an edge takes from its finer face is
//! not in here (see `meet`).

use std::sync::LazyLock;

use glam::Vec4;
use rayon::prelude::*;

use crate::colors::{Resolutions, Shape};
use crate::error::Result;
use crate::image::Transfer;
use crate::math::transfer::linear_to_srgb;
use crate::mesh::CanvasMesh;
use crate::source::{FaceReader, SurfaceSource};
use crate::watch::{self, Watch};

/// The finest grid that is read has sides of `2^10` segments. A face that has finer ones keeps them or gets one coarser than that.
const EXPONENT_READ_MAX: u8 = 10;
/// Points at which a face is judged, at most about.
const POINTS: f32 = 400.0;
/// A face's two exponents may differ from those of its finest grid by so many levels more along one axis than along the other.
const LEAN: i32 = 2;

/// An error over one face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaceError {
    /// Mean over points and components, codes squared.
    pub mean_square: f32,
    /// The largest of any point and component, codes.
    pub peak: f32,
}

impl FaceError {
    /// With what the grid that it was judged on does not show: at worst both go the same way.
    fn beside(self, of_grid: Self) -> Self {
        let root = self.mean_square.sqrt() + of_grid.mean_square.sqrt();
        Self { mean_square: root * root, peak: self.peak + of_grid.peak }
    }
}

/// What every face might have, and what it would show.
pub struct Rates {
    /// By face: where its candidates begin; and the end.
    first: Vec<u32>,
    /// The finest first.
    candidates: Vec<[u8; 2]>,
    /// By channel, candidate by candidate.
    errors: Vec<Vec<FaceError>>,
}

impl Rates {
    /// Judges all that is coarser than `finest`. Quads may get exponents of their own along each axis where
    /// `is_elongated`.
    ///
    /// # Errors
    /// `Canceled`.
    pub fn new(
        canvas: &CanvasMesh,
        sources: &[SurfaceSource<'_>],
        finest: &Resolutions,
        is_elongated: bool,
        watch: &dyn Watch,
    ) -> Result<Self> {
        let mut rates = Self { first: vec![0], candidates: Vec::new(), errors: Vec::new() };
        for (face, &exponents) in canvas.faces.iter().zip(&finest.faces) {
            candidates(exponents, is_elongated && !face.is_triangle(), &mut rates.candidates);
            rates.first.push(rates.candidates.len() as u32);
        }
        for source in sources {
            let judge = |judge: &mut Judge, face: usize| -> Result<Vec<FaceError>> {
                watch::check(watch)?;
                Ok(judge.face(source, face, canvas.faces[face].is_triangle(), rates.of(face)))
            };
            let faces = (0..canvas.faces.len()).into_par_iter().with_min_len(64);
            let errors: Vec<_> = faces.map_init(Judge::default, judge).collect::<Result<_>>()?;
            rates.errors.push(errors.concat());
        }
        Ok(rates)
    }

    pub fn face_count(&self) -> usize {
        self.first.len() - 1
    }

    /// The candidates of a face, the finest first.
    pub fn of(&self, face: usize) -> &[[u8; 2]] {
        &self.candidates[self.range(face)]
    }

    /// What each channel shows of a face with one of its candidates.
    pub fn errors(&self, face: usize, candidate: usize) -> impl Iterator<Item = FaceError> {
        let at = self.range(face).start + candidate;
        self.errors.iter().map(move |errors| errors[at])
    }

    pub fn channel_count(&self) -> usize {
        self.errors.len()
    }

    fn range(&self, face: usize) -> std::ops::Range<usize> {
        self.first[face] as usize..self.first[face + 1] as usize
    }
}

/// Appends what a face of these exponents might have, itself first.
fn candidates(finest: [u8; 2], is_elongated: bool, all: &mut Vec<[u8; 2]>) {
    let [r, s] = finest;
    all.push(finest);
    if !is_elongated {
        let read = r.min(EXPONENT_READ_MAX + 1);
        all.extend((0..read).rev().map(|exponent| [exponent; 2]));
        return;
    }
    for (r_less, s_less) in (0..=r).flat_map(|r_less| (0..=s).map(move |s_less| (r_less, s_less))) {
        let coarser = [r - r_less, s - s_less];
        let lean = i32::from(r_less) - i32::from(s_less);
        // Where one axis has come to its end the other may go on.
        let is_open = lean.abs() <= LEAN || coarser.contains(&0);
        if r_less + s_less > 0 && is_open && coarser.iter().all(|&exponent| exponent <= EXPONENT_READ_MAX) {
            all.push(coarser);
        }
    }
}

/// A point of the finest grid: its place, and the source there in codes.
struct Point {
    at: [u32; 2],
    codes: Vec4,
    /// What its color counts for.
    weight: f32,
}

/// Room to judge faces in, one after the other.
#[derive(Default)]
struct Judge {
    reader: FaceReader,
    grid: Vec<Vec4>,
    middles: Vec<Vec4>,
    points: Vec<Point>,
}

/// Components of a channel that count.
#[derive(Clone, Copy)]
struct Meaning {
    transfer: Transfer,
    is_normal: bool,
    by_alpha: bool,
    component_count: f32,
}

impl Judge {
    /// The error with each candidate, the first of which is the finest.
    fn face(
        &mut self,
        source: &SurfaceSource<'_>,
        face: usize,
        is_triangle: bool,
        candidates: &[[u8; 2]],
    ) -> Vec<FaceError> {
        if candidates.len() == 1 {
            return vec![FaceError::default()];
        }
        let channel = source.channel;
        let meaning = Meaning {
            transfer: channel.transfer,
            is_normal: channel.is_normal(),
            by_alpha: channel.is_alpha_weighted(),
            component_count: 3.0 + f32::from(u8::from(channel.is_alpha_weighted())),
        };
        let read = candidates[0].map(|exponent| exponent.min(EXPONENT_READ_MAX));
        let shape = Shape { is_triangle, segments: read.map(|exponent| 1 << exponent) };
        self.read(source, face, shape);
        let finest = self.finest(shape, meaning);
        self.choose_points(shape, meaning);
        let coarser = candidates[1..].iter().map(|&candidate| {
            let step = [0, 1].map(|k| 1u32 << (read[k] - candidate[k].min(read[k])));
            self.coarser(shape, step, meaning).beside(finest)
        });
        std::iter::once(finest).chain(coarser).collect()
    }

    /// The source on the grid, and in the middles of its cells.
    fn read(&mut self, source: &SurfaceSource<'_>, face: usize, shape: Shape) {
        let [n, m] = shape.segments;
        let side = n as usize + 1;
        self.reader.open(source, face, shape);
        self.reader.open_window(source, [0, 0], [n, m], 2 * side * (m as usize + 1));
        self.grid.resize(side * (m as usize + 1), Vec4::ZERO);
        for (j, row) in (0..=m).zip(self.grid.chunks_exact_mut(side)) {
            self.reader.row(source, 0.0, j as f32, 1.0, &mut row[..shape.point_count(j) as usize]);
        }
        // Of a triangle's cells the middles of those that are whole: the others are cut by its diagonal.
        self.middles.resize(n as usize * m as usize, Vec4::ZERO);
        for (j, row) in (0..m).zip(self.middles.chunks_exact_mut(n as usize)) {
            let count = shape.cell_count(j) - u32::from(shape.is_triangle);
            self.reader.row(source, 0.5, j as f32 + 0.5, 1.0, &mut row[..count as usize]);
        }
    }

    fn finest(&self, shape: Shape, meaning: Meaning) -> FaceError {
        let [n, m] = shape.segments;
        let mut sum = Sum::default();
        let [stride_i, stride_j] = strides(shape);
        for j in (0..m).step_by(stride_j) {
            let count = shape.cell_count(j) - u32::from(shape.is_triangle);
            for i in (0..count).step_by(stride_i) {
                let at = |di: u32, dj: u32| self.grid[((j + dj) * (n + 1) + i + di) as usize];
                // A whole cell of a triangle is drawn over the diagonal from (1, 0) to (0, 1).
                let shown = match shape.is_triangle {
                    true => (at(1, 0) + at(0, 1)) * 0.5,
                    false => (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) * 0.25,
                };
                let wanted = self.middles[(j * n + i) as usize];
                sum.add(meaning.codes(shown) - meaning.codes(wanted), meaning.weight(wanted));
            }
        }
        sum.error(meaning)
    }

    fn choose_points(&mut self, shape: Shape, meaning: Meaning) {
        let [n, m] = shape.segments;
        let [stride_i, stride_j] = strides(shape);
        self.points.clear();
        for j in (0..=m).step_by(stride_j) {
            // Shifted from row to row, so that no column goes without.
            for i in (j as usize / stride_j % stride_i..shape.point_count(j) as usize).step_by(stride_i) {
                let value = self.grid[j as usize * (n as usize + 1) + i];
                let (codes, weight) = (meaning.codes(value), meaning.weight(value));
                self.points.push(Point { at: [i as u32, j], codes, weight });
            }
        }
    }

    /// With every `step`-th sample along each axis.
    fn coarser(&self, shape: Shape, step: [u32; 2], meaning: Meaning) -> FaceError {
        let [n, m] = shape.segments;
        let mut sum = Sum::default();
        for point in &self.points {
            let [i, j] = [0, 1].map(|k| point.at[k] / step[k]);
            // A point on the last row or column belongs to the cell before it.
            let [i, j] = [i.min(n / step[0] - 1), j.min(m / step[1] - 1)];
            let [x, y] = [
                (point.at[0] - i * step[0]) as f32 / step[0] as f32,
                (point.at[1] - j * step[1]) as f32 / step[1] as f32,
            ];
            let at =
                |di: u32, dj: u32| self.grid[((j + dj) * step[1] * (n + 1) + (i + di) * step[0]) as usize];
            let shown = if !shape.is_triangle {
                at(0, 0).lerp(at(1, 0), x).lerp(at(0, 1).lerp(at(1, 1), x), y)
            } else if x + y <= 1.0 {
                at(0, 0) + (at(1, 0) - at(0, 0)) * x + (at(0, 1) - at(0, 0)) * y
            } else {
                at(1, 1) + (at(0, 1) - at(1, 1)) * (1.0 - x) + (at(1, 0) - at(1, 1)) * (1.0 - y)
            };
            sum.add(meaning.codes(shown) - point.codes, point.weight);
        }
        sum.error(meaning)
    }
}

/// From point to point along each axis: odd, so that it meets the points of every coarser grid and those between. A short
/// axis is looked at all along.
fn strides(shape: Shape) -> [usize; 2] {
    let [n, m] = shape.segments.map(|segments| segments as f32);
    let even = (shape.square_count() / POINTS).sqrt().max(1.0);
    let along_short = even.min((n.min(m) / 4.0).max(1.0));
    let along_long = even * even / along_short;
    let odd = |stride: f32| stride.ceil() as usize | 1;
    if n < m { [odd(along_short), odd(along_long)] } else { [odd(along_long), odd(along_short)] }
}

impl Meaning {
    /// A value in codes; alpha 0 where it does not count.
    fn codes(self, value: Vec4) -> Vec4 {
        if self.is_normal {
            return (value * 127.5).with_w(0.0);
        }
        let color = match self.transfer {
            Transfer::Srgb => srgb_codes(value),
            Transfer::Linear => value * 255.0,
        };
        color.with_w(if self.by_alpha { value.w * 255.0 } else { 0.0 })
    }

    /// What the color of a point counts for.
    fn weight(self, value: Vec4) -> f32 {
        if self.by_alpha { value.w } else { 1.0 }
    }
}

/// Entries of [`SRGB_CODES`].
const CODE_STEPS: usize = 2048;
/// 8-bit sRGB codes, with fractions, by the square root of the linear value, which they are nearly in proportion to.
static SRGB_CODES: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let code = |step: usize| 255.0 * linear_to_srgb((step as f32 / CODE_STEPS as f32).powi(2));
    (0..=CODE_STEPS).map(code).collect()
});

/// Within a tenth of a code.
fn srgb_codes(value: Vec4) -> Vec4 {
    let table = &SRGB_CODES;
    let steps = value.clamp(Vec4::ZERO, Vec4::ONE).map(f32::sqrt) * CODE_STEPS as f32 + 0.5;
    Vec4::new(table[steps.x as usize], table[steps.y as usize], table[steps.z as usize], 0.0)
}

#[derive(Default)]
struct Sum {
    squares: Vec4,
    peak: Vec4,
    count: u32,
}

impl Sum {
    fn add(&mut self, difference: Vec4, weight: f32) {
        let codes = difference * Vec4::splat(weight).with_w(1.0);
        self.squares += codes * codes;
        self.peak = self.peak.max(codes.abs());
        self.count += 1;
    }

    fn error(&self, meaning: Meaning) -> FaceError {
        let squares = self.squares.x + self.squares.y + self.squares.z + self.squares.w;
        let count = self.count.max(1) as f32 * meaning.component_count;
        FaceError { mean_square: squares / count, peak: self.peak.max_element() }
    }
}
