//! Where the hat function of a coarse sample on an edge or a vertex meets the fine samples inside a face.

use std::borrow::Cow;

use super::MipFilter;
use crate::colors::Shape;

/// A fine sample inside a face, seen from one of its edges: `offset` along the edge from the coarse sample,
/// `depth` rows inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EdgeTap {
    pub offset: i32,
    pub depth: u32,
    pub weight: f32,
}

/// A face at the fine level, as a strip on one of its edges meets it.
pub(super) struct StripSide {
    pub face: usize,
    pub edge: usize,
    pub shape: Shape,
    /// Segments of the face to one of the strip.
    pub step: u32,
    pub is_reversed: bool,
    pub taps: Cow<'static, [EdgeTap]>,
    /// What each tap counts for, beside its weight.
    pub weight: f32,
}

/// What the samples of the first row count for beside an even point of the edge: half of the edge's weight
/// goes to the ones that lie between it and the next coarse row.
pub(super) fn beside(is_triangle: bool) -> &'static [(i32, f32)] {
    if is_triangle { &[(0, 0.5), (-1, 0.5)] } else { &[(0, 0.5), (-1, 0.25), (1, 0.25)] }
}

const TRIANGLE_TAPS: [EdgeTap; 2] =
    [EdgeTap { offset: 0, depth: 1, weight: 0.5 }, EdgeTap { offset: -1, depth: 1, weight: 0.5 }];
const QUAD_TAPS: [EdgeTap; 3] = [
    EdgeTap { offset: 0, depth: 1, weight: 0.5 },
    EdgeTap { offset: -1, depth: 1, weight: 0.25 },
    EdgeTap { offset: 1, depth: 1, weight: 0.25 },
];

/// The samples of a face under the hat of a coarse sample inside an edge, the face having `step` segments to
/// one of the edge. Both filters agree where `step` is 1. A quad of one row of cells has nothing inside.
pub(super) fn edge_taps(shape: Shape, edge: usize, step: u32, filter: MipFilter) -> Cow<'static, [EdgeTap]> {
    let depth = shape.depth(edge);
    match (step, filter) {
        (1, _) if shape.is_triangle => Cow::Borrowed(&TRIANGLE_TAPS),
        _ if depth == 1 => Cow::Borrowed(&[]),
        (1, _) => Cow::Borrowed(&QUAD_TAPS),
        (_, MipFilter::Uniform) => Cow::Owned(wide_taps(shape.is_triangle, step, depth)),
        (_, MipFilter::Area) => Cow::Owned(basis_taps(shape.is_triangle, step)),
    }
}

/// The hat of the edge's own spacing, as wide inwards as along the edge (or as the face has rows), with a total
/// weight of 1.
fn wide_taps(is_triangle: bool, step: u32, depth: u32) -> Vec<EdgeTap> {
    let reach = 2 * step as i32;
    let scale = 1.0 / reach as f32;
    let mut taps = Vec::new();
    for depth in 1..reach.min(depth as i32) {
        for offset in -reach + 1..reach {
            let weight = if is_triangle {
                // Barycentric differences to the center: offset + depth, -offset, -depth in some order.
                1.0 - offset.abs().max(depth).max((offset + depth).abs()) as f32 * scale
            } else {
                (1.0 - offset.abs() as f32 * scale) * (1.0 - depth as f32 * scale)
            };
            if weight > 0.0 {
                taps.push(EdgeTap { offset, depth: depth as u32, weight });
            }
        }
    }
    let total: f32 = taps.iter().map(|tap| tap.weight).sum();
    taps.iter_mut().for_each(|tap| tap.weight /= total);
    taps
}

/// The coarse basis function itself, which is what the level shows: it falls to nothing along the edge at the
/// edge's spacing, and inwards over one coarse row of the face. As these functions sum to 1 everywhere, and each is
/// a sum of fine ones, weights by area keep the sum of area times color.
fn basis_taps(is_triangle: bool, step: u32) -> Vec<EdgeTap> {
    let reach = 2 * step as i32;
    let points = (2 - reach..reach).step_by(2);
    let at = |x: i32| {
        let weight = 1.0 - x.abs() as f32 / reach as f32;
        let tap = move |&(offset, share)| EdgeTap { offset: x + offset, depth: 1, weight: weight * share };
        beside(is_triangle).iter().map(tap)
    };
    points.flat_map(at).collect()
}

/// The grid point diagonally next to a quad's corner.
pub(super) fn inner_neighbor(corner: usize, shape: Shape) -> (u32, u32) {
    let [n, m] = shape.segments;
    match corner {
        0 => (1, 1),
        1 => (n - 1, 1),
        2 => (n - 1, m - 1),
        _ => (1, m - 1),
    }
}

/// The grid point `x` along an edge from its first corner and `depth` inside. On a triangle a row inside is
/// shorter: `x` counts along it from where it leaves the edge before.
pub(super) fn edge_grid_point(shape: Shape, edge: usize, (x, depth): (u32, u32)) -> (u32, u32) {
    let [n, m] = shape.segments;
    match (shape.is_triangle, edge) {
        (_, 0) => (x, depth),
        (true, 1) => (n - x - depth, x),
        (true, _) => (depth, n - x - depth),
        (false, 1) => (n - depth, x),
        (false, 2) => (n - x, m - depth),
        (false, _) => (depth, m - x),
    }
}
