//! Samples to level images.

use glam::{DVec2, DVec4, Vec4};
use rayon::prelude::*;

use crate::colors::FaceGrid;
use crate::error::Result;
use crate::image::{Image, Pixels};
use crate::layout::{Block, BlockKind};
use crate::watch::{self, Watch};

use super::{LevelChannel, LevelValues, corner_point, from_right_angle};

/// Paints one level. `values` are the samples, representable up to rounding.
///
/// Rounding comes last and is shared: copies round the sample once for all faces, and border texels and
/// points of coarser edges are worked out from rounded samples, so that only their own rounding is left.
/// Beyond vertex colors the weights are large, so there the samples enter unrounded.
pub fn paint(channel: &LevelChannel<'_>, values: &LevelValues, watch: &dyn Watch) -> Result<Image> {
    let [width, height] = channel.layout.sizes[channel.numbering.level];
    let components = channel.codec.components;
    let rounded = round_samples(channel, &values.samples);
    let painter = Painter { channel, values, rounded: &rounded, watch, width };
    let pixels = if channel.codec.bits == 8 {
        Pixels::U8(painter.paint(height, |code| code as u8)?)
    } else {
        Pixels::U16(painter.paint(height, |code| code)?)
    };
    Ok(Image { width, height, components, pixels })
}

fn round_samples(channel: &LevelChannel<'_>, values: &[Vec4]) -> Vec<Vec4> {
    if channel.frames.is_some() {
        return Vec::new(); // each face stores its own version of a normal
    }
    values.par_iter().map(|&value| channel.codec.round(value)).collect()
}

struct Painter<'a> {
    channel: &'a LevelChannel<'a>,
    values: &'a LevelValues,
    rounded: &'a [Vec4],
    watch: &'a dyn Watch,
    width: u32,
}

/// The texel rows of one layout row.
struct Band<'a, C> {
    codes: &'a mut [C],
    first_row: u32,
}

