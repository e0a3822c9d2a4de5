//! What runs: the whole presets, and for every ladder the preset `standard` with one rung changed. The
//! rungs are those of [`OPTIONS`], so a new one runs as soon as it has a name.

use meshcolor::Result;
use meshcolor::pipeline::{OPTIONS, OptionSpec, Options};
use serde_json::{Map, Value};

use super::record::{Ladder, Preset, Rung};

/// The preset that rungs are changed in.
pub const HOME: &str = "standard";

pub(super) const QUALITY: &str = "quality";

/// The conversions to run, each once, and who refers to them.
pub struct Plan {
    pub runs: Vec<PlannedRun>,
    pub presets: Vec<Preset>,
    pub ladders: Vec<Ladder>,
    /// The run with the rungs that the caller named.
    pub asked: usize,
}

pub struct PlannedRun {
    pub name: String,
    pub options: Options,
}

impl Plan {
    /// Presets and ladders, with the cuts of `base` and with its resolution where that is not its preset's; and
    /// `base` itself where it is none of them.
    ///
    /// # Errors
    /// `InvalidOptions`, which no options that were read can cause.
    pub fn new(base: &Options) -> Result<Self> {
        let mut plan = Self { runs: Vec::new(), presets: Vec::new(), ladders: Vec::new(), asked: 0 };
        for spec in OPTIONS.iter().filter(|spec| spec.name == QUALITY) {
            for name in spec.rungs {
                let run = plan.run_of(name, with(base, &[(QUALITY, name)])?);
                plan.presets.push(Preset { name: (*name).to_owned(), run });
            }
        }
        let home = with(base, &[(QUALITY, HOME)])?.to_json();
        for spec in ladders() {
            let mut rungs = Vec::new();
            for rung in spec.rungs {
                let options = with(base, &[(QUALITY, HOME), (spec.name, rung)])?;
                let run = plan.run_of(&format!("{} {rung}", spec.name), options);
                rungs.push(Rung { name: (*rung).to_owned(), run, is_home: home[spec.name] == *rung });
            }
            plan.ladders.push(Ladder { name: spec.name.to_owned(), rungs });
        }
        plan.asked = plan.run_of("as asked", base.clone());
        Ok(plan)
    }

    /// The run with these rungs; a new one where there is none yet.
    fn run_of(&mut self, name: &str, options: Options) -> usize {
        let same = |run: &PlannedRun| rungs_of(&run.options) == rungs_of(&options);
        self.runs.iter().position(same).unwrap_or_else(|| {
            self.runs.push(PlannedRun { name: name.to_owned(), options });
            self.runs.len() - 1
        })
    }
}

/// The options that are ladders, in their order.
pub fn ladders() -> impl Iterator<Item = &'static OptionSpec> {
    OPTIONS.iter().filter(|spec| spec.follows_quality && !spec.rungs.is_empty())
}

/// `base` with options changed, and with its resolution where that is not its preset's.
pub(super) fn with(base: &Options, changes: &[(&str, &str)]) -> Result<Options> {
    let mut options = base.clone();
    for (name, value) in changes {
        options.set(name, value)?;
    }
    if base.resolution != Options::of(base.quality).resolution {
        options.resolution = base.resolution;
    }
    Ok(options)
}

/// What a conversion depends on: the preset's name is a label of the rungs that follow it.
fn rungs_of(options: &Options) -> Map<String, Value> {
    let mut rungs = options.to_json();
    rungs.shift_remove(QUALITY);
    rungs
}

#[cfg(test)]
mod tests {
    use meshcolor::pipeline::Quality;

    use super::*;

    #[test]
    fn every_rung_of_every_ladder_runs_once() {
        let plan = Plan::new(&Options::default()).unwrap();
        let rungs: usize = ladders().map(|spec| spec.rungs.len()).sum();
        assert_eq!(plan.presets.len(), 3);
        assert_eq!(plan.ladders.iter().map(|ladder| ladder.rungs.len()).sum::<usize>(), rungs);
        for (number, run) in plan.runs.iter().enumerate() {
            let same = |other: &PlannedRun| rungs_of(&other.options) == rungs_of(&run.options);
            assert_eq!(plan.runs.iter().filter(|other| same(other)).count(), 1, "{}", run.name);
            let in_presets = plan.presets.iter().map(|preset| preset.run);
            let in_ladders = plan.ladders.iter().flat_map(|ladder| &ladder.rungs).map(|rung| rung.run);
            assert!(in_presets.chain(in_ladders).any(|named| named == number), "{}", run.name);
        }
        for ladder in &plan.ladders {
            let home: Vec<_> = ladder.rungs.iter().filter(|rung| rung.is_home).collect();
            assert_eq!(home.len(), 1, "{}", ladder.name);
            assert_eq!(plan.runs[home[0].run].name, HOME);
            for rung in &ladder.rungs {
                assert_eq!(plan.runs[rung.run].options.to_json()[&ladder.name], rung.name.as_str());
            }
        }
        assert_eq!(plan.runs[plan.asked].name, HOME);
    }

    #[test]
    fn options_that_are_no_rung_hold_for_all_and_unknown_rungs_run_too() {
        let mut base = Options::default();
        base.set("cut", "3").unwrap();
        base.set("sampling", "filtered:2").unwrap();
        let plan = Plan::new(&base).unwrap();
        assert!(plan.runs.iter().all(|run| run.options.cut_codes == 3.0));
        let resolutions = |plan: &Plan| -> Vec<_> {
            plan.presets.iter().map(|preset| plan.runs[preset.run].options.resolution).collect()
        };
        let standard = base.resolution;
        assert_eq!(resolutions(&plan), [Options::of(Quality::Draft).resolution, standard, standard]);
        assert_eq!((plan.asked, plan.runs[plan.asked].name.as_str()), (plan.runs.len() - 1, "as asked"));
        assert_eq!(plan.runs[plan.asked].options, base);
        base.set("resolution", "area:2").unwrap();
        assert_eq!(resolutions(&Plan::new(&base).unwrap()), [base.resolution; 3]);
    }
}
