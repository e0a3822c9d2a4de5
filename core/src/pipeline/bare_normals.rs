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
use crate::mesh::surface_point;

/// `G` of every sample, unit vectors with w = 0: interpolated over the face, and the mean of what its faces
/// show where several share it.
pub fn bare_normals(numbering: &LevelNumbering<'_>, frames: &NormalFrames) -> Vec<Vec4> {
    let topology = numbering.topology;
    let mut normals = Vec::with_capacity(numbering.sample_count());
    normals.par_extend((0..topology.fan_count()).into_par_iter().map(|fan| {
        mean(
            topology
                .corners(fan)
                .iter()
                .map(|&(face, corner)| frames.corners[face as usize][usize::from(corner)].normal),
        )
    }));
    let strips =
        (0..topology.strips.len()).into_par_iter().map(|strip| along_strip(numbering, frames, strip));
    normals.extend(strips.collect::<Vec<_>>().into_iter().flatten());
    let interiors =
        (0..numbering.canvas.faces.len()).into_par_iter().map(|face| inside(numbering, frames, face));
    normals.extend(interiors.collect::<Vec<_>>().into_iter().flatten());
    normals
}

/// Opposite normals, as of coincident sheets, have no mean: the first one stands for them.
fn mean(normals: impl Iterator<Item = Vec3> + Clone) -> Vec4 {
    let sum: Vec3 = normals.clone().map(Vec3::normalize_or_zero).sum();
    sum.try_normalize().or_else(|| normals.into_iter().next()).unwrap_or(Vec3::Z).extend(0.0)
}

fn along_strip(numbering: &LevelNumbering<'_>, frames: &NormalFrames, strip: usize) -> Vec<Vec4> {
    let canvas = numbering.canvas;
    let sides = numbering.topology.sides(&numbering.topology.strips[strip]);
    let segments = numbering.strip_segments(strip);
    let at = |step: u32| {
        let share = step as f32 / segments as f32;
        mean(sides.iter().map(|&side| {
            let [low, high] =
                [0, 1].map(|end| frames.corners[side.face as usize][canvas.corner_at_end(side, end)].normal);
            low.lerp(high, share)
        }))
    };
    (1..segments).map(at).collect()
}

fn inside(numbering: &LevelNumbering<'_>, frames: &NormalFrames, face: usize) -> Vec<Vec4> {
    let canvas_face = &numbering.canvas.faces[face];
    let segments = numbering.segments(face);
    let scale = 1.0 / segments as f32;
    let corners = &frames.corners[face];
    let mut normals = Vec::with_capacity(numbering.face_range(face).len());
    for j in 1..segments {
        let end = if canvas_face.is_triangle() { segments - j } else { segments };
        normals.extend((1..end).map(|i| {
            let (of, weights) = surface_point(canvas_face.count(), i as f32 * scale, j as f32 * scale);
            let normal = corners[of[0]].normal * weights.x
                + corners[of[1]].normal * weights.y
                + corners[of[2]].normal * weights.z;
            normal.try_normalize().unwrap_or(corners[of[0]].normal).extend(0.0)
        }));
    }
    normals
}

/// Unit normals of what a level shows: `G + D`, or `G` where that vanishes.
pub fn shown(bare: &[Vec4], added: &[Vec4]) -> Vec<Vec4> {
    let one = |(bare, added): (&Vec4, &Vec4)| {
        let bare = bare.truncate();
        (bare + added.truncate()).try_normalize().unwrap_or(bare).extend(1.0)
    };
    bare.par_iter().zip(added).map(one).collect()
}

#[cfg(test)]
mod tests;
