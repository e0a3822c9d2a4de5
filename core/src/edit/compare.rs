//! Two pictures on two surfaces, held against each other.

use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::colors::{LevelNumbering, Shape};
use crate::error::{Error, Result};
use crate::filter::{Level, MeshColors, Triangles};
use crate::math::transfer::linear_to_srgb;
use crate::watch::Watch;

use super::nearest::{Place, Surface};
use super::painting::PaintedChannel;
use super::side::{Side, Spot, spots};
use super::transfer::TransferError;

/// A channel's samples on a model.
pub struct Picture<'a> {
    pub side: &'a Side<'a>,
    pub level: &'a Level<'a>,
}

/// Samples as they are filtered (MC 4.1).
pub fn filtered<'a>(level: &'a [Level<'a>; 1]) -> Result<MeshColors<'a>> {
    MeshColors::new(level, Triangles::Linear)
        .ok_or_else(|| Error::internal("samples do not fit their numbering"))
}

/// `pictures` and `surfaces`: source and target.
pub fn errors(
    channel: &PaintedChannel,
    pictures: &[Picture<'_>; 2],
    surfaces: &[Surface; 2],
    watch: &dyn Watch,
) -> Result<TransferError> {
    let [source, target] = pictures;
    let in_cells = cell_middles(target.level.numbering);
    let at_samples = spots(source.level.numbering);
    let on_target = differences(channel, [target, source], &surfaces[0], &in_cells, watch)?;
    let on_source = differences(channel, [source, target], &surfaces[1], &at_samples, watch)?;
    Ok(TransferError {
        slots: channel.slots.iter().map(|slot| slot.gltf_name().to_owned()).collect(),
        unit: if channel.is_normal() { "degrees" } else { "codes" },
        on_target_rms: rms(&on_target),
        on_target_max: on_target.iter().copied().fold(0.0, f64::max),
        on_source_rms: rms(&on_source),
        on_source_max: on_source.iter().copied().fold(0.0, f64::max),
    })
}

/// The middle of every cell; of a triangle's of those that are whole, and of the halves.
fn cell_middles(numbering: &LevelNumbering<'_>) -> Vec<Spot> {
    let mut spots = Vec::new();
    for face in 0..numbering.canvas.faces.len() {
        let shape: Shape = numbering.shape(face);
        for j in 0..shape.segments[1] {
            let count = shape.cell_count(j);
            for i in 0..count {
                let offset = if shape.is_triangle && i + 1 == count { 1.0 / 3.0 } else { 0.5 };
                let at =
                    [(i, 0), (j, 1)].map(|(cell, axis)| (cell as f32 + offset) / shape.segments[axis] as f32);
                spots.push(Spot { face: face as u32, at });
            }
        }
    }
    spots
}

/// At spots of the first picture, against the nearest places of the second, whose surface is given.
fn differences(
    channel: &PaintedChannel,
    [one, other]: [&Picture<'_>; 2],
    surface: &Surface,
    spots: &[Spot],
    watch: &dyn Watch,
) -> Result<Vec<f64>> {
    let places = other.side.nearest_to(surface, one.side, spots, watch)?;
    let (own, others) = ([*one.level], [*other.level]);
    let (own, others) = (filtered(&own)?, filtered(&others)?);
    let difference = |(spot, place): (&Spot, &Place)| {
        let shown = own.linear(spot.face as usize, spot.at.into(), 0);
        let found = others.linear(place.face as usize, place.at, 0);
        if channel.is_normal() {
            let turned = other.side.turned(found, place.face, one.side, spot.face);
            return f64::from(shown.xyz().angle_between(turned.xyz()).to_degrees());
        }
        let is_color = channel.slots.iter().any(|slot| slot.is_color());
        let code = |value: Vec4| {
            let value =
                if channel.value_scale.is_none() { value.clamp(Vec4::ZERO, Vec4::ONE) } else { value };
            if is_color { value.xyz().map(linear_to_srgb).extend(value.w) } else { value }
        };
        f64::from((code(shown) - code(found)).abs().max_element()) * 255.0
    };
    Ok(spots.par_iter().zip(&places).map(difference).collect())
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
