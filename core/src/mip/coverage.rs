//! Alpha coverage: a masked material keeps its share of visible surface from level to level.
//!
//! Averaging moves alpha towards the middle, so the share above the cutoff drifts. Each level's alpha is
//! scaled so that the share of level 0 passes the test again (I. Castaño, "Computing alpha mipmaps", 2010).
//! The share is that of the surface, alpha being interpolated between samples, not that of the samples.

use glam::Vec4;

use crate::colors::{FaceGrid, LevelNumbering};
use crate::error::Result;
use crate::watch::{self, Watch};

/// Scales beyond this change the picture more than they save.
const SCALE_MAX: f32 = 4.0;
/// Halvings of the span of factors: down to a thousandth.
const STEPS: usize = 11;
/// What rounding to 8 bits may change.
const HALF_CODE: f32 = 0.5 / 255.0;
/// Points along a face's side are at least this many.
const POINTS_PER_SIDE: u32 = 16;

/// Area of the surface by alpha, in this many equal steps from 0 to 1.
const BINS: usize = 1 << 16;

/// Area share of the surface whose alpha passes `cutoff`.
pub fn coverage(
    numbering: &LevelNumbering<'_>,
    values: &[Vec4],
    cutoff: f32,
    watch: &dyn Watch,
) -> Result<f32> {
    let areas = areas_by_alpha(numbering, values, watch)?;
    let total: f64 = areas.iter().sum();
    // Above 1 nothing passes, whatever alpha is.
    let passing: f64 = if cutoff > 1.0 { 0.0 } else { areas[bin(cutoff)..].iter().sum() };
    Ok(if total > 0.0 { (passing / total) as f32 } else { 0.0 })
}

/// Scales alpha so that the share `wanted` of the surface passes `cutoff`, as nearly as a factor between 1/4
/// and 4 allows.
pub fn keep_coverage(
    numbering: &LevelNumbering<'_>,
    values: &mut [Vec4],
    (cutoff, wanted): (f32, f32),
    watch: &dyn Watch,
) -> Result<()> {
    if cutoff <= 0.0 || wanted <= 0.0 || wanted >= 1.0 {
        return Ok(());
    }
    let scaled = |scale: f32| -> Vec<Vec4> {
        values.iter().map(|value| value.with_w((value.w * scale).min(1.0))).collect()
    };
    // Alpha ends at 1, so what lies between two samples does not scale as they do: the factor is looked for.
    let (mut low, mut high) = (1.0 / SCALE_MAX, SCALE_MAX);
    let mut best = (f32::INFINITY, 1.0, false);
    for _ in 0..STEPS {
        let scale = (low * high).sqrt();
        let share = coverage(numbering, &scaled(scale), cutoff, watch)?;
        let apart = (share - wanted).abs();
        if apart < best.0 {
            best = (apart, scale, share >= wanted);
        }
        if share < wanted {
            low = scale;
        } else {
            high = scale;
        }
    }
    let (_, scale, is_over) = best;
    // What passes is to pass once it is stored, too.
    let scale = scale * if is_over { 1.0 + HALF_CODE / cutoff } else { 1.0 };
    values.iter_mut().for_each(|value| value.w = (value.w * scale).min(1.0));
    Ok(())
}

fn bin(alpha: f32) -> usize {
    (alpha.clamp(0.0, 1.0) * (BINS - 1) as f32) as usize
}

/// Points on an even grid over every face, in face order, counted by their alpha.
fn areas_by_alpha(numbering: &LevelNumbering<'_>, values: &[Vec4], watch: &dyn Watch) -> Result<Vec<f64>> {
    let mut areas = vec![0.0; BINS];
    let mut grid = FaceGrid::default();
    for face in 0..numbering.canvas.faces.len() {
        watch::check(watch)?;
        numbering.fill(face, values, &mut grid);
        let sides = grid.shape.segments.map(|segments| segments * POINTS_PER_SIDE.div_ceil(segments));
        let squares = f64::from(sides[0]) * f64::from(sides[1]);
        count_face(&grid, sides, f64::from(numbering.canvas.faces[face].area) / squares, &mut areas);
    }
    Ok(areas)
}

/// Middles of equal rectangles, so many a side; on a triangle those beyond the diagonal are left out, and those on it
/// count half.
fn count_face(grid: &FaceGrid, [columns, rows]: [u32; 2], area: f64, areas: &mut [f64]) {
    let [n, m] = grid.shape.segments;
    for y in 0..rows {
        for x in 0..columns {
            let share = match (grid.shape.is_triangle, (x + y + 1).cmp(&columns)) {
                (false, _) => 1.0,
                (true, std::cmp::Ordering::Less) => 2.0,
                (true, std::cmp::Ordering::Equal) => 1.0,
                (true, std::cmp::Ordering::Greater) => continue,
            };
            let at = |v: u32, side: u32, segments: u32| (v as f32 + 0.5) * segments as f32 / side as f32;
            areas[bin(grid.alpha(at(x, columns, n), at(y, rows, m)))] += area * share;
        }
    }
}
