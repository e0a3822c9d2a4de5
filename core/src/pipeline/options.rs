//! The options of a conversion, each defined once: flags, HTTP fields, OpenAPI and the docs come from
//! [`OPTIONS`].

mod channels;
mod table;
#[cfg(test)]
mod tests;
mod text;

use std::collections::BTreeSet;

use serde_json::{Map, Value};

use crate::assign::{Range, Rounding};
use crate::error::{Error, ErrorCode, Result};
use crate::layout::{Coordinates, Packing};
use crate::mip::{Beyond, MipFilter};
use crate::read::AttributeSource;
use crate::resample::{Resolution, Sampling};
use crate::solve::Solver;
use crate::write::GeometryFormat;
use crate::write::textures::{BlockFormat, TextureFormat};

use super::vertex_colors::VertexColors;

use table::{
    BEYONDS, BLOCKS, COORDINATES, GEOMETRIES, MAX_SIDE_LEAST, MAX_SIDE_MOST, MIP_FILTERS, PACKINGS,
    QUALITIES, RANGES, ROUNDINGS, SAMPLINGS, SOLVERS, SWITCH, TEXELS_MAX, TEXTURES, VERTEX_COLORS,
};
pub use table::{OPTIONS, OptionSpec};
use text::{NONE, in_range, list, name_of, named, optional, parse_list};

#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The preset that the rungs below were taken from; each may have been set by itself since.
    pub quality: Quality,
    pub sampling: Sampling,
    pub resolution: Resolution,
    /// Faces get no finer samples than keep them within so many codes of the source.
    pub max_error: Option<f32>,
    /// Level 0 of all materials together has no more texels than this.
    pub texels: Option<u64>,
    pub mip: MipFilter,
    pub beyond: Beyond,
    pub solver: Solver,
    pub range: Range,
    pub rounding: Rounding,
    pub coordinates: Coordinates,
    /// Of indexed coordinates.
    pub packing: Packing,
    /// Whether faces that store the same use one block.
    pub shares: bool,
    /// Whether materials that have the same kinds of channels get one layout.
    pub merges: bool,
    /// Largest side of a texture; what needs more becomes several.
    pub max_side: u32,
    /// Edges whose two sides differ by more than this many codes are kept as cuts.
    pub cut_codes: f32,
    /// What the levels come along as, beside `asset.glb`.
    pub textures: BTreeSet<TextureFormat>,
    /// What KTX2 files hold instead of texels, where it fits.
    pub compress: BTreeSet<BlockFormat>,
    /// Whether the samples of level 0 come along too.
    pub mesh_colors: bool,
    /// How vertices and indices of `asset.glb` are stored.
    pub geometry: GeometryFormat,
    /// Whether vertex colors become base color.
    pub vertex_colors: VertexColors,
    /// Images that become channels of their own.
    pub channels: Vec<AttributeSource>,
}

impl Default for Options {
    fn default() -> Self {
        Self::of(Quality::Standard)
    }
}

/// A set of rungs, one of each ladder, and how many samples there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    Draft,
    Standard,
    Exact,
}

impl Options {
    /// The rungs of a preset, and the defaults of everything else.
    pub fn of(quality: Quality) -> Self {
        let standard = Self {
            quality,
            sampling: Sampling::Point,
            resolution: Resolution::Area(1.0),
            max_error: None,
            texels: None,
            mip: MipFilter::Area,
            beyond: Beyond::Heat,
            solver: Solver::Global,
            range: Range::Float16,
            rounding: Rounding::Rules,
            coordinates: Coordinates::Indexed,
            packing: Packing::Tight,
            shares: true,
            merges: false,
            max_side: 8192,
            cut_codes: 8.0,
            textures: BTreeSet::new(),
            compress: BTreeSet::new(),
            mesh_colors: false,
            geometry: GeometryFormat::Plain,
            vertex_colors: VertexColors::Auto,
            channels: Vec::new(),
        };
        match quality {
            Quality::Draft => {
                let resolution = Resolution::Area(0.25);
                Self { resolution, mip: MipFilter::Uniform, packing: Packing::Quick, ..standard }
            }
            Quality::Standard => standard,
            Quality::Exact => Self { sampling: Sampling::Fitted, ..standard },
        }
    }

