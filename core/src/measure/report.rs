//! The report's types: what `report.json` holds. Everything in it is a function of input, options and
//! version; times and memory stand in `run.json`.

mod storing;

use serde::{Deserialize, Serialize};

use crate::error::Warning;

pub use storing::{SolverComponent, SolverReport, StoredReport};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// `converted` for a conversion or a converted file, `source` for a plain model, `mesh_colors` for one whose materials have
    /// these instead of textures.
    pub kind: SubjectKind,
    pub engine_version: String,
    pub verdict: Verdict,
    /// Broken guarantees, one sentence each.
    pub errors: Vec<String>,
    pub warnings: Vec<Warning>,
    /// Largest seam over all channels that are measured in codes, uncut edges, all levels.
    pub max_seam_delta_codes: f64,
    /// The options as resolved, by their names on the command line.
    pub options: serde_json::Map<String, serde_json::Value>,
    pub channels: Vec<ChannelReport>,
    pub layouts: Vec<LayoutReport>,
    pub growth: Growth,
    pub effects: Vec<Effect>,
    /// Channels with levels in blocks (`compress`).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub compression: Vec<CompressionReport>,
    /// Of a file with mesh colors that was checked: every channel of every material that has them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mesh_colors: Vec<MeshColorsReport>,
}

/// A channel of mesh colors that fits its faces.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshColorsReport {
    /// Index into the model's materials.
    pub material: usize,
    /// glTF slot names.
    pub slots: Vec<String>,
    /// Triangles and quads; two triangles that are one quad count once.
    pub face_count: u64,
    pub sample_count: u64,
    /// Of a sample.
    pub components: u8,
    /// Edges whose two sides have samples of their own.
    pub cut_edge_count: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SubjectKind {
    Source,
    Converted,
    MeshColors,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every guarantee holds.
    Pass,
    /// It holds, and something deserves a look.
    Warn,
    /// A guarantee of the bundle is broken.
    Fail,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// 8-bit code values: sRGB-encoded for color, the value for data, times 255.
    Codes,
    /// Degrees between decoded object-space normals.
    Degrees,
}

/// One channel of one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelReport {
    /// Index into the model's materials.
    pub material: usize,
    pub material_name: String,
    /// glTF slot names.
    pub slots: Vec<String>,
    pub unit: Unit,
    pub components: u32,
    /// Bits of one stored code.
    pub bits: u32,
    /// Of attributes whose numbers may be of any size: what 255 codes of this report stand for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value_scale: Option<f32>,
    /// Which edges were joined, by share of seam length (edges where the source's charts meet).
    pub cuts: CutShare,
    pub levels: Vec<LevelReport>,
    pub fidelity: Option<Fidelity>,
    /// One entry for each level that had anything out of range.
    pub solver: Vec<SolverReport>,
    /// One entry for each level that is stored in a range of its own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stored: Vec<StoredReport>,
}

/// Seam edges of the source: edges between faces of one unit whose texture coordinates differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CutShare {
    pub seam_edge_count: u64,
    /// Length of seam edges over the length of all inner edges, world units, 0 to 1.
    pub seam_share: f64,
    /// Of the seam length, the share joined.
    pub welded_share: f64,
    /// Of the seam length, the share kept as cuts.
    pub cut_share: f64,
    /// Cut edges, seam or not.
    pub cut_edge_count: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelReport {
    pub level: u32,
    /// Width and height in texels; of a material in parts those of the first, see `layouts` for others.
    pub size: [u32; 2],
    /// Over uncut edges (of a plain source: over all seam edges).
    pub seams: Option<Figures>,
    /// The same with filter weights of 8 bits, over the edges that have a face beyond vertex colors on a
    /// side; absent where there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seams_8bit_weights: Option<Figures>,
    /// `scaled16` or `float16`; absent where the level holds codes of [0, 1].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<String>,
    /// Mean jump over the seam edges whose two sides agree in the source at level 0.
    pub drift: Option<f64>,
    /// The same figures of the source with ordinary mip maps, at its level of this number.
    pub source: Option<SourceLevel>,
    /// How far the level is from the source's mean over the surface around a point. Absent at level 0,
    /// which `fidelity` judges, and where the source is not known.
    #[serde(default)]
    pub mip_error: Option<MipError>,
}

/// A level beside a Gaussian average of the full-resolution source over the surface, at probe points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MipError {
    /// Root mean square, in the channel's unit; for colors and data over all components.
    pub rms: f64,
    /// 99th percentile of the same errors.
    pub p99: f64,
    pub probe_count: u64,
    /// What the averages themselves are off by (standard error, root mean square over the probes), in the
    /// channel's unit: they are sums over finitely many points. It is part of `rms`, in square.
    pub reference_error: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SourceLevel {
    pub size: [u32; 2],
    pub seams: Option<Figures>,
    pub drift: Option<f64>,
}

/// Statistics of jumps between the two sides of edges, in the channel's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    pub max: f64,
    /// 99.9th percentile of the samples.
    pub p999: f64,
    /// Weighted by edge length.
    pub mean: f64,
    /// 19 for each edge; where an edge stays inside one cell of texels, five positions count for them.
    pub sample_count: u64,
}

