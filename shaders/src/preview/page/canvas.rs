//! The sheet's pixels.

use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

use crate::preview::PreviewError;

/// An sRGB color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ink(pub [u8; 3]);

/// Where an arrowhead points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    Down,
    Up,
    Right,
}

pub struct Canvas {
    pub size: [u32; 2],
    rgb: Vec<u8>,
}

/// Left, top, width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
}

impl Canvas {
    pub fn new(size: [u32; 2], paper: Ink) -> Self {
        let pixel_count = size[0] as usize * size[1] as usize;
        Self { size, rgb: paper.0.repeat(pixel_count) }
    }

    /// Lays ink over a pixel; what is off the sheet is left out.
    pub fn blend(&mut self, x: i64, y: i64, ink: Ink, share: f32) {
        let inside = (0..i64::from(self.size[0])).contains(&x) && (0..i64::from(self.size[1])).contains(&y);
        if !inside {
            return;
        }
        let at = 3 * (y as usize * self.size[0] as usize + x as usize);
        for (code, ink) in self.rgb[at..at + 3].iter_mut().zip(ink.0) {
            let mixed = f32::from(*code) * (1.0 - share) + f32::from(ink) * share;
            *code = (mixed + 0.5) as u8;
        }
    }

    pub fn fill(&mut self, area: Area, ink: Ink) {
        for y in area.top..area.top + area.height {
            for x in area.left..area.left + area.width {
                self.blend(i64::from(x), i64::from(y), ink, 1.0);
            }
        }
    }

    /// Copies a picture; `color` gives each pixel by its number.
    pub fn place(&mut self, area: Area, color: impl Fn(usize) -> [u8; 3]) {
        for y in 0..area.height {
            for x in 0..area.width {
                let ink = Ink(color(y as usize * area.width as usize + x as usize));
                self.blend(i64::from(area.left + x), i64::from(area.top + y), ink, 1.0);
            }
        }
    }

    /// A small arrowhead with its tip at `tip`.
    pub fn arrow(&mut self, tip: [f32; 2], points: Points, ink: Ink) {
        const HALF_WIDTH: f32 = 5.0;
        const HEIGHT: f32 = 7.0;
        const STEPS: i32 = 4;
        let side = HALF_WIDTH.max(HEIGHT) as i64 + 1;
        let (x0, y0) = (tip[0] as i64, tip[1] as i64);
        for y in y0 - side..=y0 + side {
            for x in x0 - side..=x0 + side {
                let mut inside = 0;
                for step in 0..STEPS * STEPS {
                    let part = |n: i32| (n as f32 + 0.5) / STEPS as f32;
                    let dx = x as f32 + part(step % STEPS) - tip[0];
                    let dy = y as f32 + part(step / STEPS) - tip[1];
                    let (behind, aside) = match points {
                        Points::Down => (-dy, dx),
                        Points::Up => (dy, dx),
                        Points::Right => (-dx, dy),
                    };
                    let is_inside =
                        (0.0..=HEIGHT).contains(&behind) && aside.abs() <= HALF_WIDTH * behind / HEIGHT;
                    inside += i32::from(is_inside);
                }
                self.blend(x, y, ink, inside as f32 / (STEPS * STEPS) as f32);
            }
        }
    }

    /// # Errors
    /// `Encode` where the encoder refuses.
    pub fn png(&self) -> Result<Vec<u8>, PreviewError> {
        let mut bytes = Vec::new();
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
            .write_image(&self.rgb, self.size[0], self.size[1], image::ExtendedColorType::Rgb8)
            .map_err(|error| PreviewError::Encode(error.to_string()))?;
        Ok(bytes)
    }
}
