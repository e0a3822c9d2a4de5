//! PNG from SVG, with the font that the program carries and none of the system's.

use std::io::Cursor;
use std::sync::Arc;

use anyhow::Context;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use resvg::{tiny_skia, usvg};

/// Draws a document at its own size.
///
/// # Errors
/// Where the document is no SVG or has no size.
pub fn png(svg: &str) -> anyhow::Result<Vec<u8>> {
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(crate::sheet::FONT.to_vec());
    let options = usvg::Options { fontdb: Arc::new(fonts), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(svg, &options)?;
    let size = tree.size().to_int_size();
    let mut picture =
        tiny_skia::Pixmap::new(size.width(), size.height()).context("a picture without a size")?;
    resvg::render(&tree, tiny_skia::Transform::identity(), &mut picture.as_mut());
    // Every picture has a background, so nothing is transparent.
    let rgb: Vec<u8> = picture.data().chunks_exact(4).flat_map(|rgba| [rgba[0], rgba[1], rgba[2]]).collect();
    let mut file = Cursor::new(Vec::new());
    PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive).write_image(
        &rgb,
        size.width(),
        size.height(),
        ExtendedColorType::Rgb8,
    )?;
    Ok(file.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Style, Svg, ink};

    /// Pixels that are not the background.
    fn inked(words: &str) -> usize {
        let mut svg = Svg::new(200.0, 40.0, "");
        svg.text([10.0, 30.0], Style::new(24.0, ink::TEXT), words);
        let picture = image::load_from_memory(&png(&svg.finish()).unwrap()).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (200, 40));
        picture.pixels().filter(|pixel| pixel.0 != [0x15, 0x17, 0x1a]).count()
    }

    #[test]
    fn words_are_drawn_without_fonts_of_the_system() {
        assert_eq!(inked(""), 0);
        assert!(inked("standard 1.3 s") > 300);
    }

    #[test]
    fn the_font_has_the_signs_that_pictures_use() {
        for sign in ["×", "·", "…", "µ", "%", "ü", "−"] {
            let blank = inked("\u{e123}");
            assert!(inked(sign) != blank && inked(sign) > 5, "{sign}");
        }
    }
}