/// Faithfulness at level 0, at random points of the surface. Of mesh colors as a source against their samples as the reference
/// filter reads them: linearly (MC 4.1).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fidelity {
    /// Decibels over 255 codes; 99 stands for "no difference". Degrees' root mean square for normals is
    /// in `rms`.
    pub psnr_db: f64,
    /// Root mean square error in the channel's unit.
    pub rms: f64,
    /// 99th percentile and largest of the errors that `rms` is the root mean square of: for colors and
    /// data one for each component of each point, for normals one angle for each point.
    #[serde(default)]
    pub p99: f64,
    #[serde(default)]
    pub max: f64,
    /// What one bilinear resampling of the source onto a grid turned by 27° gives at as many texels. Vertex colors that multiply a
    /// texture stay as they are. Absent where the source is mesh colors: it has no image to resample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yardstick_psnr_db: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yardstick_rms: Option<f64>,
    pub point_count: u64,
}

/// A channel in blocks, beside what it was before. Levels that no format fits are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompressionReport {
    /// Index into the model's materials.
    pub material: usize,
    pub material_name: String,
    /// glTF slot names.
    pub slots: Vec<String>,
    pub unit: Unit,
    pub levels: Vec<CompressedLevel>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompressedLevel {
    pub level: u32,
    /// As the option `compress` names it.
    pub format: String,
    /// All blocks, before Zstandard.
    pub bytes: u64,
    /// What a GPU reads, against the level before: decibels over 255 codes, over all texels, those that no face uses
    /// too, and all components (of normals in BC5: x and y); 99 stands for "no difference".
    pub psnr_db: f64,
    /// Over uncut edges, before.
    pub seams_before: Option<Figures>,
    /// The same of blocks made without regard to edges.
    pub seams_unfitted: Option<Figures>,
    /// The same of the blocks that are stored: fitted again to what the other sides of edges got, where that
    /// makes the mean less.
    pub seams: Option<Figures>,
    pub is_refitted: bool,
}

/// The layout of one set of textures: a material's, one of its parts', or one that several materials share.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayoutReport {
    /// The first of its materials, and its name.
    pub material: usize,
    pub material_name: String,
    /// All that share it, ascending; absent where it is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<usize>,
    /// Which part of each of them; absent for 0.
    #[serde(default, skip_serializing_if = "is_first")]
    pub part: usize,
    pub face_count: u64,
    pub quad_count: u64,
    pub merged_pair_count: u64,
    pub lone_triangle_count: u64,
    /// Faces by resolution exponent (of an elongated face the larger one), from 0.
    pub exponents: Vec<u64>,
    #[serde(default)]
    pub coordinates: CoordinatesKind,
    /// With indexed coordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<TableReport>,
    /// Of a conversion with indexed coordinates; over all parts, with the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub savings: Option<SavingsReport>,
    pub levels: Vec<LayoutLevel>,
}

fn is_first(part: &usize) -> bool {
    *part == 0
}

/// How corners name texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum CoordinatesKind {
    /// By a scaled part and an offset (MCT equation 2).
    #[default]
    #[serde(rename = "4d")]
    FourD,
    /// By the number of a block, which a table places at each level.
    #[serde(rename = "indexed")]
    Indexed,
}

/// What is stored once instead of several times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SavingsReport {
    /// Faces (a pair of triangles is one) that use the texels of another that stores the same.
    pub shared_face_count: u64,
    /// What they would take, at level 0 and at all levels together.
    pub shared_texels: u64,
    pub shared_texels_all_levels: u64,
    /// Faces that stand in larger blocks.
    pub joined_face_count: u64,
    /// What they would take more by themselves.
    pub joined_texels: u64,
    pub joined_texels_all_levels: u64,
}

/// The table of indexed coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableReport {
    /// Shapes of blocks.
    pub class_count: u64,
    /// What a shader holds of it, all levels.
    pub byte_count: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayoutLevel {
    pub level: u32,
    pub size: [u32; 2],
    pub allocated_texels: u64,
    /// Share of the allocated texels that no face uses (MCT Table 1).
    pub waste: f64,
    /// Distinct samples over allocated texels; absent where the samples are not known (a converted file
    /// on its own does not tell them).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub efficiency: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// Texels of all source images of converted materials, level 0.
    pub source_texels: u64,
    /// Texels of all converted images, level 0.
    pub converted_texels: u64,
    /// Texels of all converted images, all levels.
    pub converted_texels_all_levels: u64,
    pub source_vertices: u64,
    pub converted_vertices: u64,
    pub source_bytes: u64,
    pub converted_bytes: u64,
}

/// One thing that the conversion did, or left because the asset does not call for it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Effect {
    /// Snake-case name, such as `normal_encoding`.
    pub name: String,
    pub state: EffectState,
    /// Skipped: why. Run: what it did, with a figure.
    pub detail: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EffectState {
    Run,
    Skipped,
}
