//! Which edges a channel does not join: where the source itself shows two values at full resolution.

use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::colors::Cuts;
use crate::error::Result;
use crate::image::Transfer;
use crate::math::transfer::linear_to_srgb;
use crate::mesh::{CanvasEdge, CanvasMesh, Side};
use crate::source::SurfaceSource;
use crate::watch::{self, Watch};

/// An edge whose difference exceeds the threshold in the mean, or this many times it at the 95th
/// percentile, is a cut.
const PEAK_FACTOR: f32 = 4.0;
/// Codes that stand for one degree between normals.
const CODES_PER_DEGREE: f32 = 2.0;
/// Points looked at along an edge, at least and at most; between, one for each source texel.
const POINTS: [f32; 2] = [9.0, 512.0];
/// Up to this many sides all pairs are compared; beyond, all with the first, at half the threshold.
const ALL_PAIRS_SIDES: usize = 8;

/// Finds the cuts of one channel. `threshold_codes` are 8-bit codes.
pub fn find_cuts(
    source: &SurfaceSource<'_>,
    canvas: &CanvasMesh,
    threshold_codes: f32,
    watch: &dyn Watch,
) -> Result<Cuts> {
    let is_cut = |edge: &CanvasEdge| -> Result<bool> {
        watch::check(watch)?;
        let sides = canvas.sides(edge);
        Ok(sides.len() > 1 && !agree(source, canvas, sides, threshold_codes, watch)?)
    };
    Ok(Cuts { edges: canvas.edges.par_iter().map(is_cut).collect::<Result<_>>()? })
}

fn agree(
    source: &SurfaceSource<'_>,
    canvas: &CanvasMesh,
    sides: &[Side],
    threshold: f32,
    watch: &dyn Watch,
) -> Result<bool> {
    let is_same = |&side: &Side| same_places(source, canvas, sides[0], side);
    if !source.channel.is_normal() && sides[1..].iter().all(is_same) {
        return Ok(true);
    }
    let point_count = sides.iter().map(|&side| length_texels(source, canvas, side)).fold(0.0, f32::max);
    let point_count = point_count.ceil().clamp(POINTS[0], POINTS[1]) as usize;
    if sides.len() <= ALL_PAIRS_SIDES {
        let profiles: Vec<Vec<Vec4>> =
            sides.iter().map(|&side| profile(source, canvas, side, point_count)).collect();
        let mut pairs = (0..sides.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        return Ok(pairs.all(|(a, b)| profiles_agree(source, &profiles[a], &profiles[b], threshold)));
    }
    let first = profile(source, canvas, sides[0], point_count);
    for &side in &sides[1..] {
        watch::check(watch)?;
        let other = profile(source, canvas, side, point_count);
        if !profiles_agree(source, &first, &other, threshold * 0.5) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Both ends of a side in texels, low end first.
fn ends(source: &SurfaceSource<'_>, canvas: &CanvasMesh, side: Side) -> [glam::Vec2; 2] {
    let places = source.places(side.face as usize);
    [places[canvas.corner_at_end(side, 0)], places[canvas.corner_at_end(side, 1)]]
}

fn same_places(source: &SurfaceSource<'_>, canvas: &CanvasMesh, a: Side, b: Side) -> bool {
    ends(source, canvas, a) == ends(source, canvas, b)
}

fn length_texels(source: &SurfaceSource<'_>, canvas: &CanvasMesh, side: Side) -> f32 {
    let [low, high] = ends(source, canvas, side);
    low.distance(high)
}

/// The source along a side from its low end, at the middles of equal pieces, as it is compared: codes,
/// or unit normals.
fn profile(source: &SurfaceSource<'_>, canvas: &CanvasMesh, side: Side, point_count: usize) -> Vec<Vec4> {
    let edge = usize::from(side.edge);
    let reversed = canvas.faces[side.face as usize].is_reversed(edge);
    let at = |point: usize| {
        let t = (point as f32 + 0.5) / point_count as f32;
        let t = if reversed { 1.0 - t } else { t };
        let value = source.along_edge(canvas, side.face as usize, edge, t);
        if source.channel.is_normal() {
            return value;
        }
        let color = match source.channel.transfer {
            Transfer::Srgb => value.xyz().map(linear_to_srgb),
            Transfer::Linear => value.xyz(),
        };
        (color * 255.0).extend(value.w * 255.0)
    };
    (0..point_count).map(at).collect()
}

fn profiles_agree(source: &SurfaceSource<'_>, a: &[Vec4], b: &[Vec4], threshold: f32) -> bool {
    let by_alpha = source.channel.is_alpha_weighted();
    let mut differences: Vec<f32> = (a.iter().zip(b))
        // What is transparent on one side has no color there and no vote.
        .filter(|(a, b)| !by_alpha || (a.w > 0.0 && b.w > 0.0))
        .map(|(a, b)| {
            if source.channel.is_normal() {
                a.xyz().angle_between(b.xyz()).to_degrees() * CODES_PER_DEGREE
            } else {
                let difference = (*a - *b).abs();
                // An alpha that nobody shows is not stored and parts nothing.
                if by_alpha { difference.max_element() } else { difference.xyz().max_element() }
            }
        })
        .collect();
    if differences.is_empty() {
        return true;
    }
    let mean = differences.iter().sum::<f32>() / differences.len() as f32;
    differences.sort_by(f32::total_cmp);
    let peak = differences[(differences.len() * 95 / 100).min(differences.len() - 1)];
    mean <= threshold && peak <= PEAK_FACTOR * threshold
}
