//! Which levels ask for a range, and for which: by the values that their texels would store.

use rayon::prelude::*;

use crate::error::Result;
use crate::image::LevelRange;
use crate::layout::Block;
use crate::watch::{self, Watch};

use super::Painter;
use super::band::{Band, Extent, Sheet};
use super::up_to_vertex::Scratch;
use crate::assign::codec::LevelCodec;
use crate::assign::{LevelChannel, LevelValues, Range, Rounding};

/// A level is worth a range of its own where it has more texels beyond vertex colors that leave [0, 1] than
/// this share of its samples. Up to there the solver leaves 95 % of the samples as they are.
const OUTSIDE_SHARE: f64 = 0.05;
/// 16 bits that span more than this are too coarse for what shows in between. Faces that ask for more have
/// slopes that no filter with weights of few bits could follow either: such a level is solved.
const VALUE_MAX: f32 = 8.0;

/// The range that a level is stored in; `None` where it stays as the source has it: in the bounded format,
/// where every face is up to its vertex colors, where few texels leave [0, 1] and where some leave it too
/// far. With a range nothing is to be solved.
///
/// Level 0 has none: no face is beyond vertex colors there.
///
/// # Errors
/// `Canceled`.
pub fn choose_range(
    channel: &LevelChannel<'_>,
    values: &LevelValues,
    range: Range,
    watch: &dyn Watch,
) -> Result<Option<LevelRange>> {
    let codec = LevelCodec { plain: channel.codec, range: None };
    let painter = Painter { channel, values, codec, rounding: Rounding::Nearest };
    if range == Range::Unorm8 || !channel.layout.blocks.iter().any(|block| painter.is_beyond(block)) {
        return Ok(None);
    }
    let beyond = painter.extent(true, watch)?;
    if beyond.outside_count as f64 <= OUTSIDE_SHARE * channel.numbering.sample_count() as f64 {
        return Ok(None);
    }
    // Half floats hold whatever the texels up to vertex colors may be.
    let is_float = range == Range::Float16;
    let all = if is_float { beyond } else { beyond.join(painter.extent(false, watch)?) };
    if all.low.abs().max(all.high.abs()).max_element() > VALUE_MAX {
        return Ok(None);
    }
    Ok(Some(if is_float { LevelRange::Float16 } else { LevelRange::spanning(all.low, all.high) }))
}

impl Painter<'_> {
    /// What all texels beyond vertex colors are to hold, or those up to there.
    fn extent(&self, is_beyond: bool, watch: &dyn Watch) -> Result<Extent> {
        let layout = self.channel.layout;
        let width = layout.sizes[self.channel.numbering.level][0] as usize;
        let rows: Vec<_> = layout.rows().collect();
        let of_row = |scratch: &mut Scratch, blocks: &[Block]| -> Result<Extent> {
            watch::check(watch)?;
            let mut extent = Extent::NOTHING;
            let first_row = blocks[0].corner(self.channel.numbering.level).y as usize;
            let mut band = Band { sheet: Sheet::Extent(&mut extent), codec: self.codec, width, first_row };
            for block in blocks.iter().filter(|block| self.is_beyond(block) == is_beyond) {
                self.paint_block(&mut band, block, scratch);
            }
            Ok(extent)
        };
        let extents: Vec<_> =
            rows.into_par_iter().map_init(Scratch::default, of_row).collect::<Result<_>>()?;
        Ok(extents.into_iter().fold(Extent::NOTHING, Extent::join))
    }
}
