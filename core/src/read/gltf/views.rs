//! Buffer views: stretches of buffers, held against the bytes that are there.

use super::super::json::At;
use crate::error::Result;

/// `offset + length` lies inside the buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub buffer: usize,
    pub offset: usize,
    pub length: usize,
    pub stride: Option<usize>,
}

pub(super) fn read(root: &At, buffers: &[Vec<u8>]) -> Result<Vec<View>> {
    root.objects("bufferViews")?.iter().map(|at| read_one(at, buffers)).collect()
}

fn read_one(at: &At, buffers: &[Vec<u8>]) -> Result<View> {
    let buffer = at.need_index("buffer", buffers.len(), "buffers")?;
    let offset = at.size("byteOffset")?.unwrap_or(0);
    let length = at.need_size("byteLength")?;
    let available = buffers[buffer].len();
    if offset.checked_add(length).is_none_or(|end| end > available) {
        return Err(at.error(format!(
            "{length} bytes from byte {offset} reach past the end of buffer {buffer}, which has {available}"
        )));
    }
    let stride = at.size("byteStride")?;
    if let Some(stride) = stride
        && !((4..=252).contains(&stride) && stride.is_multiple_of(4))
    {
        return Err(at.error(format!("byteStride {stride} is not a multiple of 4 in 4..=252")));
    }
    Ok(View { buffer, offset, length, stride })
}
