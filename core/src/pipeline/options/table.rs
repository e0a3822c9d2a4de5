//! Every option as interfaces show it, and the names that options take.

use crate::assign::{Range, Rounding};
use crate::layout::{Coordinates, Packing};
use crate::mip::{Beyond, MipFilter};
use crate::resample::Sampling;
use crate::solve::Solver;
use crate::write::GeometryFormat;
use crate::write::textures::{BlockFormat, TextureFormat};

use super::super::vertex_colors::VertexColors;
use super::Quality;
use super::text::{NONE, names};

pub const QUALITIES: &[(&str, Quality)] =
    &[("draft", Quality::Draft), ("standard", Quality::Standard), ("exact", Quality::Exact)];
/// `filtered` takes a count behind a colon too.
pub const SAMPLINGS: &[(&str, Sampling)] =
    &[("point", Sampling::Point), ("filtered", Sampling::Filtered(None)), ("fitted", Sampling::Fitted)];
pub const MIP_FILTERS: &[(&str, MipFilter)] = &[("uniform", MipFilter::Uniform), ("area", MipFilter::Area)];
pub const BEYONDS: &[(&str, Beyond)] = &[("one-ring", Beyond::OneRing), ("heat", Beyond::Heat)];
pub const SOLVERS: &[(&str, Solver)] = &[
    ("clamp", Solver::Clamp),
    ("local", Solver::Local),
    ("global", Solver::Global),
    ("exact", Solver::Exact),
];
pub const RANGES: &[(&str, Range)] =
    &[("unorm8", Range::Unorm8), ("scaled16", Range::Scaled16), ("float16", Range::Float16)];
/// Off and on.
pub const SWITCH: &[(&str, bool)] = &[("false", false), ("true", true)];
const SWITCH_ALLOWED: &str = "false, true";
/// Of `max-size`.
pub const MAX_SIDE_LEAST: u32 = 2048;
pub const MAX_SIDE_MOST: u32 = 16384;
/// More than any set of textures has.
pub const TEXELS_MAX: u64 = 1 << 32;
pub const ROUNDINGS: &[(&str, Rounding)] = &[("nearest", Rounding::Nearest), ("rules", Rounding::Rules)];
pub const COORDINATES: &[(&str, Coordinates)] =
    &[("4d-rows", Coordinates::ScaledInRows), ("4d", Coordinates::Scaled), ("indexed", Coordinates::Indexed)];
pub const PACKINGS: &[(&str, Packing)] = &[("quick", Packing::Quick), ("tight", Packing::Tight)];
pub const TEXTURES: &[(&str, TextureFormat)] =
    &[("png", TextureFormat::Png), ("ktx2", TextureFormat::Ktx2), ("exr", TextureFormat::Exr)];
pub const BLOCKS: &[(&str, BlockFormat)] = &[
    ("bc7", BlockFormat::Bc7),
    ("bc5", BlockFormat::Bc5),
    ("bc6h", BlockFormat::Bc6h),
    ("astc", BlockFormat::Astc),
];

pub const GEOMETRIES: &[(&str, GeometryFormat)] = &[
    ("plain", GeometryFormat::Plain),
    ("meshopt", GeometryFormat::Meshopt),
    ("quantized", GeometryFormat::Quantized),
];

pub const VERTEX_COLORS: &[(&str, VertexColors)] =
    &[("keep", VertexColors::Keep), ("auto", VertexColors::Auto), ("bake", VertexColors::Bake)];

/// One option as every interface shows it.
#[derive(Clone, Copy, Debug)]
pub struct OptionSpec {
    /// `--name` on the command line, the field's name over HTTP.
    pub name: &'static str,
    /// What stands for the value in help texts.
    pub value_name: &'static str,
    /// Without the option; of the preset `standard` where the option follows the quality.
    pub default: &'static str,
    /// Whether `quality` sets it too, for whoever doesn't name it.
    pub follows_quality: bool,
    /// Whether it takes several values with commas between them, or each by itself.
    pub is_list: bool,
    /// The names that it takes, from the cheapest on; empty where it takes figures.
    pub rungs: &'static [&'static str],
    /// The values that are allowed, in words.
    pub allowed: &'static str,
    pub doc: &'static str,
}

impl OptionSpec {
    /// Whether it is on or off, and on where it is named without a value.
    pub fn is_switch(&self) -> bool {
        self.allowed == SWITCH_ALLOWED
    }
}

