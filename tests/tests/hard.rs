//! One test for each hard case (`tests/hard`, remade by `make.py` there), and the page that shows them.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::Vec2;
use meshcolor::finished::Anchor;
use meshcolor::image::{LevelRange, Pixels, Transfer};
use meshcolor::measure::SolverReport;
use meshcolor::pipeline::Conversion;
use meshcolor::watch::Unwatched;
use meshcolor_tests::cases::{files_of_cases, made_by};
use meshcolor_tests::hard::promises::{RESIDUAL, SEAM_CODES, check};
use meshcolor_tests::hard::stages::far_levels;
use meshcolor_tests::hard::{self, HardCase, RUNS, page};
use meshcolor_tests::patches::{Patch, Random};
use meshcolor_tests::repository::hold;

macro_rules! cases {
    ($($name:ident,)*) => {
        $(#[test]
        fn $name() {
            hard::run(stringify!($name));
        })*

        const LISTED: &[&str] = &[$(stringify!($name)),*];
    };
}

cases! {
    all_at_one_point,
    all_boundary,
    all_cuts,
    alpha_0_everywhere,
    alpha_0_region,
    alpha_checkers,
    alpha_mask_beyond_1,
    alpha_mask_checkers,
    at_1e6,
    bent_sheet,
    black_and_white_quads,
    black_and_white_triangles,
    black_face_white_edges,
    checkers_lone_0,
    checkers_lone_1,
    checkers_lone_2,
    checkers_lone_3,
    checkers_pairs_0,
    checkers_pairs_1,
    checkers_pairs_2,
    checkers_pairs_3,
    checkers_quads_0,
    checkers_quads_1,
    checkers_quads_2,
    checkers_quads_3,
    checkers_twins_0,
    checkers_twins_1,
    checkers_twins_2,
    checkers_twins_3,
    dense_among_coarse,
    edge_of_3_faces,
    edge_of_5_faces,
    empty_obj,
    empty_scene,
    exponents_0_and_8,
    face_2_times,
    face_3_times,
    factors_extreme,
    long_strip,
    moebius_strip,
    nearly_welded,
    needle_quads,
    needle_triangles,
    normal_scale_denormal,
    normal_scale_zero,
    obj_position_nan,
    of_denormal_size,
    of_size_1e6,
    of_size_1e9,
    of_size_1e_minus_20,
    of_size_1e_minus_6,
    opposite_winding,
    points_beside_faces,
    position_infinite,
    position_nan,
    position_too_far,
    quad_at_a_point,
    quad_bent,
    quad_concave,
    quad_crossing_itself,
    quad_folded,
    quad_on_a_line,
    quads_at_a_pole,
    sheets_back_to_back,
    single_triangle,
    source_16384x1,
    source_16385x1,
    source_1x1,
    source_1x16384,
    t_junction,
    tiny_part_in_a_huge_scene,
    uv_constant,
    uv_huge,
    uv_infinite,
    uv_nan,
    uv_on_a_line,
    uv_span_huge,
    uv_too_far,
    valence_1000,
    valence_3,
    valence_4,
    welded_to_a_line,
    white_face_black_edges,
    wide_black_and_white,
    wide_gray_alpha,
    wide_smallest_steps,
}

#[test]
fn every_folder_is_listed_and_every_listed_case_has_a_folder() {
    assert_eq!(hard::names(), LISTED);
}

#[test]
fn the_script_makes_the_same_files() {
    let Some(made) = made_by(&hard::folder().join("make.py")) else { return };
    let kept = files_of_cases(&hard::folder());
    assert_eq!(made.keys().collect::<Vec<_>>(), kept.keys().collect::<Vec<_>>());
    for (name, bytes) in &made {
        assert!(*bytes == kept[name], "{name} is not what make.py writes");
    }
}

/// Times stay as they are: `--example hard_cases` measures them.
#[test]
fn the_page_shows_what_is_recorded() {
    if !hard::records() {
        hold(page::DOCUMENT, page::MARK, &page::text(&page::times()));
    }
}

