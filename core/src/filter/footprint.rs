//! What a pixel covers of a face.

use glam::Vec2;

use crate::colors::Shape;

use super::cell::inside;

/// Probes of an anisotropic fetch at most; what is longer still goes to coarser levels.
pub const PROBES_MAX: u32 = 16;

/// So much longer than wide still counts as round, lest rounding ask for a probe more.
const ROUND: f32 = 1e-3;

/// How far `(s, t)` of a face moves from one pixel to the next: to the right, and down. Finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    pub axes: [Vec2; 2],
}

/// Where a footprint is looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probes {
    /// At least 1.
    pub count: u32,
    /// Level of each.
    pub lambda: f32,
    first: Vec2,
    step: Vec2,
}

impl Probes {
    pub fn places(&self) -> impl Iterator<Item = Vec2> + use<> {
        let Self { first, step, count, .. } = *self;
        (0..count).map(move |number| first + step * number as f32)
    }
}

impl Footprint {
    /// The level whose samples are as far apart as the longer axis is long.
    pub(super) fn lambda(&self, shape: Shape) -> f32 {
        let [(_, long), _] = self.by_length(shape);
        long.log2()
    }

    /// The axes with their lengths in samples of a grid, the longer one first.
    fn by_length(&self, shape: Shape) -> [(Vec2, f32); 2] {
        let [a, b] = self.axes.map(|axis| (axis, length(shape, axis)));
        if b.1 > a.1 { [b, a] } else { [a, b] }
    }

    /// The probes along the longer axis, inside the face of this grid.
    pub(super) fn probes(&self, shape: Shape, at: Vec2) -> Probes {
        let [(axis, long), (_, short)] = self.by_length(shape);
        // Without a length there is nothing to divide: 0 / 0 is one probe.
        let count = (long / short - ROUND).ceil().max(1.0).min(PROBES_MAX as f32);
        let lambda = (long / count).log2();
        if count == 1.0 {
            return Probes { count: 1, lambda, first: at, step: Vec2::ZERO };
        }
        let at = inside(shape.is_triangle, at);
        let [low, high] = inner_part(shape.is_triangle, at, axis);
        let count = (count * (high - low)).ceil().max(1.0);
        let step = (high - low) / count;
        Probes { count: count as u32, lambda, first: at + axis * (low + 0.5 * step), step: axis * step }
    }
}

/// In samples. A triangle counts as one with equal sides, so that its corners can be named in any order.
fn length(shape: Shape, axis: Vec2) -> f32 {
    let [n, m] = shape.segments.map(|segments| segments as f32);
    let Vec2 { x, y } = axis * Vec2::new(n, m);
    let skew = if shape.is_triangle { x * y } else { 0.0 };
    (x * x + y * y + skew).max(0.0).sqrt()
}

/// The part of -1/2 to 1/2 in which `at + part · axis` is in the face, where `at` is.
fn inner_part(is_triangle: bool, at: Vec2, axis: Vec2) -> [f32; 2] {
    let (sum, sum_step) = (at.x + at.y, axis.x + axis.y);
    let mut part = [-0.5f32, 0.5];
    let mut keep = |distance: f32, step: f32| {
        let end = -distance.max(0.0) / step;
        if step > 0.0 {
            part[0] = part[0].max(end);
        } else if step < 0.0 {
            part[1] = part[1].min(end);
        }
    };
    keep(at.x, axis.x);
    keep(at.y, axis.y);
    if is_triangle {
        keep(1.0 - sum, -sum_step);
    } else {
        keep(1.0 - at.x, -axis.x);
        keep(1.0 - at.y, -axis.y);
    }
    part
}
