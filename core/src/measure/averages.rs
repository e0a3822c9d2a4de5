//! The points and cells whose weighted mean is a Gaussian average of the surface around a probe, chosen by
//! geometry alone. Narrow averages are sums over points that cover the surface around their probe evenly;
//! wide ones are sums over the [cells] of the whole surface, in each of which the source has been
//! summed before.
//!
//! The variance of level ℓ. One 1-2-1 step from spacing h to 2h adds `2 · 1/4 · h² = h²/2` along each axis,
//! and the spacings double, so level ℓ has `h² Σ 4^k / 2 = h² (4^ℓ - 1) / 6` beyond level 0, whose spacing
//! is h: the square root of the probe's triangle, in mesh space, over its texels of level 0. The Gaussian
//! ends at 3 σ, which takes 5.06 % of its variance; σ is larger by as much.
//!
//! Distance is Euclidean. Triangles count that face the probe's side and that a chain of others within
//! reach joins with it, so nothing comes from the far side of a thin wall.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::cells::{Cells, Gauss, REACH, VARIANCE_LEFT};
use super::graph::Graph;
use super::points::{SurfacePoint, scatter};
use super::surface::Surface;

/// Probes handled in one go.
const CHUNK: usize = 16;

/// Cells are taken where the innermost ones around the probe are smaller than this, in σ: there are hundreds of
/// them then, with several points each.
const CELLS_WITHIN: f64 = 0.3;

/// Triangles within reach that are walked one by one. Where they are more, all cells take part whose
/// triangles face the probe's side and are joined with it somewhere.
const WALK_LIMIT: usize = 1024;

/// Innermost cells: one for so many texels of the largest texture, within these bounds.
const TEXELS_PER_CELL: u64 = 16;
const CELLS_LEAST: u64 = 4096;
const CELLS_MOST: u64 = 1 << 17;

/// A point and its share of the average, not normalized.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Where the triangle stands among [`Around::triangles`].
    pub triangle: u32,
    /// Barycentrics, sum 1.
    pub at: Vec3,
    pub weight: f32,
}

/// What lies around a probe at one level.
#[derive(Clone, Debug)]
pub struct Around {
    pub gauss: Gauss,
    /// The triangles within reach, the probe's first; empty where they are too many.
    pub triangles: Vec<u32>,
    /// Empty where cells are summed.
    pub samples: Vec<Sample>,
}

/// A point of the surface, and what lies around it at the levels from 1 on.
pub struct Probe {
    pub point: SurfacePoint,
    pub levels: Vec<Around>,
}

/// The cells of a surface whose largest texture has this many texels at level 0. Half of them goes by area,
/// half by texels, so that neither wide nor detailed triangles are without.
pub fn cells(surface: &Surface<'_>, graph: &Graph, texel_count: u64) -> Cells {
    let areas = (0..graph.corners.len() as u32).map(|triangle| 0.5 * graph.cross(triangle).length());
    let texels = surface.parts.iter().flat_map(|part| {
        part.placed.iter().map(|triangle| {
            let [a, b, c] = part.coordinates.texels(triangle).map(|place| place.as_dvec2());
            0.5 * (b - a).perp_dot(c - a).abs()
        })
    });
    let sizes: Vec<[f64; 2]> = areas.zip(texels).map(|sizes| sizes.into()).collect();
    let finite = |size: f64| if size.is_finite() { size } else { 0.0 };
    let total =
        |which: usize| sizes.iter().map(|size| finite(size[which])).sum::<f64>().max(f64::MIN_POSITIVE);
    let totals = [total(0), total(1)];
    let count = (texel_count / TEXELS_PER_CELL).clamp(CELLS_LEAST, CELLS_MOST) as f64;
    let weight = |size: &[f64; 2]| 0.5 * count * (finite(size[0]) / totals[0] + finite(size[1]) / totals[1]);
    let weights: Vec<f64> = sizes.iter().map(weight).collect();
    Cells::new(graph, &weights)
}

