//! The options of a conversion, each defined once: flags, HTTP fields, OpenAPI and the docs come from
//! [`OPTIONS`].

use serde_json::{Map, Value};

use crate::assign::{Range, Rounding};
use crate::error::{Error, ErrorCode, Result};
use crate::layout::Coordinates;
use crate::mip::{Beyond, MipFilter};
use crate::resample::{Resolution, Sampling};
use crate::solve::Solver;

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
    /// Edges whose two sides differ by more than this many codes are kept as cuts.
    pub cut_codes: f32,
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

const QUALITIES: &[(&str, Quality)] =
    &[("draft", Quality::Draft), ("standard", Quality::Standard), ("exact", Quality::Exact)];
/// `filtered` takes a count behind a colon too.
const SAMPLINGS: &[(&str, Sampling)] =
    &[("point", Sampling::Point), ("filtered", Sampling::Filtered(None)), ("fitted", Sampling::Fitted)];
const MIP_FILTERS: &[(&str, MipFilter)] = &[("uniform", MipFilter::Uniform), ("area", MipFilter::Area)];
const BEYONDS: &[(&str, Beyond)] = &[("one-ring", Beyond::OneRing), ("heat", Beyond::Heat)];
const SOLVERS: &[(&str, Solver)] = &[
    ("clamp", Solver::Clamp),
    ("local", Solver::Local),
    ("global", Solver::Global),
    ("exact", Solver::Exact),
];
const RANGES: &[(&str, Range)] =
    &[("unorm8", Range::Unorm8), ("scaled16", Range::Scaled16), ("float16", Range::Float16)];
/// More than any set of textures has.
const TEXELS_MAX: u64 = 1 << 32;
const ROUNDINGS: &[(&str, Rounding)] = &[("nearest", Rounding::Nearest), ("rules", Rounding::Rules)];
const COORDINATES: &[(&str, Coordinates)] =
    &[("4d-rows", Coordinates::ScaledInRows), ("4d", Coordinates::Scaled), ("indexed", Coordinates::Indexed)];

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
    /// The names that it takes, from the cheapest on; empty where it takes figures.
    pub rungs: &'static [&'static str],
    /// The values that are allowed, in words.
    pub allowed: &'static str,
    pub doc: &'static str,
}

