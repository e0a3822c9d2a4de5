//! Which triangles become quads: the pairs that save most texels.

use glam::{DVec3, Vec2};

use crate::math::matching::{WeightedEdge, maximum_weight_matching};
use crate::mesh::{CanvasEdge, CanvasMesh, Side};
use crate::source::{SurfaceSource, kink_codes};

/// Steps of one texel in a pair's weight.
const WEIGHT_STEPS: f32 = 16.0;
/// What such a step is to what tells pairs of one weight apart.
const TIES: i64 = 1 << 20;
/// Coordinates that repeat a picture a thousand times save more than any texture has.
const WEIGHT_MAX: f32 = (1u64 << 38) as f32;

/// For each face the one that it is to be a quad with. `joinable` says by canvas edge whether its two sides may become
/// one; edges that do not have exactly two different triangles never do.
pub fn pair_triangles(
    canvas: &CanvasMesh,
    sources: &[SurfaceSource<'_>],
    joinable: &[bool],
) -> Vec<Option<u32>> {
    let Some(source) = finest(canvas, sources) else { return vec![None; canvas.faces.len()] };
    matched(&Costs { canvas, lengths: Lengths::Source(source) }, joinable)
}

/// The same without a source. `positions` of the canvas' vertices are in texels.
pub fn pair_triangles_in_space(
    canvas: &CanvasMesh,
    positions: &[DVec3],
    joinable: &[bool],
) -> Vec<Option<u32>> {
    matched(&Costs { canvas, lengths: Lengths::Space(positions) }, joinable)
}

fn matched(costs: &Costs<'_>, joinable: &[bool]) -> Vec<Option<u32>> {
    let canvas = costs.canvas;
    let candidates: Vec<WeightedEdge> = (canvas.edges.iter().zip(joinable))
        .filter(|(_, joinable)| **joinable)
        .filter_map(|(edge, _)| candidate(costs, edge))
        .collect();
    maximum_weight_matching(canvas.faces.len(), &candidates)
}

/// The source of most texels.
fn finest<'s, 'a>(canvas: &CanvasMesh, sources: &'s [SurfaceSource<'a>]) -> Option<&'s SurfaceSource<'a>> {
    let area = |source: &SurfaceSource<'_>| -> f32 {
        (0..canvas.faces.len()).map(|face| source.area_texels(canvas, face)).sum()
    };
    sources.iter().max_by(|a, b| area(a).total_cmp(&area(b)))
}

fn candidate(costs: &Costs<'_>, edge: &CanvasEdge) -> Option<WeightedEdge> {
    let &[a, b] = costs.canvas.sides(edge) else { return None };
    let [face_a, face_b] = [a, b].map(|side| &costs.canvas.faces[side.face as usize]);
    let is_plain = a.face != b.face && face_a.is_triangle() && face_b.is_triangle();
    let opposite =
        |side: Side| costs.canvas.faces[side.face as usize].vertices[(usize::from(side.edge) + 2) % 3];
    // Front and back of one sheet share more than this edge.
    if !is_plain || opposite(a) == opposite(b) {
        return None;
    }
    let weight = (costs.saved_texels(a, b) * WEIGHT_STEPS).round();
    // Nothing that is not a number saves anything.
    if weight.is_nan() || weight < 1.0 {
        return None;
    }
    let tie = costs.smoothness(a, b).unwrap_or_else(|| costs.tie(a) + costs.tie(b));
    let weight = weight.min(WEIGHT_MAX) as i64 * TIES + tie;
    Some(WeightedEdge { nodes: [a.face, b.face], weight })
}

/// What faces cost in texels where every side gets a sample for each texel of the source.
struct Costs<'a> {
    canvas: &'a CanvasMesh,
    lengths: Lengths<'a>,
}

/// What tells how many texels a side has.
enum Lengths<'a> {
    Source(&'a SurfaceSource<'a>),
    /// Positions by vertex, in texels.
    Space(&'a [DVec3]),
}

impl Costs<'_> {
    /// What a pair costs less than its two triangles.
    fn saved_texels(&self, a: Side, b: Side) -> f32 {
        let [sides_a, sides_b] = [a, b].map(|side| self.sides(side));
        let ([_, next_a, last_a], [_, next_b, last_b]) = (sides_a, sides_b);
        // Around the quad the sides of the second triangle face those of the first; which face which depends on how
        // the two wind.
        let same_way = {
            let [a, b] =
                [a, b].map(|side| self.canvas.faces[side.face as usize].is_reversed(usize::from(side.edge)));
            a == b
        };
        let [facing_next, facing_last] = if same_way { [last_b, next_b] } else { [next_b, last_b] };
        let [n, m] = [next_a.max(facing_next), last_a.max(facing_last)].map(|length| length.max(1.0));
        lone(sides_a) + lone(sides_b) - (n + 1.0) * (m + 1.0)
    }

    /// Of vertex colors alone, a number below [`TIES`]: the larger, the less a pair's two triangles are bent against each other.
    fn smoothness(&self, a: Side, b: Side) -> Option<i64> {
        let Lengths::Source(source) = self.lengths else { return None };
        if !source.channel.is_bare() {
            return None;
        }
        let tint =
            |side: Side, k: usize| source.tint(side.face as usize, (0, (usize::from(side.edge) + k) % 3));
        let kink = kink_codes([tint(a, 0)?, tint(a, 1)?], [tint(a, 2)?, tint(b, 2)?]);
        Some(((1.0 - kink / 256.0) * (TIES - 1) as f32) as i64)
    }

    /// A number below half of [`TIES`] by where in the source the side lies. So which of several matchings that save as
    /// much is found does not depend on the order of faces.
    fn tie(&self, side: Side) -> i64 {
        let Lengths::Source(source) = self.lengths else { return 0 };
        let places = source.places(side.face as usize)[0];
        let [from, to] = [places[usize::from(side.edge)], places[(usize::from(side.edge) + 1) % 3]];
        let size = Vec2::new(source.channel.image.width as f32, source.channel.image.height as f32);
        let middle = ((from + to) * 0.5 / size).fract_gl();
        // Two irrational numbers, so that few places meet.
        let mixed = (middle.x * 61.803_4 + middle.y * 75.487_77).fract();
        (mixed * (TIES / 2) as f32) as i64
    }

    /// Lengths of a triangle's sides in texels, from the one that is named on.
    fn sides(&self, side: Side) -> [f32; 3] {
        let face = side.face as usize;
        let lengths = match self.lengths {
            Lengths::Source(source) => {
                let places = source.places(face)[0];
                [0, 1, 2].map(|k| Vec2::distance(places[k], places[(k + 1) % 3]))
            }
            Lengths::Space(positions) => {
                let corners = self.canvas.faces[face].vertices.map(|vertex| positions[vertex as usize]);
                [0, 1, 2].map(|k| DVec3::distance(corners[k], corners[(k + 1) % 3]) as f32)
            }
        };
        [0, 1, 2].map(|k| lengths[(usize::from(side.edge) + k) % 3])
    }
}

/// Half a block of two lone triangles, as fine as the mean of their two longer sides asks for.
fn lone(mut sides: [f32; 3]) -> f32 {
    sides.sort_by(f32::total_cmp);
    let n = (sides[1] * sides[2]).sqrt().max(1.0);
    0.5 * (n + 1.0) * (n + 4.0)
}
