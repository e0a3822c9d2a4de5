//! Hard cases: a folder each in `tests/hard`, converted by every preset and by the rungs that matter, each time
//! held against what must hold however nasty the model is. `expected.json` has one line for each run.

pub mod figures;
pub mod page;
pub mod promises;
pub mod stages;

use std::path::{Path, PathBuf};

use meshcolor::Error;
use meshcolor::asset::Asset;
use meshcolor::pipeline::{Conversion, Options, convert_asset};
use meshcolor::read::read;
use meshcolor::watch::{Unwatched, Watch};
use serde_json::{Map, Value, json};

use crate::cases::{Case, names_in};

/// Options beside those of the case.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    pub name: &'static str,
    options: &'static [(&'static str, &'static str)],
}

/// Coordinates that have texels beyond vertex colors.
const FOUR_D: (&str, &str) = ("coordinates", "4d");
/// As in the papers: faces of one exponent, in rows.
const IN_ROWS: (&str, &str) = ("coordinates", "4d-rows");

/// Point sampling keeps the source's contrast, so texels beyond vertex colors are as far out of range as can be; in 8 bits
/// all of that is to be solved.
pub const RUNS: &[Run] = &[
    Run { name: "standard", options: &[] },
    Run { name: "draft", options: &[("quality", "draft")] },
    Run { name: "exact", options: &[("quality", "exact")] },
    Run { name: "uniform", options: &[("mip", "uniform"), ("beyond", "one-ring")] },
    Run { name: "budget", options: &[("max-error", "6")] },
    Run { name: "float16", options: &[FOUR_D] },
    Run {
        name: "papers",
        options: &[IN_ROWS, ("mip", "uniform"), ("beyond", "one-ring"), ("range", "unorm8")],
    },
    Run { name: "fitted", options: &[FOUR_D, ("sampling", "fitted"), ("range", "unorm8")] },
    Run { name: "unorm8", options: &[FOUR_D, ("range", "unorm8")] },
    Run { name: "scaled16", options: &[FOUR_D, ("range", "scaled16")] },
    Run { name: "nearest", options: &[FOUR_D, ("range", "unorm8"), ("rounding", "nearest")] },
    Run { name: "local", options: &[FOUR_D, ("range", "unorm8"), ("solver", "local")] },
    Run { name: "clamp", options: &[FOUR_D, ("range", "unorm8"), ("solver", "clamp")] },
    Run {
        name: LIBRARY,
        options: &[
            IN_ROWS,
            ("mip", "uniform"),
            ("beyond", "one-ring"),
            ("range", "unorm8"),
            ("solver", "exact"),
        ],
    },
];

impl Run {
    /// Whether the run promises what the report asks of edges; the others are there to show the damage.
    pub fn keeps_edges(&self) -> bool {
        let gives_up = [("solver", "local"), ("solver", "clamp"), ("rounding", "nearest")];
        !self.options.iter().any(|option| gives_up.contains(option))
    }
}

/// The run that [`GLOBAL`] is held against.
const LIBRARY: &str = "library";
const GLOBAL: &str = "papers";

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("hard")
}

pub fn names() -> Vec<String> {
    names_in(&folder())
}

/// Whether figures are being recorded, and may be half written.
pub fn records() -> bool {
    std::env::var_os("UPDATE_CASES").is_some_and(|value| value == "1")
}

/// A hard case, read.
pub struct HardCase {
    pub name: String,
    pub case: Case,
    folder: PathBuf,
    /// The model, or why it is refused.
    pub model: Result<Asset, Error>,
}

/// One run over a case.
pub struct Outcome {
    pub run: Run,
    pub options: Options,
    pub conversion: Conversion,
}

impl HardCase {
    /// # Panics
    /// Where the case's files are not what they have to be.
    pub fn load(name: &str) -> Self {
        let folder = folder().join(name);
        let case = Case::load(&folder);
        let model = read(&case.upload(&folder), &case.limits(), &Unwatched);
        Self { name: name.to_owned(), case, folder, model }
    }

    /// # Panics
    /// Where an option is not allowed.
    pub fn options(&self, run: &Run) -> Options {
        let mut options: Map<String, Value> = self.case.options.clone();
        options.extend(run.options.iter().map(|(name, value)| ((*name).to_owned(), (*value).into())));
        Options::from_json(&options).unwrap_or_else(|e| panic!("{}, {}: {e}", self.name, run.name))
    }

    /// # Errors
    /// What the conversion refuses.
    pub fn convert(&self, run: &Run, watch: &dyn Watch) -> Result<Outcome, Error> {
        let options = self.options(run);
        let model = self.model.clone()?;
        let conversion = convert_asset(model, &options, &self.case.limits(), watch)?;
        Ok(Outcome { run: *run, options, conversion })
    }

    /// What `expected.json` has; `Null` where nothing was recorded yet.
    pub fn recorded(&self) -> Value {
        let text = std::fs::read_to_string(self.folder.join("expected.json")).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// All runs; one error where the model is refused.
    ///
    /// # Errors
    /// What the first run refuses.
    ///
    /// # Panics
    /// Where one run refuses what another takes.
    pub fn outcomes(&self) -> Result<Vec<Outcome>, Error> {
        let first = self.convert(&RUNS[0], &Unwatched)?;
        let others = RUNS[1..].iter().map(|run| {
            self.convert(run, &Unwatched)
                .unwrap_or_else(|error| panic!("{}, {}: {error}", self.name, run.name))
        });
        Ok(std::iter::once(first).chain(others).collect())
    }
}

/// Runs one case.
///
/// # Panics
/// Where a promise is broken, or a figure is not what was recorded.
pub fn run(name: &str) {
    let hard = HardCase::load(name);
    let (all, detail) = match hard.outcomes() {
        Ok(outcomes) => {
            outcomes.iter().for_each(|outcome| promises::check(name, outcome));
            promises::check_same_optimum(name, by_name(&outcomes, GLOBAL), by_name(&outcomes, LIBRARY));
            promises::check_one_color(&hard);
            let figures = outcomes.iter().map(|outcome| (outcome.run.name.to_owned(), figures::of(outcome)));
            let mut all = Value::Object(figures.collect());
            let apart = promises::shown_apart_codes(by_name(&outcomes, GLOBAL), by_name(&outcomes, LIBRARY));
            all[LIBRARY]["from_global_codes"] = figures::rounded(apart).into();
            (all, String::new())
        }
        Err(Error { code, detail, pointer, limit, actual }) => {
            let error = json!({ "code": code.name(), "pointer": pointer, "limit": limit, "actual": actual, "detail": detail });
            (json!({ "error": error }), detail)
        }
    };
    hard.case.judge_figures(&hard.folder, &all, &detail, &figures::lines(&all));
}

fn by_name<'a>(outcomes: &'a [Outcome], name: &str) -> &'a Outcome {
    let found = outcomes.iter().find(|outcome| outcome.run.name == name);
    found.unwrap_or_else(|| panic!("there is no run {name}"))
}
