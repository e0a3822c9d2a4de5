//! What the project promises about real models, as assertions: seams, drift, fidelity. Each model is
//! converted once at the defaults and once with 4D coordinates, and all tests look at these conversions.

use std::sync::OnceLock;

use meshcolor::measure::{ChannelReport, Report, SubjectKind, Unit, Verdict};
use meshcolor::pipeline::{Conversion, Coordinates, Options, check, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_tests::{models, reading, validator};

/// Largest jump, and its 99.9th percentile, over uncut edges.
const SEAM_CODES: [f64; 2] = [1.5, 1.0];
const NORMAL_P999_DEGREES: f64 = 1.0;
/// Over the source's own disagreement at level 0.
const DRIFT_CODES: f64 = 1.0;
/// Under one bilinear resampling of the source to as many texels.
const UNDER_YARDSTICK_DB: f64 = 5.0;

/// One model's conversion, shared among the tests; `None` where there is no folder of models.
struct Model {
    name: &'static str,
    coordinates: Coordinates,
    conversion: OnceLock<Option<Conversion>>,
}

impl Model {
    const fn new(name: &'static str) -> Self {
        Self::with(name, Coordinates::Indexed)
    }

    const fn with(name: &'static str, coordinates: Coordinates) -> Self {
        Self { name, coordinates, conversion: OnceLock::new() }
    }

    const fn with_4d(name: &'static str) -> Self {
        Self::with(name, Coordinates::Scaled)
    }

    fn converted(&self) -> Option<&Conversion> {
        self.conversion
            .get_or_init(|| {
                models::upload(self.name).map(|upload| converted(self.name, &upload, self.coordinates))
            })
            .as_ref()
    }
}

fn converted(name: &str, upload: &Upload, coordinates: Coordinates) -> Conversion {
    let options = Options { coordinates, ..Options::default() };
    convert(upload, &options, &Limits::default(), &Unwatched).unwrap_or_else(|e| panic!("{name}: {e}"))
}

static HELMET: Model = Model::new("DamagedHelmet");
static FOX: Model = Model::new("Fox");
/// Quads; its library names the picture beside it.
static SPOT: Model = Model::new("spot");
static HELMET_4D: Model = Model::with_4d("DamagedHelmet");
static FOX_4D: Model = Model::with_4d("Fox");
static SPOT_4D: Model = Model::with_4d("spot");

/// The demo's model, which needs no folder.
fn sample() -> &'static Conversion {
    static SAMPLE: OnceLock<Conversion> = OnceLock::new();
    SAMPLE.get_or_init(|| {
        let upload = Upload::single("sample.glb", meshcolor_service::sample::model());
        converted("sample", &upload, Coordinates::Indexed)
    })
}

fn assert_seamless(name: &str, report: &Report) {
    assert_eq!((report.errors.clone(), report.kind), (Vec::new(), SubjectKind::Converted), "{name}");
    assert_ne!(report.verdict, Verdict::Fail, "{name}");
    let mut measured_count = 0;
    for channel in &report.channels {
        for level in &channel.levels {
            let seams = level.seams.unwrap_or_else(|| panic!("{name}: no uncut edge in {:?}", channel.slots));
            let place = format!("{name}, {:?}, level {}: {seams:?}", channel.slots, level.level);
            assert!(seams.sample_count > 1000, "{place}");
            match channel.unit {
                Unit::Codes => assert!(seams.max <= SEAM_CODES[0] && seams.p999 <= SEAM_CODES[1], "{place}"),
                Unit::Degrees => assert!(seams.p999 <= NORMAL_P999_DEGREES, "{place}"),
            }
            measured_count += 1;
        }
    }
    assert!(measured_count >= 5, "{name}: {measured_count} levels");
}

/// Our drift at every level stays within a code of the source's at level 0, and the source's own mip maps
/// do not: else the figure would say nothing.
fn assert_no_drift(name: &str, channel: &ChannelReport) {
    let at = |level: usize| channel.levels[level].source.and_then(|source| source.drift);
    let at_source = at(0).unwrap_or_else(|| panic!("{name}: no edge agrees in {:?}", channel.slots));
    for level in &channel.levels {
        let ours = level.drift.expect("the same edges");
        assert!(
            ours <= at_source + DRIFT_CODES,
            "{name}, {:?}, level {}: {ours}, source {at_source}",
            channel.slots,
            level.level
        );
    }
    let worst = (0..channel.levels.len()).filter_map(at).fold(0.0, f64::max);
    assert!(worst > at_source + DRIFT_CODES, "{name}, {:?}: mip maps alone drift by {worst}", channel.slots);
}

fn assert_faithful(name: &str, channel: &ChannelReport) {
    assert_eq!(channel.slots, ["baseColorTexture"], "{name}");
    let fidelity = channel.fidelity.unwrap_or_else(|| panic!("{name}: no fidelity"));
    let under = fidelity.yardstick_psnr_db.unwrap() - fidelity.psnr_db;
    assert!(fidelity.point_count >= 10_000 && fidelity.psnr_db > 30.0, "{name}: {fidelity:?}");
    assert!(under <= UNDER_YARDSTICK_DB, "{name}: {under} dB under the yardstick, {fidelity:?}");
}

