//! How far each level is from the mean of the source over the surface around a point: what the level
//! shows at a probe (the bilinear value at `u_ℓ`, as a shader reads it at a whole λ) beside the
//! [average](super::averages) of the full-resolution source.
//!
//! Means are taken in the space that the channel is filtered in: linear light weighted by alpha, data as
//! it is, normals as what the map adds to those of the mesh. Nothing is averaged across a cut of the channel.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::averages::{self, Around, Probe};
use super::graph::Graph;
use super::judge::{Meaning, degrees_between, interpolated, object_normal};
use super::origin::Origin;
use super::points::SurfacePoint;
use super::report::MipError;
use super::seams::Converted;
use super::surface::Surface;
use super::texels::{Texels, stored_components};

/// Probes handled in one go.
const CHUNK: usize = 16;

/// Averages of less alpha have no color.
const NO_ALPHA: f32 = 1e-6;

/// What the mip errors of all channels of a material share: the probes and what lies around them.
pub struct Averages {
    graph: Graph,
    probes: Vec<Probe>,
}

impl Averages {
    pub fn new(
        surface: &Surface<'_>,
        cloud: &[SurfacePoint],
        probe_count: usize,
        level_count: usize,
    ) -> Self {
        let graph = Graph::new(surface);
        let probes = averages::probes(surface, &graph, cloud, probe_count, level_count);
        Self { graph, probes }
    }

    /// The errors of levels 1, 2 …; `None` for a level at which no probe has an average.
    pub fn mip_errors(
        &self,
        origin: &Origin<'_>,
        converted: &Converted<'_>,
        cut_flags: &[bool],
    ) -> Vec<Option<MipError>> {
        let is_walked = |probe: &Probe| probe.levels.iter().all(|around| !around.triangles.is_empty());
        let is_all_walked = self.probes.iter().all(is_walked);
        let comparison = Comparison {
            graph: &self.graph,
            origin,
            converted,
            source: origin.texels(origin.image),
            cut_flags,
            components: if is_all_walked { Vec::new() } else { self.graph.components(cut_flags) },
        };
        let level_count = converted.texture.levels.len().saturating_sub(1);
        let chunks: Vec<Vec<Errors>> = self
            .probes
            .par_chunks(CHUNK)
            .map(|probes| {
                let mut marks = vec![0; self.graph.corners.len()];
                let mut levels = vec![Errors::default(); level_count];
                for probe in probes {
                    for (number, (errors, around)) in levels.iter_mut().zip(&probe.levels).enumerate() {
                        comparison.add(&probe.point, around, number + 1, errors, &mut marks);
                    }
                }
                levels
            })
            .collect();
        let mut levels = vec![Errors::default(); level_count];
        for (total, errors) in chunks.into_iter().flat_map(|chunk| chunk.into_iter().enumerate()) {
            levels[total].join(errors);
        }
        levels.into_iter().map(Errors::figures).collect()
    }
}

struct Comparison<'a> {
    graph: &'a Graph,
    origin: &'a Origin<'a>,
    converted: &'a Converted<'a>,
    source: Texels<'a>,
    cut_flags: &'a [bool],
    /// By triangle; empty where no average needs them.
    components: Vec<u32>,
}