/// Probes over the surface by area, the same in every run. Triangles without texels get none.
pub fn probes(
    surface: &Surface<'_>,
    graph: &Graph,
    cells: &Cells,
    probe_count: usize,
    level_count: usize,
) -> Vec<Probe> {
    let chunks: Vec<Vec<Probe>> = scatter(surface, probe_count)
        .par_chunks(CHUNK)
        .map(|points| {
            let mut marks = vec![0; graph.corners.len()];
            let probe = |&point: &SurfacePoint| {
                let spacing_squared = texel_area(surface, graph, &point)?;
                let mut is_walked = true;
                let around = |level: usize| {
                    let deviation = (variance(spacing_squared, level) / VARIANCE_LEFT).sqrt();
                    let gauss = Gauss { center: graph.position(&point), deviation };
                    let around = around(graph, cells, &point, gauss, is_walked.then_some(&mut marks));
                    // The next level reaches further.
                    is_walked = !around.triangles.is_empty();
                    around
                };
                Some(Probe { point, levels: (1..level_count).map(around).collect() })
            };
            points.iter().filter_map(probe).collect()
        })
        .collect();
    chunks.into_iter().flatten().collect()
}

/// What a level has along each axis, beyond level 0 with texels of this area.
fn variance(texel_area: f64, level: usize) -> f64 {
    texel_area * ((2.0 * level as f64).exp2() - 1.0) / 6.0
}

/// The area of one texel of level 0 on a point's triangle, mesh space.
fn texel_area(surface: &Surface<'_>, graph: &Graph, point: &SurfacePoint) -> Option<f64> {
    let part = &surface.parts[point.part as usize];
    let placed = part.placed.get(point.triangle as usize)?;
    let [a, b, c] = part.coordinates.texels(placed).map(|place| place.as_dvec2());
    let area = graph.cross(graph.number(point)).length() / (b - a).perp_dot(c - a).abs();
    (area.is_finite() && area > 0.0).then_some(area)
}

/// `marks` as [`Graph::near`] takes them, where triangles are to be walked.
fn around(
    graph: &Graph,
    cells: &Cells,
    point: &SurfacePoint,
    gauss: Gauss,
    marks: Option<&mut Vec<u32>>,
) -> Around {
    let first = graph.number(point);
    let near =
        |marks: &mut Vec<u32>| graph.near(first, gauss.center, REACH * gauss.deviation, WALK_LIMIT, marks);
    let triangles = marks.and_then(near).unwrap_or_default();
    let mut samples = Vec::new();
    if cells.radius(first) > CELLS_WITHIN * gauss.deviation {
        for (local, &triangle) in triangles.iter().enumerate() {
            gauss.cover(&FEW, graph.corners[triangle as usize], local as u32, &mut samples);
        }
    }
    Around { gauss, triangles, samples }
}

impl Around {
    /// More points around the same place, on the triangles that are named.
    pub fn refined(&self, graph: &Graph, is_joined: &[bool]) -> Vec<Sample> {
        let mut samples = Vec::new();
        for (local, &triangle) in self.triangles.iter().enumerate().filter(|(local, _)| is_joined[*local]) {
            self.gauss.cover(&MANY, graph.corners[triangle as usize], local as u32, &mut samples);
        }
        samples
    }
}

/// So many points spread by a Gaussian of σ 1, as far as it reaches: on a golden spiral.
struct Spread(Vec<DVec2>);

impl Spread {
    fn new(count: usize) -> Self {
        let share = *WITHIN_REACH;
        let place = |number: usize| {
            let radius = (-2.0 * (-share * (number as f64 + 0.5) / count as f64).ln_1p()).sqrt();
            DVec2::from_angle(number as f64 * GOLDEN_ANGLE) * radius
        };
        Self((0..count).map(place).collect())
    }
}

