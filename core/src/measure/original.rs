//! What a conversion is held against at a point of the surface: the source's image, or its mesh colors.

use super::judge::Meaning;
use super::origin::Origin;
use super::painted::PaintedOrigin;
use crate::finished::Frame;

#[derive(Clone, Copy)]
pub enum Original<'a> {
    Image(&'a Origin<'a>),
    Painted(&'a PaintedOrigin<'a>),
}

impl Original<'_> {
    pub fn meaning(&self) -> Meaning {
        match self {
            Original::Image(origin) => origin.meaning,
            Original::Painted(painted) => painted.meaning,
        }
    }

    /// How many components the material shows.
    pub fn components(&self) -> u8 {
        match self {
            Original::Image(origin) => origin.components,
            Original::Painted(painted) => painted.channel.components,
        }
    }

    /// Frames whose normals are the mesh's own at the corners of a triangle, where the channel holds normals.
    pub fn corner_frames(&self, part: usize, triangle: usize) -> Option<&[Frame; 3]> {
        match self {
            Original::Image(origin) => origin.corner_frames(part, triangle),
            Original::Painted(painted) => painted.corner_frames(part, triangle),
        }
    }
}
