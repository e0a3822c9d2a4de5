//! The texels of one row of blocks, as something to write lines of values into.

use glam::Vec4;

use super::cell::Cell;
use crate::assign::codec::{LevelCodec, Line, write_line8, write_line16};

/// Where values go.
pub(super) enum Sheet<'a> {
    Codes8(&'a mut [u8]),
    Codes16(&'a mut [u16]),
    /// Nowhere: what they are like is noted.
    Extent(&'a mut Extent),
}

/// What texels are to hold.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    /// Least and largest value by component.
    pub low: Vec4,
    pub high: Vec4,
    /// Texels with a component outside of [0, 1].
    pub outside_count: u64,
}

impl Extent {
    pub const NOTHING: Self = Self { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY, outside_count: 0 };
    /// As much outside of [0, 1] is rounding, as the solver sees it.
    const TOLERANCE: f32 = 1e-6;

    fn add(&mut self, value: Vec4) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
        let is_outside =
            value.min_element() < -Self::TOLERANCE || value.max_element() > 1.0 + Self::TOLERANCE;
        self.outside_count += u64::from(is_outside);
    }

    pub fn join(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            outside_count: self.outside_count + other.outside_count,
        }
    }
}

/// The texel rows from `first_row` on.
pub(super) struct Band<'a> {
    pub sheet: Sheet<'a>,
    pub codec: LevelCodec,
    /// Texels.
    pub width: usize,
    pub first_row: usize,
}

impl Band<'_> {
    /// The number of a texel of the image among those of the band.
    pub fn texel(&self, x: u32, y: u32) -> usize {
        (y as usize - self.first_row) * self.width + x as usize
    }

    pub fn write(&mut self, line: Line<'_>) {
        match &mut self.sheet {
            Sheet::Codes8(codes) => write_line8(&self.codec.plain, codes, line),
            Sheet::Codes16(codes) => write_line16(&self.codec, codes, line),
            Sheet::Extent(extent) => {
                // An alpha that nobody reads has no say.
                let has_alpha = self.codec.plain.has_alpha();
                let judged = |value: &Vec4| if has_alpha { *value } else { value.with_w(0.5) };
                line.values.iter().for_each(|value| extent.add(judged(value)));
            }
        }
    }

    pub fn put(&mut self, texel: usize, value: Vec4) {
        self.write(Line { first: texel, step: 1, values: &[value] });
    }

    /// Writes four texels, given what they should hold, with the codes that show least of it in between.
    pub fn put_cell(&mut self, texels: [usize; 4], wanted: &[Vec4; 4], cell: &Cell) {
        let stored = self.codec.plain.stored();
        for (slot, &component) in stored.iter().enumerate() {
            let codes = || cell.codes(&self.codec, component, wanted.map(|value| value[component]));
            let at = texels.map(|texel| texel * stored.len() + slot);
            match &mut self.sheet {
                Sheet::Codes8(sheet) => at.iter().zip(codes()).for_each(|(&at, code)| sheet[at] = code as u8),
                Sheet::Codes16(sheet) => at.iter().zip(codes()).for_each(|(&at, code)| sheet[at] = code),
                Sheet::Extent(_) => {}
            }
        }
    }

    /// The value that a texel holds since it was written; `None` where values go nowhere.
    pub fn read(&self, texel: usize) -> Option<Vec4> {
        let count = usize::from(self.codec.plain.components);
        let mut stored = [0; 4];
        match &self.sheet {
            Sheet::Codes8(codes) => {
                stored.iter_mut().zip(&codes[texel * count..][..count]).for_each(|(s, c)| *s = u16::from(*c));
            }
            Sheet::Codes16(codes) => stored[..count].copy_from_slice(&codes[texel * count..][..count]),
            Sheet::Extent(_) => return None,
        }
        Some(self.codec.decode(stored))
    }
}
