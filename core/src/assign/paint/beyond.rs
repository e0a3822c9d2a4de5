//! Beyond vertex colors along both axes: the function through the corners of a triangle or quad, extrapolated to the texels around it (MCT 3.4). In 64 bits: the weights reach `4^(level - r)`.

use glam::{DVec2, DVec4, Vec4};

use crate::layout::Block;

use super::Painter;
use super::band::Band;
use super::cell::Cell;
use crate::assign::{LevelChannel, Rounding, corner_point};

impl Painter<'_> {
    /// Writes the texels around a face.
    pub(super) fn extrapolate(&self, band: &mut Band<'_>, block: &Block, face: usize) {
        let corners = self.corner_values(face);
        let cell = BeyondCell::new(self.channel, block, face);
        // One texel more than the bilinear footprint: a corner that stands exactly on its far side may be
        // rounded across.
        let mut values = [[Vec4::ZERO; 3]; 3];
        for dy in 0..cell.columns_rows[1] {
            for dx in 0..cell.columns_rows[0] {
                let value = extrapolated(&corners, cell.at(dx, dy));
                values[dy as usize][dx as usize] = value;
                band.put(band.texel(cell.first[0] + dx, cell.first[1] + dy), value);
            }
        }
        if self.rounding == Rounding::Rules
            && let Some(between) = cell.between(&corners)
        {
            let steps = [(0, 0), (1, 0), (0, 1), (1, 1)];
            let texels = steps.map(|(dx, dy)| band.texel(cell.first[0] + dx, cell.first[1] + dy));
            band.put_cell(texels, &[values[0][0], values[0][1], values[1][0], values[1][1]], &between);
        }
    }

    /// Stored values at the corners of the block's square, where the face has them.
    fn corner_values(&self, face: usize) -> [[Option<DVec4>; 2]; 2] {
        let numbering = self.channel.numbering;
        let value = |corner: usize| {
            let sample = numbering.topology.fan_of[face][corner] as usize;
            let (s, t) = corner_point(numbering.canvas.faces[face].is_triangle(), corner);
            self.channel.stored(face, self.values.corner(face, corner, sample), s, t)
        };
        self.channel.square(face).map(|row| row.map(|corner| corner.map(value)))
    }
}

/// The texels around a face beyond vertex colors.
pub(in crate::assign) struct BeyondCell {
    pub first: [u32; 2],
    /// 2, or 3 where the far side stands exactly on a texel center.
    pub columns_rows: [u32; 2],
    corner: DVec2,
    segments_per_texel: DVec2,
}

/// Texels that a side reaches along one axis: 2, or 3 where its end stands exactly on a texel center.
pub(super) fn span(corner: f64, side: f64) -> u32 {
    if corner + side - corner.floor() >= 1.0 { 3 } else { 2 }
}

impl BeyondCell {
    pub fn new(channel: &LevelChannel<'_>, block: &Block, face: usize) -> Self {
        let level = channel.numbering.level;
        let shift = channel.layout.shift(face, level);
        let corner = channel.layout.first_corner(block, level) + DVec2::new(f64::from(shift), 0.0);
        let side = DVec2::from(block.exponents.map(|exponent| (f64::from(exponent) - level as f64).exp2()));
        let first = corner.floor();
        Self {
            first: [first.x as u32, first.y as u32],
            columns_rows: [span(corner.x, side.x), span(corner.y, side.y)],
            corner,
            segments_per_texel: 1.0 / side,
        }
    }

    /// The corners that are there, among the first two by two texels: the far ones stand on them too.
    fn between(&self, corners: &[[Option<DVec4>; 2]; 2]) -> Option<Cell> {
        let near = self.corner - DVec2::new(f64::from(self.first[0]), f64::from(self.first[1]));
        let all = [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().filter(|&(x, y)| corners[y][x].is_some());
        let places = all.map(|(x, y)| near + DVec2::new(x as f64, y as f64) / self.segments_per_texel);
        Cell::new(&places.collect::<Vec<_>>())
    }

    /// A texel's place on the block's unit square (far outside it at high levels).
    pub fn at(&self, dx: u32, dy: u32) -> DVec2 {
        let texel = DVec2::new(f64::from(self.first[0] + dx), f64::from(self.first[1] + dy));
        (texel - self.corner) * self.segments_per_texel
    }
}

/// The bilinear function through four corners of the unit square, or the linear one through three. The
/// weights sum to 1, so differences to one corner are weighed: large weights then multiply what is small,
/// and one color stays itself to the last bit.
fn extrapolated(corners: &[[Option<DVec4>; 2]; 2], at: DVec2) -> Vec4 {
    let weights = corner_weights(corners.map(|row| row.map(|c| c.is_some())), at);
    let value = |[x, y]: [usize; 2]| corners[y][x].unwrap_or(DVec4::ZERO);
    let base = value(weights[0].0);
    let changes = weights[1..].iter().map(|&(corner, weight)| (value(corner) - base) * weight);
    (base + changes.sum::<DVec4>()).as_vec4()
}

/// Weights of the corners of the unit square at a point, 0 of one that is not there.
pub(in crate::assign) fn corner_weights(there: [[bool; 2]; 2], at: DVec2) -> [([usize; 2], f64); 4] {
    let all = [[0, 0], [1, 0], [0, 1], [1, 1]];
    let Some(missing) = all.into_iter().find(|&[x, y]| !there[y][x]) else {
        let axis = |k: usize, v: f64| if k == 1 { v } else { 1.0 - v };
        return all.map(|[x, y]| ([x, y], axis(x, at.x) * axis(y, at.y)));
    };
    // Measured from the right angle, which is opposite to what is missing.
    let [rx, ry] = [1 - missing[0], 1 - missing[1]];
    let along = |corner: usize, v: f64| if corner == 1 { 1.0 - v } else { v };
    let (a, b) = (along(rx, at.x), along(ry, at.y));
    [([rx, ry], 1.0 - a - b), ([1 - rx, ry], a), ([rx, 1 - ry], b), (missing, 0.0)]
}
