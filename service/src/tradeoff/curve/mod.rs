//! Texels against error: what a budget buys, beside the resolution that matches the source's area and beside the source
//! itself, resampled to as many texels (the report's yardstick, which every run has at its own number of texels).

mod run;
mod table;
#[cfg(test)]
mod tests;

use meshcolor::measure::Report;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

pub use run::{RUN_COUNT, area_matched, run};
pub use table::{headline, table};

/// Faces of fewer texels than this on the average are mostly corners, which cannot be coarser.
pub const FLOOR_TEXELS: u64 = 4;
const BASE_COLOR: &str = "baseColorTexture";

/// The runs along the curve. The counts of texels are those of level 0 of one map, all materials together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Of the finest source image of each material; absent where the runs do not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source_texels: Option<u64>,
    /// Faces as they are stored: quads, pairs of triangles, and triangles alone.
    pub stored_face_count: u64,
    /// CPU seconds of all its runs, all stages; the run that `standard` shares with it is not among them.
    pub cpu_seconds: f64,
    pub lines: Vec<Line>,
}

/// Runs that differ in their texels alone, the fewest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    pub name: String,
    pub points: Vec<Point>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Of the texels (of the source's area) that the area-matched run with the most has.
    pub share: f64,
    /// Every option as resolved.
    pub options: Map<String, Value>,
    #[serde(flatten)]
    pub end: PointEnd,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum PointEnd {
    Done(Figures),
    /// The error's code, and why: a budget may be less than what the faces' corners take.
    Refused {
        code: String,
        reason: String,
    },
}

/// What one run came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    pub texels: u64,
    pub stored_face_count: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source_texels: Option<u64>,
    pub maps: Vec<MapError>,
}

/// The error of one map of one material at level 0, decibels over 255 codes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapError {
    pub material: usize,
    /// glTF slot names.
    pub slots: Vec<String>,
    pub psnr_db: f64,
    /// Of the source resampled once to as many texels.
    pub yardstick_psnr_db: f64,
}

impl MapError {
    /// How much nearer to the source than one resampling of it.
    pub fn gain_db(&self) -> f64 {
        self.psnr_db - self.yardstick_psnr_db
    }
}

/// What a report tells of texels and errors.
pub fn figures_of(report: &Report) -> Figures {
    let texels = report.layouts.iter().filter_map(|layout| layout.levels.first());
    let faces = report.layouts.iter().map(|l| l.quad_count + l.merged_pair_count + l.lone_triangle_count);
    let maps = report.channels.iter().filter_map(|channel| {
        let fidelity = channel.fidelity.as_ref()?;
        Some(MapError {
            material: channel.material,
            slots: channel.slots.clone(),
            psnr_db: fidelity.psnr_db,
            yardstick_psnr_db: fidelity.yardstick_psnr_db?,
        })
    });
    Figures {
        texels: texels.map(|level| level.allocated_texels).sum(),
        stored_face_count: faces.sum(),
        source_texels: source_texels(report),
        maps: maps.collect(),
    }
}

/// Of each material the most that one of its maps has in the source.
fn source_texels(report: &Report) -> Option<u64> {
    let mut by_material = std::collections::BTreeMap::new();
    for channel in &report.channels {
        let [width, height] = channel.levels.first()?.source.as_ref()?.size.map(u64::from);
        let most = by_material.entry(channel.material).or_insert(0);
        *most = width.saturating_mul(height).max(*most);
    }
    (!by_material.is_empty()).then(|| by_material.values().sum())
}

impl Figures {
    /// Of all base colors, as one picture; where there is none, of the first map. And of the yardstick.
    pub fn color_psnr_db(&self) -> Option<[f64; 2]> {
        let colors: Vec<_> =
            self.maps.iter().filter(|map| map.slots.iter().any(|slot| slot == BASE_COLOR)).collect();
        let maps = if colors.is_empty() { self.maps.first().into_iter().collect() } else { colors };
        Some([
            joined_db(maps.iter().map(|map| map.psnr_db))?,
            joined_db(maps.iter().map(|map| map.yardstick_psnr_db))?,
        ])
    }

    /// Over all maps how much nearer than one resampling: the mean, the least, the most.
    pub fn gains_db(&self) -> Option<[f64; 3]> {
        let gains = || self.maps.iter().map(MapError::gain_db);
        let least = gains().reduce(f64::min)?;
        Some([gains().sum::<f64>() / self.maps.len() as f64, least, gains().reduce(f64::max)?])
    }

    /// Whether faces have more than their corners' texels, on the average.
    pub fn is_above_floor(&self) -> bool {
        self.texels > FLOOR_TEXELS * self.stored_face_count
    }
}

/// The PSNR of pictures of one size side by side.
fn joined_db(psnrs: impl Iterator<Item = f64>) -> Option<f64> {
    let squares: Vec<f64> = psnrs.map(|psnr| 10f64.powf(-psnr / 10.0)).collect();
    (!squares.is_empty()).then(|| -10.0 * (squares.iter().sum::<f64>() / squares.len() as f64).log10())
}

impl Line {
    /// Its runs that came to an end, the fewest texels first.
    pub fn done(&self) -> impl Iterator<Item = &Figures> {
        self.points.iter().filter_map(|point| match &point.end {
            PointEnd::Done(figures) => Some(figures),
            PointEnd::Refused { .. } => None,
        })
    }
}

impl Curve {
    /// The line that shows what the converter can do.
    pub fn best(&self) -> Option<&Line> {
        self.lines.iter().find(|line| line.name == run::BEST)
    }
}
