use glam::{DVec4, Vec3, Vec4};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::mip::tests::{Case, PLAIN, Random, canvas, sheet};
use crate::mip::{Beyond, MipFilter, Rungs};

const AREA: Rungs = Rungs { filter: MipFilter::Area, ..PLAIN };
const AREA_HEAT: Rungs = Rungs { beyond: Beyond::Heat, ..AREA };

/// Two triangles over one edge, the second three times as large.
fn uneven() -> Case {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(2.0, 2.0, 0.0)];
    Case::new(canvas(&positions, &[&[0, 1, 2], &[3, 2, 1]]), vec![2, 2])
}

#[test]
fn an_edge_sample_takes_from_each_side_by_its_area() {
    let case = uneven();
    let topology = case.topology();
    let (fine, coarse) = (case.level(&topology, 0), case.level(&topology, 1));
    let mut values = vec![Vec4::ZERO; fine.sample_count()];
    values[fine.face_range(1)].fill(Vec4::ONE);
    let middle = coarse.edge_tap(0, 1, 1).samples[0] as usize;
    for (rungs, expected) in [(PLAIN, 1.0 / 4.0), (AREA, 3.0 / 8.0)] {
        let found = case.levels(&values, rungs, 1)[1][middle].x;
        assert!((found - expected).abs() < 1e-6, "{rungs:?}: {found}");
    }
}

/// However fine a face is, all of its samples together count for its area under the hat.
#[test]
fn a_finer_face_counts_for_its_area() {
    let mut case = uneven();
    case.resolutions.faces = vec![[3; 2], [2; 2]];
    let topology = case.topology();
    let (fine, coarse) = (case.level(&topology, 0), case.level(&topology, 1));
    let middle = coarse.edge_tap(1, 1, 1).samples[0] as usize;
    let mut values = vec![Vec4::ZERO; fine.sample_count()];
    values[fine.face_range(0)].fill(Vec4::ONE);
    let found = case.levels(&values, AREA, 1)[1][middle].x;
    // Areas of face 0 (1/2) and 1 (3/2) in cells of 1/8 and 1/4 of their sides. The edge's own samples have
    // half a cell's height of each face; the hat's other half of height lies inside the faces.
    let (inner, outer) = (1.0 / 64.0, 3.0 / 16.0);
    let within = inner * (0.5 * (1.0 + 0.5 + 0.5)) * 2.0;
    let expected = within / (2.0 * within + 2.0 * outer);
    assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
}

/// The sum of area times color, and of area.
fn integral(case: &Case, level: usize, samples: &[Vec4]) -> (DVec4, f64) {
    let areas = case.areas(level);
    let sum = areas.iter().zip(samples).map(|(&area, value)| value.as_dvec4() * f64::from(area)).sum();
    (sum, areas.iter().map(|&area| f64::from(area)).sum())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: RngSeed::Fixed(31), failure_persistence: None, ..ProptestConfig::default() })]

    /// Weights by area are those of the coarse basis functions, which sum to 1; heat flow only moves color about.
    #[test]
    fn the_sum_of_area_times_color_stays(seed in any::<u64>(), exponent_end in 1usize..=6) {
        let mut random = Random(seed);
        let case = sheet(&mut random, 4, 0.3, exponent_end);
        let levels = case.levels(&random.colors(case.sample_count()), AREA_HEAT, 9);
        let (first, area) = integral(&case, 0, &levels[0]);
        for (level, samples) in levels.iter().enumerate() {
            let (sum, coarse_area) = integral(&case, level, samples);
            prop_assert!((coarse_area / area - 1.0).abs() < 1e-5);
            let drift = ((sum - first) / area).abs().max_element();
            prop_assert!(drift < 2e-6 * (level + 1) as f64, "level {level} drifts by {drift}");
        }
    }
}
