//! A finished picture, and what draws one.

use super::PreviewError;
use super::scene::Shot;
use super::scene::texture::Texture;

/// What stands behind the model.
pub const BACKGROUND_SRGB: [u8; 3] = [38, 40, 44];

/// sRGB codes, three a pixel, row 0 at the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    pub size: [u32; 2],
    pub rgb: Vec<u8>,
}

/// What draws shots. Both renderers agree within a few codes (tested).
pub trait Renderer {
    /// What the sheet says about it.
    fn label(&self) -> String;

    /// # Errors
    /// `Device` where the adapter refuses or is lost.
    fn draw(&mut self, textures: &[Texture<'_>], shot: &Shot<'_>) -> Result<Picture, PreviewError>;
}

/// The largest difference over the components of each pixel, in codes.
pub fn differences(a: &Picture, b: &Picture) -> Vec<u8> {
    let pixels = a.rgb.chunks_exact(3).zip(b.rgb.chunks_exact(3));
    pixels.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)).collect()
}
