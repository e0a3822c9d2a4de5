//! Alpha coverage: a masked material keeps its share of visible surface from level to level.
//!
//! Averaging moves alpha towards the middle, so the share above the cutoff drifts. Each level's alpha is
//! scaled so that the share of level 0 passes the test again (I. Castaño, "Computing alpha mipmaps", 2010).
//! The share is that of the surface, alpha being interpolated between samples, not that of the samples.

use glam::Vec4;
use rayon::prelude::*;

use crate::colors::{FaceGrid, LevelNumbering};

/// Scales beyond this change the picture more than they save.
const SCALE_MAX: f32 = 4.0;
/// Points along a face's side are at least this many.
const POINTS_PER_SIDE: u32 = 16;

/// Alpha at a point of the surface, and the area that the point stands for.
type AlphaPoint = (f32, f32);

/// Area share of the surface whose alpha passes `cutoff`.
pub fn coverage(numbering: &LevelNumbering<'_>, values: &[Vec4], cutoff: f32) -> f32 {
    let points = alpha_points(numbering, values);
    let total: f64 = points.iter().map(|point| f64::from(point.1)).sum();
    let passing: f64 = points.iter().filter(|point| point.0 >= cutoff).map(|point| f64::from(point.1)).sum();
    if total > 0.0 { (passing / total) as f32 } else { 0.0 }
}

/// Scales alpha so that the share `wanted` of the surface passes `cutoff`, as nearly as a factor between 1/4
/// and 4 allows.
pub fn keep_coverage(numbering: &LevelNumbering<'_>, values: &mut [Vec4], cutoff: f32, wanted: f32) {
    if cutoff <= 0.0 || wanted <= 0.0 || wanted >= 1.0 {
        return;
    }
    let mut points = alpha_points(numbering, values);
    points.par_sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)));
    let target = f64::from(wanted) * points.iter().map(|point| f64::from(point.1)).sum::<f64>();
    let mut sum = 0.0;
    let last_passing = points.iter().find(|point| {
        sum += f64::from(point.1);
        sum >= target
    });
    let Some(&(alpha, _)) = last_passing else { return };
    let scale = (cutoff / alpha.max(1e-6)).clamp(1.0 / SCALE_MAX, SCALE_MAX);
    values.iter_mut().for_each(|value| value.w = (value.w * scale).min(1.0));
}

/// Points on an even grid over every face, in face order.
fn alpha_points(numbering: &LevelNumbering<'_>, values: &[Vec4]) -> Vec<AlphaPoint> {
    let faces = 0..numbering.canvas.faces.len();
    let by_face = faces.into_par_iter().map_init(FaceGrid::default, |grid, face| {
        numbering.fill(face, values, grid);
        let side = grid.segments * POINTS_PER_SIDE.div_ceil(grid.segments);
        let area = numbering.canvas.faces[face].area / (side * side) as f32;
        face_points(grid, side, area)
    });
    by_face.flatten_iter().collect()
}

/// Middles of `side * side` squares; on a triangle those beyond the diagonal are left out, and those on it
/// count half.
fn face_points(grid: &FaceGrid, side: u32, area: f32) -> Vec<AlphaPoint> {
    let mut points = Vec::with_capacity((side * side) as usize);
    for y in 0..side {
        for x in 0..side {
            let share = match (grid.is_triangle, (x + y + 1).cmp(&side)) {
                (false, _) => 1.0,
                (true, std::cmp::Ordering::Less) => 2.0,
                (true, std::cmp::Ordering::Equal) => 1.0,
                (true, std::cmp::Ordering::Greater) => continue,
            };
            let at = |v: u32| (v as f32 + 0.5) * grid.segments as f32 / side as f32;
            points.push((grid.alpha(at(x), at(y)), area * share));
        }
    }
    points
}
