//! What every conversion must hold, however nasty its model.
//!
//! "No growth of error with the level" is measured in three ways, at every level: uncut edges stay within the guarantee;
//! the surface shows nothing outside of the hull of the source's values; and a picture of one color is shown as
//! that color, which is where rounding and cancellation of large weights would be seen first.

use glam::Vec3;
use meshcolor::asset::Asset;
use meshcolor::finished::{Finished, FinishedPrimitive, FinishedTexture};
use meshcolor::image::{Image, Pixels};
use meshcolor::measure::{Figures, SolverReport, Unit};
use meshcolor::pipeline::{Sampling, Solver};
use meshcolor::watch::Unwatched;

use super::figures::solved;
use super::{HardCase, Outcome, RUNS};
use crate::reading::{jumps_codes, shown_codes_of};

/// Largest jump that rounding explains, in codes: the guarantee of the report.
pub const SEAM_CODES: f32 = 1.5;
/// The solver's stated tolerance, linear values.
pub const RESIDUAL: f64 = 1e-6;
/// Rounding to codes, at both ends of the hull.
const HULL_CODES: f32 = 1.01;
/// A color is stored as its own code.
const COLOR_CODES: f32 = 0.51;
/// Codes in 8 bits of the picture of one color.
const COLOR: [u8; 4] = [37, 201, 5, 255];

/// Known bugs, each a case and a run that break the guarantee in 8 bits by less than half a code, and say so in
/// their verdict. There are none now.
const KNOWN: [&str; 0] = [];

/// Where a triangle is looked at: corners, middles of edges, inside.
const LOOKS: [[f32; 3]; 8] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [0.25, 0.25, 0.5],
    [0.75, 0.125, 0.125],
];

/// # Panics
/// Where something does not hold, with the case, the run and the figure.
pub fn check(name: &str, outcome: &Outcome) {
    let at = format!("{name}, {}", outcome.run.name);
    check_finite(&at, outcome);
    check_places(&at, &outcome.conversion.finished);
    if outcome.run.keeps_edges() {
        check_edges(&at, outcome);
        check_hull(&at, outcome);
    }
}

fn check_finite(at: &str, outcome: &Outcome) {
    let report = &outcome.conversion.report;
    let of_seams = |seams: &Figures| [seams.max, seams.p999, seams.mean];
    let levels = report.channels.iter().flat_map(|channel| &channel.levels);
    let mut figures: Vec<f64> =
        levels.filter_map(|level| level.seams).flat_map(|seams| of_seams(&seams)).collect();
    figures
        .extend(report.channels.iter().flat_map(|channel| &channel.levels).filter_map(|level| level.drift));
    let fidelities = report.channels.iter().filter_map(|channel| channel.fidelity);
    figures.extend(fidelities.flat_map(|f| [f.psnr_db, f.rms, f.p99, f.max]));
    let stored = report.channels.iter().flat_map(|channel| &channel.stored);
    figures.extend(stored.flat_map(|level| [level.change_mean_codes, level.change_max_codes]));
    let mip_errors = report.channels.iter().flat_map(|channel| &channel.levels).filter_map(|l| l.mip_error);
    figures.extend(mip_errors.flat_map(|error| [error.rms, error.p99, error.reference_error]));
    figures.extend(solved(outcome).flat_map(|level| {
        [
            level.residual,
            level.dual_residual,
            level.complementarity,
            level.change_mean_codes,
            level.change_max_codes,
        ]
    }));
    assert!(figures.iter().all(|figure| figure.is_finite()), "{at}: a figure of the report is not finite");
    // Codes of [0, 1] are finite whatever they are.
    for texture in &outcome.conversion.finished.textures {
        for (&level, range) in &texture.ranges {
            let image = &texture.levels[level];
            let mut texels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
            let is_finite = texels.all(|(x, y)| range.texel(image, x, y).is_finite());
            assert!(is_finite, "{at}: a texel of level {level} is not finite");
        }
    }
}

