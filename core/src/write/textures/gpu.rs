//! Texels as a GPU takes them.
//!
//! | level | format |
//! |---|---|
//! | color, 8 bits | `R8G8B8A8_SRGB`: GPUs filter sRGB of one, two or three components rarely or not at all |
//! | color, 16 bits | `R16G16B16A16_SFLOAT`, linear light: there is no sRGB of 16 bits |
//! | data, 8 or 16 bits | `UNORM` of one, two or four components; three get an alpha of 1 |
//! | range `scaled16` | `UNORM` of 16 bits, before scale and bias |
//! | range `float16` | `SFLOAT` of 16 bits |

use glam::Vec4;
use half::f16;
use ktx2::Format;

use crate::error::{Error, Result};
use crate::image::{LevelRange, Pixels, Transfer};

use super::Level;

/// The bytes of one level, rows from the top, without padding.
#[derive(Clone)]
pub struct Texels {
    pub format: Format,
    /// Width and height that the bytes are for.
    pub size: [u32; 2],
    pub bytes: Vec<u8>,
    /// What a reader has to know beside the format, as keys of KTX2.
    pub keys: Vec<(&'static str, String)>,
}

/// The code of an alpha that is 1.
const OPAQUE_8: u8 = u8::MAX;
const OPAQUE_16: u16 = u16::MAX;

pub fn texels(level: &Level<'_>) -> Result<Texels> {
    let components = level.image.components;
    if !(1..=4).contains(&components) {
        return Err(Error::internal(format!("an image has {components} components")));
    }
    let by_count = |formats: [Format; 3]| match components {
        1 => (formats[0], Some("rrr1")),
        2 => (formats[1], Some("rrrg")),
        _ => (formats[2], None),
    };
    // glTF's gray is red, green and blue.
    let ((format, swizzle), bytes) = match (&level.image.pixels, level.range, level.transfer) {
        (Pixels::U8(codes), _, Transfer::Srgb) => ((Format::R8G8B8A8_SRGB, None), colors(codes, components)),
        (Pixels::U8(codes), _, Transfer::Linear) => {
            let formats = [Format::R8_UNORM, Format::R8G8_UNORM, Format::R8G8B8A8_UNORM];
            (by_count(formats), padded(codes, components, OPAQUE_8))
        }
        (Pixels::U16(_), None, Transfer::Srgb) => {
            ((Format::R16G16B16A16_SFLOAT, None), half_floats(&level.values()))
        }
        (Pixels::U16(codes), Some(LevelRange::Float16), _) => {
            let formats = [Format::R16_SFLOAT, Format::R16G16_SFLOAT, Format::R16G16B16A16_SFLOAT];
            (by_count(formats), little_endian(&padded(codes, components, f16::ONE.to_bits())))
        }
        (Pixels::U16(codes), _, _) => {
            let formats = [Format::R16_UNORM, Format::R16G16_UNORM, Format::R16G16B16A16_UNORM];
            (by_count(formats), little_endian(&padded(codes, components, OPAQUE_16)))
        }
        (Pixels::F32(_), _, _) => return Err(Error::internal("a source's values are no level image")),
    };
    let mut keys: Vec<_> = swizzle.map(|swizzle| ("KTXswizzle", swizzle.to_owned())).into_iter().collect();
    if let Some(LevelRange::Scaled16 { scale, bias }) = level.range {
        let stored: &[usize] = match components {
            1 => &[0],
            2 => &[0, 3],
            _ => &[0, 1, 2, 3],
        };
        keys.extend([("MCTscale", numbers(stored, scale)), ("MCTbias", numbers(stored, bias))]);
    }
    keys.extend(level.value_scale.map(|scale| ("MCTvalueScale", scale.to_string())));
    Ok(Texels { format, size: level.image.size(), bytes, keys })
}

/// Some components with spaces between them.
pub fn numbers(components: &[usize], of: &Vec4) -> String {
    let numbers: Vec<String> = components.iter().map(|&component| of[component].to_string()).collect();
    numbers.join(" ")
}

/// Three components with an alpha of 1; others as they are.
fn padded<T: Copy>(codes: &[T], components: u8, opaque: T) -> Vec<T> {
    match components {
        3 => codes.chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], opaque]).collect(),
        _ => codes.to_vec(),
    }
}

/// Four components, whatever is stored.
pub fn colors(codes: &[u8], components: u8) -> Vec<u8> {
    let rgba = |texel: &[u8]| match *texel {
        [gray] => [gray, gray, gray, OPAQUE_8],
        [gray, alpha] => [gray, gray, gray, alpha],
        [red, green, blue] => [red, green, blue, OPAQUE_8],
        [red, green, blue, alpha, ..] => [red, green, blue, alpha],
        [] => [0; 4],
    };
    codes.chunks_exact(usize::from(components)).flat_map(rgba).collect()
}

/// Four half floats for each value.
pub(super) fn half_floats(values: &[Vec4]) -> Vec<u8> {
    let halves = values.iter().flat_map(|value| value.to_array()).map(f16::from_f32);
    halves.flat_map(f16::to_le_bytes).collect()
}

fn little_endian(codes: &[u16]) -> Vec<u8> {
    codes.iter().flat_map(|code| code.to_le_bytes()).collect()
}
