use super::*;
use crate::random::Random;

const EXPONENTS: [[u8; 2]; 8] = [[2, 0], [2, 1], [3, 0], [3, 1], [4, 1], [4, 2], [5, 3], [3, 3]];

fn random_triangle(random: &mut Random, exponents: [u8; 2]) -> Triangle {
    Triangle::new(Grid::new(exponents), |_| random.values())
}

/// The largest difference of the two sides of the diagonal.
fn jump(triangle: &Triangle) -> f64 {
    let points = (0..triangle.grid.n).flat_map(|i| (0..=8).map(move |k| (i, f64::from(k) / 8.0)));
    let jumps = points.map(|(i, t)| {
        let [own, other] = triangle.both_sides(i, t);
        (own - other).abs().max_element()
    });
    jumps.fold(0.0, f64::max)
}

#[test]
fn with_the_rows_both_sides_of_the_diagonal_show_the_same() {
    let mut random = Random::new(1);
    for exponents in EXPONENTS {
        let exact = random_triangle(&mut random, exponents).exact();
        assert!(jump(&exact) < 1e-12, "{exponents:?}: {}", jump(&exact));
    }
}

#[test]
fn without_them_they_differ_by_the_bound() {
    let mut random = Random::new(2);
    for exponents in EXPONENTS {
        for range in [None, Some([0.0, 1.0])] {
            let triangle = random_triangle(&mut random, exponents).paper(range);
            let grid = triangle.grid;
            let mut largest: f64 = 0.0;
            for (first, row) in Triangle::strips(grid) {
                let gradient = |b: usize| {
                    let [low, high] = [row, row + 1].map(|j| triangle.texels[grid.index(first + b, j)]);
                    high - low
                };
                for (b, k) in (0..grid.q()).flat_map(|b| (0..=8).map(move |k| (b, k))) {
                    let t = f64::from(k) / 8.0;
                    let [own, other] = triangle.both_sides(first + b, t);
                    let told = (gradient(b + 1) - gradient(b)) * (t * (1.0 - t) / grid.q() as f64);
                    assert!((own - other).abs_diff_eq(told, 1e-12), "{exponents:?} {b} {t}");
                    largest = largest.max(told.abs().max_element());
                }
            }
            // A triangle of one exponent has nothing but the texels of MCT equation 1.
            assert_eq!(largest > 0.01, grid.q() > 1, "{exponents:?}: {largest}");
        }
    }
}

#[test]
fn no_other_gradients_change_the_samples_less() {
    let mut random = Random::new(3);
    for exponents in EXPONENTS {
        let triangle = random_triangle(&mut random, exponents);
        let exact = triangle.clone().exact();
        let cost = |of: &Triangle| -> DVec3 {
            triangle.samples().zip(of.samples()).map(|(old, new)| (old - new) * (old - new)).sum()
        };
        let least = cost(&exact);
        for step in [-0.01, 0.01] {
            // One strip with another gradient, its rows met by the inner texels and the diagonal in any shares.
            for (first, row) in Triangle::strips(triangle.grid) {
                let q = triangle.grid.q();
                let mut other = exact.clone();
                for b in 0..q {
                    let more = DVec3::splat(step * (1.0 - b as f64 / q as f64));
                    let share = random.values();
                    other.diagonal[first + b] += more * share;
                    let inner = triangle.grid.index(first + b, row);
                    other.texels[inner] -= more * (1.0 - share);
                }
                let more = cost(&other) - least;
                // With one column in a strip no row binds, and nothing was changed.
                assert!(more.min_element() > 0.0, "{exponents:?}: {more}");
            }
        }
    }
}

#[test]
fn samples_that_meet_the_rows_stay_as_they_are() {
    // A plane, whose gradients are one everywhere.
    for exponents in EXPONENTS {
        let plane = Triangle::new(Grid::new(exponents), |[x, y]| DVec3::new(x, y, 0.3 * x + 0.5 * y));
        let exact = plane.clone().exact();
        assert!(plane.samples().zip(exact.samples()).all(|(a, b)| a.abs_diff_eq(b, 1e-12)), "{exponents:?}");
        assert!(jump(&plane.clone().paper(None)) < 1e-12);
        for [x, y] in [[0.1, 0.2], [0.6, 0.3], [0.01, 0.98]] {
            let at = [x * plane.grid.n as f64, y * plane.grid.m as f64];
            assert!(exact.shown(at).abs_diff_eq(DVec3::new(x, y, 0.3 * x + 0.5 * y), 1e-12), "{exponents:?}");
        }
    }
}

#[test]
fn the_papers_rule_meets_the_diagonal_at_its_samples_and_keeps_to_a_range() {
    let mut random = Random::new(4);
    for exponents in EXPONENTS {
        let samples = random_triangle(&mut random, exponents);
        let free = samples.clone().paper(None);
        assert_eq!(free.diagonal, samples.diagonal);
        let bound = samples.clone().paper(Some([0.0, 1.0]));
        for triangle in [&free, &bound] {
            for i in 0..triangle.grid.n {
                let [own, other] = triangle.both_sides(i, 0.0);
                assert!(own.abs_diff_eq(other, 1e-12), "{exponents:?}");
            }
        }
        for (first, row) in Triangle::strips(bound.grid) {
            for b in 1..bound.grid.q() {
                let outer = bound.texels[bound.grid.index(first + b, row + 1)];
                assert!(outer.min_element() >= 0.0 && outer.max_element() <= 1.0, "{exponents:?}: {outer}");
            }
        }
    }
}

/// Texels that one triangle reads, those that it weighs with nothing left out.
fn read(grid: Grid) -> Vec<[usize; 2]> {
    let own = (0..=grid.m).flat_map(|j| (0..=grid.n - grid.q() * j).map(move |i| [i, j]));
    let border =
        Triangle::strips(grid).flat_map(|(first, row)| (1..=grid.q()).map(move |b| [first + b, row + 1]));
    own.chain(border).collect()
}

#[test]
fn two_triangles_have_room_in_a_block() {
    for exponents in [[2, 0], [3, 1], [4, 1], [4, 2], [5, 3], [3, 3]] {
        let grid = Grid::new(exponents);
        let mut first = read(grid);
        first.sort_unstable();
        assert!(first.windows(2).all(|pair| pair[0] != pair[1]), "{exponents:?}");
        let meets = |[right, up]: [usize; 2]| {
            let turned = read(grid).into_iter().map(|[i, j]| [grid.n - i + right, grid.m - j + up]);
            turned.into_iter().any(|texel| first.binary_search(&texel).is_ok())
        };
        let [[along, _], [_, across]] = grid.shifts();
        assert!(!meets([along, 0]) && !meets([0, across]), "{exponents:?}");
        // One strip alone would do with less.
        let is_tight = meets([along - 1, 0]) && meets([0, across - 1]);
        assert_eq!(is_tight, grid.m > 1, "{exponents:?}");
    }
}
