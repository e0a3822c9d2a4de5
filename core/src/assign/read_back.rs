//! What is left of the samples of a level in a range: read from the image as a sampler does, against what was to be
//! stored. What the solver did to samples that no range is wide enough for is told apart from it.

use glam::{Vec2, Vec4};
use rayon::prelude::*;

use crate::colors::{Shape, Tap};
use crate::image::{Image, LevelRange, Transfer};
use crate::math::transfer::{linear_to_srgb, srgb_slope};

use super::{LevelChannel, LevelValues};

/// The change of every sample in codes, the largest of the stored components counting: of one with
/// faces beyond vertex colors the largest of what they show there, of any other its rounding.
pub fn read_back(
    channel: &LevelChannel<'_>,
    values: &LevelValues,
    image: &Image,
    range: &LevelRange,
) -> Vec<f64> {
    let mut is_stored = Vec4::ZERO;
    channel.codec.stored().iter().for_each(|&component| is_stored[component] = 1.0);
    let change = |found: Vec4, wanted: Vec4| {
        f64::from((difference(channel.codec.transfer, found, wanted) * is_stored).max_element() * 255.0)
    };
    let of_copy = |value: Vec4| change(range.round(value), value);
    let mut changes: Vec<f64> = match channel.frames {
        None => values.samples.par_iter().map(|value| of_copy(*value)).collect(),
        Some(_) => of_versions(channel, values, of_copy),
    };
    let numbering = channel.numbering;
    for (face, canvas_face) in numbering.canvas.faces.iter().enumerate() {
        if !channel.layout.is_beyond(channel.layout.block(face), numbering.level) {
            continue;
        }
        let shape = numbering.shape(face);
        let [start, i_end, j_end] =
            [0, 1, canvas_face.count() - 1].map(|corner| channel.layout.place(face, corner, numbering.level));
        // Corners alone, or the ends of columns.
        for (i, j) in points(shape) {
            let tap = numbering.tap(face, i, j);
            if tap.second == 0.0 {
                let [s, t] = shape.unit(i, j);
                let wanted = channel.stored(face, values.value(tap), s, t).as_vec4();
                let place = start + (i_end - start) * s + (j_end - start) * t;
                let changed = &mut changes[tap.samples[0] as usize];
                *changed = changed.max(change(bilinear(image, range, place), wanted));
            }
        }
    }
    changes
}

/// Normals up to vertex colors: each face stores a version of its own, and the one that changes most counts.
fn of_versions(channel: &LevelChannel<'_>, values: &LevelValues, change: impl Fn(Vec4) -> f64) -> Vec<f64> {
    let numbering = channel.numbering;
    let mut changes = vec![0.0f64; values.samples.len()];
    for face in 0..numbering.canvas.faces.len() {
        if channel.layout.is_beyond(channel.layout.block(face), numbering.level) {
            continue;
        }
        let shape = numbering.shape(face);
        for (i, j) in points(shape) {
            let Tap { samples: [sample, _], second } = numbering.tap(face, i, j);
            if second == 0.0 {
                let [s, t] = shape.unit(i, j);
                let value = values.samples[sample as usize].as_dvec4();
                let changed = &mut changes[sample as usize];
                *changed = changed.max(change(channel.stored(face, value, s, t).as_vec4()));
            }
        }
    }
    changes
}

/// All points of a face's grid.
fn points(shape: Shape) -> impl Iterator<Item = (u32, u32)> {
    (0..=shape.segments[1]).flat_map(move |j| (0..shape.point_count(j)).map(move |i| (i, j)))
}

/// How far the components of two values are apart, as shares of the code range.
#[inline]
fn difference(transfer: Transfer, found: Vec4, wanted: Vec4) -> Vec4 {
    let difference = (found - wanted).abs();
    if transfer == Transfer::Linear || difference == Vec4::ZERO {
        return difference;
    }
    let mut coded = difference;
    for k in (0..3).filter(|&k| difference[k] > 0.0) {
        let middle = 0.5 * (found[k] + wanted[k]);
        coded[k] = if difference[k] * 64.0 > middle {
            (linear_to_srgb(found[k]) - linear_to_srgb(wanted[k])).abs()
        } else {
            // So near to each other the slope between them says it better than what is left of two codes.
            difference[k] * srgb_slope(middle)
        };
    }
    coded
}

fn bilinear(image: &Image, range: &LevelRange, at_texels: Vec2) -> Vec4 {
    let corner = (at_texels - 0.5).max(Vec2::ZERO);
    let part = corner.fract();
    let first = corner.as_uvec2();
    let texel = |dx: u32, dy: u32| {
        range.texel(image, (first.x + dx).min(image.width - 1), (first.y + dy).min(image.height - 1))
    };
    texel(0, 0).lerp(texel(1, 0), part.x).lerp(texel(0, 1).lerp(texel(1, 1), part.x), part.y)
}
