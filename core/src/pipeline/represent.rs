//! Brings one level's samples to where every texel can be stored, by the solver that was asked for.

use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::assign::{LevelChannel, LevelValues, Rules};
use crate::colors::SampleAreas;
use crate::error::{Error, ErrorCode, Result};
use crate::image::Transfer;
use crate::math::transfer::linear_to_srgb;
use crate::measure::{SolverComponent, SolverReport};
use crate::solve::{
    FaceChange, Problem, Solution, Solver, TOLERANCE, VARIABLES_MAX, solve, solve_exactly, solve_locally,
};
use crate::watch::{self, Watch};

use super::changes::Changes;

/// A sample counts for at least this share of the mean sample in the solver's objective: faces of no area
/// must not make it singular.
const WEIGHT_FLOOR: f64 = 1e-4;

/// What is asked for: every texel within `width` around 1/2, by one of the solvers.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    pub solver: Solver,
    /// 1 for [0, 1].
    pub width: f64,
}

/// Brings the samples to where every texel can be stored; `None` where nothing was out of range.
///
/// # Errors
/// Canceled; or `exact` was asked for a level that is too large for it.
pub fn represent(
    channel: &LevelChannel<'_>,
    rules: &Rules,
    values: &mut LevelValues,
    Task { solver, width }: Task,
    watch: &dyn Watch,
) -> Result<Option<SolverReport>> {
    let systems = System::all(channel, width);
    let wanted: Vec<Vec<f64>> =
        systems.par_iter().map(|system| system.gather(rules, &values.samples)).collect();
    let is_violated = |wanted: &Vec<f64>| {
        (0..rules.len())
            .into_par_iter()
            .any(|row| !(-TOLERANCE..=1.0 + TOLERANCE).contains(&rules.value(row, wanted)))
    };
    if !wanted.iter().any(is_violated) {
        return Ok(None);
    }
    let weights = weights(channel, rules);
    let center = systems[0].middle();
    // Texels may leave [0, 1] where there is room for it; what shows may not.
    let bounds = channel.frames.is_none().then(|| [0.0, 1.0].map(|end| systems[0].in_unit(end)));
    // Gray stored as RGB is common: components that want the same get the same.
    let twin = |k: usize| (0..k).find(|&earlier| wanted[earlier] == wanted[k]);
    let twins: Vec<Option<usize>> = (0..systems.len()).map(twin).collect();
    let solved: Vec<Option<Solved>> = (wanted.par_iter().zip(&twins))
        .map(|(wanted, twin)| {
            let problem = Problem { rules, wanted, weights: &weights, center, bounds };
            if twin.is_some() { Ok(None) } else { solve_by(solver, &problem, watch).map(Some) }
        })
        .collect::<Result<_>>()?;
    watch::check(watch)?;
    let solved: Vec<&Solved> =
        (0..systems.len()).filter_map(|k| solved[twins[k].unwrap_or(k)].as_ref()).collect();
    let before = samples_of(channel, rules, &values.samples);
    for (system, solved) in systems.iter().zip(&solved) {
        system.scatter(rules, &solved.solution.values, values);
    }
    let after = samples_of(channel, rules, &values.samples);
    if solver == Solver::Local {
        part(channel, rules, values, &systems, &solved);
    }
    let mut report = report(rules, &solved, width);
    let changes = Changes::among(changes(channel, &before, &after), values.samples.len());
    report.level = channel.numbering.level as u32;
    report.change_mean_codes = changes.mean_codes;
    report.change_p95_codes = changes.p95_codes;
    report.change_max_codes = changes.max_codes;
    report.stop_rule = stop_rule(solver).to_owned();
    Ok(Some(report))
}

/// One component's solution, and where faces part from it.
struct Solved {
    solution: Solution,
    /// Of [`Solver::Local`]: what all faces share.
    shared: Vec<f64>,
    faces: Vec<FaceChange>,
}

