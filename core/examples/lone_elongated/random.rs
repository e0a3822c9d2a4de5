//! Numbers that are the same in every run.

use glam::DVec3;

/// A linear congruential generator.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed ^ 0x9E37_79B9_7F4A_7C15)
    }

    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }

    /// Three in [0, 1).
    pub fn values(&mut self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.unit()))
    }
}
