//! Pictures of Basis Universal in KTX2, as `KHR_texture_basisu` has them: ETC1S and UASTC, level 0 to 8 bits.

mod container;

use basisu::{DecodeFlags, TargetFormat, Transcoder};

use super::image_header::{Format, Header};
use crate::error::{Error, Result};
use crate::image::{Image, Pixels};
use container::Container;
pub(super) use container::MARK;

pub(super) fn header(bytes: &[u8]) -> Result<Header> {
    let Container { width, height, .. } = Container::read(bytes)?;
    Ok(Header { format: Format::Basis, width, height })
}

/// Level 0, of three components where the file has no alpha, else of four.
pub(super) fn decode(bytes: &[u8]) -> Result<Image> {
    let container = Container::read(bytes)?;
    let alone = container.alone()?;
    let rgba = Transcoder::new(&alone)
        .and_then(|transcoder| transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE))
        .map_err(|error| Error::invalid(format!("the image cannot be decoded: {error:?}")))?;
    let (components, pixels) = if container.has_alpha {
        (4, rgba)
    } else {
        (3, rgba.chunks_exact(4).flat_map(|texel| [texel[0], texel[1], texel[2]]).collect())
    };
    let Container { width, height, .. } = container;
    Ok(Image { width, height, components, pixels: Pixels::U8(pixels) })
}
