//! The libraries that make blocks: `bc7e` (BC7), Intel's ISPC kernels (BC5, BC6H), `astcenc` (ASTC).
//!
//! An image goes in strips of whole rows of blocks, in parallel; blocks do not depend on one another.

use std::ffi::c_void;

use ctt_astcenc::bindings::{astcenc_image, astcenc_type_ASTCENC_TYPE_U8};
use ctt_astcenc::{Context, Flags, Preset, Profile, Swizzle, config_init};
use ctt_bc7enc_rdo as bc7e;
use ctt_intel_texture_compressor::{RgSurface, RgbaF16Surface, bc5, bc6h};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image::Transfer;

use super::blocks::{BLOCK_BYTES, BlockFormat, SIDE, TEXELS};

/// Rows of blocks in a strip. `astcenc` makes tables for each, so not too few.
const STRIP_ROWS: usize = 32;

/// An image of whole blocks: RGBA of 8 bits for BC7 and ASTC, RG for BC5, RGBA of half floats for BC6H.
pub struct Whole {
    pub bytes: Vec<u8>,
    pub size: [u32; 2],
    pub transfer: Transfer,
}

impl Whole {
    /// The image with its last column and row repeated.
    pub fn padded(bytes: &[u8], [width, height]: [u32; 2], transfer: Transfer) -> Self {
        let size = [width, height].map(|side| side.next_multiple_of(SIDE as u32));
        let texel_bytes = bytes.len() / (width as usize * height as usize);
        let row_bytes = texel_bytes * width as usize;
        let mut whole = Vec::with_capacity(texel_bytes * size[0] as usize * size[1] as usize);
        for y in 0..size[1].min(height + SIDE as u32) {
            let row = &bytes[y.min(height - 1) as usize * row_bytes..][..row_bytes];
            whole.extend_from_slice(row);
            for _ in width..size[0] {
                whole.extend_from_slice(&row[row_bytes - texel_bytes..]);
            }
        }
        Self { bytes: whole, size, transfer }
    }

    /// The blocks, row by row from the top.
    ///
    /// # Errors
    /// `Internal` where the library refuses the image.
    pub fn encoded(&self, format: BlockFormat) -> Result<Vec<u8>> {
        let [width, height] = self.size;
        let columns = width as usize / SIDE;
        let row_bytes = self.bytes.len() / height as usize;
        let mut blocks = vec![0; columns * (height as usize / SIDE) * BLOCK_BYTES];
        let strips = blocks.par_chunks_mut(columns * BLOCK_BYTES * STRIP_ROWS);
        let strips = strips.zip(self.bytes.par_chunks(row_bytes * SIDE * STRIP_ROWS));
        strips
            .try_for_each(|(blocks, texels)| {
                let rows = (texels.len() / row_bytes) as u32;
                match format {
                    BlockFormat::Bc5 => {
                        bc5::compress_blocks_into(&RgSurface::new(texels, width, rows, 2 * width), blocks);
                    }
                    BlockFormat::Bc6h => {
                        let surface = RgbaF16Surface::new(texels, width, rows, 8 * width);
                        bc6h::compress_blocks_into(&bc6h::basic_settings(), &surface, blocks);
                    }
                    BlockFormat::Bc7 => bc7(texels, columns, blocks),
                    BlockFormat::Astc => astc(texels, [width, rows], self.transfer, blocks)?,
                }
                Ok(())
            })
            .map(|()| blocks)
    }
}

fn bc7(texels: &[u8], columns: usize, blocks: &mut [u8]) {
    let texel = |at: usize| u32::from_ne_bytes([texels[at], texels[at + 1], texels[at + 2], texels[at + 3]]);
    let width = columns * SIDE;
    let by_block: Vec<u32> = (0..blocks.len() / BLOCK_BYTES)
        .flat_map(|block| {
            let (x, y) = (block % columns * SIDE, block / columns * SIDE);
            (0..TEXELS).map(move |k| 4 * ((y + k / SIDE) * width + x + k % SIDE))
        })
        .map(texel)
        .collect();
    let mut words = vec![0u64; blocks.len() / size_of::<u64>()];
    // Every code counts as much, not what an eye sees of it: a seam shows by its worst component.
    bc7e::compress_blocks(&mut words, &by_block, &bc7e::params_init_basic(false));
    for (bytes, word) in blocks.chunks_exact_mut(size_of::<u64>()).zip(words) {
        bytes.copy_from_slice(&word.to_ne_bytes());
    }
}

fn astc(texels: &[u8], size: [u32; 2], transfer: Transfer, blocks: &mut [u8]) -> Result<()> {
    // The library reads through a pointer that it could write through, so it gets a copy.
    let mut texels = texels.to_vec();
    with_image(&mut texels, size, |image| context(transfer)?.compress(image, Swizzle::IDENTITY, blocks))
}

/// Whole rows of ASTC blocks to RGBA of 8 bits.
///
/// # Errors
/// `Internal` where the library refuses the blocks.
pub fn astc_decoded(blocks: &[u8], columns: usize, transfer: Transfer) -> Result<Vec<u8>> {
    let rows = blocks.len() / BLOCK_BYTES / columns;
    let mut texels = vec![0; blocks.len() / BLOCK_BYTES * TEXELS * 4];
    let size = [columns * SIDE, rows * SIDE].map(|side| side as u32);
    with_image(&mut texels, size, |image| context(transfer)?.decompress(blocks, image, Swizzle::IDENTITY))?;
    Ok(texels)
}

fn context(transfer: Transfer) -> std::result::Result<Context, ctt_astcenc::Error> {
    let profile = if transfer == Transfer::Srgb { Profile::LdrSrgb } else { Profile::Ldr };
    let side = SIDE as u32;
    Context::new(&config_init(profile, side, side, 1, Preset::Medium, Flags::SELF_DECOMPRESS_ONLY)?)
}

fn with_image(
    texels: &mut [u8],
    [width, height]: [u32; 2],
    run: impl FnOnce(&mut astcenc_image) -> std::result::Result<(), ctt_astcenc::Error>,
) -> Result<()> {
    let mut slice = texels.as_mut_ptr().cast::<c_void>();
    let mut image = astcenc_image {
        dim_x: width,
        dim_y: height,
        dim_z: 1,
        data_type: astcenc_type_ASTCENC_TYPE_U8,
        data: &mut slice,
    };
    run(&mut image).map_err(|error| Error::internal(format!("ASTC: {error}")))
}
