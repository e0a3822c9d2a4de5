//! The points whose weighted mean is a Gaussian average of the surface around a probe: sums over finitely
//! many points, chosen so that they cover the surface evenly, by geometry alone.
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

use super::graph::Graph;
use super::points::{SurfacePoint, scatter};
use super::surface::Surface;

/// Probes handled in one go.
const CHUNK: usize = 16;

/// Points that a whole Gaussian on a plane gets.
const POINT_COUNT: usize = 128;

/// Where the Gaussian ends, in σ, and the share of its variance in the plane that is left.
const REACH: f64 = 3.0;
const VARIANCE_LEFT: f64 = 0.9494;

/// Triangles within reach that are walked one by one. Where they are more, the points come from a cloud
/// over the whole surface, and the chain of joined triangles need not stay within reach.
const WALK_LIMIT: usize = 1024;

/// Points of the cloud at least, where it has as many.
const CLOUD_LEAST: usize = 4096;

/// A point and its share of the average, not normalized.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Where the triangle stands among [`Around::triangles`]; its number in the graph where these are none.
    pub triangle: u32,
    /// Barycentrics, sum 1.
    pub at: Vec3,
    pub weight: f32,
}

/// What lies around a probe at one level.
#[derive(Clone, Debug, Default)]
pub struct Around {
    /// The triangles within reach, the probe's first; empty where they are too many.
    pub triangles: Vec<u32>,
    pub samples: Vec<Sample>,
}

/// A point of the surface, and what lies around it at the levels from 1 on.
pub struct Probe {
    pub point: SurfacePoint,
    pub levels: Vec<Around>,
}