fn solve_by(solver: Solver, problem: &Problem<'_>, watch: &dyn Watch) -> Result<Solved> {
    watch::check(watch)?;
    let solution = match solver {
        Solver::Clamp => {
            let (residual, violated_count) = problem.violations(problem.wanted);
            Solution { residual, violated_count, ..Solution::unchanged(problem) }
        }
        Solver::Local => {
            let local = solve_locally(problem);
            return Ok(Solved { solution: local.solution, shared: local.shared, faces: local.faces });
        }
        Solver::Global => solve(problem, &|| watch.canceled()),
        Solver::Exact => {
            let count = problem.wanted.len();
            if count > VARIABLES_MAX {
                let detail = format!(
                    "solver `exact` takes {VARIABLES_MAX} variables a component and level at most, and here \
                     are {count}: use `global`, or a lower resolution"
                );
                return Err(Error::new(ErrorCode::InvalidOptions, detail)
                    .at("/solver")
                    .limit(VARIABLES_MAX as u64, count as u64));
            }
            solve_exactly(problem).map_err(|reason| Error::internal(format!("solver `exact`: {reason}")))?
        }
    };
    Ok(Solved { solution, shared: Vec::new(), faces: Vec::new() })
}

/// When a solver stops. The figures are those of `solve`'s constants.
fn stop_rule(solver: Solver) -> &'static str {
    match solver {
        Solver::Clamp => "at once: nothing is solved",
        Solver::Local => {
            "a face when no texel of it is out of range by more than the tolerance, or after nine steps"
        }
        Solver::Global => {
            "an island of few binding rules when all hold to a tenth of the tolerance, another when its duality gap \
             proves the objective to be within 0.05 % of the optimum, at complementarity and gradient of 1e-6; \
             the level when no rule is broken by more than the tolerance"
        }
        Solver::Exact => "the level at a gap and residuals of 1e-9",
    }
}

/// In linear values, of which the solver's unit is `width`.
fn report(rules: &Rules, solved: &[&Solved], width: f64) -> SolverReport {
    let component = |solved: &&Solved| SolverComponent {
        variable_count: solved.solution.values.len() as u64,
        violated_count: solved.solution.violated_count,
        iteration_count: solved.solution.step_count,
        objective: solved.solution.objective * width * width,
        residual: solved.solution.residual * width,
        dual_residual: solved.solution.dual_residual * width,
        complementarity: solved.solution.complementarity * width * width,
    };
    let components: Vec<SolverComponent> = solved.iter().map(component).collect();
    let largest = |figure: fn(&SolverComponent) -> f64| components.iter().map(figure).fold(0.0, f64::max);
    SolverReport {
        row_count: (rules.len() * components.len()) as u64,
        violated_count: components.iter().map(|component| component.violated_count).sum(),
        iteration_count: components.iter().map(|component| component.iteration_count).max().unwrap_or(0),
        residual: largest(|component| component.residual),
        dual_residual: largest(|component| component.dual_residual),
        complementarity: largest(|component| component.complementarity),
        tolerance: TOLERANCE * width,
        objective: components.iter().map(|component| component.objective).sum(),
        components,
        ..SolverReport::default()
    }
}

/// Gives every face its own version of its corners: the shared ones, or what its own solve made of them.
fn part(
    channel: &LevelChannel<'_>,
    rules: &Rules,
    values: &mut LevelValues,
    systems: &[System],
    solved: &[&Solved],
) {
    for (system, solved) in systems.iter().zip(solved) {
        system.scatter(rules, &solved.shared, values);
    }
    if solved.iter().all(|solved| solved.faces.is_empty()) {
        return;
    }
    let fan_of = &channel.numbering.topology.fan_of;
    values.corners = fan_of.iter().map(|fans| fans.map(|fan| values.fans[fan as usize])).collect();
    for (system, solved) in systems.iter().zip(solved) {
        for change in &solved.faces {
            if let Some(face) = rules.face(change.group) {
                let count = channel.numbering.canvas.faces[face].count();
                for &(variable, value) in &change.values {
                    let (sample, component) = system.place(rules.variables()[variable as usize]);
                    let value = system.value(value);
                    let corners = values.corners[face][..count].iter_mut().zip(fan_of[face]);
                    let own = corners.filter(|(_, fan)| *fan as usize == sample);
                    own.for_each(|(corner, _)| corner[component] = value);
                }
            }
        }
    }
}

