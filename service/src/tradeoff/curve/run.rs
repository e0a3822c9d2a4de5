//! Runs the curve: the area-matched line first, since budgets are shares of what it takes.

use meshcolor::Result;
use meshcolor::measure::Report;
use meshcolor::pipeline::{Options, Resolution, Sampling};

use super::super::plan::{HOME, QUALITY, with};
use super::super::run::{Runner, ends_all};
use super::{Curve, Figures, Line, Point, PointEnd, figures_of};

/// The line that [`Curve::best`] names.
pub const BEST: &str = "budget, fitted";
const AREA: &str = "area-matched";

/// Shares of the source's area, the fewest first; the last one `standard` has run in most cases.
const AREA_SHARES: [f64; 4] = [1.0 / 16.0, 1.0 / 4.0, 1.0 / 2.0, 1.0];

/// A line of budgets.
struct Budgets {
    name: &'static str,
    sampling: Sampling,
    shares: &'static [f64],
}

/// Each budget looks at the whole source again, so the line that is there to compare has fewer.
const BUDGETS: [Budgets; 2] = [
    Budgets { name: BEST, sampling: Sampling::Fitted, shares: &AREA_SHARES },
    Budgets { name: "budget, point", sampling: Sampling::Point, shares: &[1.0 / 16.0, 1.0 / 2.0] },
];

/// Conversions that a curve takes at most.
pub const RUN_COUNT: usize = AREA_SHARES.len() + BUDGETS[0].shares.len() + BUDGETS[1].shares.len();

/// `standard` with so many texels for each texel that the faces have in the source, times the share.
///
/// # Errors
/// `InvalidOptions`, which no options that were read can cause.
pub fn area_matched(base: &Options, share: f64) -> Result<Options> {
    let mut options = with(base, &[(QUALITY, HOME)])?;
    let texels = match options.resolution {
        Resolution::Area(texels) => texels,
        Resolution::Fixed(_) | Resolution::Density(_) => 1.0,
    };
    options.resolution = Resolution::Area((f64::from(texels) * share) as f32);
    (options.texels, options.max_error) = (None, None);
    Ok(options)
}

/// Runs it. `matched` is what the area-matched run of share 1 came to, where it has run.
///
/// # Errors
/// `Canceled`, and errors of our own; a run that refuses the asset is a point.
pub fn run(runner: &mut Runner<'_>, base: &Options, matched: Option<Figures>) -> Result<Curve> {
    let mut curve = Curve { source_texels: None, stored_face_count: 0, cpu_seconds: 0.0, lines: Vec::new() };
    let mut area = Line { name: AREA.to_owned(), points: Vec::new() };
    for share in AREA_SHARES {
        let options = area_matched(base, share)?;
        let end = match &matched {
            Some(figures) if share == 1.0 => PointEnd::Done(figures.clone()),
            _ => one(runner, &options, &mut curve.cpu_seconds)?,
        };
        area.points.push(Point { share, options: options.to_json(), end });
    }
    let most = area.points.last().and_then(|point| match &point.end {
        PointEnd::Done(figures) => Some(figures.clone()),
        PointEnd::Refused { .. } => None,
    });
    curve.lines.push(area);
    // Without its texels there is nothing that budgets could be shares of.
    let Some(most) = most else { return Ok(curve) };
    (curve.source_texels, curve.stored_face_count) = (most.source_texels, most.stored_face_count);
    for Budgets { name, sampling, shares } in &BUDGETS {
        let mut line = Line { name: (*name).to_owned(), points: Vec::new() };
        for &share in *shares {
            let mut options = area_matched(base, 1.0)?;
            options.sampling = *sampling;
            options.texels = Some(((most.texels as f64 * share).round() as u64).max(1));
            let end = one(runner, &options, &mut curve.cpu_seconds)?;
            line.points.push(Point { share, options: options.to_json(), end });
        }
        curve.lines.insert(curve.lines.len() - 1, line);
    }
    Ok(curve)
}

fn one(runner: &mut Runner<'_>, options: &Options, cpu_seconds: &mut f64) -> Result<PointEnd> {
    let (report, stages) = runner.convert(options);
    *cpu_seconds += stages.iter().map(|stage| stage.cpu_seconds).sum::<f64>();
    point_end(report)
}

fn point_end(report: Result<Report>) -> Result<PointEnd> {
    match report {
        Err(error) if ends_all(&error) => Err(error),
        Err(error) => Ok(PointEnd::Refused { code: error.code.name().to_owned(), reason: error.to_string() }),
        Ok(report) => Ok(PointEnd::Done(figures_of(&report))),
    }
}