/// Probes over the surface by area, the same in every run; `cloud` are many more points of the same kind.
/// Triangles without texels get none.
pub fn probes(
    surface: &Surface<'_>,
    graph: &Graph,
    cloud: &[SurfacePoint],
    probe_count: usize,
    level_count: usize,
) -> Vec<Probe> {
    let area: f64 = (0..graph.corners.len() as u32).map(|t| 0.5 * graph.cross(t).length()).sum();
    let gather = Gather { graph, cloud, density: cloud.len() as f64 / area };
    let chunks: Vec<Vec<Probe>> = scatter(surface, probe_count)
        .par_chunks(CHUNK)
        .map(|points| {
            let mut marks = vec![0; graph.corners.len()];
            let probe = |&point: &SurfacePoint| {
                let spacing_squared = texel_area(surface, graph, &point)?;
                let around = |level: usize| {
                    let deviation = (variance(spacing_squared, level) / VARIANCE_LEFT).sqrt();
                    gather.around(&point, deviation, &mut marks)
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
    let placed = surface.parts[point.part as usize].placed.get(point.triangle as usize)?;
    let [a, b, c] = placed.scaled.map(|place| place.as_dvec2());
    let area = graph.cross(graph.number(point)).length() / (b - a).perp_dot(c - a).abs();
    (area.is_finite() && area > 0.0).then_some(area)
}

struct Gather<'a> {
    graph: &'a Graph,
    cloud: &'a [SurfacePoint],
    /// Points of the cloud for each unit of area.
    density: f64,
}

impl Gather<'_> {
    fn around(&self, point: &SurfacePoint, deviation: f64, marks: &mut [u32]) -> Around {
        let gauss = Gauss { center: self.graph.position(point), deviation };
        let first = self.graph.number(point);
        match self.graph.near(first, gauss.center, REACH * deviation, WALK_LIMIT, marks) {
            Some(triangles) => {
                let mut samples = Vec::new();
                for (local, &triangle) in triangles.iter().enumerate() {
                    gauss.cover(self.graph.corners[triangle as usize], local as u32, &mut samples);
                }
                Around { triangles, samples }
            }
            None => Around { triangles: Vec::new(), samples: self.of_cloud(&gauss, first) },
        }
    }

    /// Every so many of the cloud's points, which leaves equal shares of the area to each.
    fn of_cloud(&self, gauss: &Gauss, first: u32) -> Vec<Sample> {
        let wanted = POINT_COUNT as f64 / (4.0 * PI * gauss.deviation.powi(2));
        let most = (self.cloud.len() / CLOUD_LEAST).max(1);
        let step = ((self.density / wanted) as usize).clamp(1, most);
        let normal = self.graph.cross(first);
        let mut samples = Vec::new();
        for point in self.cloud.iter().step_by(step) {
            let weight = gauss.at(self.graph.position(point) - gauss.center);
            let triangle = self.graph.number(point);
            if weight > 0.0 && self.graph.cross(triangle).dot(normal) > 0.0 {
                samples.push(Sample { triangle, at: point.at, weight: weight as f32 });
            }
        }
        samples
    }
}

struct Gauss {
    center: DVec3,
    /// σ, mesh space.
    deviation: f64,
}

impl Gauss {
    /// 1 in the middle, 0 beyond the reach.
    fn at(&self, offset: DVec3) -> f64 {
        let squared = offset.length_squared() / self.deviation.powi(2);
        if squared > REACH * REACH { 0.0 } else { (-0.5 * squared).exp() }
    }

    /// Points on one triangle, each with the weight of its share of the area over σ².
    fn cover(&self, corners: [DVec3; 3], triangle: u32, samples: &mut Vec<Sample>) {
        let [a, b, c] = corners.map(|corner| corner - self.center);
        let cross = (b - a).cross(c - a);
        let area = 0.5 * cross.length() / self.deviation.powi(2);
        if area <= 0.0 || !area.is_finite() {
            return;
        }
        // As dense as points that are spread by the Gaussian are in its middle, over two: both kinds then
        // have the same sum of squared weights on a plane.
        let count = area * POINT_COUNT as f64 / (4.0 * PI);
        if count > POINT_COUNT as f64 {
            self.cover_plane([a, b, c], cross, triangle, samples);
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

    /// Points of equal weight in the triangle's plane, spread by the Gaussian on a golden spiral; those
    /// within the triangle stay.
    fn cover_plane(&self, [a, b, c]: [DVec3; 3], cross: DVec3, triangle: u32, samples: &mut Vec<Sample>) {
        let normal = cross.normalize();
        let height = normal.dot(a);
        let height_squared = (height / self.deviation).powi(2);
        if height_squared >= REACH * REACH {
            return;
        }
        let share = 1.0 - (-0.5 * (REACH * REACH - height_squared)).exp();
        let weight = (-0.5 * height_squared).exp() * TAU * share / POINT_COUNT as f64;
        let (right, up) = normal.any_orthonormal_pair();
        let spiral = &*SPIRAL;
        for (number, along) in spiral.iter().enumerate() {
            let radius = (-2.0 * (-share * (number as f64 + 0.5) / POINT_COUNT as f64).ln_1p()).sqrt();
            let place = normal * height + (right * along.x + up * along.y) * radius * self.deviation;
            let second = (place - a).cross(c - a).dot(cross) / cross.length_squared();
            let third = (b - a).cross(place - a).dot(cross) / cross.length_squared();
            if second >= 0.0 && third >= 0.0 && second + third <= 1.0 {
                let at = Vec3::new((1.0 - second - third) as f32, second as f32, third as f32);
                samples.push(Sample { triangle, at, weight: weight as f32 });
            }
        }
    }
}

/// `π (3 - √5)`.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Where the spiral's points stand around its middle, unit length.
static SPIRAL: LazyLock<Vec<DVec2>> = LazyLock::new(|| {
    (0..POINT_COUNT).map(|number| DVec2::from_angle(number as f64 * GOLDEN_ANGLE)).collect()
});

/// Points that cover a triangle evenly, as its second and third barycentrics: multiples of the inverse
/// powers of the plastic number (Roberts' R2 sequence), the square folded over its diagonal.
fn folded(number: usize) -> (f64, f64) {
    let along = |step: f64| (0.5 + step * (number + 1) as f64).fract();
    let (x, y) = (along(0.754_877_666_246_692_7), along(0.569_840_290_998_053_3));
    if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) }
}

#[cfg(test)]
mod tests;
