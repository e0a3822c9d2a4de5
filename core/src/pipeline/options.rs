//! The options of a conversion, each defined once: flags, HTTP fields, OpenAPI and the docs come from
//! [`OPTIONS`].

use serde_json::{Map, Value};

use crate::error::{Error, ErrorCode, Result};

#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    pub sampling: Sampling,
    pub resolution: Resolution,
    pub solver: Solver,
    /// Edges whose two sides differ by more than this many codes are kept as cuts.
    pub cut_codes: f32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            sampling: Sampling::Filtered,
            resolution: Resolution::Area(1.0),
            solver: Solver::Global,
            cut_codes: 8.0,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// One bilinear fetch at the sample's position.
    Point,
    /// The source integrated against the sample's hat function.
    Filtered,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Texels per source texel, by area.
    Area(f32),
    /// One exponent for every face: sides of `2^r` segments.
    Fixed(u8),
    /// Texels per world unit.
    Density(f32),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// No solve: texels out of range are clamped (shows the damage).
    Clamp,
    /// The whole level at once, to a stated tolerance.
    Global,
}

/// One option as every interface shows it.
#[derive(Clone, Copy, Debug)]
pub struct OptionSpec {
    /// `--name` on the command line, the field's name over HTTP.
    pub name: &'static str,
    /// What stands for the value in help texts.
    pub value_name: &'static str,
    pub default: &'static str,
    /// The values that are allowed, in words.
    pub allowed: &'static str,
    pub doc: &'static str,
}

pub const OPTIONS: &[OptionSpec] = &[
    OptionSpec {
        name: "sampling",
        value_name: "RUNG",
        default: "filtered",
        allowed: "point, filtered",
        doc: "How a sample gets its value: one bilinear fetch, or the source integrated against the sample's hat function",
    },
    OptionSpec {
        name: "resolution",
        value_name: "RULE",
        default: "area:1",
        allowed: "area:F with F in 0.001..=64 (texels per source texel), fixed:R with R in 0..=12 (sides of 2^R segments), density:D with D in 1e-6..=1e9 (texels per world unit)",
        doc: "How many samples a face gets",
    },
    OptionSpec {
        name: "solver",
        value_name: "RUNG",
        default: "global",
        allowed: "clamp, global",
        doc: "What is done about texels outside the format's range: clamp them, or change the samples as little as possible",
    },
    OptionSpec {
        name: "cut",
        value_name: "CODES",
        default: "8",
        allowed: "0..=255 (8-bit codes; 2 codes stand for 1 degree of a normal)",
        doc: "Edges whose two sides differ by more than this at full resolution keep their two sides",
    },
];

impl Options {
    /// Sets one option from its text form.
    ///
    /// # Errors
    /// `InvalidOptions`, naming the option, the value and what is allowed.
    pub fn set(&mut self, name: &str, value: &str) -> Result<()> {
        let refuse = || refused(name, value);
        match name {
            "sampling" => {
                self.sampling = match value {
                    "point" => Sampling::Point,
                    "filtered" => Sampling::Filtered,
                    _ => return Err(refuse()),
                }
            }
            "resolution" => self.resolution = parse_resolution(value).ok_or_else(refuse)?,
            "solver" => {
                self.solver = match value {
                    "clamp" => Solver::Clamp,
                    "global" => Solver::Global,
                    _ => return Err(refuse()),
                }
            }
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
        for (name, value) in object {
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
            Sampling::Point => "point",
            Sampling::Filtered => "filtered",
        };
        let solver = match self.solver {
            Solver::Clamp => "clamp",
            Solver::Global => "global",
        };
        Map::from_iter([
            ("sampling".to_owned(), sampling.into()),
            ("resolution".to_owned(), resolution.into()),
            ("solver".to_owned(), solver.into()),
            ("cut".to_owned(), f64::from(self.cut_codes).into()),
        ])
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

fn in_range(value: &str, low: f32, high: f32) -> Option<f32> {
    value.parse::<f32>().ok().filter(|v| (low..=high).contains(v))
}

fn refused(name: &str, value: &str) -> Error {
    let allowed = OPTIONS.iter().find(|spec| spec.name == name).map_or("", |spec| spec.allowed);
    Error::new(ErrorCode::InvalidOptions, format!("{name} = \"{value}\" is not allowed; allowed: {allowed}"))
        .at(format!("/{name}"))
}