/// Every corner lies inside of its image, half a texel from the border at least.
fn check_places(at: &str, finished: &Finished) {
    for piece in &finished.primitives {
        let Some(texture) =
            finished.textures.iter().find(|texture| texture.is_of(piece.material, piece.part))
        else {
            panic!("{at}: a primitive without a texture")
        };
        for (level, image) in texture.levels.iter().enumerate() {
            let triangles = 0..piece.triangles.len();
            for (triangle, corner) in triangles.flat_map(|t| (0..3).map(move |corner| (t, corner))) {
                let place = piece.place(triangle, corner, level);
                let inside = |at: f32, side: u32| (0.5..=side as f32 - 0.5).contains(&at);
                let holds = inside(place.x, image.width) && inside(place.y, image.height);
                assert!(holds, "{at}: level {level} has a corner at {place} of {:?}", image.size());
            }
        }
    }
}

fn check_edges(at: &str, outcome: &Outcome) {
    let conversion = &outcome.conversion;
    let seam = conversion.report.max_seam_delta_codes;
    let is_known = KNOWN.contains(&at);
    assert!(!is_known || seam > f64::from(SEAM_CODES), "{at}: known no more");
    let seam_allowed = f64::from(SEAM_CODES) + if is_known { 0.5 } else { 0.0 };
    assert!(seam <= seam_allowed, "{at}: a seam of {seam} codes");
    assert!(is_known || conversion.report.errors.is_empty(), "{at}: {:?}", conversion.report.errors);
    // The library states no residual of ours; ten levels beyond vertex colors it leaves this much.
    let allowed = if outcome.options.solver == Solver::Exact { 100.0 } else { 1.0 };
    for level in solved(outcome) {
        let SolverReport { residual, tolerance, .. } = level;
        assert!(*residual <= allowed * tolerance, "{at}: a texel is out of range by {residual}");
    }
    // A second opinion, by code that shares nothing with `measure`.
    for (texture, channel) in conversion.report.channels.iter().enumerate() {
        if channel.unit == Unit::Codes {
            let jumps = jumps_codes(&conversion.asset, &conversion.finished, texture);
            let worst = jumps.into_iter().fold(0.0, f32::max);
            assert!(f64::from(worst) <= seam_allowed, "{at}: channel {texture} jumps by {worst} codes");
        }
    }
}

/// At every level the surface shows nothing that the source does not have. Fitted samples may leave the hull to be
/// nearer to the source between them.
fn check_hull(at: &str, outcome: &Outcome) {
    if outcome.options.sampling == Sampling::Fitted {
        return;
    }
    let Outcome { conversion, .. } = outcome;
    for texture in conversion.finished.textures.iter().filter(|texture| !texture.is_normal()) {
        let [low, high] = hull_codes(source_image(&conversion.asset, texture));
        each_look(&conversion.finished, texture, |level, shown| {
            let holds =
                (low - shown).max_element() <= HULL_CODES && (shown - high).max_element() <= HULL_CODES;
            assert!(holds, "{at}: level {level} shows {shown}, outside of {low} to {high}");
        });
    }
}

fn source_image<'a>(asset: &'a Asset, texture: &FinishedTexture) -> &'a Image {
    let slot = asset.materials[texture.materials[0]].slot(texture.slots[0]);
    &asset.images[slot.map_or(0, |slot| slot.image)]
}

/// Least and largest codes of an image; gray in all three.
fn hull_codes(image: &Image) -> [Vec3; 2] {
    let texels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    texels.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], (x, y)| {
        let [red, green, blue, _] = image.normalized(x, y);
        let codes = Vec3::new(red, green, blue) * 255.0;
        [low.min(codes), high.max(codes)]
    })
}

/// What a viewer sees at some points of every triangle at every level, in codes.
fn each_look(finished: &Finished, texture: &FinishedTexture, mut look: impl FnMut(usize, Vec3)) {
    let triangles: Vec<(&FinishedPrimitive, usize)> = finished
        .primitives
        .iter()
        .filter(|piece| texture.is_of(piece.material, piece.part))
        .flat_map(|piece| (0..piece.triangles.len()).map(move |triangle| (piece, triangle)))
        .collect();
    for level in 0..texture.levels.len() {
        for ((piece, triangle), at) in triangles.iter().flat_map(|triangle| LOOKS.map(|at| (triangle, at))) {
            look(level, shown_codes_of(texture, level, piece.place_at(*triangle, Vec3::from(at), level)));
        }
    }
}

