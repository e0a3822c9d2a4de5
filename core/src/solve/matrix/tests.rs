use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::Matrix;
use crate::solve::island::Island;

/// An island of cells, each with this many rows of weights made from `seed`.
fn island(variable_count: usize, cells: &[Vec<u32>], rows: usize, seed: u64) -> Island {
    let mut island = Island::new((0..variable_count as u32).collect(), false);
    let mut numbers = numbers(seed);
    for cell in cells {
        for _ in 0..rows {
            let terms: Vec<(u32, f64)> = cell.iter().map(|&v| (v, numbers.next().unwrap() - 0.5)).collect();
            island.push(terms.into_iter(), 0.5, [0.0, 1.0]);
        }
    }
    island
}

/// In [0, 1).
fn numbers(seed: u64) -> impl Iterator<Item = f64> {
    let mut state = seed;
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    })
}

/// Solves for a known answer; the product is formed row by row, without any of the matrix's own code.
fn check(island: &Island, seed: u64) {
    let count = island.variables().len();
    let mut numbers = numbers(seed);
    let mut some = |count: usize| -> Vec<f64> { numbers.by_ref().take(count).map(|n| n + 0.1).collect() };
    let (a, d, answer) = (some(count), some(island.row_count()), some(count));
    let mut right: Vec<f64> = a.iter().zip(&answer).map(|(a, x)| a * x).collect();
    for (row, d) in d.iter().enumerate() {
        let value: f64 = island.terms(row).map(|(v, weight)| weight * answer[v as usize]).sum();
        island.terms(row).for_each(|(v, weight)| right[v as usize] += d * value * weight);
    }
    let mut matrix = Matrix::new(island).unwrap();
    // The second factor must not see the first.
    for _ in 0..2 {
        assert!(matrix.factor(island, &a, &d));
        let mut x = right.clone();
        matrix.solve(&mut x);
        for (x, answer) in x.iter().zip(&answer) {
            assert!((x - answer).abs() < 1e-9, "{x} instead of {answer}");
        }
    }
}

fn grid(side: u32) -> Vec<Vec<u32>> {
    let corners =
        |x: u32, y: u32| vec![y * side + x, y * side + x + 1, (y + 1) * side + x, (y + 1) * side + x + 1];
    (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| (x, y))).map(|(x, y)| corners(x, y)).collect()
}

#[test]
fn grids_are_solved() {
    for side in [2, 5, 8, 17, 40] {
        check(&island((side * side) as usize, &grid(side), 4, 1), 2);
    }
}

/// A vertex that a thousand faces share, and variables that share no row with any other.
#[test]
fn fans_and_lone_variables_are_solved() {
    let fan: Vec<Vec<u32>> = (1..1000).map(|at| vec![0, at, at + 1]).collect();
    check(&island(1100, &fan, 4, 3), 4);
    check(&island(40, &[], 0, 3), 4);
    check(&island(0, &[], 0, 3), 4);
}

#[test]
fn a_matrix_without_a_factor_is_refused() {
    let island = island(100, &grid(10), 1, 5);
    let mut matrix = Matrix::new(&island).unwrap();
    let d = vec![1.0; island.row_count()];
    assert!(!matrix.factor(&island, &[-1e3; 100], &d));
    assert!(!matrix.factor(&island, &[f64::NAN; 100], &d));
    assert!(matrix.factor(&island, &[1.0; 100], &d));
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 64,
        rng_seed: RngSeed::Fixed(22),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Cells of any number of variables, thrown about.
    #[test]
    fn any_cells_are_solved(
        cells in prop::collection::vec(prop::collection::btree_set(0u32..120, 1..14), 1..90),
        rows in 1usize..4,
        seed in any::<u64>(),
    ) {
        let cells: Vec<Vec<u32>> = cells.into_iter().map(|cell| cell.into_iter().collect()).collect();
        let island = island(120, &cells, rows, seed);
        check(&island, !seed);
        // The products with all rows of a cell at once are those row by row.
        let y: Vec<f64> = numbers(seed).take(120).collect();
        let mut all = Vec::new();
        island.apply(&y, &mut all);
        let mut transposed = vec![0.0; 120];
        island.add_transposed(&all, &mut transposed);
        for (row, value) in all.iter().enumerate() {
            prop_assert!((value - island.row_of(row, &y)).abs() < 1e-12);
            island.terms(row).for_each(|(v, weight)| transposed[v as usize] -= weight * value);
        }
        prop_assert!(transposed.iter().all(|rest| rest.abs() < 1e-9));
    }
}
