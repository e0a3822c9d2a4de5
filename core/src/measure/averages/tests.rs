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
    let gather = Gather { graph: &graph, cloud: &[], density: 0.0 };
    // On the diagonal's middle, so that both triangles have a part in it.
    let point = SurfacePoint { part: 0, triangle: 0, at: Vec3::new(0.0, 0.5, 0.5) };
    let around = gather.around(&point, deviation, &mut [0; 2]);
    let (mut weight, mut sum, mut squares) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for sample in &around.samples {
        let triangle = around.triangles[sample.triangle as usize] as usize;
        let [a, b, c] = graph.corners[triangle];
        let at = sample.at.as_dvec3();
        let offset = a * at.x + b * at.y + c * at.z - graph.position(&point);
        weight += f64::from(sample.weight);
        sum += offset * f64::from(sample.weight);
        squares += offset * offset * f64::from(sample.weight);
    }
    (weight, sum / weight, squares / weight, around.samples.len())
}

#[test]
fn points_on_a_plane_are_the_truncated_gaussian() {
    // Far smaller than the square, so that all of it lies inside.
    for deviation in [0.01, 0.05, 0.1] {
        let (weight, mean, variance, count) = moments(deviation);
        assert!((weight / (TAU * (1.0 - (-4.5f64).exp())) - 1.0).abs() < 0.03, "{deviation}: {weight}");
        assert!(mean.length() < 0.04 * deviation, "{deviation}: {mean}");
        for along in [variance.x, variance.y] {
            let left = along / deviation.powi(2);
            assert!((left / VARIANCE_LEFT - 1.0).abs() < 0.05, "{deviation}: {left}");
        }
        assert!(count >= POINT_COUNT / 2);
    }
}

#[test]
fn a_reach_over_everything_is_the_plain_mean() {
    let (weight, mean, variance, _) = moments(100.0);
    assert!((weight - 1.0 / 1e4).abs() < 1e-6, "{weight}");
    assert!(mean.length() < 0.4 && variance.x < 0.5, "{mean} {variance}");
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

#[test]
fn a_cloud_stands_in_where_triangles_are_too_many() {
    let (asset, conversion) = (model(), finished(Slot::Occlusion, |_| [0; 3]));
    let surface = surface_of(&asset, &conversion);
    let graph = Graph::new(&surface);
    let cloud = scatter(&surface, 16_384);
    let gather = Gather { graph: &graph, cloud: &cloud, density: 16_384.0 };
    let gauss = Gauss { center: DVec3::new(0.5, 0.5, 0.0), deviation: 0.1 };
    let samples = gather.of_cloud(&gauss, 0);
    let mut marks = vec![0; 2];
    assert_eq!(graph.near(0, gauss.center, 0.3, 1, &mut marks), None);
    assert_eq!((graph.near(0, gauss.center, 0.3, 2, &mut marks), marks), (Some(vec![0, 1]), vec![0; 2]));
    // σ wants 1019 points for each unit of area; the least is 4096, every fourth.
    let within = 4096.0 * PI * 0.09;
    assert!((samples.len() as f64 / within - 1.0).abs() < 0.05, "{} {within}", samples.len());
    let share: f64 = samples.iter().map(|sample| f64::from(sample.weight)).sum::<f64>() / 4096.0;
    assert!((share / (TAU * 0.01) - 1.0).abs() < 0.05, "{share}");
}