impl Comparison<'_> {
    /// Adds a probe's errors at one level, if it has an average.
    fn add(
        &self,
        point: &SurfacePoint,
        around: &Around,
        level: usize,
        errors: &mut Errors,
        marks: &mut [u32],
    ) {
        let Some(halves) = self.average(point, around, marks) else { return };
        let part = &self.converted.surface.parts[point.part as usize];
        let triangle = point.triangle as usize;
        let shown = self.converted.texels(level).bilinear(part.placed[triangle].place_at(point.at, level));
        let whole = halves[0] + halves[1];
        if let Meaning::Normal { scale } = self.origin.meaning {
            let Some(frames) = part.frames().get(triangle) else { return };
            let shown = object_normal(shown, scale, &interpolated(frames, point.at));
            let Some(own) = self.origin.corner_frames(point.part as usize, triangle) else { return };
            let bare = interpolated(own, point.at).normal.normalize_or_zero();
            let Some(wanted) = (bare + whole.mean().truncate()).try_normalize() else { return };
            let [a, b] = halves.map(|half| (bare + half.mean().truncate()).normalize_or(wanted));
            errors.add(degrees_between(wanted, shown), 0.5 * degrees_between(a, b));
            errors.probe_count += 1;
            return;
        }
        let codes = |mean: Vec4| Vec4::from(self.origin.meaning.codes(mean.to_array()));
        let error = codes(whole.mean()) - Vec4::from(self.origin.meaning.codes(shown));
        let doubt = 0.5 * (codes(halves[0].mean()) - codes(halves[1].mean()));
        for &component in stored_components(self.origin.components) {
            // What cannot be seen has no color.
            if component == 3 || whole.alpha() > NO_ALPHA {
                errors.add(error[component].abs(), doubt[component].abs());
            }
        }
        errors.probe_count += 1;
    }

    /// The weighted sums of the source over both halves of the points; `None` where there are none.
    fn average(&self, point: &SurfacePoint, around: &Around, marks: &mut [u32]) -> Option<[Sums; 2]> {
        let is_walked = !around.triangles.is_empty();
        let is_joined =
            if is_walked { self.graph.joined(&around.triangles, self.cut_flags, marks) } else { Vec::new() };
        let own = self.graph.number(point) as usize;
        let mut halves = [Sums::default(); 2];
        for (number, sample) in around.samples.iter().enumerate() {
            let triangle = if is_walked {
                if !is_joined[sample.triangle as usize] {
                    continue;
                }
                around.triangles[sample.triangle as usize]
            } else {
                if self.components[sample.triangle as usize] != self.components[own] {
                    continue;
                }
                sample.triangle
            };
            halves[number % 2].add(self.value(triangle, sample.at), sample.weight, self.weighs_by_alpha());
        }
        let is_empty = |half: &Sums| half.weight <= 0.0;
        (!halves.iter().any(is_empty)).then_some(halves)
    }

    /// Whether color counts by how much of it is seen.
    fn weighs_by_alpha(&self) -> bool {
        self.origin.meaning == Meaning::Color && matches!(self.origin.components, 2 | 4)
    }

    /// The source at a point of the surface: what is filtered; of a normal map what it adds to the mesh's own
    /// normal, in object space.
    fn value(&self, triangle: u32, at: Vec3) -> Vec4 {
        let (part, triangle) = self.graph.place(triangle);
        let vertices = self.converted.surface.parts[part].triangles[triangle];
        let value = self.source.bilinear(self.origin.place(part, vertices, at, self.source.size_texels()));
        match (self.origin.meaning, self.origin.corner_frames(part, triangle)) {
            (Meaning::Normal { scale }, Some(frames)) => {
                let frame = interpolated(frames, at);
                (object_normal(value, scale, &frame) - frame.normal.normalize_or_zero()).extend(1.0)
            }
            _ => Vec4::from(value),
        }
    }
}

#[derive(Clone, Copy, Default)]
struct Sums {
    /// Red, green and blue weighted by `color_weight`, alpha by `weight`.
    sum: Vec4,
    color_weight: f32,
    weight: f32,
}

impl Sums {
    fn add(&mut self, value: Vec4, weight: f32, weighs_by_alpha: bool) {
        let color_weight = if weighs_by_alpha { weight * value.w } else { weight };
        self.sum += value * Vec3::splat(color_weight).extend(weight);
        self.color_weight += color_weight;
        self.weight += weight;
    }

    fn mean(&self) -> Vec4 {
        let color_weight = self.color_weight.max(f32::MIN_POSITIVE);
        self.sum / Vec3::splat(color_weight).extend(self.weight)
    }

    /// How much of the average is seen, 0 to 1.
    fn alpha(&self) -> f32 {
        self.color_weight / self.weight
    }
}

impl std::ops::Add for Sums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            sum: self.sum + other.sum,
            color_weight: self.color_weight + other.color_weight,
            weight: self.weight + other.weight,
        }
    }
}

/// Errors of one level, in the channel's unit.
#[derive(Clone, Default)]
struct Errors {
    sizes: Vec<f32>,
    squared_doubt: f64,
    probe_count: u64,
}

impl Errors {
    fn add(&mut self, size: f32, doubt: f32) {
        self.sizes.push(size);
        self.squared_doubt += f64::from(doubt).powi(2);
    }

    fn join(&mut self, other: Self) {
        self.sizes.extend(other.sizes);
        self.squared_doubt += other.squared_doubt;
        self.probe_count += other.probe_count;
    }

    fn figures(mut self) -> Option<MipError> {
        let count = self.sizes.len();
        let squared: f64 = self.sizes.iter().map(|&size| f64::from(size).powi(2)).sum();
        self.sizes.sort_unstable_by(f32::total_cmp);
        let p99 = *self.sizes.get((count * 99).div_ceil(100).checked_sub(1)?)?;
        Some(MipError {
            rms: (squared / count as f64).sqrt(),
            p99: f64::from(p99),
            probe_count: self.probe_count,
            reference_error: (self.squared_doubt / count as f64).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests;