    /// Sets every rung to those of a preset.
    fn set_quality(&mut self, quality: Quality) {
        let Self {
            max_error,
            texels,
            shares,
            merges,
            max_side,
            cut_codes,
            textures,
            compress,
            mesh_colors,
            geometry,
            vertex_colors,
            channels,
            ..
        } = self.clone();
        *self = Self {
            max_error,
            texels,
            shares,
            merges,
            max_side,
            cut_codes,
            textures,
            compress,
            mesh_colors,
            geometry,
            vertex_colors,
            channels,
            ..Self::of(quality)
        };
    }

    /// Sets one option from its text form. `quality` sets all rungs, so it comes before them.
    ///
    /// # Errors
    /// `InvalidOptions`, naming the option, the value and what is allowed.
    pub fn set(&mut self, name: &str, value: &str) -> Result<()> {
        let refuse = || refused(name, value);
        match name {
            "quality" => self.set_quality(named(QUALITIES, value).ok_or_else(refuse)?),
            "sampling" => self.sampling = parse_sampling(value).ok_or_else(refuse)?,
            "resolution" => self.resolution = parse_resolution(value).ok_or_else(refuse)?,
            "max-error" => {
                self.max_error = optional(value, |value| in_range(value, 0.01, 255.0)).ok_or_else(refuse)?
            }
            "texels" => {
                let count = |value: &str| value.parse().ok().filter(|count| (1..=TEXELS_MAX).contains(count));
                self.texels = optional(value, count).ok_or_else(refuse)?;
            }
            "mip" => self.mip = named(MIP_FILTERS, value).ok_or_else(refuse)?,
            "beyond" => self.beyond = named(BEYONDS, value).ok_or_else(refuse)?,
            "solver" => self.solver = named(SOLVERS, value).ok_or_else(refuse)?,
            "range" => self.range = named(RANGES, value).ok_or_else(refuse)?,
            "rounding" => self.rounding = named(ROUNDINGS, value).ok_or_else(refuse)?,
            "coordinates" => self.coordinates = named(COORDINATES, value).ok_or_else(refuse)?,
            "packing" => self.packing = named(PACKINGS, value).ok_or_else(refuse)?,
            "no-share" => self.shares = !named(SWITCH, value).ok_or_else(refuse)?,
            "merge" => self.merges = named(SWITCH, value).ok_or_else(refuse)?,
            "max-size" => {
                let side = value.parse().ok().filter(|side| (MAX_SIDE_LEAST..=MAX_SIDE_MOST).contains(side));
                self.max_side = side.ok_or_else(refuse)?;
            }
            "cut" => {
                self.cut_codes = in_range(value, 0.0, 255.0).ok_or_else(refuse)?;
            }
            "textures" => self.textures = parse_textures(value)?,
            "mesh-colors" => self.mesh_colors = named(SWITCH, value).ok_or_else(refuse)?,
            "geometry" => self.geometry = named(GEOMETRIES, value).ok_or_else(refuse)?,
            "vertex-colors" => self.vertex_colors = named(VERTEX_COLORS, value).ok_or_else(refuse)?,
            "channel" => self.channels = channels::parse(value)?,
            "compress" => {
                self.compress = parse_list(BLOCKS, value).filter(is_one_way).ok_or_else(refuse)?;
            }
            _ => {
                let names: Vec<_> = OPTIONS.iter().map(|spec| spec.name).collect();
                return Err(Error::new(
                    ErrorCode::InvalidOptions,
                    format!("there is no option \"{name}\"; there are: {}", names.join(", ")),
                )
                .at(format!("/{name}")));
            }
        }
        Ok(())
    }

    /// Options from a JSON object of names and values (strings, or numbers and booleans where the text form
    /// is one).
    pub fn from_json(object: &Map<String, Value>) -> Result<Self> {
        let mut options = Self::default();
        let is_quality = |(name, _): &(&String, &Value)| *name == "quality";
        let rest = object.iter().filter(|pair| !is_quality(pair));
        for (name, value) in object.iter().filter(is_quality).chain(rest) {
            match value {
                Value::String(text) => options.set(name, text)?,
                Value::Number(number) => options.set(name, &number.to_string())?,
                Value::Bool(is_on) => options.set(name, name_of(SWITCH, *is_on))?,
                other => return Err(refused(name, &other.to_string())),
            }
        }
        options.check()?;
        Ok(options)
    }