pub const OPTIONS: &[OptionSpec] = &[
    OptionSpec {
        name: "quality",
        value_name: "PRESET",
        default: "standard",
        follows_quality: false,
        is_list: false,
        rungs: &names::<_, 3>(QUALITIES),
        allowed: "draft, standard, exact",
        doc: "A set of rungs, one of each ladder below, and a resolution; what is named by itself counts before it",
    },
    OptionSpec {
        name: "sampling",
        value_name: "RUNG",
        default: "point",
        follows_quality: true,
        is_list: false,
        rungs: &names::<_, 3>(SAMPLINGS),
        allowed: "point, filtered or filtered:K with K in 1..=16 (fetches along a side of a cell; without K, one for each source texel), fitted",
        doc: "How a sample gets its value: one bilinear fetch, the source integrated against the sample's hat function, or the samples whose interpolation is nearest to the source",
    },
    OptionSpec {
        name: "resolution",
        value_name: "RULE",
        default: "area:1",
        follows_quality: true,
        is_list: false,
        rungs: &[],
        allowed: "area:F with F in 0.001..=64 (texels per source texel), fixed:R with R in 0..=12 (sides of 2^R segments), density:D with D in 1e-6..=1e9 (texels per world unit)",
        doc: "How many samples a face gets",
    },
    OptionSpec {
        name: "max-error",
        value_name: "CODES",
        default: NONE,
        follows_quality: false,
        is_list: false,
        rungs: &[],
        allowed: "none, or 0.01..=255 (8-bit codes: root mean square over a face, and four times that anywhere)",
        doc: "Faces get as few samples as show every channel within this of the source, at most as many as by `resolution`",
    },
    OptionSpec {
        name: "texels",
        value_name: "COUNT",
        default: NONE,
        follows_quality: false,
        is_list: false,
        rungs: &[],
        allowed: "none, or 1..=4294967296 (texels of level 0 of one channel, all materials together)",
        doc: "A budget, spent over all faces and channels where it takes away most error; a face gets at most four times the texels that `resolution` gives it, or as many as by `max-error`",
    },
    OptionSpec {
        name: "mip",
        value_name: "RUNG",
        default: "area",
        follows_quality: true,
        is_list: false,
        rungs: &names::<_, 2>(MIP_FILTERS),
        allowed: "uniform, area",
        doc: "How a coarse sample weighs the fine ones around it: by its hat function alone, or by their surface area too",
    },
    OptionSpec {
        name: "beyond",
        value_name: "RUNG",
        default: "heat",
        follows_quality: true,
        is_list: false,
        rungs: &names::<_, 2>(BEYONDS),
        allowed: "one-ring, heat",
        doc: "How levels go on where a face is down to its vertices: the mean over neighboring vertices, or heat flow over the surface",
    },
    OptionSpec {
        name: "solver",
        value_name: "RUNG",
        default: "global",
        follows_quality: true,
        is_list: false,
        rungs: &names::<_, 4>(SOLVERS),
        allowed: "clamp, local, global, exact",
        doc: "What is done about texels outside the format's range: clamp them, change samples face by face, the least change of the whole level, or the same by a library (slow)",
    },
    OptionSpec {
        name: "range",
        value_name: "RUNG",
        default: "float16",
        follows_quality: true,
        is_list: false,
        rungs: &names::<_, 3>(RANGES),
        allowed: "unorm8 (codes as the source has them), scaled16 (16 bits with a scale and a bias), float16",
        doc: "How levels are stored where texels beyond vertex colors leave [0, 1], more than 5 % of the count of samples",
    },
    OptionSpec {
        name: "rounding",
        value_name: "RUNG",
        default: "rules",
        follows_quality: true,
        is_list: false,
        rungs: &names::<_, 2>(ROUNDINGS),
        allowed: "nearest, rules",
        doc: "How samples become codes: each texel to the nearest, or samples first, so that texels made from them keep their rules",
    },
    OptionSpec {
        name: "coordinates",
        value_name: "RUNG",
        default: "indexed",
        follows_quality: true,
        is_list: false,
        rungs: &names::<_, 3>(COORDINATES),
        allowed: "4d-rows (the paper's: squares in rows), 4d (rectangles in shelves), indexed",
        doc: "How a viewer finds texels: u_s / 2^level + u_delta, or by the number of a face's block and a table of levels, which needs fewer texels and no change of colors at coarse levels",
    },
    OptionSpec {
        name: "packing",
        value_name: "RUNG",
        default: "tight",
        follows_quality: true,
        is_list: false,
        rungs: &names::<_, 2>(PACKINGS),
        allowed: "quick, tight",
        doc: "How long a way to set out the levels is looked for that leaves next to nothing empty (with indexed coordinates)",
    },
    OptionSpec {
        name: "no-share",
        value_name: "BOOL",
        default: "false",
        follows_quality: false,
        is_list: false,
        rungs: &[],
        allowed: SWITCH_ALLOWED,
        doc: "Every face has texels of its own, also where others store the same: mirrored halves, tiles, stamps (4d never shares)",
    },
    OptionSpec {
        name: "merge",
        value_name: "BOOL",
        default: "false",
        follows_quality: false,
        is_list: false,
        rungs: &[],
        allowed: SWITCH_ALLOWED,
        doc: "Materials whose channels are of the same kinds get one set of textures, so that they can be drawn at once",
    },
    OptionSpec {
        name: "max-size",
        value_name: "TEXELS",
        default: "8192",
        follows_quality: false,
        is_list: false,
        rungs: &[],
        allowed: "2048..=16384",
        doc: "Largest side of a texture; what needs more is split into several, and so are primitives",
    },
    OptionSpec {
        name: "cut",
        value_name: "CODES",
        default: "8",
        follows_quality: false,
        is_list: false,
        rungs: &[],
        allowed: "0..=255 (8-bit codes; 2 codes stand for 1 degree of a normal)",
        doc: "Edges whose two sides differ by more than this at full resolution keep their two sides",
    },
    OptionSpec {
        name: "textures",
        value_name: "FORMATS",
        default: NONE,
        follows_quality: false,
        is_list: true,
        rungs: &[],
        allowed: "none, or one or several of png, ktx2, exr with commas between them",
        doc: "The levels as loose files too, one for each, for engines that load textures by themselves",
    },
    OptionSpec {
        name: "compress",
        value_name: "FORMATS",
        default: NONE,
        follows_quality: false,
        is_list: true,
        rungs: &[],
        allowed: "none, or one or several of bc7 or astc (8 bits), bc5 (normal maps, two components of data), bc6h (levels in a range of their own, without alpha) with commas between them; textures has to have ktx2",
        doc: "What the loose KTX2 files hold: blocks that GPUs decode as they sample, where a format fits the level. The two sides of an edge come out differently, and the report says by how much",
    },
    OptionSpec {
        name: "mesh-colors",
        value_name: "SWITCH",
        default: "false",
        follows_quality: false,
        is_list: false,
        rungs: &[],
        allowed: SWITCH_ALLOWED,
        doc: "Writes the samples themselves too, as `mesh_colors.glb`, which can be converted again",
    },
    OptionSpec {
        name: "geometry",
        value_name: "FORMAT",
        default: "plain",
        follows_quality: false,
        is_list: false,
        rungs: &[],
        allowed: "plain, meshopt, quantized",
        doc: "How `asset.glb` stores vertices and indices: as they are, packed by EXT_meshopt_compression, or packed with positions, normals and tangents rounded; mesh color coordinates stay exact",
    },
    OptionSpec {
        name: "vertex-colors",
        value_name: "RUNG",
        default: "auto",
        follows_quality: false,
        is_list: false,
        rungs: &[],
        allowed: "keep, auto, bake",
        doc: "What becomes of vertex colors (COLOR_0): they stay as they are, or they become the base color of materials that have no texture at all, or they multiply every base color; taken ones leave the vertices",
    },
    OptionSpec {
        name: "channel",
        value_name: "NAME=IMAGE",
        default: NONE,
        follows_quality: false,
        is_list: true,
        rungs: &[],
        allowed: "none, or one or several of NAME=IMAGE, NAME@MATERIAL=IMAGE, each with #SET behind it where not TEXCOORD_0 places the \
                  image, with commas between them; NAME has 1 to 32 letters, digits, `_` and `-`, a letter first",
        doc: "Images that become channels beside those of the material: baked light, thickness, height, masks. IMAGE is a file beside \
              the model, PNG, JPEG, WebP or KTX2 (data of 8 or 16 bits), or OpenEXR (numbers of any size)",
    },
];
