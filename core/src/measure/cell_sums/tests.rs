use super::*;
use crate::asset::Slot;
use crate::measure::averages;
use crate::measure::hand_made::{finished, image, square, surface_of};
use crate::measure::origin::Origin;

#[test]
fn cells_hold_the_mean_of_the_source_by_area() {
    // A ramp along u: the left triangle spans u from 0.1 to 0.4, the right one from 0.6 to 0.9.
    let asset = square(Slot::Occlusion, image([256, 4], |x, _| [x as u8; 3]));
    let conversion = finished(Slot::Occlusion, |_| [0; 3]);
    let surface = surface_of(&asset, &conversion);
    let graph = Graph::new(&surface);
    let cells = averages::cells(&surface, &graph, 0);
    let origin = Origin::new(&asset, &surface, Slot::Occlusion, false).unwrap().unwrap();
    let source = Averaged { graph: &graph, surface: &surface, original: Original::Image(&origin) };
    let in_cells = source.in_cells(&cells);
    let [a, b] = in_cells[0];
    assert!((a.weight - 1.0).abs() < 1e-3 && (b.weight - 1.0).abs() < 1e-3);
    // The triangles' centers, in texels, are at 0.2 and 0.8 of the width; texel x has its center half a texel on.
    let wanted = (0.5 * (0.2 + 0.8) * 256.0 - 0.5) / 255.0;
    for half in [a, b] {
        assert!((half.mean().x - wanted).abs() < 2e-4, "{} {wanted}", half.mean());
    }
    assert_ne!(a.mean(), b.mean());
}

#[test]
fn points_fill_the_triangle() {
    let count = 4096;
    let (mut x, mut y) = (12_345u32 << 16, 54_321u32 << 16);
    let (mut second, mut third) = (0.0, 0.0);
    for _ in 0..count {
        let (s, t) = folded(x, y);
        assert!(s >= 0.0 && t >= 0.0 && s + t <= 1.0);
        (second, third) = (second + s / count as f32, third + t / count as f32);
        (x, y) = (x.wrapping_add(STEP_X), y.wrapping_add(STEP_Y));
    }
    assert!((second - 1.0 / 3.0).abs() < 0.01 && (third - 1.0 / 3.0).abs() < 0.01, "{second} {third}");
}
