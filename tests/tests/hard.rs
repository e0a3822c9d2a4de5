//! One test for each hard case (`tests/hard`, remade by `make.py` there), and the page that shows them.

use meshcolor::image::Transfer;
use meshcolor_tests::cases::{files_of_cases, made_by};
use meshcolor_tests::hard::promises::{RESIDUAL, SEAM_CODES};
use meshcolor_tests::hard::stages::far_levels;
use meshcolor_tests::hard::{self, page};
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
    sheets_back_to_back,
    single_triangle,
    source_16384x1,
    source_16385x1,
    source_1x1,
    source_1x16384,
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
/// `4^20`. What must not grow: jumps, and how far the shown vertices are from the solved ones. The residual has the
/// cancellation of such weights in 64 bits as its floor, and so has the optimum: to a tenth it stays where it was.
#[test]
fn twenty_levels_beyond_vertex_colors_stay_stable() {
    for (seed, transfer) in
        [(1, Transfer::Srgb), (2, Transfer::Linear), (3, Transfer::Srgb), (4, Transfer::Linear)]
    {
        let patch = Patch::wild(&mut Random::new(seed), 4);
        let levels = far_levels(&patch, 20, transfer, seed);
        let settled = levels[12].change_mean;
        for found in &levels {
            let cancellation = 4f64.powi(found.level as i32) * f64::EPSILON;
            assert!(found.residual <= RESIDUAL + cancellation, "{found:?}");
            assert!(found.jump_codes <= SEAM_CODES && found.apart_codes <= 0.51, "{found:?}");
            // Continuity costs more from level to level and converges: one color for all that hangs together.
            let slack = if found.level <= 13 { 1.002 } else { 1.1 };
            assert!(
                found.change_mean <= slack * settled && found.change_max < 1.0,
                "{found:?}, settled at {settled}"
            );
        }
    }
}
