//! Image files to planes: PNG, JPEG, WebP and Basis Universal, told by their first bytes, sizes checked before decoding, each
//! file decoded once however often it is named.

use std::collections::HashMap;
use std::io::Cursor;

use image::{
    DynamicImage, ImageDecoder, codecs::jpeg::JpegDecoder, codecs::png::PngDecoder, codecs::webp::WebPDecoder,
};
use rayon::prelude::*;

use super::basis;
use super::budget::with_pixels;
use super::image_header::{self, Header};
use super::{Context, Limits, image_header::Format};
use crate::asset::EncodedImage;
use crate::error::{Error, ErrorCode, Result};
use crate::image::{Image, Pixels};
use crate::watch;

/// Memory that a decoder may use besides the picture: rows, text and profile chunks.
const DECODER_EXTRA_BYTES: u64 = 16 << 20;

/// Whether an image is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    No,
    /// Once for all images that are the same file, at the place of the first.
    Shared,
    /// At its own place, copied there where it is not the first of its kind.
    InPlace,
}

/// All images of a model by index.
pub(super) struct Decoded {
    /// Placeholders of one black texel where an image is not decoded.
    pub images: Vec<Image>,
    /// For each image the first one with the same bytes: the one that is decoded.
    pub canonical: Vec<usize>,
}

/// Decodes the images that are wanted, in parallel, with the same result in any order. `place` says
/// where in the model an image stands.
pub(super) fn decode_all(
    encoded: &[EncodedImage],
    wanted: &[Wanted],
    place: impl Fn(usize) -> String + Sync,
    context: &Context,
) -> Result<Decoded> {
    let (limits, watch) = (context.budget.limits, context.watch);
    let canonical = first_of_equals(encoded);
    let mut chosen = vec![false; encoded.len()];
    for (index, _) in wanted.iter().enumerate().filter(|(_, wanted)| **wanted != Wanted::No) {
        chosen[canonical[index]] = true;
    }
    let is_copy = |index: usize| wanted[index] == Wanted::InPlace && canonical[index] != index;
    let mut headers = Vec::new();
    let mut total_pixels = context.budget.pixels();
    for (index, file) in encoded.iter().enumerate().filter(|(index, _)| chosen[*index] || is_copy(*index)) {
        let header = checked_header(&file.bytes, limits, &place(index))?;
        total_pixels =
            with_pixels(total_pixels, header.pixels(), limits).map_err(|error| error.at(place(index)))?;
        if chosen[index] {
            headers.push((index, header));
        }
    }
    watch::check(watch)?;
    watch.step(Some("decode"));
    let decoded: Vec<Result<Image>> = headers
        .par_iter()
        .map(|&(index, header)| {
            watch::check(watch)?;
            decode(&encoded[index].bytes, header).map_err(|error| error.at(place(index)))
        })
        .collect();
    watch.step(None);
    let mut images = vec![placeholder(); encoded.len()];
    for ((index, _), image) in headers.into_iter().zip(decoded) {
        images[index] = image?;
    }
    for index in (0..images.len()).filter(|index| is_copy(*index)) {
        images[index] = images[canonical[index]].clone();
    }
    Ok(Decoded { images, canonical })
}

fn placeholder() -> Image {
    Image { width: 1, height: 1, components: 1, pixels: Pixels::U8(vec![0]) }
}

fn first_of_equals(encoded: &[EncodedImage]) -> Vec<usize> {
    let mut first = HashMap::new();
    encoded
        .iter()
        .enumerate()
        .map(|(index, file)| *first.entry(blake3::hash(&file.bytes)).or_insert(index))
        .collect()
}

/// The media type by first bytes, for the formats that are read.
pub(super) fn media_type_of(bytes: &[u8]) -> Option<&'static str> {
    image_header::format(bytes).map(|format| match format {
        Format::Png => "image/png",
        Format::Jpeg => "image/jpeg",
        Format::WebP => "image/webp",
        Format::Basis => "image/ktx2",
    })
}

fn checked_header(bytes: &[u8], limits: &Limits, pointer: &str) -> Result<Header> {
    let header = image_header::read(bytes).map_err(|error| error.at(pointer))?;
    check_size([header.width, header.height], limits, pointer)?;
    Ok(header)
}

/// Of an image that nothing was allocated for yet.
pub(super) fn check_size([width, height]: [u32; 2], limits: &Limits, pointer: &str) -> Result<()> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(Error::invalid("the image has a side of 0 pixels").at(pointer));
    }
    let too_large = |name: &str, limit: u64, actual: u64| {
        let detail =
            format!("the image is {width}x{height} ({pixels} pixels); the limit is {limit} (limit `{name}`)");
        Err(Error::new(ErrorCode::ImageTooLarge, detail).at(pointer).limit(limit, actual))
    };
    let side = width.max(height);
    if side > limits.image_side {
        return too_large("image_side", limits.image_side.into(), side.into());
    }
    if pixels > limits.image_pixels {
        return too_large("image_pixels", limits.image_pixels, pixels);
    }
    Ok(())
}

/// Decodes a file whose header was checked.
fn decode(bytes: &[u8], header: Header) -> Result<Image> {
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(header.width);
    limits.max_image_height = Some(header.height);
    limits.max_alloc = Some(header.pixels() * 8 + DECODER_EXTRA_BYTES);
    let picture = match header.format {
        Format::Png => {
            PngDecoder::with_limits(Cursor::new(bytes), limits).and_then(DynamicImage::from_decoder)
        }
        Format::Jpeg => JpegDecoder::new(Cursor::new(bytes)).and_then(|mut decoder| {
            decoder.set_limits(limits)?;
            DynamicImage::from_decoder(decoder)
        }),
        Format::WebP => WebPDecoder::new(Cursor::new(bytes)).and_then(|mut decoder| {
            decoder.set_limits(limits)?;
            DynamicImage::from_decoder(decoder)
        }),
        Format::Basis => return basis::decode(bytes),
    };
    let picture = picture.map_err(|error| Error::invalid(format!("the image cannot be decoded: {error}")))?;
    to_planes(picture)
}

fn to_planes(picture: DynamicImage) -> Result<Image> {
    let (width, height) = (picture.width(), picture.height());
    let (components, pixels) = match picture {
        DynamicImage::ImageLuma8(p) => (1, Pixels::U8(p.into_raw())),
        DynamicImage::ImageLumaA8(p) => (2, Pixels::U8(p.into_raw())),
        DynamicImage::ImageRgb8(p) => (3, Pixels::U8(p.into_raw())),
        DynamicImage::ImageRgba8(p) => (4, Pixels::U8(p.into_raw())),
        DynamicImage::ImageLuma16(p) => (1, Pixels::U16(p.into_raw())),
        DynamicImage::ImageLumaA16(p) => (2, Pixels::U16(p.into_raw())),
        DynamicImage::ImageRgb16(p) => (3, Pixels::U16(p.into_raw())),
        DynamicImage::ImageRgba16(p) => (4, Pixels::U16(p.into_raw())),
        other => {
            let detail = format!("the image has pixels of a kind that is not read: {:?}", other.color());
            return Err(Error::invalid(detail));
        }
    };
    Ok(Image { width, height, components, pixels })
}
