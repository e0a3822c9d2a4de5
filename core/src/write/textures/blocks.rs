//! Levels in blocks of 4 × 4 texels that a GPU decodes as it samples: BC5, BC6H, BC7, ASTC.
//!
//! | format | levels that it fits |
//! |---|---|
//! | `bc5` | 8-bit data of two components; normal maps of 8 bits: x and y, z follows from the unit length |
//! | `bc6h` | those in a range of their own, without alpha |
//! | `bc7`, `astc` | 8 bits, any number of components |
//!
//! What none of the formats asked for fits stays as it is. A level is a texture of its own, and GPUs want
//! whole blocks there, so its last column and row are repeated up to a multiple of four.

use std::collections::BTreeSet;

use glam::Vec4;
use half::f16;
use ktx2::Format;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image::{Image, LevelRange, Pixels, Transfer};

use super::Level;
use super::encoders::{Whole, astc_decoded};
use super::gpu::{Texels, colors, half_floats, numbers};

/// Texels along the side of a block.
pub const SIDE: usize = 4;
pub const TEXELS: usize = SIDE * SIDE;
pub const BLOCK_BYTES: usize = 16;

const RGBA: [usize; 4] = [0, 1, 2, 3];

/// A format of blocks. Where several fit a level, the first is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BlockFormat {
    Bc5,
    Bc6h,
    Bc7,
    Astc,
}

impl BlockFormat {
    /// As the options and reports name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bc5 => "bc5",
            Self::Bc6h => "bc6h",
            Self::Bc7 => "bc7",
            Self::Astc => "astc",
        }
    }

    fn vulkan(self, transfer: Transfer) -> Format {
        match (self, transfer) {
            (Self::Bc5, _) => Format::BC5_UNORM_BLOCK,
            (Self::Bc6h, _) => Format::BC6H_UFLOAT_BLOCK,
            (Self::Bc7, Transfer::Srgb) => Format::BC7_SRGB_BLOCK,
            (Self::Bc7, Transfer::Linear) => Format::BC7_UNORM_BLOCK,
            (Self::Astc, Transfer::Srgb) => Format::ASTC_4x4_SRGB_BLOCK,
            (Self::Astc, Transfer::Linear) => Format::ASTC_4x4_UNORM_BLOCK,
        }
    }

    fn fits(self, level: &Level<'_>) -> bool {
        let components = level.image.components;
        let has_codes = matches!(level.image.pixels, Pixels::U8(_));
        match self {
            Self::Bc5 => {
                let is_pair = components == 2 && level.transfer == Transfer::Linear;
                has_codes && (is_pair || (level.is_normal && components >= 3))
            }
            Self::Bc6h => level.range.is_some() && !level.image.has_alpha(),
            Self::Bc7 | Self::Astc => has_codes,
        }
    }
}

/// A level in blocks.
#[derive(Clone)]
pub struct Blocks {
    pub format: BlockFormat,
    /// The blocks, row by row from the top, with the size that they cover.
    pub(super) texels: Texels,
    /// What a sampler adds to the decoded value: BC6H has no sign here.
    bias: Vec4,
}

impl Blocks {
    pub fn bytes(&self) -> u64 {
        self.texels.bytes.len() as u64
    }

    /// The level in the first of the formats that fits it.
    ///
    /// # Errors
    /// `Internal` where the library refuses the level.
    pub(super) fn encode(level: &Level<'_>, formats: &BTreeSet<BlockFormat>) -> Result<Option<Self>> {
        let Some(format) = formats.iter().copied().find(|format| format.fits(level)) else { return Ok(None) };
        let image = level.image;
        let codes: &[u8] = if let Pixels::U8(codes) = &image.pixels { codes } else { &[] };
        let mut bias = Vec4::ZERO;
        let mut keys = vec![("MCTsize", format!("{} {}", image.width, image.height))];
        let bytes: Vec<u8> = match format {
            BlockFormat::Bc6h => {
                let mut values = level.values();
                bias = least(&values);
                keys.extend([("MCTbias", numbers(&RGBA, &bias)), ("MCTscale", numbers(&RGBA, &Vec4::ONE))]);
                values.iter_mut().for_each(|value| *value -= bias);
                half_floats(&values)
            }
            BlockFormat::Bc5 => {
                if image.components == 2 {
                    keys.push(("KTXswizzle", "rrrg".to_owned()));
                }
                let texels = codes.chunks_exact(usize::from(image.components));
                texels.flat_map(|texel| [texel[0], texel[1]]).collect()
            }
            BlockFormat::Bc7 | BlockFormat::Astc => colors(codes, image.components),
        };
        let whole = Whole::padded(&bytes, image.size(), level.transfer);
        let bytes = whole.encoded(format)?;
        let texels = Texels { format: format.vulkan(level.transfer), size: whole.size, bytes, keys };
        Ok(Some(Self { format, texels, bias }))
    }

