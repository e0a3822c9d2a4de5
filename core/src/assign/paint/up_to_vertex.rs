//! Faces up to vertex colors: samples copied line by line, points of coarser edges between two samples, and
//! the border texels of lone triangles.

use glam::Vec4;

use crate::colors::Shape;
use crate::layout::Block;

use super::Painter;
use super::band::Band;
use crate::assign::codec::Line;
use crate::assign::frames::FrameLine;
use crate::assign::{Rounding, from_right_angle};

/// Room for lines of values, kept from face to face.
#[derive(Default)]
pub(super) struct Scratch {
    between: Vec<Vec4>,
    stored: Vec<Vec4>,
}

/// A face's grid on the texels of a band: point `(i, j)` stands on texel `origin + i · along[0] + j · along[1]`.
struct Grid {
    face: usize,
    shape: Shape,
    origin: usize,
    along: [isize; 2],
}

impl Grid {
    fn step(&self, [i, j]: [i32; 2]) -> isize {
        self.along[0] * i as isize + self.along[1] * j as isize
    }

    fn texel(&self, (i, j): (u32, u32)) -> usize {
        self.origin.wrapping_add_signed(self.step([i as i32, j as i32]))
    }
}

/// Points of a grid: the first one, and the step to the next.
#[derive(Clone, Copy)]
struct GridLine {
    first: (u32, u32),
    step: [i32; 2],
}

impl Painter<'_> {
    /// Writes the texels of one face.
    pub(super) fn copy(&self, band: &mut Band<'_>, block: &Block, face: usize, scratch: &mut Scratch) {
        let grid = self.grid(band, block, face);
        let numbering = self.channel.numbering;
        let samples = &self.values.samples;
        let shape = grid.shape;
        let mut interior = &samples[numbering.face_range(face)];
        for j in shape.inner_rows() {
            let (row, after) = interior.split_at(shape.cell_count(j) as usize - 1);
            interior = after;
            let line = GridLine { first: (1, j), step: [1, 0] };
            self.write(band, &grid, line, row, &mut scratch.stored);
        }
        for edge in 0..shape.edge_count() {
            self.copy_edge(band, &grid, edge, scratch);
            let line = GridLine { first: shape.edge_point(edge, 0), step: [0, 0] };
            let sample = numbering.topology.fan_of[face][edge] as usize;
            self.write(band, &grid, line, &samples[sample..=sample], &mut scratch.stored);
        }
        if block.kind.is_lone() {
            self.border(band, &grid);
        }
    }

    fn grid(&self, band: &Band<'_>, block: &Block, face: usize) -> Grid {
        let numbering = self.channel.numbering;
        let layout = self.channel.layout;
        let placement = &layout.placements[face];
        let shape = numbering.shape(face);
        let [x, y] = layout.first_texel(block, numbering.level);
        let corner = |k: usize| placement.corners[k].map(|unit| i32::from(unit) as isize);
        let [start, i_end, j_end] = [corner(0), corner(1), corner(shape.edge_count() - 1)];
        let along = |end: [isize; 2]| (end[1] - start[1]) * band.width as isize + (end[0] - start[0]);
        // Only lone triangles, whose sides are equal, begin elsewhere than at the first texel.
        let [left, top] = placement.corners[0].map(|unit| u32::from(unit) * shape.segments[0]);
        let origin = band.texel(x + left + layout.shift(face, numbering.level), y + top);
        Grid { face, shape, origin, along: [along(i_end), along(j_end)] }
    }

    /// Writes samples as the face stores them.
    fn write(
        &self,
        band: &mut Band<'_>,
        grid: &Grid,
        line: GridLine,
        samples: &[Vec4],
        stored: &mut Vec<Vec4>,
    ) {
        let values = match self.channel.frames {
            None => samples,
            Some(frames) => {
                let at = grid.shape.unit(line.first.0, line.first.1);
                let step = [0, 1].map(|k| line.step[k] as f32 / grid.shape.segments[k] as f32);
                let points = FrameLine { face: grid.face, at, step };
                frames.store(self.channel.numbering.canvas, &points, samples, stored);
                stored
            }
        };
        band.write(Line { first: grid.texel(line.first), step: grid.step(line.step), values });
    }

    /// Writes the inside of an edge; its ends are corners.
    fn copy_edge(&self, band: &mut Band<'_>, grid: &Grid, edge: usize, scratch: &mut Scratch) {
        let numbering = self.channel.numbering;
        let strip = numbering.topology.strip_of[grid.face][edge] as usize;
        let (n, coarse) = (grid.shape.edge_segments(edge), numbering.strip_segments(strip));
        if n == 1 {
            return;
        }
        // Lines run from the low end, as the samples of a strip do.
        let is_reversed = numbering.canvas.faces[grid.face].is_reversed(edge);
        let point =
            |from_low: u32| grid.shape.edge_point(edge, if is_reversed { n - from_low } else { from_low });
        let (first, second) = (point(1), point(2));
        let step = [second.0 as i32 - first.0 as i32, second.1 as i32 - first.1 as i32];
        let line = GridLine { first, step };
        let samples = &self.values.samples;
        if coarse == n {
            let inside = &samples[numbering.strip_range(strip)];
            self.write(band, grid, line, inside, &mut scratch.stored);
            return;
        }
        scratch.between.clear();
        let fine = n / coarse;
        let sample = |at: u32| self.shared(samples[numbering.strip_sample(strip, at) as usize]);
        let mut low = sample(0);
        for at in 0..coarse {
            let high = sample(at + 1);
            scratch.between.push(low);
            scratch.between.extend((1..fine).map(|rest| low.lerp(high, rest as f32 / fine as f32)));
            low = high;
        }
        self.write(band, grid, line, &scratch.between[1..], &mut scratch.stored);
    }

    /// A sample as texels are worked out from it; of normals each face stores a version of its own.
    fn shared(&self, sample: Vec4) -> Vec4 {
        if self.rounding == Rounding::Rules && self.channel.frames.is_none() {
            self.codec.round(sample)
        } else {
            sample
        }
    }

    /// The line of texels beyond a lone triangle's diagonal: `c3 = c1 + c2 - c0` (MCT equation 1).
    fn border(&self, band: &mut Band<'_>, grid: &Grid) {
        let [n, _] = grid.shape.segments;
        let (right, _) = self.channel.right_angle(grid.face);
        let point = |x: u32, y: u32| from_right_angle(right, n, x, y);
        for x in 1..=n {
            let y = n + 1 - x;
            let parts = [point(x, y - 1), point(x - 1, y), point(x - 1, y - 1)];
            let [c1, c2, c0] = parts.map(|at| grid.texel(at));
            let [one, two, zero] = parts.map(|at| self.point(band, grid, at));
            band.put(c1 + c2 - c0, one + two - zero);
        }
    }

    /// The value at a grid point that border texels are worked out from: by the rules what its texel holds.
    fn point(&self, band: &Band<'_>, grid: &Grid, (i, j): (u32, u32)) -> Vec4 {
        let held = band.read(grid.texel((i, j))).filter(|_| self.rounding == Rounding::Rules);
        held.unwrap_or_else(|| {
            let value = self.channel.numbering.tap(grid.face, i, j).value(&self.values.samples);
            let [s, t] = grid.shape.unit(i, j);
            self.channel.stored(grid.face, value.as_dvec4(), s, t).as_vec4()
        })
    }
}