impl Painter<'_> {
    fn paint<C: Copy + Default + Send>(&self, height: u32, code: impl Fn(u16) -> C + Sync) -> Result<Vec<C>> {
        let layout = self.channel.layout;
        let level = self.channel.numbering.level;
        let row_codes = self.width as usize * usize::from(self.channel.codec.components);
        let mut codes = vec![C::default(); row_codes * height as usize];
        let mut bands = Vec::with_capacity(layout.row_starts.len());
        let mut rest = codes.as_mut_slice();
        for (row, &start) in layout.row_starts.iter().enumerate() {
            let first_row = layout.blocks[start].corner(level).y as u32;
            let next = layout.row_starts.get(row + 1).copied();
            let end_row = next.map_or(height, |next| layout.blocks[next].corner(level).y as u32);
            let (band, after) = rest.split_at_mut((end_row - first_row) as usize * row_codes);
            rest = after;
            let blocks = &layout.blocks[start..next.unwrap_or(layout.blocks.len())];
            bands.push((Band { codes: band, first_row }, blocks));
        }
        bands.into_par_iter().try_for_each_init(FaceGrid::default, |grid, (mut band, blocks)| {
            watch::check(self.watch)?;
            for block in blocks {
                self.paint_block(&mut band, block, grid, &code);
            }
            Ok(())
        })?;
        Ok(codes)
    }

    fn put<C: Copy>(&self, band: &mut Band<'_, C>, at: [u32; 2], value: Vec4, code: &impl Fn(u16) -> C) {
        let components = usize::from(self.channel.codec.components);
        let texel = (at[1] - band.first_row) as usize * self.width as usize + at[0] as usize;
        let codes = self.channel.codec.encode(value);
        for (slot, stored) in band.codes[texel * components..][..components].iter_mut().zip(codes) {
            *slot = code(stored);
        }
    }

    fn paint_block<C: Copy>(
        &self,
        band: &mut Band<'_, C>,
        block: &Block,
        grid: &mut FaceGrid,
        code: &impl Fn(u16) -> C,
    ) {
        let (first, second) = block.kind.faces();
        let is_beyond = block.segments >> self.channel.numbering.level == 0;
        let lone = matches!(block.kind, BlockKind::Lone(_) | BlockKind::Twins(_));
        if is_beyond && !lone {
            self.extrapolate(band, block, &[Some(first), second], code);
            return;
        }
        for face in std::iter::once(first).chain(second) {
            if is_beyond {
                self.extrapolate(band, block, &[Some(face)], code);
                continue;
            }
            self.fill(face as usize, grid);
            self.copy(band, block, face as usize, grid, code);
            if lone {
                self.border(band, block, face as usize, grid, code);
            }
        }
    }

    /// The face's stored values, rounded.
    fn fill(&self, face: usize, grid: &mut FaceGrid) {
        let numbering = self.channel.numbering;
        if self.channel.frames.is_none() {
            numbering.fill(face, self.rounded, grid);
            return;
        }
        numbering.fill(face, &self.values.samples, grid);
        let scale = 1.0 / grid.segments as f32;
        for j in 0..=grid.segments {
            let end = if grid.is_triangle { grid.segments - j } else { grid.segments };
            for i in 0..=end {
                let value = grid.at(i, j).as_dvec4();
                let stored = self.channel.stored(face, value, i as f32 * scale, j as f32 * scale).as_vec4();
                *grid.at_mut(i, j) = self.channel.codec.round(stored);
            }
        }
    }

    /// The texel of a face's grid point.
    fn texel(&self, block: &Block, face: usize, n: u32, i: u32, j: u32) -> [u32; 2] {
        let placement = &self.channel.layout.placements[face];
        let last = if self.channel.numbering.canvas.faces[face].is_triangle() { 2 } else { 3 };
        let first = block.texel(self.channel.numbering.level);
        let axis = |k: usize| {
            let corner = |c: usize| i64::from(placement.corners[c][k]);
            let (i, j, n) = (i64::from(i), i64::from(j), i64::from(n));
            let local = corner(0) * n + i * (corner(1) - corner(0)) + j * (corner(last) - corner(0));
            first[k] + local as u32
        };
        [axis(0) + placement.shift, axis(1)]
    }

    fn copy<C: Copy>(
        &self,
        band: &mut Band<'_, C>,
        block: &Block,
        face: usize,
        grid: &FaceGrid,
        code: &impl Fn(u16) -> C,
    ) {
        let n = grid.segments;
        for j in 0..=n {
            let end = if grid.is_triangle { n - j } else { n };
            for i in 0..=end {
                self.put(band, self.texel(block, face, n, i, j), grid.at(i, j), code);
            }
        }
    }

    /// The line of texels beyond a lone triangle's diagonal: `c3 = c1 + c2 - c0` (MCT equation 1).
    fn border<C: Copy>(
        &self,
        band: &mut Band<'_, C>,
        block: &Block,
        face: usize,
        grid: &FaceGrid,
        code: &impl Fn(u16) -> C,
    ) {
        let n = grid.segments;
        let (right, _) = self.channel.right_angle(face);
        let place = |x: u32, y: u32| {
            let (i, j) = from_right_angle(right, n, x, y);
            (grid.at(i, j), self.texel(block, face, n, i, j))
        };
        for x in 1..=n {
            let y = n + 1 - x;
            let (c0, at0) = place(x - 1, y - 1);
            let (c1, at1) = place(x, y - 1);
            let (c2, at2) = place(x - 1, y);
            let at = [at1[0] + at2[0] - at0[0], at1[1] + at2[1] - at0[1]];
            self.put(band, at, c1 + c2 - c0, code);
        }
    }

    /// Beyond vertex colors: the function through the corners of one triangle, one quad or both triangles of
    /// a pair, extrapolated to the texels around it.
    fn extrapolate<C: Copy>(
        &self,
        band: &mut Band<'_, C>,
        block: &Block,
        faces: &[Option<u32>],
        code: &impl Fn(u16) -> C,
    ) {
        let corners = self.corner_values(faces);
        let first_face = faces[0].unwrap_or(0) as usize;
        let cell = BeyondCell::new(self.channel, block, first_face);
        // One texel more than the bilinear footprint: a corner that stands exactly on its far side may be
        // rounded across.
        for dy in 0..cell.columns_rows[1] {
            for dx in 0..cell.columns_rows[0] {
                let at = cell.at(dx, dy);
                self.put(band, [cell.first[0] + dx, cell.first[1] + dy], extrapolated(&corners, at), code);
            }
        }
    }

    /// Stored values at the corners of the block's square, where the faces have them.
    fn corner_values(&self, faces: &[Option<u32>]) -> [[Option<DVec4>; 2]; 2] {
        let mut values = [[None; 2]; 2];
        let numbering = self.channel.numbering;
        for face in faces.iter().flatten().map(|&face| face as usize) {
            let canvas_face = &numbering.canvas.faces[face];
            for corner in 0..canvas_face.count() {
                let [x, y] = self.channel.layout.placements[face].corners[corner].map(usize::from);
                let sample = numbering.topology.fan_of[face][corner] as usize;
                let (s, t) = corner_point(canvas_face.is_triangle(), corner);
                let value = self.values.corner(face, corner, sample);
                values[y][x] = Some(self.channel.stored(face, value, s, t));
            }
        }
        values
    }
}

