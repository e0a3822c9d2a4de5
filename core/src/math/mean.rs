//! Weighted means of colors in which alpha has a say.

use glam::{Vec4, Vec4Swizzles};

/// What a sample without alpha counts for in the mean of a color: nothing, unless all are so.
pub const TRANSPARENT_WEIGHT: f32 = 1e-5;

/// A running mean of values `(r, g, b, a)`. With `by_alpha` the color is weighted by alpha, so that what is
/// transparent has no vote; the result is straight (not premultiplied).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WeightedMean {
    /// Color by `color_weight`, alpha by `weight`.
    sum: Vec4,
    color_weight: f32,
    weight: f32,
}

impl WeightedMean {
    pub fn add(&mut self, value: Vec4, weight: f32, by_alpha: bool) {
        if by_alpha {
            let color_weight = weight * (value.w + TRANSPARENT_WEIGHT);
            self.sum += value * Vec4::splat(color_weight).with_w(weight);
            self.color_weight += color_weight;
        } else {
            self.sum += value * weight;
            self.color_weight += weight;
        }
        self.weight += weight;
    }

    /// Adds another mean's samples with their weights times `factor`.
    pub fn merge(&mut self, other: &Self, factor: f32) {
        self.sum += other.sum * factor;
        self.color_weight += other.color_weight * factor;
        self.weight += other.weight * factor;
    }

    pub fn weight(&self) -> f32 {
        self.weight
    }

    /// The mean, or zero where nothing was added.
    pub fn mean(&self) -> Vec4 {
        if self.weight > 0.0 && self.color_weight > 0.0 {
            (self.sum.xyz() / self.color_weight).extend(self.sum.w / self.weight)
        } else {
            Vec4::ZERO
        }
    }
}