    /// What a GPU reads from the blocks: the image and its range. Gray comes back as color, because its
    /// components differ now. Of normals in BC5 the image holds z too, by the unit length of each texel.
    ///
    /// # Errors
    /// `Internal` where there are not as many blocks as the size asks for.
    pub(super) fn decode(&self, level: &Level<'_>) -> Result<(Image, Option<LevelRange>)> {
        let [width, height] = level.image.size();
        let columns = (self.texels.size[0] as usize).div_ceil(SIDE);
        let rows = (self.texels.size[1] as usize).div_ceil(SIDE);
        if self.texels.bytes.len() != columns * rows * BLOCK_BYTES {
            return Err(Error::internal("a level has another number of blocks than its size"));
        }
        let components = match (self.format, level.image.components) {
            (BlockFormat::Bc5, 2) => 2,
            (BlockFormat::Bc5 | BlockFormat::Bc6h, _) | (_, 1 | 3) => 3,
            _ => 4,
        };
        let image = |pixels: Pixels| Image { width, height, components: components as u8, pixels };
        let blocks =
            Tiles { blocks: &self.texels.bytes, columns, width: width as usize, height: height as usize };
        Ok(match self.format {
            BlockFormat::Bc7 => {
                let codes = blocks.texels(components, |block, out: &mut [[u8; 4]; TEXELS]| {
                    bcdec_rs::bc7(block, out.as_flattened_mut(), SIDE * 4);
                });
                (image(Pixels::U8(codes)), None)
            }
            BlockFormat::Astc => {
                let codes = astc_decoded(&self.texels.bytes, columns, level.transfer)?;
                let rows = codes.chunks_exact(columns * SIDE * 4).take(height as usize);
                let texels = rows.flat_map(|row| row.chunks_exact(4).take(width as usize));
                let codes = texels.flat_map(|texel| &texel[..components]).copied().collect();
                (image(Pixels::U8(codes)), None)
            }
            BlockFormat::Bc5 => {
                let codes = blocks.texels(components, |block, out: &mut [[u16; 4]; TEXELS]| {
                    let mut pairs = [[0.0f32; 2]; TEXELS];
                    bcdec_rs::bc5_float(block, pairs.as_flattened_mut(), SIDE * 2, false);
                    let code = |value: f32| (value.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16;
                    *out = pairs.map(|[x, y]| [code(x), code(y), code(unit_z(x, y)), 0]);
                });
                (image(Pixels::U16(codes)), None)
            }
            BlockFormat::Bc6h => {
                let codes = blocks.texels(components, |block, out: &mut [[u16; 4]; TEXELS]| {
                    let mut halves = [[0u16; 3]; TEXELS];
                    bcdec_rs::bc6h_half(block, halves.as_flattened_mut(), SIDE * 3, false);
                    let value = |half: u16, k: usize| {
                        f16::from_f32(f16::from_bits(half).to_f32() + self.bias[k]).to_bits()
                    };
                    *out =
                        halves.map(|[red, green, blue]| [value(red, 0), value(green, 1), value(blue, 2), 0]);
                });
                (image(Pixels::U16(codes)), Some(LevelRange::Float16))
            }
        })
    }
}

/// Blocks that cover an image.
struct Tiles<'a> {
    blocks: &'a [u8],
    columns: usize,
    width: usize,
    height: usize,
}

impl Tiles<'_> {
    /// The first `components` of every texel of the image, each block by `decode`.
    fn texels<T: Copy + Default + Send>(
        &self,
        components: usize,
        decode: impl Fn(&[u8], &mut [[T; 4]; TEXELS]) + Sync,
    ) -> Vec<T> {
        let row_codes = self.width * components;
        let mut codes = vec![T::default(); row_codes * self.height];
        let rows =
            codes.par_chunks_mut(row_codes * SIDE).zip(self.blocks.par_chunks(self.columns * BLOCK_BYTES));
        rows.for_each(|(lines, blocks)| {
            let mut texels = [[T::default(); 4]; TEXELS];
            for (column, block) in blocks.chunks_exact(BLOCK_BYTES).enumerate() {
                decode(block, &mut texels);
                let places = column * SIDE..self.width.min((column + 1) * SIDE);
                for (line, texels) in lines.chunks_exact_mut(row_codes).zip(texels.chunks_exact(SIDE)) {
                    for (x, texel) in places.clone().zip(texels) {
                        line[x * components..][..components].copy_from_slice(&texel[..components]);
                    }
                }
            }
        });
        codes
    }
}

/// The z of a unit normal, all three as glTF stores them.
fn unit_z(x: f32, y: f32) -> f32 {
    let [x, y] = [x, y].map(|stored| 2.0 * stored - 1.0);
    0.5 + 0.5 * (1.0 - x * x - y * y).max(0.0).sqrt()
}

/// Of red, green and blue the least value, where it is below 0.
fn least(values: &[Vec4]) -> Vec4 {
    values.iter().copied().fold(Vec4::ZERO, Vec4::min).truncate().extend(0.0)
}
