use glam::Vec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::{Problem, Solution, TOLERANCE, solve};
use crate::assign::Rules;

fn run(rules: &Rules, wanted: &[f64], moves: bool) -> Solution {
    let weights = vec![1.0; wanted.len()];
    solve(&Problem { rules, wanted, weights: &weights, center: 0.5, is_stored: true }, moves, &|| false)
}

/// MCT 3.1's worst case: a white texel between two black edge samples changes each by a third.
#[test]
fn white_among_black_changes_by_a_third() {
    let rules = Rules::from_rows(&[(&[(0, 1.0), (1, 1.0), (2, -1.0)], 0.0)]);
    let solution = run(&rules, &[0.0, 0.0, 1.0], true);
    for (value, expected) in solution.values.iter().zip([1.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0]) {
        assert!((value - expected).abs() < 1e-6, "{:?}", solution.values);
    }
    assert_eq!(solution.violated_count, 1);
    assert!(solution.residual <= TOLERANCE);
}

#[test]
fn what_fits_is_left_alone_to_the_last_bit() {
    let rules = Rules::from_rows(&[(&[(0, 1.0), (1, 1.0), (2, -1.0)], 0.0)]);
    let wanted = [0.25, 0.5, 0.125];
    let solution = run(&rules, &wanted, true);
    assert_eq!(solution.values, wanted);
    assert_eq!((solution.violated_count, solution.step_count), (0, 0));
}

#[test]
fn without_moves_the_damage_is_told() {
    let rules = Rules::from_rows(&[(&[(0, 3.0), (1, -2.0)], 0.0)]);
    let solution = run(&rules, &[0.0, 1.0], false);
    assert_eq!(solution.values, [0.0, 1.0]);
    assert!((solution.residual - 2.0).abs() < 1e-12);
}

/// Corners of a face `2^levels` beyond vertex colors: two texels a side, the corners `1/m` of a texel apart.
fn beyond_rows(first: u32, m: f64, offset: f64) -> Vec<(Vec<(u32, f64)>, f32)> {
    let weights = |s: f64| [1.0 - s, s];
    let mut rows = Vec::new();
    for y in 0..2 {
        for x in 0..2 {
            let (s, t) = ((f64::from(x) - offset) * m, (f64::from(y) - offset) * m);
            let (ws, wt) = (weights(s), weights(t));
            let terms = (0..4).map(|k| (first + k, ws[k as usize % 2] * wt[k as usize / 2]));
            rows.push((terms.collect(), 0.0));
        }
    }
    rows
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 64,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Chains of faces up to twelve levels beyond vertex colors: every rule holds, the conditions of the
    /// optimum hold, and no nearby feasible point is nearer to what was wanted.
    #[test]
    fn chains_far_beyond_vertex_colors_are_solved(
        wanted in prop::collection::vec(0.0f64..1.0, 24),
        level in 1u32..12,
        offset in 0.0f64..0.9,
        nudge in prop::collection::vec(-1.0f64..1.0, 24),
    ) {
        let m = f64::from(1u32 << level);
        let mut rows = Vec::new();
        // Faces overlap in two corners each, as in a strip.
        for face in 0..11 {
            rows.extend(beyond_rows(2 * face, m, offset * (1.0 - 1.0 / m)));
        }
        let borrowed: Vec<(&[(u32, f64)], f32)> = rows.iter().map(|(terms, k)| (terms.as_slice(), *k)).collect();
        let rules = Rules::from_rows(&borrowed);
        let solution = run(&rules, &wanted, true);
        prop_assert!(solution.residual <= TOLERANCE, "{solution:?}");
        prop_assert!(solution.values.iter().all(|v| v.is_finite()));
        // Weights reach m²: rounding leaves the gradient less exact than on a few levels, and 1e-4 moves a
        // sample by a fortieth of a code. Beyond that the report warns.
        prop_assert!(solution.complementarity < 1e-9 && solution.dual_residual < 1e-4, "{solution:?}");
        let cost = |values: &[f64]| values.iter().zip(&wanted).map(|(v, c)| (v - c).powi(2)).sum::<f64>();
        // Towards the middle every point is feasible; sideways only some are.
        let other: Vec<f64> = solution.values.iter().zip(&nudge).map(|(v, n)| v + 0.02 * (0.5 - v) + 1e-4 * n).collect();
        if super::violated_count(&rules, &other) == 0 {
            prop_assert!(cost(&other) >= cost(&solution.values) - 1e-6);
        }
    }
}

/// The frames of normals mix components; the rules are the same kind.
#[test]
fn rules_with_constants_center_on_zero() {
    let direction = Vec3::new(0.6, 0.0, 0.8);
    let terms: Vec<(u32, f64)> = (0u32..3).map(|k| (k, f64::from(direction[k as usize]))).collect();
    let rules = Rules::from_rows(&[(&terms, 0.5)]);
    let wanted = [0.6, 0.0, 0.8];
    let weights = [1.0; 3];
    let problem =
        Problem { rules: &rules, wanted: &wanted, weights: &weights, center: 0.0, is_stored: false };
    let solution = solve(&problem, true, &|| false);
    let value: f64 = (0..3).map(|k| solution.values[k] * f64::from(direction[k])).sum();
    assert!((value - 0.5).abs() < 1e-6, "the texel leans on its bound: {value}");
}
