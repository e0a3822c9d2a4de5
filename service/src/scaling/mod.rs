//! How time and memory grow with the number of faces: one torus in ever finer grids, every stage and rung
//! timed. Each face sees as much of the texture at every size (it repeats), so what grows is the number of
//! faces and nothing else. `cargo bench -p meshcolor --bench scaling` runs it.

mod mesh;
mod plot;
mod table;

pub use plot::svg;
pub use table::text;

use meshcolor::Result;
use meshcolor::pipeline::{ENGINE_VERSION, Options, convert_read};
use meshcolor::read::{Limits, read};
use meshcolor::watch::{Stage, Watch};
use serde::{Deserialize, Serialize};

use crate::clock::Timestamp;
use crate::tradeoff::{Cost, HOME, Machine, Plan, cost_of};
use crate::watch::JobWatch;

/// Faces that are asked for; the grids come near.
pub const FACE_COUNTS: [u64; 7] = [1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000];

/// Sizes from here on count for the exponents; below, what every conversion costs once weighs in.
const FITTED_FROM: u64 = 10_000;

/// The record: what `docs/scaling.json` holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    pub engine_version: String,
    pub started_at: String,
    pub machine: Machine,
    pub sizes: Vec<Size>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Size {
    pub face_count: u64,
    /// Of level 0.
    pub texel_count: u64,
    /// `standard` first.
    pub runs: Vec<SizeRun>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SizeRun {
    pub name: String,
    pub cost: Cost,
}

impl Scaling {
    pub fn begin() -> Self {
        Self {
            engine_version: ENGINE_VERSION.to_owned(),
            started_at: Timestamp::now().to_string(),
            machine: Machine::here(),
            sizes: Vec::new(),
        }
    }

    /// Converts a torus of about so many faces, by `standard` and, `with_rungs`, by all others.
    ///
    /// # Errors
    /// Those of a conversion.
    pub fn add(&mut self, face_count: u64, with_rungs: bool) -> Result<()> {
        let limits = Limits::default();
        let reading = JobWatch::alone();
        reading.stage(Stage::Read);
        let asset = read(&mesh::torus(face_count), &limits, &reading)?;
        let read_figures = reading.finish();
        let mut size = Size { face_count: mesh::face_count(face_count), texel_count: 0, runs: Vec::new() };
        let mut planned = Plan::new(&Options::default())?.runs;
        planned.sort_by_key(|run| run.name != HOME);
        planned.retain(|run| with_rungs || run.name == HOME);
        for run in planned {
            let clocks = JobWatch::alone();
            let product = convert_read(&asset, &run.options, &limits, &clocks)?;
            size.texel_count = product.report.growth.converted_texels;
            let stages: Vec<_> = read_figures.iter().cloned().chain(clocks.finish()).collect();
            size.runs.push(SizeRun { name: run.name, cost: cost_of(&stages) });
        }
        self.sizes.push(size);
        Ok(())
    }

    /// What is drawn and fitted: a name, and a figure at every size that has it.
    fn series(&self, name: &str, figure: impl Fn(&Size) -> Option<f64>) -> Series {
        let points = self.sizes.iter().filter_map(|size| Some((size.face_count as f64, figure(size)?)));
        Series { name: name.to_owned(), points: points.filter(|(_, value)| *value > 0.0).collect() }
    }

    /// CPU seconds of each stage of `standard`.
    fn stages(&self) -> Vec<Series> {
        let stage = |name: &str| {
            self.series(name, |size| {
                let stages = &size.runs.first()?.cost.stages;
                Some(stages.iter().find(|stage| stage.stage == name)?.cpu_seconds)
            })
        };
        Stage::ALL.iter().map(|s| stage(s.name())).filter(|series| !series.points.is_empty()).collect()
    }

    /// CPU seconds of each run without reading, measuring and writing.
    fn runs(&self) -> Vec<Series> {
        let mut names: Vec<&str> = Vec::new();
        for run in self.sizes.iter().flat_map(|size| &size.runs) {
            if !names.contains(&run.name.as_str()) {
                names.push(&run.name);
            }
        }
        let run = |name: &&str| {
            let found = |size: &Size| size.runs.iter().find(|run| run.name == *name).cloned();
            self.series(name, |size| Some(found(size)?.cost.converting_cpu_seconds))
        };
        names.iter().map(run).collect()
    }

    /// Peak memory of `standard`, MiB.
    fn memory(&self) -> Series {
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        self.series("peak memory", |size| size.runs.first()?.cost.peak_memory_bytes.map(mib))
    }
}

/// A figure by the number of faces.
struct Series {
    name: String,
    points: Vec<(f64, f64)>,
}

impl Series {
    /// The exponent of growth: the slope of the logarithms by least squares; `None` with less than three
    /// sizes.
    fn exponent(&self) -> Option<f64> {
        let logs = self.points.iter().filter(|(faces, _)| *faces >= FITTED_FROM as f64 * 0.9);
        let logs: Vec<(f64, f64)> = logs.map(|(faces, value)| (faces.ln(), value.ln())).collect();
        if logs.len() < 3 {
            return None;
        }
        let count = logs.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(|point| point.0), mean(|point| point.1));
        let above: f64 = logs.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
        let below: f64 = logs.iter().map(|point| (point.0 - x).powi(2)).sum();
        Some(above / below)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_those_of_the_powers() {
        let faces = [1e4, 1e5, 1e6];
        let series = |power: f64| Series {
            name: String::new(),
            points: faces.iter().map(|n: &f64| (*n, 3.0 * n.powf(power))).collect(),
        };
        assert!((series(1.5).exponent().unwrap() - 1.5).abs() < 1e-9);
        let few = Series { name: String::new(), points: vec![(1e3, 1.0), (1e4, 2.0), (1e5, 3.0)] };
        assert_eq!(few.exponent(), None, "the smallest size does not count");
    }

    #[test]
    fn a_small_torus_is_converted_and_drawn() {
        let mut scaling = Scaling::begin();
        for faces in [100, 200] {
            scaling.add(faces, false).unwrap();
        }
        assert_eq!(scaling.sizes[0].face_count, 100);
        assert!(scaling.sizes[1].texel_count > scaling.sizes[0].texel_count);
        assert!(text(&scaling).contains("solve"));
        crate::plot::png(&svg(&scaling)).unwrap();
    }
}