pub const OPTIONS: &[OptionSpec] = &[
    OptionSpec {
        name: "quality",
        value_name: "PRESET",
        default: "standard",
        follows_quality: false,
        rungs: &names::<_, 3>(QUALITIES),
        allowed: "draft, standard, exact",
        doc: "A set of rungs, one of each ladder below, and a resolution; what is named by itself counts before it",
    },
    OptionSpec {
        name: "sampling",
        value_name: "RUNG",
        default: "point",
        follows_quality: true,
        rungs: &names::<_, 3>(SAMPLINGS),
        allowed: "point, filtered or filtered:K with K in 1..=16 (fetches along a side of a cell; without K, one for each source texel), fitted",
        doc: "How a sample gets its value: one bilinear fetch, the source integrated against the sample's hat function, or the samples whose interpolation is nearest to the source",
    },
    OptionSpec {
        name: "resolution",
        value_name: "RULE",
        default: "area:1",
        follows_quality: true,
        rungs: &[],
        allowed: "area:F with F in 0.001..=64 (texels per source texel), fixed:R with R in 0..=12 (sides of 2^R segments), density:D with D in 1e-6..=1e9 (texels per world unit)",
        doc: "How many samples a face gets",
    },
    OptionSpec {
        name: "max-error",
        value_name: "CODES",
        default: "none",
        follows_quality: false,
        rungs: &[],
        allowed: "none, or 0.01..=255 (8-bit codes: root mean square over a face, and four times that anywhere)",
        doc: "Faces get as few samples as show every channel within this of the source, at most as many as by `resolution`",
    },
    OptionSpec {
        name: "texels",
        value_name: "COUNT",
        default: "none",
        follows_quality: false,
        rungs: &[],
        allowed: "none, or 1..=4294967296 (texels of level 0 of one channel, all materials together)",
        doc: "A budget, spent over all faces and channels where it takes away most error; a face gets at most four times the texels that `resolution` gives it, or as many as by `max-error`",
    },
    OptionSpec {
        name: "mip",
        value_name: "RUNG",
        default: "area",
        follows_quality: true,
        rungs: &names::<_, 2>(MIP_FILTERS),
        allowed: "uniform, area",
        doc: "How a coarse sample weighs the fine ones around it: by its hat function alone, or by their surface area too",
    },
    OptionSpec {
        name: "beyond",
        value_name: "RUNG",
        default: "heat",
        follows_quality: true,
        rungs: &names::<_, 2>(BEYONDS),
        allowed: "one-ring, heat",
        doc: "How levels go on where a face is down to its vertices: the mean over neighboring vertices, or heat flow over the surface",
    },
    OptionSpec {
        name: "solver",
        value_name: "RUNG",
        default: "global",
        follows_quality: true,
        rungs: &names::<_, 4>(SOLVERS),
        allowed: "clamp, local, global, exact",
        doc: "What is done about texels outside the format's range: clamp them, change samples face by face, the least change of the whole level, or the same by a library (slow)",
    },
    OptionSpec {
        name: "range",
        value_name: "RUNG",
        default: "float16",
        follows_quality: true,
        rungs: &names::<_, 3>(RANGES),
        allowed: "unorm8 (codes as the source has them), scaled16 (16 bits with a scale and a bias), float16",
        doc: "How levels are stored where texels beyond vertex colors leave [0, 1], more than 5 % of the count of samples",
    },
    OptionSpec {
        name: "rounding",
        value_name: "RUNG",
        default: "rules",
        follows_quality: true,
        rungs: &names::<_, 2>(ROUNDINGS),
        allowed: "nearest, rules",
        doc: "How samples become codes: each texel to the nearest, or samples first, so that texels made from them keep their rules",
    },
    OptionSpec {
        name: "coordinates",
        value_name: "RUNG",
        default: "indexed",
        follows_quality: true,
        rungs: &names::<_, 3>(COORDINATES),
        allowed: "4d-rows (the paper's: squares in rows), 4d (rectangles in shelves), indexed",
        doc: "How a viewer finds texels: u_s / 2^level + u_delta, or by the number of a face's block and a table of levels, which needs fewer texels and no change of colors at coarse levels",
    },
    OptionSpec {
        name: "cut",
        value_name: "CODES",
        default: "8",
        follows_quality: false,
        rungs: &[],
        allowed: "0..=255 (8-bit codes; 2 codes stand for 1 degree of a normal)",
        doc: "Edges whose two sides differ by more than this at full resolution keep their two sides",
    },
];

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
            cut_codes: 8.0,
        };
        match quality {
            Quality::Draft => {
                Self { resolution: Resolution::Area(0.25), mip: MipFilter::Uniform, ..standard }
            }
            Quality::Standard => standard,
            Quality::Exact => Self { sampling: Sampling::Fitted, ..standard },
        }
    }

    /// Sets every rung to those of a preset.
    fn set_quality(&mut self, quality: Quality) {
        *self = Self {
            cut_codes: self.cut_codes,
            max_error: self.max_error,
            texels: self.texels,
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
            "cut" => {
                self.cut_codes = in_range(value, 0.0, 255.0).ok_or_else(refuse)?;
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

    /// Options from a JSON object of names and values (strings, or numbers where the text form is one).
    pub fn from_json(object: &Map<String, Value>) -> Result<Self> {
        let mut options = Self::default();
        let is_quality = |(name, _): &(&String, &Value)| *name == "quality";
        let rest = object.iter().filter(|pair| !is_quality(pair));
        for (name, value) in object.iter().filter(is_quality).chain(rest) {
            match value {
                Value::String(text) => options.set(name, text)?,
                Value::Number(number) => options.set(name, &number.to_string())?,
                other => return Err(refused(name, &other.to_string())),
            }
        }
        Ok(options)
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
            self.max_error.map_or("none".into(), |codes| f64::from(codes).into()),
            self.texels.map_or("none".into(), Value::from),
            name_of(MIP_FILTERS, self.mip).into(),
            name_of(BEYONDS, self.beyond).into(),
            name_of(SOLVERS, self.solver).into(),
            name_of(RANGES, self.range).into(),
            name_of(ROUNDINGS, self.rounding).into(),
            name_of(COORDINATES, self.coordinates).into(),
            f64::from(self.cut_codes).into(),
        ];
        OPTIONS.iter().map(|spec| spec.name.to_owned()).zip(values).collect()
    }
}

/// The names of a table, for [`OptionSpec::rungs`].
const fn names<T, const COUNT: usize>(table: &[(&'static str, T)]) -> [&'static str; COUNT] {
    assert!(table.len() == COUNT);
    let mut names = [""; COUNT];
    let mut at = 0;
    while at < COUNT {
        names[at] = table[at].0;
        at += 1;
    }
    names
}

fn named<T: Copy>(table: &[(&str, T)], value: &str) -> Option<T> {
    table.iter().find(|(name, _)| *name == value).map(|(_, rung)| *rung)
}

fn name_of<T: PartialEq>(table: &[(&'static str, T)], value: T) -> &'static str {
    table.iter().find(|(_, rung)| *rung == value).map_or("", |(name, _)| name)
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

/// `none`, or what `parse` makes of the value; `None` where it makes nothing of it.
fn optional<T>(value: &str, parse: impl Fn(&str) -> Option<T>) -> Option<Option<T>> {
    if value == "none" { Some(None) } else { parse(value).map(Some) }
}

fn in_range(value: &str, low: f32, high: f32) -> Option<f32> {
    value.parse::<f32>().ok().filter(|v| (low..=high).contains(v))
}

fn refused(name: &str, value: &str) -> Error {
    let allowed = OPTIONS.iter().find(|spec| spec.name == name).map_or("", |spec| spec.allowed);
    Error::new(ErrorCode::InvalidOptions, format!("{name} = \"{value}\" is not allowed; allowed: {allowed}"))
        .at(format!("/{name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn told_defaults_are_the_defaults() {
        for spec in OPTIONS {
            let mut options = Options::default();
            options.set(spec.name, spec.default).unwrap();
            assert_eq!(options, Options::default(), "{}", spec.name);
        }
    }

    #[test]
    fn rungs_are_values_that_are_told_and_read_back() {
        for spec in OPTIONS {
            for rung in spec.rungs {
                let mut options = Options::default();
                options.set(spec.name, rung).unwrap();
                assert_eq!(options.to_json()[spec.name], *rung);
                assert!(spec.allowed.contains(rung), "{} does not tell {rung}", spec.name);
            }
            let is_ladder = spec.name != "quality" && spec.name != "resolution" && spec.follows_quality;
            assert_eq!(is_ladder || spec.name == "quality", !spec.rungs.is_empty(), "{}", spec.name);
        }
    }
}
