//! Blocks of elongated quads that are beyond vertex colors along their short side alone (MCT 3.6): along the long one
//! samples stand on columns of texels still, and in each column the line through its two samples is extrapolated to the
//! texels around them.

use glam::{DVec2, DVec4, Vec4};

use crate::layout::Block;

use super::Painter;
use super::band::Band;
use super::beyond::span;
use super::cell::Cell;
use crate::assign::{LevelChannel, Rounding};

/// The columns of texels of a block.
pub(in crate::assign) struct Columns {
    pub first: [u32; 2],
    /// How many of them, and the texels of each: 2, or 3 where the far side stands exactly on a texel center.
    pub columns_rows: [u32; 2],
    /// Whether the face's own first axis is the block's second.
    is_turned: bool,
    /// Of the near samples, from the first texel.
    near_texels: f64,
    segments_per_texel: f64,
}

impl Columns {
    pub fn new(channel: &LevelChannel<'_>, block: &Block, face: usize) -> Self {
        let level = channel.numbering.level;
        let first = channel.layout.first_texel(block, level);
        let corner = channel.layout.first_corner(block, level).y;
        let side = (f64::from(block.exponents[1]) - level as f64).exp2();
        let column_count = (1 << (usize::from(block.exponents[0]) - level)) + 1;
        Self {
            first,
            columns_rows: [column_count, span(corner, side)],
            is_turned: channel.layout.placements[face].corners[1] == [0, 1],
            near_texels: corner - f64::from(first[1]),
            segments_per_texel: 1.0 / side,
        }
    }

    /// The face's grid points in a column: the near one and the far one.
    pub fn points(&self, column: u32) -> [(u32, u32); 2] {
        [0, 1].map(|row| if self.is_turned { (row, column) } else { (column, row) })
    }

    /// Weights of both samples of a column in one of its texels; their sum is 1.
    pub fn weights(&self, dy: u32) -> [f64; 2] {
        let far = (f64::from(dy) - self.near_texels) * self.segments_per_texel;
        [1.0 - far, far]
    }

    /// Both samples between the first two texels of a column, for rounding these together.
    fn between(&self) -> Option<Cell> {
        let ends = [self.near_texels, self.near_texels + 1.0 / self.segments_per_texel];
        Cell::new(&ends.map(|end| DVec2::new(1.0, end)))
    }
}

impl Painter<'_> {
    /// Writes the columns of a face.
    pub(super) fn extrapolate_columns(&self, band: &mut Band<'_>, block: &Block, face: usize) {
        let columns = Columns::new(self.channel, block, face);
        let between = columns.between().filter(|_| self.rounding == Rounding::Rules);
        for dx in 0..columns.columns_rows[0] {
            let [near, far] = columns.points(dx).map(|point| self.wanted(face, point));
            let mut values = [Vec4::ZERO; 3];
            let mut texels = [0; 3];
            for dy in 0..columns.columns_rows[1] {
                // The weights sum to 1: the large ones multiply what is small.
                let value = (near + (far - near) * columns.weights(dy)[1]).as_vec4();
                let texel = band.texel(columns.first[0] + dx, columns.first[1] + dy);
                band.put(texel, value);
                (values[dy as usize], texels[dy as usize]) = (value, texel);
            }
            if let Some(between) = &between {
                // The column is the right side of its cell; what is left of it has no weight, and is written over.
                let ([t0, t1, _], [v0, v1, _]) = (texels, values);
                band.put_cell([t0, t0, t1, t1], &[v0, v0, v1, v1], between);
            }
        }
    }

    /// What a face is to show at one of its grid points, as it stores it.
    fn wanted(&self, face: usize, (i, j): (u32, u32)) -> DVec4 {
        let value = self.values.value(self.channel.numbering.tap(face, i, j));
        let [s, t] = self.channel.numbering.shape(face).unit(i, j);
        self.channel.stored(face, value, s, t)
    }
}