/// The texels around a block (or one of two lone triangles) beyond vertex colors.
pub(super) struct BeyondCell {
    pub first: [u32; 2],
    /// 2, or 3 where the far side stands exactly on a texel center.
    pub columns_rows: [u32; 2],
    corner: DVec2,
    segments_per_texel: f64,
}

impl BeyondCell {
    pub fn new(channel: &LevelChannel<'_>, block: &Block, face: usize) -> Self {
        let level = channel.numbering.level;
        let shift = channel.layout.placements[face].shift;
        let corner = block.corner(level) + DVec2::new(f64::from(shift), 0.0);
        let side = f64::from(block.segments) / (level as f64).exp2();
        let first = corner.floor();
        let far = corner + side;
        let count = |far: f64, first: f64| if far - first >= 1.0 { 3 } else { 2 };
        Self {
            first: [first.x as u32, first.y as u32],
            columns_rows: [count(far.x, first.x), count(far.y, first.y)],
            corner,
            segments_per_texel: 1.0 / side,
        }
    }

    /// A texel's place on the block's unit square (far outside it at high levels).
    pub fn at(&self, dx: u32, dy: u32) -> DVec2 {
        let texel = DVec2::new(f64::from(self.first[0] + dx), f64::from(self.first[1] + dy));
        (texel - self.corner) * self.segments_per_texel
    }
}

/// The bilinear function through four corners of the unit square, or the linear one through three. In 64
/// bits: the weights reach `4^(level - r)`, and their sum is 1.
fn extrapolated(corners: &[[Option<DVec4>; 2]; 2], at: DVec2) -> Vec4 {
    let mut value = DVec4::ZERO;
    for ([x, y], weight) in corner_weights(corners.map(|row| row.map(|c| c.is_some())), at) {
        value += corners[y][x].unwrap_or(DVec4::ZERO) * weight;
    }
    value.as_vec4()
}

/// Weights of the corners of the unit square at a point, four or the three that are there.
pub(super) fn corner_weights(there: [[bool; 2]; 2], at: DVec2) -> Vec<([usize; 2], f64)> {
    let all = [[0, 0], [1, 0], [0, 1], [1, 1]];
    let Some(missing) = all.into_iter().find(|&[x, y]| !there[y][x]) else {
        let axis = |k: usize, v: f64| if k == 1 { v } else { 1.0 - v };
        return all.into_iter().map(|[x, y]| ([x, y], axis(x, at.x) * axis(y, at.y))).collect();
    };
    // Measured from the right angle, which is opposite to what is missing.
    let [rx, ry] = [1 - missing[0], 1 - missing[1]];
    let along = |corner: usize, v: f64| if corner == 1 { 1.0 - v } else { v };
    let (a, b) = (along(rx, at.x), along(ry, at.y));
    vec![([rx, ry], 1.0 - a - b), ([1 - rx, ry], a), ([rx, 1 - ry], b)]
}
