//! Alpha coverage: a masked material keeps its share of visible surface from level to level.
//!
//! Averaging moves alpha towards the middle, so the share above the cutoff drifts. Each level's alpha is
//! scaled so that the share of level 0 passes the test again (I. Castaño, "Computing alpha mipmaps", 2010).

use glam::Vec4;

/// Scales beyond this change the picture more than they save.
const SCALE_MAX: f32 = 4.0;

/// Area share of the samples whose alpha passes `cutoff`.
pub fn coverage(values: &[Vec4], areas: &[f32], cutoff: f32) -> f32 {
    let total: f32 = areas.iter().sum();
    let passing: f32 = values.iter().zip(areas).filter(|(v, _)| v.w >= cutoff).map(|(_, a)| a).sum();
    if total > 0.0 { passing / total } else { 0.0 }
}

/// Scales alpha so that the share `wanted` passes `cutoff`, as nearly as whole samples and a factor between
/// 1/4 and 4 allow.
pub fn keep_coverage(values: &mut [Vec4], areas: &[f32], cutoff: f32, wanted: f32) {
    if cutoff <= 0.0 || wanted <= 0.0 || wanted >= 1.0 {
        return;
    }
    let mut order: Vec<u32> = (0..values.len() as u32).collect();
    order.sort_by(|&a, &b| values[b as usize].w.total_cmp(&values[a as usize].w).then(a.cmp(&b)));
    let target = wanted * areas.iter().sum::<f32>();
    let mut sum = 0.0;
    let last_passing = order.iter().find(|&&sample| {
        sum += areas[sample as usize];
        sum >= target
    });
    let Some(&sample) = last_passing else { return };
    let scale = (cutoff / values[sample as usize].w.max(1e-6)).clamp(1.0 / SCALE_MAX, SCALE_MAX);
    values.iter_mut().for_each(|value| value.w = (value.w * scale).min(1.0));
}
