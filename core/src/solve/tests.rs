use glam::Vec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::{Problem, Solution, TOLERANCE, solve, solve_exactly, solve_locally};
use crate::assign::Rules;

fn problem<'a>(rules: &'a Rules, wanted: &'a [f64], weights: &'a [f64]) -> Problem<'a> {
    Problem { rules, wanted, weights, center: 0.5, bounds: Some([0.0, 1.0]) }
}

fn run(rules: &Rules, wanted: &[f64]) -> Solution {
    solve(&problem(rules, wanted, &vec![1.0; wanted.len()]), &|| false)
}

/// MCT 3.1's worst case: a white texel between two black edge samples changes each by a third.
#[test]
fn white_among_black_changes_by_a_third() {
    let rules = Rules::from_rows(&[(&[(0, 1.0), (1, 1.0), (2, -1.0)], 0.0)]);
    let solution = run(&rules, &[0.0, 0.0, 1.0]);
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
    let solution = run(&rules, &wanted);
    assert_eq!(solution.values, wanted);
    assert_eq!((solution.violated_count, solution.step_count), (0, 0));
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
        let solution = run(&rules, &wanted);
        prop_assert!(solution.residual <= TOLERANCE, "{solution:?}");
        prop_assert!(solution.values.iter().all(|v| v.is_finite()));
        // Weights reach m²: rounding leaves the gradient less exact than on a few levels, and 1e-4 moves a
        // sample by a fortieth of a code. Beyond that the report warns.
        prop_assert!(solution.complementarity <= 1e-6 && solution.dual_residual < 1e-4, "{solution:?}");
        let cost = |values: &[f64]| values.iter().zip(&wanted).map(|(v, c)| (v - c).powi(2)).sum::<f64>();
        // Towards the middle every point is feasible; sideways only some are.
        let other: Vec<f64> = solution.values.iter().zip(&nudge).map(|(v, n)| v + 0.02 * (0.5 - v) + 1e-4 * n).collect();
        let weights = vec![1.0; 24];
        if problem(&rules, &wanted, &weights).violations(&other).1 == 0 {
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
    let problem = Problem { rules: &rules, wanted: &wanted, weights: &weights, center: 0.0, bounds: None };
    let solution = solve(&problem, &|| false);
    let value: f64 = (0..3).map(|k| solution.values[k] * f64::from(direction[k])).sum();
    assert!((value - 0.5).abs() < 1e-6, "the texel leans on its bound: {value}");
}

/// A strip of faces, each sharing two corners with the next.
fn strip(face_count: u32, m: f64, offset: f64) -> Rules {
    let rows: Vec<_> =
        (0..face_count).flat_map(|face| beyond_rows(2 * face, m, offset * (1.0 - 1.0 / m))).collect();
    Rules::from_cells(&rows)
}

fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(|_| next()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 48,
        rng_seed: RngSeed::Fixed(8),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// The library, which gets every rule at once, finds nothing that is nearer by more than a thousandth.
    #[test]
    fn the_objective_is_that_of_the_library(seed in any::<u64>(), level in 0u32..6, offset in 0.0f64..0.9) {
        let rules = strip(30, f64::from(1u32 << level), offset);
        let wanted = noise(62, seed);
        let weights: Vec<f64> = noise(62, !seed).into_iter().map(|weight| 0.1 + weight).collect();
        let problem = problem(&rules, &wanted, &weights);
        let (ours, exact) = (solve(&problem, &|| false), solve_exactly(&problem).unwrap());
        prop_assert!(ours.residual <= TOLERANCE && exact.residual <= TOLERANCE, "{ours:?} {exact:?}");
        prop_assert!((ours.objective - exact.objective).abs() <= 1e-3 * exact.objective + 1e-9, "{} {}", ours.objective, exact.objective);
        prop_assert_eq!(ours.violated_count, exact.violated_count);
    }
}

/// Twenty levels beyond vertex colors a triangle's rules weigh its corners by 2^20 and are nearly parallel.
#[test]
fn weights_of_a_million_are_solved() {
    let m = f64::from(1u32 << 20);
    let mut rows: Vec<(Vec<(u32, f64)>, f32)> = Vec::new();
    for face in 0..20 {
        for (x, y) in [(0.3, 0.4), (-0.7, 0.4), (0.3, -0.6), (-0.7, -0.6)] {
            let (a, b) = (x * m, y * m);
            rows.push((vec![(face, 1.0 - a - b), (face + 1, a), (face + 2, b)], 0.0));
        }
    }
    let rules = Rules::from_cells(&rows);
    let wanted = noise(22, 5);
    let weights = vec![1.0; 22];
    let problem = problem(&rules, &wanted, &weights);
    let ours = solve(&problem, &|| false);
    assert!(ours.values.iter().all(|value| value.is_finite()));
    assert!(ours.residual <= TOLERANCE, "{ours:?}");
    // The corners have to agree to a millionth, so the mean is the best.
    let mean = wanted.iter().sum::<f64>() / 22.0;
    let best: f64 = wanted.iter().map(|value| (value - mean).powi(2)).sum();
    assert!((ours.objective - best).abs() < 1e-3 * best, "{} {best}", ours.objective);
    let exact = solve_exactly(&problem).unwrap();
    assert!((ours.objective - exact.objective).abs() < 1e-3 * best, "{} {}", ours.objective, exact.objective);
}

/// The outcome is the same to the last bit with any number of threads.
#[test]
fn threads_change_no_bit() {
    let rules = strip(400, 4.0, 0.4);
    let wanted = noise(802, 11);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&rules, &wanted))
    };
    assert_eq!(on(1), on(4));
}