    /// Whether the options go together; each alone was checked as it was set.
    ///
    /// # Errors
    /// `InvalidOptions`, naming the option that cannot be met.
    pub fn check(&self) -> Result<()> {
        if self.compress.is_empty() || self.textures.contains(&TextureFormat::Ktx2) {
            return Ok(());
        }
        let detail = format!(
            "compress = \"{}\" is about loose KTX2 files, and textures = \"{}\" asks for none; add ktx2 to textures",
            list(BLOCKS, &self.compress),
            list(TEXTURES, &self.textures)
        );
        Err(Error::new(ErrorCode::InvalidOptions, detail).at("/compress"))
    }

    /// Every option with its value, in the order of [`OPTIONS`].
    pub fn to_json(&self) -> Map<String, Value> {
        let resolution = match self.resolution {
            Resolution::Area(texels) => format!("area:{texels}"),
            Resolution::Fixed(exponent) => format!("fixed:{exponent}"),
            Resolution::Density(texels) => format!("density:{texels}"),
        };
        let sampling = match self.sampling {
            Sampling::Filtered(Some(count)) => format!("filtered:{count}"),
            named => name_of(SAMPLINGS, named).to_owned(),
        };
        let values = [
            name_of(QUALITIES, self.quality).into(),
            sampling.into(),
            resolution.into(),
            self.max_error.map_or(NONE.into(), |codes| f64::from(codes).into()),
            self.texels.map_or(NONE.into(), Value::from),
            name_of(MIP_FILTERS, self.mip).into(),
            name_of(BEYONDS, self.beyond).into(),
            name_of(SOLVERS, self.solver).into(),
            name_of(RANGES, self.range).into(),
            name_of(ROUNDINGS, self.rounding).into(),
            name_of(COORDINATES, self.coordinates).into(),
            name_of(PACKINGS, self.packing).into(),
            (!self.shares).into(),
            self.merges.into(),
            self.max_side.into(),
            f64::from(self.cut_codes).into(),
            list(TEXTURES, &self.textures).into(),
            list(BLOCKS, &self.compress).into(),
            self.mesh_colors.into(),
            name_of(GEOMETRIES, self.geometry).into(),
            name_of(VERTEX_COLORS, self.vertex_colors).into(),
            channels::text(&self.channels).into(),
        ];
        OPTIONS.iter().map(|spec| spec.name.to_owned()).zip(values).collect()
    }
}

fn parse_sampling(value: &str) -> Option<Sampling> {
    match value.split_once(':') {
        None => named(SAMPLINGS, value),
        Some(("filtered", count)) => {
            let count = count.parse().ok().filter(|count| (1..=16).contains(count));
            count.map(|count| Sampling::Filtered(Some(count)))
        }
        Some(_) => None,
    }
}

fn parse_resolution(value: &str) -> Option<Resolution> {
    let (rule, figure) = value.split_once(':')?;
    match rule {
        "area" => in_range(figure, 0.001, 64.0).map(Resolution::Area),
        "fixed" => figure.parse().ok().filter(|r| *r <= 12).map(Resolution::Fixed),
        "density" => in_range(figure, 1e-6, 1e9).map(Resolution::Density),
        _ => None,
    }
}

fn parse_textures(value: &str) -> Result<BTreeSet<TextureFormat>> {
    if value.split(',').any(|name| matches!(name.trim(), "jpeg" | "jpg")) {
        let mut error = refused("textures", value);
        error.detail.push_str(
            "; JPEG is not: it changes the texels on the two sides of an edge differently, so seams would come back",
        );
        return Err(error);
    }
    parse_list(TEXTURES, value).ok_or_else(|| refused("textures", value))
}

/// BC7 and ASTC are for the same levels.
fn is_one_way(formats: &BTreeSet<BlockFormat>) -> bool {
    !formats.is_superset(&BTreeSet::from([BlockFormat::Bc7, BlockFormat::Astc]))
}

fn refused(name: &str, value: &str) -> Error {
    refusal(name, value, "")
}

fn refused_because(name: &str, value: &str, reason: &str) -> Error {
    refusal(name, value, &format!(": {reason}"))
}

fn refusal(name: &str, value: &str, reason: &str) -> Error {
    let allowed = OPTIONS.iter().find(|spec| spec.name == name).map_or("", |spec| spec.allowed);
    let detail = format!("{name} = \"{value}\" is not allowed{reason}; allowed: {allowed}");
    Error::new(ErrorCode::InvalidOptions, detail).at(format!("/{name}"))
}