/// The written file alone: valid, and measured again it has the report's figures.
fn assert_file_tells_the_same(name: &str, conversion: &Conversion) {
    let file = &conversion.files[0];
    assert_eq!(file.path, "asset.glb");
    validator::expect_valid(name, &file.bytes, false);
    let upload = Upload::single("asset.glb", file.bytes.clone());
    let again = check(&upload, &Options::default(), &Limits::default(), &Unwatched)
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(again.kind, SubjectKind::Converted);
    assert_eq!(again.max_seam_delta_codes, conversion.report.max_seam_delta_codes, "{name}");
    assert_eq!(again.channels.len(), conversion.report.channels.len(), "{name}");
    for (again, before) in again.channels.iter().zip(&conversion.report.channels) {
        let seams = |channel: &ChannelReport| -> Vec<_> {
            channel.levels.iter().map(|level| (level.size, level.seams)).collect()
        };
        assert_eq!(seams(again), seams(before), "{name}, {:?}", before.slots);
        assert_eq!(again.cuts.cut_edge_count, before.cuts.cut_edge_count, "{name}, {:?}", before.slots);
    }
}

/// The same by the tests' own arithmetic, which shares nothing with `measure`.
fn assert_seamless_by_our_own_measure(name: &str, conversion: &Conversion) {
    for (number, texture) in
        conversion.finished.textures.iter().enumerate().filter(|(_, texture)| !texture.is_normal())
    {
        for (level, jump) in
            reading::jumps_codes(&conversion.asset, &conversion.finished, number).into_iter().enumerate()
        {
            assert!(f64::from(jump) <= SEAM_CODES[0], "{name}, {:?}, level {level}: {jump}", texture.slots);
            assert!(level == 0 || jump > 0.0, "{name}: level {level} has no rounding at all");
        }
    }
}

macro_rules! for_model {
    ($($(#[$mark:meta])* $test:ident: $model:expr, $assert:expr;)*) => {
        $(#[test]
        $(#[$mark])*
        fn $test() {
            let Some(conversion) = $model.converted() else { return };
            $assert($model.name, conversion);
        })*
    };
}

for_model! {
    the_helmet_is_seamless: HELMET, |name, conversion: &Conversion| assert_seamless(name, &conversion.report);
    the_fox_is_seamless: FOX, |name, conversion: &Conversion| assert_seamless(name, &conversion.report);
    spot_is_seamless: SPOT, |name, conversion: &Conversion| assert_seamless(name, &conversion.report);
    the_helmet_is_seamless_with_4d_coordinates: HELMET_4D, |name, conversion: &Conversion| assert_seamless(name, &conversion.report);
    the_fox_is_seamless_with_4d_coordinates: FOX_4D, |name, conversion: &Conversion| assert_seamless(name, &conversion.report);
    spot_is_seamless_with_4d_coordinates: SPOT_4D, |name, conversion: &Conversion| assert_seamless(name, &conversion.report);
    the_helmets_4d_file_tells_the_same: HELMET_4D, assert_file_tells_the_same;
    the_foxs_4d_coordinates_are_seamless_by_our_own_measure: FOX_4D, assert_seamless_by_our_own_measure;
    spots_4d_coordinates_are_seamless_by_our_own_measure: SPOT_4D, assert_seamless_by_our_own_measure;
    spot_does_not_drift_with_4d_coordinates: SPOT_4D, |name, conversion: &Conversion| assert_no_drift(name, &conversion.report.channels[0]);
    the_helmet_is_seamless_by_our_own_measure: HELMET, assert_seamless_by_our_own_measure;
    the_fox_is_seamless_by_our_own_measure: FOX, assert_seamless_by_our_own_measure;
    spot_is_seamless_by_our_own_measure: SPOT, assert_seamless_by_our_own_measure;
    the_helmet_is_faithful: HELMET, |name, conversion: &Conversion| assert_faithful(name, &conversion.report.channels[0]);
    spot_is_faithful: SPOT, |name, conversion: &Conversion| assert_faithful(name, &conversion.report.channels[0]);
    spot_does_not_drift: SPOT, |name, conversion: &Conversion| assert_no_drift(name, &conversion.report.channels[0]);
    the_helmets_file_tells_the_same: HELMET, assert_file_tells_the_same;
    the_foxs_file_tells_the_same: FOX, assert_file_tells_the_same;
    spots_file_tells_the_same: SPOT, assert_file_tells_the_same;
}

#[test]
fn the_helmet_does_not_drift() {
    let Some(conversion) = HELMET.converted() else { return };
    let slots = conversion.report.channels.iter().map(|channel| channel.slots.join(" ")).collect::<Vec<_>>();
    let expected = ["baseColor", "metallicRoughness", "normal", "occlusion", "emissive"];
    assert_eq!(slots, expected.map(|name| format!("{name}Texture")));
    for channel in conversion.report.channels.iter().filter(|channel| channel.unit == Unit::Codes) {
        assert_no_drift(HELMET.name, channel);
    }
}

#[test]
fn spots_quads_stay_quads_and_nothing_is_cut() {
    let Some(conversion) = SPOT.converted() else { return };
    let layout = &conversion.report.layouts[0];
    assert_eq!((layout.face_count, layout.quad_count), (212, 160), "{layout:?}");
    // Its charts meet without a visible seam, so nothing may be cut.
    assert_eq!(conversion.report.channels[0].cuts.cut_edge_count, 0);
}

#[test]
fn the_sample_is_seamless() {
    assert_seamless("sample", &sample().report);
    assert_seamless_by_our_own_measure("sample", sample());
}

#[test]
fn the_samples_file_tells_the_same() {
    assert_file_tells_the_same("sample", sample());
}
