//! Typeset words: one anti-aliased font, kerned, placed on a baseline.

use ab_glyph::{Font, FontRef, PxScale, PxScaleFont, ScaleFont};

use super::canvas::{Canvas, Ink};
use crate::FONT;
use crate::preview::PreviewError;

/// The font, once for a sheet.
pub struct Typeface {
    font: FontRef<'static>,
}

/// How words look.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Pixels from the top of a tall letter's line to its bottom.
    pub height: f32,
    /// Pixels added between letters.
    pub spacing: f32,
    pub ink: Ink,
}

impl Typeface {
    /// # Errors
    /// `Font` where the font that is built in cannot be read.
    pub fn new() -> Result<Self, PreviewError> {
        let font = FontRef::try_from_slice(FONT).map_err(|error| PreviewError::Font(error.to_string()))?;
        Ok(Self { font })
    }

    /// Width of a line in pixels.
    pub fn width(&self, words: &str, style: Style) -> f32 {
        self.walk(words, style, |_, _, _| {})
    }

    /// Draws a line whose baseline starts at `at`, and says where it ended.
    pub fn draw(&self, canvas: &mut Canvas, at: [f32; 2], words: &str, style: Style) -> f32 {
        let width = self.walk(words, style, |font, letter, x| {
            let position = ab_glyph::point(at[0] + x, at[1]);
            let glyph = font.scaled_glyph(letter);
            let glyph = ab_glyph::Glyph { position, ..glyph };
            let Some(outline) = font.outline_glyph(glyph) else { return };
            let bounds = outline.px_bounds();
            outline.draw(|dx, dy, share| {
                let [x, y] = [bounds.min.x as i64 + i64::from(dx), bounds.min.y as i64 + i64::from(dy)];
                canvas.blend(x, y, style.ink, share.min(1.0));
            });
        });
        at[0] + width
    }

    /// Draws a line that ends at `at`.
    pub fn draw_right(&self, canvas: &mut Canvas, at: [f32; 2], words: &str, style: Style) {
        let start = at[0] - self.width(words, style);
        self.draw(canvas, [start, at[1]], words, style);
    }

    /// The longest beginning of `words` that fits, with an ellipsis where something was left out.
    pub fn fitted(&self, words: &str, width: f32, style: Style) -> String {
        if self.width(words, style) <= width {
            return words.to_owned();
        }
        let letters: Vec<char> = words.chars().collect();
        let shortened = |count: usize| letters[..count].iter().collect::<String>() + "…";
        // Names of files can be of any length: halve, do not count down.
        let fits = |count: &usize| self.width(&shortened(*count), style) <= width;
        let (mut low, mut high) = (0, letters.len());
        while low < high {
            let middle = (low + high).div_ceil(2);
            if fits(&middle) { low = middle } else { high = middle - 1 }
        }
        shortened(low)
    }

    fn walk(
        &self,
        words: &str,
        style: Style,
        mut visit: impl FnMut(&PxScaleFont<&FontRef<'static>>, char, f32),
    ) -> f32 {
        let font = self.font.as_scaled(PxScale::from(style.height));
        let mut x = 0.0;
        let mut before = None;
        for letter in words.chars().map(|letter| self.printable(letter)) {
            let id = font.glyph_id(letter);
            x += before.map_or(0.0, |before| font.kern(before, id));
            visit(&font, letter, x);
            x += font.h_advance(id) + style.spacing;
            before = Some(id);
        }
        (x - style.spacing).max(0.0)
    }

    /// A letter that the font lacks shows as a dot.
    fn printable(&self, letter: char) -> char {
        if letter.is_control() {
            ' '
        } else if self.font.glyph_id(letter).0 == 0 {
            '·'
        } else {
            letter
        }
    }
}
