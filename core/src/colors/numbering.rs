//! Sample numbers of one channel at one level: fans first, then strips, then face interiors.

use glam::Vec4;

use crate::mesh::{CanvasFace, CanvasMesh};

use super::{ChannelTopology, Resolutions, SamplePlace, Shape, exponent_at};

/// A face's view of one grid point: a sample, or a point between two samples of a coarser edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    pub samples: [u32; 2],
    /// Weight of the second sample; 0 where the point is a sample.
    pub second: f32,
}

impl Tap {
    fn one(sample: u32) -> Self {
        Self { samples: [sample, sample], second: 0.0 }
    }

    pub fn value(&self, values: &[Vec4]) -> Vec4 {
        let first = values[self.samples[0] as usize];
        if self.second == 0.0 {
            return first;
        }
        first.lerp(values[self.samples[1] as usize], self.second)
    }
}

pub struct LevelNumbering<'a> {
    pub canvas: &'a CanvasMesh,
    pub topology: &'a ChannelTopology,
    pub level: usize,
    /// Exponents at level 0.
    finest_exponents: Vec<[u8; 2]>,
    /// Grids at this level.
    shapes: Vec<Shape>,
    strip_exponents: Vec<u8>,
    strip_first: Vec<u32>,
    face_first: Vec<u32>,
}

impl<'a> LevelNumbering<'a> {
    pub fn new(
        canvas: &'a CanvasMesh,
        topology: &'a ChannelTopology,
        resolutions: &Resolutions,
        level: usize,
    ) -> Self {
        let shape = |(face, exponents): (&CanvasFace, &[u8; 2])| Shape {
            is_triangle: face.is_triangle(),
            segments: exponents.map(|exponent| 1 << exponent_at(exponent, level)),
        };
        let shapes: Vec<Shape> = canvas.faces.iter().zip(&resolutions.faces).map(shape).collect();
        let strip_exponents: Vec<u8> =
            topology.strips.iter().map(|strip| exponent_at(strip.exponent, level)).collect();
        let mut next = topology.fan_count() as u32;
        let mut take = |count: u32| {
            let first = next;
            next += count;
            first
        };
        let mut strip_first: Vec<u32> = strip_exponents.iter().map(|&e| take((1 << e) - 1)).collect();
        strip_first.push(take(0));
        let mut face_first: Vec<u32> = shapes.iter().map(|shape| take(shape.interior_count())).collect();
        face_first.push(take(0));
        Self {
            canvas,
            topology,
            level,
            finest_exponents: resolutions.faces.clone(),
            shapes,
            strip_exponents,
            strip_first,
            face_first,
        }
    }

    pub fn sample_count(&self) -> usize {
        self.face_first[self.face_first.len() - 1] as usize
    }

    /// Samples on vertices and edges; those inside faces follow.
    pub fn shared_count(&self) -> usize {
        self.face_first[0] as usize
    }

    /// A buffer of one value for each sample. Those that `room` held may still stand there: all are to be set.
    pub fn values_in(&self, mut room: Vec<Vec4>) -> Vec<Vec4> {
        let count = self.sample_count();
        if room.capacity() < count {
            // Another channel of the same faces may have more cuts.
            room = Vec::with_capacity(count + count / 8);
        }
        room.resize(count, Vec4::ZERO);
        room
    }

    /// What a sample lies on.
    pub fn place(&self, sample: usize) -> SamplePlace {
        let last_from = |first: &[u32]| first.partition_point(|&first| first as usize <= sample) - 1;
        if sample < self.topology.fan_count() {
            SamplePlace::Fan(sample)
        } else if sample < self.shared_count() {
            SamplePlace::Strip(last_from(&self.strip_first))
        } else {
            SamplePlace::Face(last_from(&self.face_first))
        }
    }

