//! How many levels there are: down to where all that a material covers is about one texel.

use glam::Vec3;

use crate::mesh::CanvasMesh;

use super::Resolutions;

/// No level beyond this is asked for: its texels are a million times as wide as those of level 0.
pub const LEVEL_MAX: usize = 20;

/// The number of levels: to the first at which the diagonal of the box around the faces is at most one
/// texel. A texel of level 0 is the side of a mean cell, and `2^level` times that at a level.
///
/// Every face reaches vertex colors in any case. Each mesh is looked at in its own space and the one of
/// most levels counts: where its instances stand says how small one of them may be drawn, not how large all
/// of them are together.
pub fn level_count(canvas: &CanvasMesh, resolutions: &Resolutions) -> usize {
    let mut last = usize::from(resolutions.max());
    let mut first = 0;
    for faces in canvas.faces.chunk_by(|a, b| a.mesh == b.mesh) {
        let mut extent = Extent::default();
        for (face, &[r, s]) in faces.iter().zip(&resolutions.faces[first..]) {
            let squares = if face.is_triangle() { 0.5 } else { 1.0 };
            extent.area += f64::from(face.area);
            extent.cells += squares * f64::from(r + s).exp2();
            for &vertex in &face.vertices[..face.count()] {
                extent.low = extent.low.min(canvas.positions[vertex as usize]);
                extent.high = extent.high.max(canvas.positions[vertex as usize]);
            }
        }
        first += faces.len();
        last = last.max(extent.level_of_one_texel().min(LEVEL_MAX));
    }
    last + 1
}

struct Extent {
    low: Vec3,
    high: Vec3,
    area: f64,
    cells: f64,
}

impl Default for Extent {
    fn default() -> Self {
        Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, area: 0.0, cells: 0.0 }
    }
}

impl Extent {
    /// 0 where there is no area to measure a texel by.
    fn level_of_one_texel(&self) -> usize {
        let texels = (self.high.as_dvec3() - self.low.as_dvec3()).length() / (self.area / self.cells).sqrt();
        if texels.is_finite() { texels.log2().ceil().max(0.0) as usize } else { 0 }
    }
}
