//! What the bundle takes from the shaders crate: the text of the sampling functions and the picture.
//! Nothing else in this crate touches it.

use meshcolor::pipeline::Conversion;

/// The seam-check sheet, and what drew it.
pub struct Sheet {
    pub png: Vec<u8>,
    pub renderer: String,
}

/// Draws the sheet of a conversion.
///
/// # Errors
/// Whatever kept the renderer from drawing; a conversion is complete without its picture.
pub fn draw(_conversion: &Conversion) -> anyhow::Result<Sheet> {
    anyhow::bail!("this build has no preview renderer")
}

/// The sampling functions that users paste into their shaders.
pub fn wgsl() -> Option<&'static str> {
    None
}
