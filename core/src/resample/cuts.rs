//! Which edges a channel does not join: where the source itself shows two values at full resolution.

use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::colors::Cuts;
use crate::error::Result;
use crate::image::Transfer;
use crate::math::transfer::linear_to_srgb;
use crate::mesh::{CanvasEdge, CanvasMesh, Side};
use crate::source::{SurfaceSource, edge_ends};
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
    if sides[1..].iter().all(|&side| is_same(source, canvas, sides[0], side)) {
        return Ok(true);
    }
    let point_count = sides.iter().map(|&side| length_texels(source, canvas, side)).fold(0.0, f32::max);
    let point_count = point_count.ceil().clamp(POINTS[0], POINTS[1]) as u32;
    let look = |a: Side, b: Side, threshold: f32| {
        let shown = [a, b].map(|side| Profile { source, canvas, side, point_count });
        sides_agree(&shown, threshold)
    };
    if sides.len() <= ALL_PAIRS_SIDES {
        let mut pairs = (0..sides.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        return Ok(pairs.all(|(a, b)| look(sides[a], sides[b], threshold)));
    }
    for &side in &sides[1..] {
        watch::check(watch)?;
        if !look(sides[0], side, threshold * 0.5) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Both ends of a side in texels, low end first.
fn ends(source: &SurfaceSource<'_>, canvas: &CanvasMesh, side: Side) -> [glam::Vec2; 2] {
    let places = source.places(side.face as usize);
    [0, 1].map(|end| {
        let (triangle, corner) = drawn_end(canvas, side, end);
        places[triangle][corner]
    })
}

/// The corner of a drawn triangle at an end of its side, low end first.
fn drawn_end(canvas: &CanvasMesh, side: Side, end: usize) -> (usize, usize) {
    let face = &canvas.faces[side.face as usize];
    let edge = usize::from(side.edge);
    let (triangle, ends) = edge_ends(face.count(), edge);
    (triangle, ends[usize::from(face.is_reversed(edge) != (end == 1))])
}

/// Whether two sides show the same without looking: the same places, of normals in the same frames, with the same vertex colors.
fn is_same(source: &SurfaceSource<'_>, canvas: &CanvasMesh, a: Side, b: Side) -> bool {
    let frame = |side: Side, end: usize| source.frame(side.face as usize, drawn_end(canvas, side, end));
    let tint = |side: Side, end: usize| source.tint(side.face as usize, drawn_end(canvas, side, end));
    ends(source, canvas, a) == ends(source, canvas, b)
        && (0..2).all(|end| frame(a, end) == frame(b, end) && tint(a, end) == tint(b, end))
}

fn length_texels(source: &SurfaceSource<'_>, canvas: &CanvasMesh, side: Side) -> f32 {
    let [low, high] = ends(source, canvas, side);
    low.distance(high)
}

/// The source along a side, looked at in the middles of equal pieces.
struct Profile<'a> {
    source: &'a SurfaceSource<'a>,
    canvas: &'a CanvasMesh,
    side: Side,
    point_count: u32,
}

impl Profile<'_> {
    /// The value of a piece, counted from the side's low end.
    fn value(&self, piece: u32) -> Vec4 {
        let edge = usize::from(self.side.edge);
        let t = (piece as f32 + 0.5) / self.point_count as f32;
        let t = if self.canvas.faces[self.side.face as usize].is_reversed(edge) { 1.0 - t } else { t };
        self.source.along_edge(self.canvas, self.side.face as usize, edge, t)
    }
}

/// Looks from piece to piece until it is clear that the mean, or the 95th percentile, is beyond its bound.
fn sides_agree(sides: &[Profile<'_>; 2], threshold: f32) -> bool {
    let point_count = sides[0].point_count;
    let by_alpha = sides[0].source.channel.is_alpha_weighted();
    let (mut sum, mut compared, mut peaks) = (0.0, 0, 0);
    for piece in 0..point_count {
        let [a, b] = [&sides[0], &sides[1]].map(|side| side.value(piece));
        // What is transparent on one side has no color there and no vote.
        if by_alpha && (a.w <= 0.0 || b.w <= 0.0) {
            continue;
        }
        let difference = difference_codes(sides[0].source, a, b);
        sum += difference;
        compared += 1;
        peaks += u32::from(difference > PEAK_FACTOR * threshold);
        let is_beyond = sum > threshold * point_count as f32 || is_many(peaks, point_count);
        if is_beyond {
            return false;
        }
    }
    sum <= threshold * compared as f32 && !is_many(peaks, compared)
}

/// Whether so many of `count` are more than a twentieth: whether the 95th percentile is one of them.
fn is_many(peaks: u32, count: u32) -> bool {
    count > 0 && peaks >= count - (count * 95 / 100).min(count - 1)
}

fn difference_codes(source: &SurfaceSource<'_>, a: Vec4, b: Vec4) -> f32 {
    if source.channel.is_normal() {
        return a.xyz().angle_between(b.xyz()).to_degrees() * CODES_PER_DEGREE;
    }
    let code = |value: Vec4| match source.channel.transfer {
        Transfer::Srgb => value.xyz().map(linear_to_srgb).extend(value.w),
        Transfer::Linear => value,
    };
    // Equal values need no codes: encoding is what costs.
    let difference = if a == b { Vec4::ZERO } else { (code(a) - code(b)).abs() * 255.0 };
    // An alpha that nobody shows is not stored and parts nothing.
    if source.channel.is_alpha_weighted() { difference.max_element() } else { difference.xyz().max_element() }
}