/// The weight of each variable's change: the surface area of its sample, 1 in the mean over all samples.
fn weights(channel: &LevelChannel<'_>, rules: &Rules) -> Vec<f64> {
    let areas = SampleAreas::new(channel.numbering);
    let total: f64 = channel.numbering.canvas.faces.iter().map(|face| f64::from(face.area)).sum();
    let mean = total / channel.numbering.sample_count() as f64;
    // A mesh without any area still has a mean to divide by.
    let mean = if mean > 0.0 { mean } else { 1.0 };
    let area = |sample: u32| f64::from(areas.of(channel.numbering, sample as usize));
    let weight = |sample: u32| (area(sample) / mean).max(WEIGHT_FLOOR);
    rules.variables().iter().map(|&variable| weight(sample_of(channel, variable))).collect()
}

/// The sample that a variable is, or is a component of.
fn sample_of(channel: &LevelChannel<'_>, variable: u32) -> u32 {
    if channel.frames.is_some() { variable / 3 } else { variable }
}

/// The values of the samples that rules are about.
fn samples_of(channel: &LevelChannel<'_>, rules: &Rules, values: &[Vec4]) -> Vec<Vec4> {
    let mut samples: Vec<u32> =
        rules.variables().iter().map(|&variable| sample_of(channel, variable)).collect();
    samples.dedup();
    samples.into_iter().map(|sample| values[sample as usize]).collect()
}

/// The variables that one solve is about, and its unit.
#[derive(Clone, Copy, PartialEq)]
struct System {
    of: Of,
    /// The solver's 0 to 1 are so much around 1/2, or around 0 for normals, whose rows add the 1/2.
    width: f64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Of {
    /// One component of every sample.
    Component(usize),
    /// All three components of every normal, which the frames mix.
    Normals,
}

impl System {
    fn all(channel: &LevelChannel<'_>, width: f64) -> Vec<Self> {
        if channel.frames.is_some() {
            return vec![Self { of: Of::Normals, width }];
        }
        let components = channel.codec.stored().iter();
        components.map(|&component| Self { of: Of::Component(component), width }).collect()
    }

    fn middle(self) -> f64 {
        if self.of == Of::Normals { 0.0 } else { 0.5 }
    }

    /// In the solver's unit. The range [0, 1] is left to the last bit.
    fn in_unit(self, value: f64) -> f64 {
        if self.width == 1.0 { value } else { self.middle() + (value - self.middle()) / self.width }
    }

    /// Back from the solver's unit.
    fn value(self, in_unit: f64) -> f64 {
        if self.width == 1.0 { in_unit } else { self.middle() + (in_unit - self.middle()) * self.width }
    }

    /// The values of the rules' variables, in the solver's unit.
    fn gather(self, rules: &Rules, values: &[Vec4]) -> Vec<f64> {
        let value = |&variable: &u32| {
            let (sample, component) = self.place(variable);
            self.in_unit(f64::from(values[sample][component]))
        };
        rules.variables().iter().map(value).collect()
    }

    fn scatter(self, rules: &Rules, solved: &[f64], values: &mut LevelValues) {
        for (&variable, &in_unit) in rules.variables().iter().zip(solved) {
            let (sample, component) = self.place(variable);
            values.set(sample, component, self.value(in_unit));
        }
    }

    /// Sample and component of a variable.
    fn place(self, variable: u32) -> (usize, usize) {
        match self.of {
            Of::Component(k) => (variable as usize, k),
            Of::Normals => (variable as usize / 3, variable as usize % 3),
        }
    }
}

/// The samples' changes in codes, the largest component counting; those that are nothing are left out.
fn changes(channel: &LevelChannel<'_>, before: &[Vec4], after: &[Vec4]) -> Vec<f64> {
    let is_color = channel.codec.transfer == Transfer::Srgb;
    let encode = |value: Vec4| {
        if !is_color {
            return value;
        }
        value.xyz().map(linear_to_srgb).extend(value.w)
    };
    // Normals span [-1, 1], two of these to a code range.
    let scale = if channel.frames.is_some() { 127.5 } else { 255.0 };
    let changed = before.iter().zip(after).filter(|(before, after)| before != after);
    changed
        .map(|(before, after)| f64::from((encode(*before) - encode(*after)).abs().max_element()) * scale)
        .collect()
}
