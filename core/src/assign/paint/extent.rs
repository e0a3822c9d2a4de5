//! Which levels need a range, and which: by the values that their texels would store.

use glam::Vec4;
use rayon::prelude::*;

use crate::error::Result;
use crate::image::LevelRange;
use crate::layout::{self, Block};
use crate::watch::{self, Watch};

use super::Painter;
use super::band::{Band, Extent, Sheet};
use super::up_to_vertex::Scratch;
use crate::assign::codec::LevelCodec;
use crate::assign::{LevelChannel, LevelValues, Range, Rounding};

/// A level is worth a range of its own where it has more texels beyond vertex colors that leave [0, 1] than
/// this share of its samples. Up to there the solver leaves 95 % of the samples as they are.
const OUTSIDE_SHARE: f64 = 0.05;
/// The width of the values that a level in a range may have, around 1/2. Sixteen bits that span more are too coarse for
/// what shows in between, and no filter with weights of few bits could follow the slopes of such a face. What asks
/// for more is solved, as texels outside of [0, 1] are at other levels.
pub const RANGE_WIDTH: f32 = 8.0;

/// What a level has to be stored in, before anything was solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// The format of the source: codes of [0, 1].
    Plain,
    /// A range of its own; whether some texels want to be outside of [`RANGE_WIDTH`].
    Ranged { is_too_wide: bool },
}

/// Whether a level is to have a range: not in the bounded format, not where every face is up to its vertex colors
/// and not where few texels leave [0, 1].
///
/// Level 0 has none: no face is beyond vertex colors there.
///
/// # Errors
/// `Canceled`.
pub fn need_of_range(
    channel: &LevelChannel<'_>,
    values: &LevelValues,
    range: Range,
    watch: &dyn Watch,
) -> Result<Need> {
    let painter = plain(channel, values);
    if range == Range::Unorm8 || !channel.layout.blocks.iter().any(|block| painter.is_beyond(block)) {
        return Ok(Need::Plain);
    }
    let beyond = painter.extent(|block| painter.is_beyond(block), watch)?;
    if beyond.outside_count as f64 <= OUTSIDE_SHARE * channel.numbering.sample_count() as f64 {
        return Ok(Need::Plain);
    }
    let far = (beyond.low - 0.5).abs().max((beyond.high - 0.5).abs()).max_element();
    Ok(Need::Ranged { is_too_wide: far > 0.5 * RANGE_WIDTH })
}

/// The range that holds a level's texels, and of numbers of any size all from -1 to 1: so it does not depend on them where
/// texels are samples.
///
/// # Errors
/// `Canceled`.
pub fn range_of(
    channel: &LevelChannel<'_>,
    values: &LevelValues,
    (range, is_number): (Range, bool),
    watch: &dyn Watch,
) -> Result<LevelRange> {
    if range == Range::Float16 {
        return Ok(LevelRange::Float16);
    }
    let all = plain(channel, values).extent(|_| true, watch)?;
    let reach = if is_number { Vec4::ONE } else { Vec4::NEG_INFINITY };
    Ok(LevelRange::spanning(all.low.min(-reach), all.high.max(reach)))
}

fn plain<'a>(channel: &'a LevelChannel<'a>, values: &'a LevelValues) -> Painter<'a> {
    let codec = LevelCodec { plain: channel.codec, range: None };
    Painter { channel, values, codec, rounding: Rounding::Nearest }
}

impl Painter<'_> {
    /// What the texels of some blocks are to hold.
    fn extent(&self, counts: impl Fn(&Block) -> bool + Sync, watch: &dyn Watch) -> Result<Extent> {
        let (layout, level) = (self.channel.layout, self.channel.numbering.level);
        let width = layout.sizes[level][0] as usize;
        let of_row = |scratch: &mut Scratch, row: &layout::Band| -> Result<Extent> {
            watch::check(watch)?;
            let mut extent = Extent::NOTHING;
            let first_row = row.first_row as usize;
            let mut band = Band { sheet: Sheet::Extent(&mut extent), codec: self.codec, width, first_row };
            for block in self.blocks(row).filter(|block| counts(block)) {
                self.paint_block(&mut band, block, scratch);
            }
            Ok(extent)
        };
        let rows = layout.bands[level].par_iter();
        let extents: Vec<_> = rows.map_init(Scratch::default, of_row).collect::<Result<_>>()?;
        Ok(extents.into_iter().fold(Extent::NOTHING, Extent::join))
    }
}
