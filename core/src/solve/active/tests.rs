use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::{ACTIVE_MAX, solve_active};
use crate::solve::interior::Outcome;
use crate::solve::island::Island;

/// A row of all variables, and its constant.
type Row = (Vec<f64>, f64);

fn island(variable_count: usize, rows: &[Row]) -> Island {
    let mut island = Island::new((0..variable_count as u32).collect(), false);
    for (weights, constant) in rows {
        island.push((0..).zip(weights.iter().copied()), *constant, [0.0, 1.0]);
    }
    island
}

fn solve(wanted: &[f64], weights: &[f64], rows: &[Row]) -> Option<Outcome> {
    solve_active(&island(wanted.len(), rows), wanted, weights)
}

/// Tries every choice of rows that bind low, high or not at all, and keeps the nearest that fits.
fn by_trial(wanted: &[f64], weights: &[f64], rows: &[Row]) -> Option<Vec<f64>> {
    let value = |row: &Row, y: &[f64]| row.1 + row.0.iter().zip(y).map(|(w, y)| w * y).sum::<f64>();
    let cost = |y: &[f64]| -> f64 { (0..y.len()).map(|k| weights[k] * (y[k] - wanted[k]).powi(2)).sum() };
    let mut best: Option<Vec<f64>> = None;
    for mut choice in 0..3usize.pow(rows.len() as u32) {
        let mut binding = Vec::new();
        for row in rows {
            if !choice.is_multiple_of(3) {
                binding.push((row, (choice % 3 - 1) as f64));
            }
            choice /= 3;
        }
        let product = |a: &Row, b: &Row| (0..wanted.len()).map(|k| a.0[k] * b.0[k] / weights[k]).sum::<f64>();
        let mut system: Vec<Vec<f64>> = (binding.iter())
            .map(|(row, bound)| {
                let products = binding.iter().map(|(other, _)| product(row, other));
                products.chain([bound - value(row, wanted)]).collect()
            })
            .collect();
        let Some(multipliers) = eliminate(&mut system) else { continue };
        let mut y = wanted.to_vec();
        for ((row, _), multiplier) in binding.iter().zip(multipliers) {
            (0..y.len()).for_each(|k| y[k] += multiplier * row.0[k] / weights[k]);
        }
        let fits = rows.iter().all(|row| (-1e-9..=1.0 + 1e-9).contains(&value(row, &y)));
        if fits && best.as_ref().is_none_or(|best| cost(&y) < cost(best)) {
            best = Some(y);
        }
    }
    best
}

/// Gauss with the largest pivots; `None` where the rows depend on each other.
fn eliminate(system: &mut [Vec<f64>]) -> Option<Vec<f64>> {
    let count = system.len();
    for at in 0..count {
        let pivot = (at..count).max_by(|&a, &b| system[a][at].abs().total_cmp(&system[b][at].abs()))?;
        system.swap(at, pivot);
        if system[at][at].abs() < 1e-6 {
            return None;
        }
        for other in (0..count).filter(|&other| other != at) {
            let factor = system[other][at] / system[at][at];
            let row = system[at].clone();
            system[other].iter_mut().zip(row).for_each(|(entry, by)| *entry -= factor * by);
        }
    }
    Some((0..count).map(|at| system[at][count] / system[at][at]).collect())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 256,
        rng_seed: RngSeed::Fixed(21),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// It ends where a trial of every choice of binding rows does.
    #[test]
    fn the_nearest_point_is_found(
        wanted in prop::collection::vec(-2.0f64..3.0, 4),
        weights in prop::collection::vec(0.1f64..4.0, 4),
        rows in prop::collection::vec((prop::collection::vec(-1.0f64..1.0, 4), 0.3f64..0.7), 1..6),
    ) {
        let expected = by_trial(&wanted, &weights, &rows).expect("zero always fits");
        let outcome = solve(&wanted, &weights, &rows).expect("few rows bind");
        for (value, expected) in outcome.values.iter().zip(&expected) {
            prop_assert!((value - expected).abs() < 1e-5, "{:?} {expected:?}", outcome.values);
        }
        prop_assert!(outcome.dual_residual < 1e-9 && outcome.complementarity < 1e-6);
    }
}

fn unit(at: usize, count: usize) -> Vec<f64> {
    (0..count).map(|k| f64::from(k == at)).collect()
}

#[test]
fn what_fits_takes_no_step() {
    let outcome = solve(&[0.25, 0.75], &[1.0, 1.0], &[(vec![1.0, -1.0], 0.5)]).unwrap();
    assert_eq!((outcome.values, outcome.step_count), (vec![0.25, 0.75], 0));
}

/// The same row thrice, and one that is made of two others: only what is independent binds.
#[test]
fn rows_that_depend_on_others_are_kept_too() {
    let row = (vec![1.0, 0.0], 0.0);
    let rows = [row.clone(), row.clone(), (vec![0.0, 1.0], 0.0), (vec![0.5, 0.5], 0.0), row];
    let outcome = solve(&[-1.0, -2.0], &[1.0, 3.0], &rows).unwrap();
    assert!(outcome.values.iter().all(|value| value.abs() < 1e-6), "{:?}", outcome.values);
}

/// A row that came in first and has to go again: where both bind, its multiplier would pull.
#[test]
fn a_row_that_would_pull_is_let_go() {
    let rows = [(vec![1.0, 0.0], 0.0), (vec![0.6, 0.8], 0.0)];
    let wanted = [-0.5, -4.0];
    let outcome = solve(&wanted, &[1.0; 2], &rows).unwrap();
    let expected = by_trial(&wanted, &[1.0; 2], &rows).unwrap();
    assert!(expected[0] > 0.1, "the first row is to be free: {expected:?}");
    assert!((outcome.values[0] - expected[0]).abs() < 1e-6 && (outcome.values[1] - expected[1]).abs() < 1e-6);
}

#[test]
fn contradicting_rows_are_left_to_others() {
    let rows = [(vec![1.0], 0.0), (vec![1.0], 5.0)];
    assert!(solve(&[0.5], &[1.0], &rows).is_none());
}

#[test]
fn what_is_not_a_number_is_left_to_others() {
    let rows = [(vec![1.0, 1.0], 0.0)];
    assert!(solve(&[f64::NAN, 0.5], &[1.0; 2], &rows).is_none());
}

/// As many as may bind are solved, one more is not, and far more are not even tried.
#[test]
fn many_binding_rows_are_left_to_others() {
    let run = |count: usize| {
        let rows: Vec<Row> = (0..count).map(|at| (unit(at, count), 0.0)).collect();
        solve(&vec![-1.0; count], &vec![1.0; count], &rows)
    };
    let outcome = run(ACTIVE_MAX).unwrap();
    assert_eq!(outcome.step_count, ACTIVE_MAX as u64);
    assert!(outcome.values.iter().all(|value| value.abs() < 1e-6));
    assert!(run(ACTIVE_MAX + 1).is_none() && run(3 * ACTIVE_MAX).is_none());
}
