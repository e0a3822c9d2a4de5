//! One conversion's report, drawn together over its channels.
//!
//! Over channels, the root mean square weighs each stored component alike (every channel is measured at
//! as many points of the surface); percentiles and maxima are those of the worst channel, because
//! percentiles of a union do not follow from those of its parts.

use meshcolor::measure::{ChannelReport, Fidelity, LevelReport, Report, Unit};

use super::record::{Change, Errors, LevelError, Output, Spread, UnitErrors};

pub fn errors_of(report: &Report) -> Errors {
    let of_unit = |unit: Unit| {
        let channels: Vec<_> = report.channels.iter().filter(|channel| channel.unit == unit).collect();
        unit_errors(&channels)
    };
    Errors { codes: of_unit(Unit::Codes), degrees: of_unit(Unit::Degrees), change: change(report) }
}

pub fn output_of(report: &Report) -> Output {
    Output {
        texels: report.growth.converted_texels,
        texels_all_levels: report.growth.converted_texels_all_levels,
        bytes: report.growth.converted_bytes,
    }
}

/// What the report tells of level 0.
fn of_level_0(fidelity: &Fidelity) -> Spread {
    Spread { rms: fidelity.rms, p99: Some(fidelity.p99), max: Some(fidelity.max) }
}

/// What the report tells of one level above 0 against the mean over the surface.
fn of_level(level: &LevelReport) -> Option<Spread> {
    level.mip_error.map(|error| Spread { rms: error.rms, p99: Some(error.p99), max: None })
}

/// `None` where no channel has this unit.
fn unit_errors(channels: &[&ChannelReport]) -> Option<UnitErrors> {
    let level_0: Vec<_> = channels
        .iter()
        .filter_map(|channel| Some((channel.components, of_level_0(channel.fidelity.as_ref()?))))
        .collect();
    let level_0 = joined(&level_0)?;
    let level_count = channels.iter().map(|channel| channel.levels.len()).max().unwrap_or(0);
    let coarse = (1..level_count).filter_map(|level| {
        let spreads: Vec<_> = channels
            .iter()
            .filter_map(|channel| Some((channel.components, of_level(channel.levels.get(level)?)?)))
            .collect();
        Some(LevelError { level: level as u32, error: joined(&spreads)? })
    });
    let levels: Vec<_> = std::iter::once(LevelError { level: 0, error: level_0 }).chain(coarse).collect();
    // Level 0 alone says nothing of the mip maps.
    let mean_square = || root_mean_square(levels.iter().map(|level| (1.0, level.error.rms)));
    let all_levels_rms = if levels.len() > 1 { mean_square() } else { None };
    let seams = || channels.iter().flat_map(|channel| &channel.levels).filter_map(|level| level.seams);
    Some(UnitErrors {
        level_0,
        all_levels_rms,
        levels,
        seam_max: seams().map(|seams| seams.max).fold(0.0, f64::max),
        seam_p999: seams().map(|seams| seams.p999).fold(0.0, f64::max),
    })
}

/// The spread over channels, each with its components; `None` without any.
fn joined(spreads: &[(u32, Spread)]) -> Option<Spread> {
    let worst = |figure: fn(&Spread) -> Option<f64>| {
        spreads.iter().filter_map(|(_, spread)| figure(spread)).reduce(f64::max)
    };
    Some(Spread {
        rms: root_mean_square(
            spreads.iter().map(|(components, spread)| (f64::from(*components), spread.rms)),
        )?,
        p99: worst(|spread| spread.p99),
        max: worst(|spread| spread.max),
    })
}

/// Of values with weights; `None` without any weight.
fn root_mean_square(values: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (weight, sum) = values
        .fold((0.0, 0.0), |(weights, sum), (weight, value)| (weights + weight, sum + weight * value * value));
    (weight > 0.0).then(|| (sum / weight).sqrt())
}

/// The worst level of any channel: what the solver changed, or storing in a range.
fn change(report: &Report) -> Option<Change> {
    let of_channel = |channel: &ChannelReport| {
        let solved = channel
            .solver
            .iter()
            .map(|solve| (solve.change_mean_codes, solve.change_p95_codes, solve.change_max_codes));
        let stored = channel
            .stored
            .iter()
            .map(|stored| (stored.change_mean_codes, stored.change_p95_codes, stored.change_max_codes));
        solved.chain(stored).collect::<Vec<_>>()
    };
    let all = report.channels.iter().flat_map(of_channel);
    let worst = all.reduce(|a, b| (a.0.max(b.0), a.1.max(b.1), a.2.max(b.2)))?;
    Some(Change { mean_codes: worst.0, p95_codes: Some(worst.1), max_codes: worst.2 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_weigh_and_the_worst_channel_counts() {
        let spread = |rms, p99| Spread { rms, p99: Some(p99), max: None };
        let joined = joined(&[(3, spread(1.0, 9.0)), (1, spread(5.0, 4.0))]).unwrap();
        assert!((joined.rms - 7f64.sqrt()).abs() < 1e-12);
        assert_eq!((joined.p99, joined.max), (Some(9.0), None));
        assert!(super::joined(&[]).is_none());
    }
}
