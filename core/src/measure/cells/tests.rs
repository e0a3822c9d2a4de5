use super::*;
use crate::asset::Slot;
use crate::measure::hand_made::{finished, image, square, surface_of};

fn graph() -> Graph {
    let asset = square(Slot::Occlusion, image([4, 4], |_, _| [0; 3]));
    let conversion = finished(Slot::Occlusion, |_| [0; 3]);
    Graph::new(&surface_of(&asset, &conversion))
}

#[test]
fn innermost_cells_stand_in_the_order_of_their_corners() {
    let graph = graph();
    let cells = Cells::new(&graph, &[64.0, 1.0]);
    let depths: Vec<u32> = cells.cuts().iter().map(|cut| cut.depth).collect();
    assert!(depths == [3, 0] || depths == [0, 3], "{depths:?}");
    let mut centers = Vec::new();
    for cut in cells.cuts() {
        let [a, b, c] = graph.corners[cut.triangle as usize];
        centers.extend(corners(cut.depth).iter().map(|[p, q, r]| {
            let at = (*p + *q + *r).as_dvec3() / 3.0;
            a * at.x + b * at.y + c * at.z
        }));
    }
    let held = cells.gathered(centers.clone(), |sum, other| *sum += *other);
    // All of them are in the outermost.
    assert!(held[0].distance(centers.iter().sum()) < 1e-9);
    let innermost = cells.cells.iter().enumerate().filter(|(at, cell)| cell.next as usize == at + 1);
    let found: Vec<DVec3> = innermost.map(|(_, cell)| cell.center).collect();
    assert_eq!(found.len(), 65);
    assert!(found.iter().zip(&centers).all(|(a, b)| a.distance(*b) < 1e-6));
}

#[test]
fn a_sum_over_cells_is_the_truncated_gaussian() {
    let graph = graph();
    let cells = Cells::new(&graph, &[4096.0; 2]);
    let shares = cells.cuts().iter().flat_map(|cut| std::iter::repeat_n(cut.share, cut.cell_count()));
    let shares = cells.gathered(shares.collect(), |sum, other| *sum += *other);
    assert!((shares[0] - 1.0).abs() < 1e-4);
    let gauss = Gauss { center: DVec3::new(0.5, 0.5, 0.0), deviation: 0.1 };
    let (mut weight, mut variance, mut count) = (0.0, 0.0, 0);
    for triangle in 0..2 {
        cells.of_triangle(triangle, &gauss, |cell, value| {
            let weighted = f64::from(shares[cell] * value);
            weight += weighted;
            variance += weighted * (cells.cells[cell].center.x - 0.5).powi(2);
            count += 1;
        });
    }
    // The square's area is 1.
    let expected = std::f64::consts::TAU * 0.01 * (1.0 - (-4.5f64).exp());
    assert!((weight / expected - 1.0).abs() < 0.03, "{weight} {expected}");
    assert!((variance / weight / 0.01 / VARIANCE_LEFT - 1.0).abs() < 0.05, "{}", variance / weight);
    // Far fewer than all, and none wider than it may be.
    assert!((50..1000).contains(&count), "{count}");
}

#[test]
fn the_far_side_and_other_components_are_left_out() {
    let graph = graph();
    let cells = Cells::new(&graph, &[64.0; 2]);
    let shares = cells.cuts().iter().flat_map(|cut| std::iter::repeat_n(cut.share, cut.cell_count()));
    let shares = cells.gathered(shares.collect(), |sum, other| *sum += *other);
    let sum = |normal: Vec3, by_triangle: &mut [u32], triangle: usize| {
        let components = cells.components(by_triangle);
        let admitted = Admitted { normal, component: by_triangle[triangle], components: &components };
        let gauss = Gauss { center: DVec3::ZERO, deviation: 1e6 };
        let mut sum = 0.0;
        cells.of_all(&gauss, &admitted, |cell, value| sum += shares[cell] * value);
        sum
    };
    assert!((sum(Vec3::Z, &mut [1, 1], 0) - 1.0).abs() < 1e-4);
    assert_eq!(sum(Vec3::NEG_Z, &mut [1, 1], 0), 0.0);
    assert!((sum(Vec3::Z, &mut [0, 1], 1) - 0.5).abs() < 1e-4);
}
