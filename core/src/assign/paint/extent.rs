//! Which levels ask for a range, and for which: by the values that their texels would store.

use glam::Vec4;

use crate::error::Result;
use crate::image::LevelRange;
use crate::watch::Watch;

use super::band::Sheet;
use super::{Painter, Row};
use crate::assign::codec::LevelCodec;
use crate::assign::{LevelChannel, LevelValues, Range, Rounding};

/// As much outside of [0, 1] is rounding, as the solver sees it.
const TOLERANCE: f32 = 1e-6;

/// The range that a level is stored in; `None` where it stays as the source has it: in the bounded
/// format, where every face is up to its vertex colors, and where all texels lie in [0, 1]. With a range
/// nothing is to be solved.
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
    let level = channel.numbering.level;
    let is_beyond = channel.layout.blocks.iter().any(|block| block.segments >> level == 0);
    if range == Range::Unorm8 || !is_beyond {
        return Ok(None);
    }
    let [low, high] = extent(channel, values, watch)?;
    let leaves = |&component: &usize| low[component] < -TOLERANCE || high[component] > 1.0 + TOLERANCE;
    if !channel.codec.stored().iter().any(leaves) {
        return Ok(None);
    }
    Ok(match range {
        Range::Unorm8 => None,
        Range::Scaled16 => Some(LevelRange::spanning(low, high)),
        Range::Float16 => Some(LevelRange::Float16),
    })
}

/// The least and the largest value of all texels, by component.
fn extent(channel: &LevelChannel<'_>, values: &LevelValues, watch: &dyn Watch) -> Result<[Vec4; 2]> {
    const NOTHING: [Vec4; 2] = [Vec4::INFINITY, Vec4::NEG_INFINITY];
    let layout = channel.layout;
    let ends = layout.row_starts.iter().skip(1).copied().chain([layout.blocks.len()]);
    let spans = layout.row_starts.iter().copied().zip(ends);
    let mut extents = vec![[NOTHING]; layout.row_starts.len()];
    let rows = spans.zip(&mut extents).map(|((start, end), extent)| Row {
        blocks: &layout.blocks[start..end],
        codes: extent,
        first_row: layout.blocks[start].corner(channel.numbering.level).y as u32,
    });
    let codec = LevelCodec { plain: channel.codec, range: None };
    let painter = Painter { channel, values, codec, rounding: Rounding::Nearest };
    painter.paint(rows.collect(), |extents| Sheet::Extent(extents), watch)?;
    let join = |[low, high]: [Vec4; 2], [[l, h]]: [[Vec4; 2]; 1]| [low.min(l), high.max(h)];
    Ok(extents.into_iter().fold(NOTHING, join))
}
