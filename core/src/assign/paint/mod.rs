//! Samples to level images.

mod band;
mod beyond;
mod cell;
mod columns;
mod extent;
mod up_to_vertex;

pub(super) use beyond::{BeyondCell, corner_weights};
pub(super) use columns::Columns;
pub use extent::{Need, RANGE_WIDTH, need_of_range, range_of};

use rayon::prelude::*;

use crate::error::Result;
use crate::image::{Image, LevelRange, Pixels};
use crate::layout::{self, Block};
use crate::watch::{self, Watch};

use super::codec::LevelCodec;
use super::{LevelChannel, LevelValues, Rounding};
use band::{Band, Sheet};
use up_to_vertex::Scratch;

/// How a level is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Storing {
    pub rounding: Rounding,
    /// `None`: codes of [0, 1].
    pub range: Option<LevelRange>,
}

/// Paints one level. `values` are the samples, representable up to rounding.
///
/// Rounding comes last. By [`Rounding::Rules`] it is shared: copies round the sample once for all faces,
/// points of coarser edges are worked out from rounded samples and border texels from stored texels, so
/// that only their own rounding is left (none at all for the borders of linear formats). Beyond vertex
/// colors the weights are large, so there the samples enter unrounded, and the four texels around a face (or the two of a
/// column) are rounded together, to what shows least at its corners.
///
/// # Errors
/// `Canceled`.
pub fn paint(
    channel: &LevelChannel<'_>,
    values: &LevelValues,
    storing: Storing,
    watch: &dyn Watch,
) -> Result<Image> {
    let [width, height] = channel.layout.sizes[channel.numbering.level];
    let codec = LevelCodec { plain: channel.codec, range: storing.range };
    let components = channel.codec.components;
    let painter = Painter { channel, values, codec, rounding: storing.rounding };
    let code_count = width as usize * height as usize * usize::from(components);
    let pixels = if codec.plain.bits == 8 && storing.range.is_none() {
        let mut codes = vec![0; code_count];
        painter.paint(rows(channel, &mut codes), |codes| Sheet::Codes8(codes), watch)?;
        Pixels::U8(codes)
    } else {
        let mut codes = vec![0; code_count];
        painter.paint(rows(channel, &mut codes), |codes| Sheet::Codes16(codes), watch)?;
        Pixels::U16(codes)
    };
    Ok(Image { width, height, components, pixels })
}

struct Painter<'a> {
    channel: &'a LevelChannel<'a>,
    values: &'a LevelValues,
    codec: LevelCodec,
    rounding: Rounding,
}

/// A band of the layout and the codes of its texel rows.
struct Row<'a, C> {
    band: &'a layout::Band,
    codes: &'a mut [C],
}

/// The image cut into the bands of its layout; every code belongs to one.
fn rows<'a, C>(channel: &LevelChannel<'a>, codes: &'a mut [C]) -> Vec<Row<'a, C>> {
    let layout = channel.layout;
    let level = channel.numbering.level;
    let [width, height] = layout.sizes[level];
    let row_codes = width as usize * usize::from(channel.codec.components);
    let bands = &layout.bands[level];
    let mut rows = Vec::with_capacity(bands.len());
    let mut rest = codes;
    let end_rows = bands.iter().skip(1).map(|band| band.first_row).chain([height]);
    for (band, end_row) in bands.iter().zip(end_rows) {
        let (codes, after) = rest.split_at_mut((end_row - band.first_row) as usize * row_codes);
        rest = after;
        rows.push(Row { band, codes });
    }
    rows
}

impl Painter<'_> {
    fn paint<C: Send>(
        &self,
        rows: Vec<Row<'_, C>>,
        sheet: impl Fn(&mut [C]) -> Sheet<'_> + Sync,
        watch: &dyn Watch,
    ) -> Result<()> {
        let width = self.channel.layout.sizes[self.channel.numbering.level][0] as usize;
        rows.into_par_iter().try_for_each_init(Scratch::default, |scratch, row| {
            watch::check(watch)?;
            let (sheet, first_row) = (sheet(row.codes), row.band.first_row as usize);
            let mut band = Band { sheet, codec: self.codec, width, first_row };
            self.blocks(row.band).for_each(|block| self.paint_block(&mut band, block, scratch));
            Ok(())
        })
    }

    fn blocks<'b>(&'b self, band: &'b layout::Band) -> impl Iterator<Item = &'b Block> {
        band.blocks.iter().flat_map(|range| &self.channel.layout.blocks[range.clone()])
    }

    fn is_beyond(&self, block: &Block) -> bool {
        self.channel.layout.is_beyond(block, self.channel.numbering.level)
    }

    fn paint_block(&self, band: &mut Band<'_>, block: &Block, scratch: &mut Scratch) {
        let layout = self.channel.layout;
        if layout.is_beyond_across(block, self.channel.numbering.level) {
            block.kind.faces().for_each(|face| self.extrapolate_columns(band, block, face));
        } else if self.is_beyond(block) {
            block.kind.faces().for_each(|face| self.extrapolate(band, block, face));
        } else {
            block.kind.faces().for_each(|face| self.copy(band, block, face, scratch));
        }
    }
}