/// MCT 3.1: a third each, on the samples that all faces share.
#[test]
fn local_shares_out_what_a_border_texel_lacks() {
    let rules = Rules::from_rows(&[(&[(0, 1.0), (1, 1.0), (2, -1.0)], 0.0)]);
    let weights = [1.0; 3];
    let local = solve_locally(&problem(&rules, &[0.0, 0.0, 1.0], &weights));
    assert!(local.faces.is_empty());
    for (value, expected) in local.shared.iter().zip([1.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0]) {
        assert!((value - expected).abs() < 1e-12, "{:?}", local.shared);
    }
    assert!(local.solution.residual <= TOLERANCE);
}

/// MCT 3.4: each face fits on its own, with the least change for the texels that it took in, and faces
/// end with different versions of what they share.
#[test]
fn local_solves_each_face_by_itself() {
    let rules = strip(6, 2.0, 0.25);
    let wanted = noise(14, 3);
    let weights = [1.0; 14];
    let problem = problem(&rules, &wanted, &weights);
    let local = solve_locally(&problem);
    assert_eq!(local.shared, wanted);
    let mut versions: Vec<Vec<f64>> = vec![Vec::new(); 14];
    for change in &local.faces {
        let mut values = wanted.clone();
        for &(variable, value) in &change.values {
            values[variable as usize] = value;
            versions[variable as usize].push(value);
        }
        for row in rules.group(change.group) {
            assert!(problem.violation(row, &values) <= local.solution.residual + 1e-12);
        }
    }
    assert!(versions.iter().any(|all| all.len() == 2 && all[0] != all[1]), "{versions:?}");
    let global = solve(&problem, &|| false);
    assert!(local.solution.objective != global.objective);
}

/// One violated texel: the shortest change along its own weights.
#[test]
fn local_change_is_the_shortest() {
    let rules = Rules::from_cells(&[(vec![(0, 2.0), (1, -1.0)], 0.0), (vec![(0, 0.5), (1, 0.5)], 0.0)]);
    let weights = [1.0; 2];
    let local = solve_locally(&problem(&rules, &[0.2, 0.9], &weights));
    let values: Vec<f64> = local.faces[0].values.iter().map(|&(_, value)| value).collect();
    // 2 · 0.2 - 0.9 = -0.5, so (2, -1) · 0.5 / 5 is added.
    assert!((values[0] - 0.4).abs() < 1e-12 && (values[1] - 0.8).abs() < 1e-12, "{values:?}");
}