/// What an average gets at first, and what it gets where those leave it in doubt.
static FEW: LazyLock<Spread> = LazyLock::new(|| Spread::new(256));
static MANY: LazyLock<Spread> = LazyLock::new(|| Spread::new(2048));

/// The share of a Gaussian in a plane that stands within its reach.
static WITHIN_REACH: LazyLock<f64> = LazyLock::new(|| 1.0 - (-0.5 * REACH * REACH).exp());

/// `π (3 - √5)`.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

impl Gauss {
    /// Points on one triangle, each with the weight of its share of the area over σ².
    fn cover(&self, spread: &Spread, corners: [DVec3; 3], triangle: u32, samples: &mut Vec<Sample>) {
        let [a, b, c] = corners.map(|corner| corner - self.center);
        let cross = (b - a).cross(c - a);
        let area = 0.5 * cross.length() / self.deviation.powi(2);
        if area <= 0.0 || !area.is_finite() {
            return;
        }
        // As dense as points that are spread by the Gaussian are in its middle, over two: both kinds then
        // have the same sum of squared weights on a plane.
        let count = area * spread.0.len() as f64 / (4.0 * PI);
        if count > spread.0.len() as f64 {
            self.cover_plane(spread, [a, b, c], triangle, samples);
            return;
        }
        let count = count.round().max(1.0) as usize;
        for number in 0..count {
            let (second, third) = if count == 1 { (1.0 / 3.0, 1.0 / 3.0) } else { folded(number) };
            let weight = self.at(a + (b - a) * second + (c - a) * third) * area / count as f64;
            if weight > 0.0 {
                let at = Vec3::new((1.0 - second - third) as f32, second as f32, third as f32);
                samples.push(Sample { triangle, at, weight: weight as f32 });
            }
        }
    }

    /// Points of equal weight in the triangle's plane, spread by the Gaussian; those within the triangle
    /// stay.
    fn cover_plane(&self, spread: &Spread, [a, b, c]: [DVec3; 3], triangle: u32, samples: &mut Vec<Sample>) {
        let cross = (b - a).cross(c - a);
        let normal = cross.normalize();
        let height = normal.dot(a);
        let height_squared = (height / self.deviation).powi(2);
        if height_squared >= REACH * REACH {
            return;
        }
        let weight = ((-0.5 * height_squared).exp() * TAU * *WITHIN_REACH / spread.0.len() as f64) as f32;
        let (right, up) = normal.any_orthonormal_pair();
        // Barycentrics are linear over the plane.
        let (from_b, from_c) = ((c - a).cross(cross), cross.cross(b - a));
        let [second, third] = [from_b, from_c].map(|toward| {
            let toward = toward / toward.dot(if toward == from_b { b - a } else { c - a });
            let start = (normal * height - a).dot(toward);
            (start, DVec2::new(right.dot(toward), up.dot(toward)) * self.deviation)
        });
        for &place in &spread.0 {
            let (second, third) = (second.0 + second.1.dot(place), third.0 + third.1.dot(place));
            let is_inside = second >= 0.0 && third >= 0.0 && second + third <= 1.0;
            if is_inside && place.length_squared() + height_squared <= REACH * REACH {
                let at = Vec3::new((1.0 - second - third) as f32, second as f32, third as f32);
                samples.push(Sample { triangle, at, weight });
            }
        }
    }
}

/// Points that cover a triangle evenly, as its second and third barycentrics: multiples of the inverse
/// powers of the plastic number (Roberts' R2 sequence), the square folded over its diagonal.
fn folded(number: usize) -> (f64, f64) {
    let along = |step: f64| {
        let along = 0.5 + step * (number + 1) as f64;
        // The part after the point, without a call.
        along - f64::from(along as u32)
    };
    let (x, y) = (along(0.754_877_666_246_692_7), along(0.569_840_290_998_053_3));
    if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) }
}

#[cfg(test)]
mod tests;
