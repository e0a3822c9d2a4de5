//! The normals that the mesh shows without its normal map, at every sample.
//!
//! A normal map is filtered as what it adds to them, `D = N - G`: a level shows `G + D` with `D` filtered
//! and `G` the mesh's own. Filtering `N` itself would turn the normals of a whole model into one, level by
//! level, which no face could store in frames that go on turning; and it isn't what mip maps of a tangent-
//! space map do, whose coarse levels end in the mesh's own normals too.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::assign::NormalFrames;
use crate::colors::LevelNumbering;
use crate::mesh::{Side, drawn_corners, surface_point};

/// `N` to `D`: takes the mesh's own normals from samples.
pub fn take_bare(numbering: &LevelNumbering<'_>, frames: &NormalFrames, normals: &mut [Vec4]) {
    with_bare(numbering, frames, normals, |normal, bare| *normal -= bare);
}

/// `D` to what a level shows: unit vectors along `G + D`, or `G` where that vanishes, with w = 1.
pub fn show(numbering: &LevelNumbering<'_>, frames: &NormalFrames, added: &mut [Vec4]) {
    with_bare(numbering, frames, added, |added, bare| {
        *added = (bare + added.with_w(0.0)).try_normalize().unwrap_or(bare).with_w(1.0);
    });
}

/// Visits every sample with its `G`: a unit vector with w = 0, interpolated over the face, and the mean of what its
/// faces show where several share it.
fn with_bare(
    numbering: &LevelNumbering<'_>,
    frames: &NormalFrames,
    values: &mut [Vec4],
    visit: impl Fn(&mut Vec4, Vec4) + Sync,
) {
    let [fans, strips, inner] = numbering.parts(values);
    fans.par_iter_mut().with_min_len(256).enumerate().for_each(|(fan, value)| {
        let corners = numbering.topology.corners(fan).iter();
        let normals =
            corners.map(|&(face, corner)| frames.corners[face as usize][usize::from(corner)].normal);
        visit(value, mean(normals));
    });
    numbering.by_strip(strips).into_par_iter().with_min_len(64).for_each(|(strip, values)| {
        along_strip(numbering, frames, strip, values, &visit);
    });
    numbering.by_face(inner).into_par_iter().with_min_len(16).for_each(|(face, values)| {
        inside(numbering, frames, face, values, &visit);
    });
}

/// Opposite normals, as of coincident sheets, have no mean: the first one stands for them.
fn mean(normals: impl Iterator<Item = Vec3> + Clone) -> Vec4 {
    let sum: Vec3 = normals.clone().map(Vec3::normalize_or_zero).sum();
    sum.try_normalize().or_else(|| normals.into_iter().next()).unwrap_or(Vec3::Z).extend(0.0)
}

fn along_strip(
    numbering: &LevelNumbering<'_>,
    frames: &NormalFrames,
    strip: usize,
    values: &mut [Vec4],
    visit: impl Fn(&mut Vec4, Vec4),
) {
    let canvas = numbering.canvas;
    let sides = numbering.topology.sides(&numbering.topology.strips[strip]);
    let segments = numbering.strip_segments(strip);
    for (step, value) in (1..segments).zip(values) {
        let share = step as f32 / segments as f32;
        let of_side = |&side: &Side| {
            let at = |end| frames.corners[side.face as usize][canvas.corner_at_end(side, end)].normal;
            at(0).lerp(at(1), share)
        };
        visit(value, mean(sides.iter().map(of_side)));
    }
}

fn inside(
    numbering: &LevelNumbering<'_>,
    frames: &NormalFrames,
    face: usize,
    values: &mut [Vec4],
    visit: impl Fn(&mut Vec4, Vec4),
) {
    let canvas_face = &numbering.canvas.faces[face];
    let shape = numbering.shape(face);
    let corners = frames.corners[face].map(|frame| frame.normal.extend(0.0));
    let at = |i: u32, j: u32| {
        let [s, t] = shape.unit(i, j);
        let (triangle, weights) = surface_point(canvas_face.count(), s, t);
        let of = drawn_corners(triangle);
        corners[of[0]] * weights.x + corners[of[1]] * weights.y + corners[of[2]] * weights.z
    };
    let mut values = values.iter_mut();
    let [n, m] = shape.segments;
    for j in shape.inner_rows() {
        // One triangle of the face after the other: on each the row is affine.
        let turn = if shape.is_triangle { 1 } else { (j * n).div_ceil(m) };
        for (first, end) in [(1, turn), (turn, shape.cell_count(j))] {
            let Some(count) = end.checked_sub(first).filter(|&count| count > 0) else { continue };
            let start = at(first, j);
            let step = (at(end - 1, j) - start) / (count - 1).max(1) as f32;
            for (value, i) in values.by_ref().take(count as usize).zip(0u32..) {
                let normal = start + step * i as f32;
                visit(value, normal.try_normalize().unwrap_or(corners[0]));
            }
        }
    }
}

#[cfg(test)]
mod tests;
