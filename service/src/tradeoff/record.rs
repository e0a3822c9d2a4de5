//! The record: what `tradeoff.json` holds, and all that the table and the picture are made of.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::curve::Curve;

/// The version of the record's form; changes with the meaning or the place of any field.
pub const RECORD_VERSION: u32 = 1;

/// One asset, converted by every rung.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tradeoff {
    pub record_version: u32,
    pub engine_version: String,
    /// The model's file name without its ending.
    pub model: String,
    pub face_count: u64,
    /// The options that are no ladder: cuts, which hold for every run, and the resolution, of which a preset may have its
    /// own.
    pub options: Map<String, Value>,
    pub started_at: String,
    pub machine: Machine,
    /// How often each conversion ran; the cost is that of the fastest.
    pub repeat_count: u32,
    pub presets: Vec<Preset>,
    pub ladders: Vec<Ladder>,
    /// The run with the rungs that the caller named.
    pub asked: usize,
    /// Each conversion once; presets and rungs refer to it by its place.
    pub runs: Vec<Run>,
    /// Texels against error; absent in records of before it was taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<Curve>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    pub os: String,
    pub architecture: String,
    pub processor_count: usize,
    pub thread_count: usize,
}

/// A whole set of rungs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Preset {
    pub name: String,
    pub run: usize,
}

/// The preset `standard` with each rung of one ladder in turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ladder {
    pub name: String,
    pub rungs: Vec<Rung>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rung {
    pub name: String,
    pub run: usize,
    /// Whether `standard` has it.
    pub is_home: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    pub name: String,
    /// Every option as resolved.
    pub options: Map<String, Value>,
    #[serde(flatten)]
    pub end: End,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum End {
    Done(Box<Done>),
    /// The rung cannot be had on this asset: the error's code, and why.
    Refused {
        code: String,
        reason: String,
    },
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Done {
    pub cost: Cost,
    pub errors: Errors,
    pub output: Output,
    /// Whether both sides of every edge agree, as a conversion promises.
    pub is_seamless: bool,
    /// No other seamless run is better in both the time and the error of level 0.
    pub is_on_front: bool,
    /// The same for the error over all levels.
    pub is_on_mip_front: bool,
}

/// What a run cost. CPU time and memory are the process's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Of the stages that rungs decide about, [`super::run::CONVERTING`].
    pub converting_cpu_seconds: f64,
    /// Of all stages, reading included.
    pub cpu_seconds: f64,
    pub seconds: f64,
    pub peak_memory_bytes: Option<u64>,
    pub stages: Vec<StageCost>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageCost {
    pub stage: String,
    pub seconds: f64,
    pub cpu_seconds: f64,
    pub peak_memory_bytes: Option<u64>,
}

/// How near a run came to the source, over all channels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Color and data channels, in 8-bit codes.
    pub codes: Option<UnitErrors>,
    /// Normal maps, in degrees.
    pub degrees: Option<UnitErrors>,
    /// What the solver changed, and storing in a range; absent where neither had to do with any level.
    pub change: Option<Change>,
}

/// The errors of all channels that are measured in one unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnitErrors {
    /// Level 0 against the source.
    pub level_0: Spread,
    /// Level 0, then each level that was measured against the mean of the source over the surface.
    pub levels: Vec<LevelError>,
    /// Root mean square over the levels, each counting alike; absent where level 0 is all there is.
    pub all_levels_rms: Option<f64>,
    /// Largest jump over uncut edges, all levels.
    pub seam_max: f64,
    /// Largest of the levels' 99.9th percentiles.
    pub seam_p999: f64,
}

/// Statistics of errors: over the channels the root mean square weighs each stored component alike, and
/// the others are those of the worst channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    pub rms: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p99: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelError {
    pub level: u32,
    #[serde(flatten)]
    pub error: Spread,
}

/// The worst of all channels and levels, each figure by itself, in codes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Change {
    pub mean_codes: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p95_codes: Option<f64>,
    pub max_codes: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Output {
    pub texels: u64,
    pub texels_all_levels: u64,
    pub bytes: u64,
}

impl Errors {
    /// The errors to compare runs by: codes, or degrees where there is nothing but normal maps.
    pub fn main(&self) -> Option<(&UnitErrors, &'static str)> {
        let codes = self.codes.as_ref().map(|errors| (errors, "codes"));
        codes.or(self.degrees.as_ref().map(|errors| (errors, "degrees")))
    }
}

impl Run {
    pub fn done(&self) -> Option<&Done> {
        match &self.end {
            End::Done(done) => Some(done),
            End::Refused { .. } => None,
        }
    }
}

impl Done {
    /// Error of level 0.
    pub fn level_0_error(&self) -> Option<f64> {
        self.errors.main().map(|(errors, _)| errors.level_0.rms)
    }

    /// Error over all levels.
    pub fn mip_error(&self) -> Option<f64> {
        self.errors.main().and_then(|(errors, _)| errors.all_levels_rms)
    }
}

impl Tradeoff {
    pub fn preset(&self, name: &str) -> Option<&Run> {
        let preset = self.presets.iter().find(|preset| preset.name == name)?;
        self.runs.get(preset.run)
    }
}
