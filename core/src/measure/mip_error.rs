//! How far each level is from the mean of the source over the surface around a point: what the level
//! shows at a probe (the bilinear value at `u_ℓ`, as a shader reads it at a whole λ) beside the
//! [average](super::averages) of the full-resolution source.
//!
//! Means are taken in the space that the channel is filtered in: linear light weighted by alpha, data as
//! it is, normals as what the map adds to those of the mesh. Nothing is averaged across a cut of the channel.

use glam::Vec4;
use rayon::prelude::*;

use super::averages::{self, Around, Probe, Sample};
use super::cell_sums::{Averaged, Sums};
use super::cells::{Admitted, Cells};
use super::graph::Graph;
use super::judge::{Meaning, degrees_between, interpolated, object_normal};
use super::original::Original;
use super::points::SurfacePoint;
use super::report::MipError;
use super::seams::Converted;
use super::surface::Surface;
use super::texels::stored_components;

/// Probes handled in one go.
const CHUNK: usize = 16;

/// An average over points that may be off by more than this gets more of them; codes or degrees.
const DOUBT_MOST: f32 = 1.0;

/// Averages of less alpha have no color.
const NO_ALPHA: f32 = 1e-6;

/// What the mip errors of all channels of a material share: the probes and what lies around them.
pub struct Averages {
    graph: Graph,
    cells: Cells,
    probes: Vec<Probe>,
}

impl Averages {
    pub fn new(surface: &Surface<'_>, texel_count: u64, probe_count: usize, level_count: usize) -> Self {
        let graph = Graph::new(surface);
        let cells = averages::cells(surface, &graph, texel_count);
        let probes = averages::probes(surface, &graph, &cells, probe_count, level_count);
        Self { graph, cells, probes }
    }

    /// The errors of levels 1, 2 …; `None` for a level at which no probe has an average.
    pub fn mip_errors(
        &self,
        original: Original<'_>,
        converted: &Converted<'_>,
        cut_flags: &[bool],
    ) -> Vec<Option<MipError>> {
        let source = Averaged { graph: &self.graph, surface: converted.surface, original };
        let arounds = || self.probes.iter().flat_map(|probe| &probe.levels);
        let needs_cells = arounds().any(|around| around.samples.is_empty());
        let needs_components = arounds().any(|around| around.triangles.is_empty());
        let mut components = if needs_components { self.graph.components(cut_flags) } else { Vec::new() };
        let comparison = Comparison {
            graph: &self.graph,
            converted,
            cut_flags,
            cells: &self.cells,
            in_cells: if needs_cells { source.in_cells(&self.cells) } else { Vec::new() },
            components_of_cells: if needs_components {
                self.cells.components(&mut components)
            } else {
                Vec::new()
            },
            components,
            source,
        };
        let level_count = converted.level_count().saturating_sub(1);
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
    cells: &'a Cells,
    source: Averaged<'a>,
    converted: &'a Converted<'a>,
    cut_flags: &'a [bool],
    /// Both halves' sums by cell; empty where no average needs them, as the others.
    in_cells: Vec<[Sums; 2]>,
    /// By triangle, and the least and the greatest by cell.
    components: Vec<u32>,
    components_of_cells: Vec<[u32; 2]>,
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
        let Some(mut found) = self.compared(point, &halves, level) else { return };
        if found.doubt() > DOUBT_MOST && !around.samples.is_empty() {
            let is_joined = self.graph.joined(&around.triangles, self.cut_flags, marks);
            let halves = self.over_points(around, &around.refined(self.graph, &is_joined), &is_joined);
            found = self.compared(point, &halves, level).unwrap_or(found);
        }
        for &(error, doubt) in found.components.iter().flatten() {
            errors.add(error, doubt);
        }
        errors.probe_count += 1;
    }