    /// The values of all samples as those of vertices, strips and faces.
    pub fn parts<'v>(&self, values: &'v mut [Vec4]) -> [&'v mut [Vec4]; 3] {
        let (fans, rest) = values.split_at_mut(self.topology.fan_count());
        let (strips, faces) = rest.split_at_mut(self.shared_count() - self.topology.fan_count());
        [fans, strips, faces]
    }

    /// The values of strips as those of each strip that has any, with its number.
    pub fn by_strip<'v>(&self, values: &'v mut [Vec4]) -> Vec<(usize, &'v mut [Vec4])> {
        split(values, &self.strip_first)
    }

    /// The values of faces as those of each face that has any, with its number.
    pub fn by_face<'v>(&self, values: &'v mut [Vec4]) -> Vec<(usize, &'v mut [Vec4])> {
        split(values, &self.face_first)
    }

    /// The grid of the face at this level.
    pub fn shape(&self, face: usize) -> Shape {
        self.shapes[face]
    }

    pub fn strip_segments(&self, strip: usize) -> u32 {
        1 << self.strip_exponents[strip]
    }

    /// Whether the face has come down to its ends along one axis at least.
    pub fn is_down(&self, face: usize) -> bool {
        self.shapes[face].segments.contains(&1)
    }

    /// The share of a quad, or twice that of a triangle, that a texel of this level is: the area of a square of `2^level` by
    /// `2^level` of its cells at level 0.
    pub fn texel_share(&self, face: usize) -> f64 {
        let [r, s] = self.finest_exponents[face].map(i32::from);
        f64::from(2 * self.level as i32 - r - s).exp2()
    }

    /// Samples inside the strip, low end first; its ends are fans.
    pub fn strip_range(&self, strip: usize) -> std::ops::Range<usize> {
        self.strip_first[strip] as usize..self.strip_first[strip + 1] as usize
    }

    /// Interior samples of the face: rows of constant `j`, from 1, `i` from 1.
    pub fn face_range(&self, face: usize) -> std::ops::Range<usize> {
        self.face_first[face] as usize..self.face_first[face + 1] as usize
    }

    /// The sample at `(i, j)` strictly inside the face.
    pub fn inner_sample(&self, face: usize, i: u32, j: u32) -> usize {
        (self.face_first[face] + self.shapes[face].interior_index(i, j)) as usize
    }

    /// Sample number `at` of a strip, 0 being the low fan and `strip_segments` the high one.
    pub fn strip_sample(&self, strip: usize, at: u32) -> u32 {
        let fans = self.topology.strips[strip].fans;
        if at == 0 {
            fans[0]
        } else if at == self.strip_segments(strip) {
            fans[1]
        } else {
            self.strip_first[strip] + at - 1
        }
    }

    /// The face's view of its grid point `(i, j)`.
    pub fn tap(&self, face: usize, i: u32, j: u32) -> Tap {
        match self.shapes[face].on_edge(i, j) {
            Some((edge, along)) => self.edge_tap(face, edge, along),
            None => Tap::one(self.inner_sample(face, i, j) as u32),
        }
    }

    /// The face's view of point `along` (from corner `edge`, 0 to the edge's segments) on one of its edges.
    pub fn edge_tap(&self, face: usize, edge: usize, along: u32) -> Tap {
        let n = self.shapes[face].edge_segments(edge);
        let count = self.canvas.faces[face].count();
        // Corners are read off the fan table: on an edge without length both ends differ by fan only.
        if along == 0 || along == n {
            let corner = if along == 0 { edge } else { (edge + 1) % count };
            return Tap::one(self.topology.fan_of[face][corner]);
        }
        let strip = self.topology.strip_of[face][edge] as usize;
        let from_low = if self.canvas.faces[face].is_reversed(edge) { n - along } else { along };
        let step = n / self.strip_segments(strip);
        let (at, rest) = (from_low / step, from_low % step);
        let first = self.strip_sample(strip, at);
        if rest == 0 {
            return Tap::one(first);
        }
        Tap { samples: [first, self.strip_sample(strip, at + 1)], second: rest as f32 / step as f32 }
    }

    /// Fills `grid` with the face's values at this level.
    pub fn fill(&self, face: usize, values: &[Vec4], grid: &mut FaceGrid) {
        let shape = self.shapes[face];
        grid.reset(shape);
        for edge in 0..shape.edge_count() {
            for along in 0..shape.edge_segments(edge) {
                let (i, j) = shape.edge_point(edge, along);
                *grid.at_mut(i, j) = self.edge_tap(face, edge, along).value(values);
            }
        }
        let mut interior = values[self.face_range(face)].iter();
        for j in shape.inner_rows() {
            for (i, value) in (1..shape.cell_count(j)).zip(&mut interior) {
                *grid.at_mut(i, j) = *value;
            }
        }
    }
}

/// Parts that begin at the numbers `first`, the last of which is the end; empty ones are left out.
fn split<'v>(mut rest: &'v mut [Vec4], first: &[u32]) -> Vec<(usize, &'v mut [Vec4])> {
    let mut parts = Vec::new();
    for (number, ends) in first.windows(2).enumerate().filter(|(_, ends)| ends[0] < ends[1]) {
        let (part, after) = rest.split_at_mut((ends[1] - ends[0]) as usize);
        rest = after;
        parts.push((number, part));
    }
    parts
}

/// All values of one face at one level, `(i, j)` as in the module's doc.
#[derive(Clone, Debug, Default)]
pub struct FaceGrid {
    pub shape: Shape,
    values: Vec<Vec4>,
}

impl FaceGrid {
    pub fn reset(&mut self, shape: Shape) {
        self.shape = shape;
        let [columns, rows] = shape.segments.map(|segments| segments as usize + 1);
        self.values.clear();
        self.values.resize(columns * rows, Vec4::ZERO);
    }

    pub fn at(&self, i: u32, j: u32) -> Vec4 {
        self.values[(j * (self.shape.segments[0] + 1) + i) as usize]
    }

    pub fn at_mut(&mut self, i: u32, j: u32) -> &mut Vec4 {
        &mut self.values[(j * (self.shape.segments[0] + 1) + i) as usize]
    }

    /// Interpolated alpha at `(x, y)` in segments, see [`Self::value`].
    pub fn alpha(&self, x: f32, y: f32) -> f32 {
        self.interpolated(x, y, |i, j| self.at(i, j).w)
    }

    /// Interpolated value at `(x, y)` in segments, inside the face: bilinear in a quad's cells, linear in a
    /// triangle's.
    pub fn value(&self, x: f32, y: f32) -> Vec4 {
        self.interpolated(x, y, |i, j| self.at(i, j))
    }

    fn interpolated<T>(&self, x: f32, y: f32, at: impl Fn(u32, u32) -> T) -> T
    where
        T: std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
    {
        let [i_last, j_last] = self.shape.segments.map(|segments| segments - 1);
        let (i, j) = ((x as u32).min(i_last), (y as u32).min(j_last));
        let (x, y) = (x - i as f32, y - j as f32);
        let corner = |di: u32, dj: u32| at(i + di, j + dj);
        if self.shape.is_triangle && x + y <= 1.0 {
            corner(0, 0) * (1.0 - x - y) + corner(1, 0) * x + corner(0, 1) * y
        } else if self.shape.is_triangle {
            corner(1, 1) * (x + y - 1.0) + corner(0, 1) * (1.0 - x) + corner(1, 0) * (1.0 - y)
        } else {
            let low = corner(0, 0) * (1.0 - x) + corner(1, 0) * x;
            let high = corner(0, 1) * (1.0 - x) + corner(1, 1) * x;
            low * (1.0 - y) + high * y
        }
    }
}
