use super::*;
use crate::asset::{Asset, Slot};
use crate::measure::hand_made::{finished, image, square, surface_of};

fn model() -> Asset {
    square(Slot::Occlusion, image([4, 4], |_, _| [0; 3]))
}

/// Weight, mean and variance along x and y of what is gathered around the square's middle.
fn moments(deviation: f64) -> (f64, DVec3, DVec3, usize) {
    let (asset, conversion) = (model(), finished(Slot::Occlusion, |_| [0; 3]));
    let surface = surface_of(&asset, &conversion);
    let graph = Graph::new(&surface);
    let cells = cells(&surface, &graph, 0);
    // On the diagonal's middle, so that both triangles have a part in it.
    let point = SurfacePoint { part: 0, triangle: 0, at: Vec3::new(0.0, 0.5, 0.5) };
    let gauss = Gauss { center: graph.position(&point), deviation };
    let around = around(&graph, &cells, &point, gauss, Some(&mut vec![0; 2]));
    let (mut weight, mut sum, mut squares) = (0.0, DVec3::ZERO, DVec3::ZERO);
    let samples = around.refined(&graph, &[true; 2]);
    for sample in &samples {
        let triangle = around.triangles[sample.triangle as usize] as usize;
        let [a, b, c] = graph.corners[triangle];
        let at = sample.at.as_dvec3();
        let offset = a * at.x + b * at.y + c * at.z - graph.position(&point);
        weight += f64::from(sample.weight);
        sum += offset * f64::from(sample.weight);
        squares += offset * offset * f64::from(sample.weight);
    }
    (weight, sum / weight, squares / weight, samples.len())
}

#[test]
fn points_on_a_plane_are_the_truncated_gaussian() {
    // Far smaller than the square, so that all of it lies inside.
    for deviation in [0.01, 0.05, 0.1] {
        let (weight, mean, variance, count) = moments(deviation);
        assert!((weight / (TAU * (1.0 - (-4.5f64).exp())) - 1.0).abs() < 0.01, "{deviation}: {weight}");
        assert!(mean.length() < 0.01 * deviation, "{deviation}: {mean}");
        for along in [variance.x, variance.y] {
            let left = along / deviation.powi(2);
            assert!((left / VARIANCE_LEFT - 1.0).abs() < 0.02, "{deviation}: {left}");
        }
        assert!(count >= MANY.0.len() / 2);
    }
}

#[test]
fn a_reach_over_everything_is_the_plain_mean() {
    let (weight, mean, variance, _) = moments(100.0);
    assert!((weight - 1.0 / 1e4).abs() < 1e-6, "{weight}");
    assert!(mean.length() < 0.4 && variance.x < 0.5, "{mean} {variance}");
}

#[test]
fn wide_averages_are_of_cells_and_narrow_ones_of_points() {
    let (asset, conversion) = (model(), finished(Slot::Occlusion, |_| [0; 3]));
    let surface = surface_of(&asset, &conversion);
    let graph = Graph::new(&surface);
    let cells = cells(&surface, &graph, 0);
    // Half a square in 2048 or 4096 cells.
    assert!((0.005..0.03).contains(&cells.radius(0)), "{}", cells.radius(0));
    let point = SurfacePoint { part: 0, triangle: 0, at: Vec3::splat(1.0 / 3.0) };
    let has_points = |deviation: f64| {
        let gauss = Gauss { center: graph.position(&point), deviation };
        let around = around(&graph, &cells, &point, gauss, Some(&mut vec![0; 2]));
        assert_eq!(around.triangles[0], 0);
        !around.samples.is_empty()
    };
    assert!(!has_points(cells.radius(0) / CELLS_WITHIN * 1.5));
    // Where cells are too coarse there are points, and where triangles are not walked all cells take part.
    let coarse = Cells::new(&graph, &[1.0; 2]);
    let gauss = Gauss { center: graph.position(&point), deviation: 0.2 };
    assert!(!super::around(&graph, &coarse, &point, gauss, Some(&mut vec![0; 2])).samples.is_empty());
    let unwalked = super::around(&graph, &coarse, &point, gauss, None);
    assert!(unwalked.triangles.is_empty() && unwalked.samples.is_empty());
}

#[test]
fn the_variance_is_that_of_repeated_halving() {
    let (asset, conversion) = (model(), finished(Slot::Occlusion, |_| [0; 3]));
    let surface = surface_of(&asset, &conversion);
    let graph = Graph::new(&surface);
    let point = SurfacePoint { part: 0, triangle: 0, at: Vec3::splat(1.0 / 3.0) };
    // Four segments to the square's side.
    let spacing_squared = texel_area(&surface, &graph, &point).unwrap();
    assert!((spacing_squared - 1.0 / 16.0).abs() < 1e-9);
    let mut steps = 0.0;
    for level in 1..6 {
        // 1-2-1 over the texels of the level before: a quarter on each side, one spacing away.
        steps += 2.0 * 0.25 * spacing_squared * 4f64.powi(level as i32 - 1);
        assert!((steps / variance(spacing_squared, level) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_sequence_covers_the_triangle() {
    let count = 64;
    let (mut second, mut third) = (0.0, 0.0);
    for (x, y) in (0..count).map(folded) {
        assert!(x >= 0.0 && y >= 0.0 && x + y <= 1.0);
        second += x / count as f64;
        third += y / count as f64;
    }
    assert!((second - 1.0 / 3.0).abs() < 0.02 && (third - 1.0 / 3.0).abs() < 0.02, "{second} {third}");
}