    /// What the level shows beside an average; `None` where a normal has no direction.
    fn compared(&self, point: &SurfacePoint, halves: &[Sums; 2], level: usize) -> Option<Compared> {
        let part = &self.converted.surface.parts[point.part as usize];
        let triangle = point.triangle as usize;
        let shown = self
            .converted
            .texels(point.part as usize, level)
            .bilinear(part.place_at(triangle, point.at, level));
        let whole = halves[0] + halves[1];
        let mut components = [None; 4];
        if let Meaning::Normal { scale } = self.source.original.meaning() {
            let shown = object_normal(shown, scale, &interpolated(part.frames().get(triangle)?, point.at));
            let own = self.source.original.corner_frames(point.part as usize, triangle)?;
            let bare = interpolated(own, point.at).normal.normalize_or_zero();
            let wanted = (bare + whole.mean().truncate()).try_normalize()?;
            let [a, b] = halves.map(|half| (bare + half.mean().truncate()).normalize_or(wanted));
            components[0] = Some((degrees_between(wanted, shown), 0.5 * degrees_between(a, b)));
            return Some(Compared { components });
        }
        let codes = |mean: Vec4| Vec4::from(self.source.original.meaning().codes(mean.to_array()));
        let error = codes(whole.mean()) - Vec4::from(self.source.original.meaning().codes(shown));
        let doubt = 0.5 * (codes(halves[0].mean()) - codes(halves[1].mean()));
        for &component in stored_components(self.source.original.components()) {
            // What cannot be seen has no color.
            if component == 3 || whole.alpha() > NO_ALPHA {
                components[component] = Some((error[component].abs(), doubt[component].abs()));
            }
        }
        Some(Compared { components })
    }

    /// The weighted sums of the source over both halves of the points; `None` where there are none.
    fn average(&self, point: &SurfacePoint, around: &Around, marks: &mut [u32]) -> Option<[Sums; 2]> {
        let mut halves = [Sums::default(); 2];
        let mut add_cell = |cell: usize, weight: f32| {
            halves.iter_mut().zip(&self.in_cells[cell]).for_each(|(half, sums)| half.add_times(sums, weight));
        };
        if around.triangles.is_empty() {
            let own = self.graph.number(point);
            let admitted = Admitted {
                normal: self.graph.cross(own).normalize_or_zero().as_vec3(),
                component: self.components[own as usize],
                components: &self.components_of_cells,
            };
            self.cells.of_all(&around.gauss, &admitted, add_cell);
        } else {
            let is_joined = self.graph.joined(&around.triangles, self.cut_flags, marks);
            if around.samples.is_empty() {
                for (&triangle, _) in around.triangles.iter().zip(is_joined).filter(|(_, joined)| *joined) {
                    self.cells.of_triangle(triangle, &around.gauss, &mut add_cell);
                }
            } else {
                halves = self.over_points(around, &around.samples, &is_joined);
            }
        }
        let is_empty = |half: &Sums| half.weight <= 0.0;
        (!halves.iter().any(is_empty)).then_some(halves)
    }

    fn over_points(&self, around: &Around, samples: &[Sample], is_joined: &[bool]) -> [Sums; 2] {
        let mut halves = [Sums::default(); 2];
        let weighs_by_alpha = self.source.weighs_by_alpha();
        // One point after the other goes to each in turn.
        let mut half = 0;
        for samples in samples.chunk_by(|a, b| a.triangle == b.triangle) {
            let local = samples[0].triangle as usize;
            if !is_joined[local] {
                continue;
            }
            let source = self.source.on(around.triangles[local]);
            for sample in samples {
                halves[half].add(source.value(sample.at), sample.weight, weighs_by_alpha);
                half = 1 - half;
            }
        }
        halves
    }
}

/// What one average says of one level: the error and its doubt, by component (an angle is the first).
struct Compared {
    components: [Option<(f32, f32)>; 4],
}

impl Compared {
    fn doubt(&self) -> f32 {
        self.components.iter().flatten().map(|(_, doubt)| *doubt).fold(0.0, f32::max)
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