/// Largest difference of what two conversions show, in codes, over the levels that are stored as the source
/// is. (The texels around a face far beyond vertex colors magnify what its corners differ by.)
pub fn shown_apart_codes(a: &Outcome, b: &Outcome) -> f64 {
    let (a, b) = (&a.conversion.finished, &b.conversion.finished);
    let mut worst: f64 = 0.0;
    for (ours, theirs) in a.textures.iter().zip(&b.textures) {
        let looks = |finished: &Finished, texture: &FinishedTexture| {
            let mut looks = Vec::new();
            each_look(finished, texture, |level, shown| looks.push((level, shown)));
            looks
        };
        for ((level, ours_shows), (_, theirs_shows)) in looks(a, ours).into_iter().zip(looks(b, theirs)) {
            if !ours.ranges.contains_key(&level) && !theirs.ranges.contains_key(&level) {
                worst = worst.max(f64::from((ours_shows - theirs_shows).abs().max_element()));
            }
        }
    }
    worst
}

/// The optimum is one point: the library's solver ends at the same samples, up to both tolerances and rounding.
///
/// # Panics
/// Where the objective is more than 0.1 % above, or what shows differs by more than two codes.
pub fn check_same_optimum(name: &str, global: &Outcome, library: &Outcome) {
    for (ours, theirs) in global.conversion.report.channels.iter().zip(&library.conversion.report.channels) {
        let levels =
            |solver: &[meshcolor::measure::SolverReport]| solver.iter().map(|s| s.level).collect::<Vec<_>>();
        assert_eq!(levels(&ours.solver), levels(&theirs.solver), "{name}: the levels that are solved");
        for (ours, theirs) in ours.solver.iter().zip(&theirs.solver) {
            let allowed = theirs.objective * 1.001 + 1e-6;
            assert!(
                ours.objective <= allowed,
                "{name}, level {}: objective {}, not {}",
                ours.level,
                ours.objective,
                theirs.objective
            );
        }
    }
    let apart = shown_apart_codes(global, library);
    assert!(apart <= 2.0, "{name}: the two solvers show what is {apart} codes apart");
}

/// The same model with pictures of one color shows that color, at every level.
///
/// # Panics
/// Where it shows another.
pub fn check_one_color(hard: &HardCase) {
    let mut asset = hard.model.clone().unwrap_or_else(|error| panic!("{}: {error}", hard.name));
    asset.images.iter_mut().for_each(paint_over);
    let one_color = HardCase {
        model: Ok(asset),
        name: hard.name.clone(),
        case: hard.case.clone(),
        folder: hard.folder.clone(),
    };
    for run in RUNS.iter().filter(|run| ["standard", "unorm8"].contains(&run.name)) {
        let outcome = one_color
            .convert(run, &Unwatched)
            .unwrap_or_else(|error| panic!("{}, one color: {error}", hard.name));
        check_finite(&hard.name, &outcome);
        let finished = &outcome.conversion.finished;
        for texture in finished.textures.iter().filter(|texture| !texture.is_normal()) {
            let [color, _] = hull_codes(source_image(&outcome.conversion.asset, texture));
            each_look(finished, texture, |level, shown| {
                let apart = (shown - color).abs().max_element();
                assert!(
                    apart <= COLOR_CODES,
                    "{}, {}: level {level} shows {shown}, not {color}",
                    hard.name,
                    run.name
                );
            });
        }
    }
}

fn paint_over(image: &mut Image) {
    let n = usize::from(image.components);
    let code = |at: usize| if n == 2 && at % n == 1 { COLOR[3] } else { COLOR[at % n] };
    match &mut image.pixels {
        Pixels::U8(codes) => codes.iter_mut().enumerate().for_each(|(at, c)| *c = code(at)),
        Pixels::U16(codes) => codes.iter_mut().enumerate().for_each(|(at, c)| *c = u16::from(code(at)) * 257),
        Pixels::F32(_) => {}
    }
}