/// Faces of exponent 0 up to level 20, where corners stand a millionth of a texel apart and rules weigh them by up to
/// `4^20`. What must not grow: jumps, how far the shown vertices are from the solved ones, what the solver leaves out
/// of range, and what continuity costs.
#[test]
fn twenty_levels_beyond_vertex_colors_stay_stable() {
    for (seed, transfer) in
        [(1, Transfer::Srgb), (2, Transfer::Linear), (3, Transfer::Srgb), (4, Transfer::Linear)]
    {
        let patch = Patch::wild(&mut Random::new(seed), 4);
        let levels = far_levels(&patch, 20, transfer, seed);
        let settled = levels[12].change_mean;
        for found in &levels {
            assert!(found.residual <= RESIDUAL, "{found:?}");
            assert!(found.jump_codes <= SEAM_CODES && found.apart_codes <= 0.51, "{found:?}");
            // Continuity costs more from level to level and converges: one color for all that hangs together.
            assert!(
                found.change_mean <= 1.002 * settled && found.change_max < 1.0,
                "{found:?}, settled at {settled}"
            );
        }
    }
}

#[test]
fn the_promises_see_what_they_look_for() {
    let hard = HardCase::load("source_1x1");
    let breaks = |change: &dyn Fn(&mut Conversion)| {
        // A run in the source's own 8 bits, which the independent reader knows.
        let run = RUNS.iter().find(|run| run.name == "papers").unwrap();
        let mut outcome = hard.convert(run, &Unwatched).unwrap();
        change(&mut outcome.conversion);
        catch_unwind(AssertUnwindSafe(|| check("source_1x1", &outcome)))
            .err()
            .map(|panic| *panic.downcast().unwrap())
    };
    assert_eq!(breaks(&|_| ()), None::<String>);
    let sees = |wanted: &str, change: &dyn Fn(&mut Conversion)| {
        let said = breaks(change).unwrap_or_default();
        assert!(said.contains(wanted), "{wanted}: {said}");
    };
    sees("not finite", &|it| it.report.channels[0].levels[1].drift = Some(f64::NAN));
    sees("level 1 is not finite", &|it| {
        let texture = &mut it.finished.textures[0];
        texture.ranges.insert(1, LevelRange::Float16);
        let image = &mut texture.levels[1];
        let mut halves =
            vec![0; image.width as usize * image.height as usize * usize::from(image.components)];
        // Infinity.
        halves[7] = 0x7c00;
        image.pixels = Pixels::U16(halves);
    });
    let moved = |it: &mut Conversion, by: Vec2| {
        let Anchor::Offset(offset) = &mut it.finished.primitives[0].triangles[3].anchor else { panic!("4D") };
        *offset += by;
    };
    sees("has a corner", &|it| moved(it, Vec2::new(f32::NAN, 0.0)));
    sees("has a corner", &|it| moved(it, Vec2::new(0.0, 99.0)));
    sees("a seam of", &|it| it.report.max_seam_delta_codes = 1.6);
    sees("out of range by", &|it| {
        it.report.channels[0].solver.push(SolverReport { residual: 2e-6, ..SolverReport::default() });
    });
    // A texel at a corner that several faces share; then every texel, which no edge tells.
    let tint = |it: &mut Conversion, level: usize, texels: Range<usize>| {
        let Pixels::U8(codes) = &mut it.finished.textures[0].levels[level].pixels else { panic!("8 bits") };
        let end = texels.end.min(codes.len() / 3);
        (texels.start..end).for_each(|texel| codes[3 * texel] += 2);
    };
    let corner = |it: &Conversion| {
        let place = it.finished.primitives[0].place(9, 0, 0);
        place.y as usize * it.finished.textures[0].levels[0].width as usize + place.x as usize
    };
    sees("jumps by", &|it| (0..3).for_each(|_| tint(it, 0, corner(it)..corner(it) + 1)));
    sees("outside of", &|it| tint(it, 2, 0..usize::MAX));
}
