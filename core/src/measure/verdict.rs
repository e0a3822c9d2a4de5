//! The bundle's guarantee, held against the figures: on edges that are not cut, 8-bit channels differ by
//! rounding only.

use super::report::{ChannelReport, Figures, SubjectKind, Unit, Verdict};
use crate::error::Warning;

/// Largest jump that rounding explains.
pub const MAX_CODES: f64 = 1.5;

/// Limit of the 99.9th percentile.
pub const P999_CODES: f64 = 1.0;

/// Fewer samples have no 99.9th percentile but their maximum, which has a limit of its own.
pub const P999_SAMPLES: u64 = 1000;

/// Limit of the 99.9th percentile of normals. More is a reason to look, not a broken promise.
pub const P999_DEGREES: f64 = 1.0;

/// What the figures of all channels add up to.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    pub verdict: Verdict,
    /// Broken guarantees, one sentence each.
    pub errors: Vec<String>,
    pub warnings: Vec<Warning>,
    /// Largest jump over channels in codes, all levels.
    pub max_seam_delta_codes: f64,
}

/// Judges the channels. A plain source promises nothing: it always passes.
pub fn judge(kind: SubjectKind, channels: &[ChannelReport]) -> Judgement {
    let mut judgement = Judgement {
        verdict: Verdict::Pass,
        errors: Vec::new(),
        warnings: Vec::new(),
        max_seam_delta_codes: 0.0,
    };
    for channel in channels {
        let levels = channel.levels.iter().filter_map(|level| Some((level.level, level.seams?)));
        if channel.unit == Unit::Codes {
            let largest = levels.clone().map(|(_, seams)| seams.max).fold(0.0, f64::max);
            judgement.max_seam_delta_codes = judgement.max_seam_delta_codes.max(largest);
        }
        if kind == SubjectKind::Converted {
            match channel.unit {
                Unit::Codes => judgement.errors.extend(levels.filter_map(|at| broken(channel, at))),
                Unit::Degrees => judgement.warnings.extend(tilted(channel, levels)),
            }
        }
    }
    if !judgement.errors.is_empty() {
        judgement.verdict = Verdict::Fail;
    } else if !judgement.warnings.is_empty() {
        judgement.verdict = Verdict::Warn;
    }
    judgement
}

/// The sentence about a level that breaks the guarantee, if it does.
fn broken(channel: &ChannelReport, (level, seams): (u32, Figures)) -> Option<String> {
    let (what, figure, limit) = if seams.max > MAX_CODES {
        ("the largest jump", seams.max, MAX_CODES)
    } else if seams.p999 > P999_CODES && seams.sample_count >= P999_SAMPLES {
        ("the 99.9th percentile of the jumps", seams.p999, P999_CODES)
    } else {
        return None;
    };
    Some(format!(
        "{} of material {} (\"{}\"), level {level}: {what} across uncut edges is {figure:.2} codes; the limit is {limit}.",
        channel.slots.join(" + "),
        channel.material,
        channel.material_name,
    ))
}

fn tilted(channel: &ChannelReport, levels: impl Iterator<Item = (u32, Figures)>) -> Option<Warning> {
    let over: Vec<_> = levels.filter(|(_, seams)| seams.p999 > P999_DEGREES).collect();
    let (level, seams) = over.iter().max_by(|x, y| x.1.p999.total_cmp(&y.1.p999).then(y.0.cmp(&x.0)))?;
    Some(Warning {
        code: "normal_seam".to_owned(),
        detail: format!(
            "level {level}: the 99.9th percentile of the angle between the two sides of uncut edges is {:.2} degrees; up to {P999_DEGREES} is expected",
            seams.p999
        ),
        pointer: format!("/materials/{}/{}", channel.material, channel.slots.join("+")),
        count: over.len() as u64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::report::{CutShare, LevelReport};

    fn channel(unit: Unit, figures: &[(f64, f64)]) -> ChannelReport {
        let level = |(number, &(max, p999)): (usize, &(f64, f64))| LevelReport {
            level: number as u32,
            size: [4, 4],
            seams: Some(Figures { max, p999, mean: 0.0, sample_count: 19_000 }),
            seams_8bit_weights: None,
            range: None,
            drift: None,
            source: None,
            mip_error: None,
        };
        ChannelReport {
            value_scale: None,
            material: 2,
            material_name: "Brass".to_owned(),
            slots: vec!["baseColorTexture".to_owned()],
            unit,
            components: 3,
            bits: 8,
            cuts: CutShare::default(),
            levels: figures.iter().enumerate().map(level).collect(),
            fidelity: None,
            solver: Vec::new(),
            stored: Vec::new(),
        }
    }

    #[test]
    fn rounding_passes() {
        let judgement = judge(SubjectKind::Converted, &[channel(Unit::Codes, &[(1.5, 1.0), (0.2, 0.1)])]);
        assert_eq!((judgement.verdict, judgement.max_seam_delta_codes), (Verdict::Pass, 1.5));
    }

    #[test]
    fn a_jump_fails_with_its_place_figure_and_limit() {
        let judgement = judge(SubjectKind::Converted, &[channel(Unit::Codes, &[(1.0, 1.0), (3.25, 0.5)])]);
        assert_eq!(judgement.verdict, Verdict::Fail);
        let [sentence] = &judgement.errors[..] else { panic!("{:?}", judgement.errors) };
        for part in ["baseColorTexture", "material 2", "Brass", "level 1", "3.25 codes", "1.5"] {
            assert!(sentence.contains(part), "{sentence}");
        }
        let many = judge(SubjectKind::Converted, &[channel(Unit::Codes, &[(1.4, 1.01)])]);
        assert!(many.errors[0].contains("99.9th"));
        let mut few = channel(Unit::Codes, &[(1.4, 1.4)]);
        few.levels[0].seams = Some(Figures { max: 1.4, p999: 1.4, mean: 0.1, sample_count: 38 });
        assert_eq!(judge(SubjectKind::Converted, &[few]).verdict, Verdict::Pass);
    }

    #[test]
    fn normals_only_warn_and_sources_promise_nothing() {
        let tilted = judge(SubjectKind::Converted, &[channel(Unit::Degrees, &[(9.0, 1.2), (9.0, 3.0)])]);
        assert_eq!((tilted.verdict, tilted.max_seam_delta_codes), (Verdict::Warn, 0.0));
        assert_eq!((tilted.warnings.len(), tilted.warnings[0].count), (1, 2));
        assert!(tilted.warnings[0].detail.contains("level 1"));
        let source = judge(SubjectKind::Source, &[channel(Unit::Codes, &[(200.0, 90.0)])]);
        assert_eq!((source.verdict, source.max_seam_delta_codes), (Verdict::Pass, 200.0));
    }
}
