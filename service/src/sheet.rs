//! What the bundle takes from the shaders crate: the text of the sampling functions and the picture.
//! Nothing else in this crate touches it.

use meshcolor::pipeline::Conversion;
pub use meshcolor_shaders::preview::Sheet;

/// Draws the sheet of a conversion, under the name of the model's file.
///
/// # Errors
/// Whatever kept the renderer from drawing; a conversion is complete without its picture.
pub fn draw(conversion: &Conversion, title: &str) -> anyhow::Result<Sheet> {
    Ok(meshcolor_shaders::preview::sheet_titled(conversion, title)?)
}

/// The font that pictures are set in.
pub const FONT: &[u8] = meshcolor_shaders::FONT;

/// The sampling functions that users paste into their shaders.
pub fn wgsl() -> &'static str {
    meshcolor_shaders::WGSL
}
