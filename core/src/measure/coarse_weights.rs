//! Filtering as most GPUs do it: the fractions between texel centers are rounded to 8 bits. Up to vertex
//! colors that is nothing; beyond them the texels around a face lie far apart in value, and the error grows
//! with each level, whatever format holds them.

use glam::Vec2;

use super::edges::EdgePair;
use super::surface::Surface;

/// The weights of a bilinear fetch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weights {
    /// In 32 bits.
    Exact,
    /// Multiples of 1/256.
    EightBits,
}

const STEPS: f32 = 256.0;

impl Weights {
    /// The place that is filtered for one that is asked for, both in texels.
    #[inline]
    pub fn place(self, asked: Vec2) -> Vec2 {
        match self {
            Self::Exact => asked,
            // Texel centers lie at halves, themselves multiples of a step.
            Self::EightBits => (asked * STEPS).round() / STEPS,
        }
    }
}

/// Whether a pair has a face beyond vertex colors on a side at that level, and texels there that were
/// extrapolated from its corners. With indexed coordinates none are.
pub fn is_beyond(surface: &Surface<'_>, pair: &EdgePair, level: usize) -> bool {
    [&pair.a, &pair.b].into_iter().any(|side| {
        let part = surface.part(side);
        part.coordinates.is_extrapolated(&part.placed[side.triangle as usize], level)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_move_by_half_a_step_at_most() {
        assert_eq!(Weights::Exact.place(Vec2::new(3.217, 0.1)), Vec2::new(3.217, 0.1));
        assert_eq!(Weights::EightBits.place(Vec2::new(7.5, 0.25)), Vec2::new(7.5, 0.25));
        assert_eq!(Weights::EightBits.place(Vec2::new(1.0 + 0.6 / 256.0, 0.0)).x, 1.0 + 1.0 / 256.0);
    }
}
