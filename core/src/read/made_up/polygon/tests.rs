//! Polygons of known area, turned every way in space.

use glam::{DQuat, DVec3};

use super::{Cut, cut};

fn in_plane(points: &[(f64, f64)]) -> Vec<DVec3> {
    points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect()
}

/// The triangles' areas along the polygon's normal; all positive where every one turns its way.
fn areas(points: &[DVec3], cut: &Cut, normal: DVec3) -> Vec<f64> {
    let area =
        |&[a, b, c]: &[usize; 3]| (points[b] - points[a]).cross(points[c] - points[a]).dot(normal) / 2.0;
    cut.triangles.iter().map(area).collect()
}

fn check(name: &str, flat: &[(f64, f64)], area: f64) {
    for turn in 0..12 {
        let rotation =
            DQuat::from_axis_angle(DVec3::new(1.0, f64::from(turn), 2.0).normalize(), f64::from(turn));
        let mut points: Vec<DVec3> =
            in_plane(flat).into_iter().map(|p| rotation * p + DVec3::splat(7.0)).collect();
        // Begin at another corner each time.
        points.rotate_left(turn as usize % flat.len());
        let cut = cut(&points);
        assert!(cut.simple, "{name}");
        assert_eq!(cut.triangles.len(), flat.len() - 2, "{name}");
        let areas = areas(&points, &cut, rotation * DVec3::Z);
        assert!(areas.iter().all(|area| *area > -1e-9), "{name}: {areas:?}");
        assert!((areas.iter().sum::<f64>() - area).abs() < 1e-9, "{name}: {areas:?}");
    }
}

#[test]
fn simple_polygons_are_covered_once() {
    check("pentagon", &[(0.0, 0.0), (2.0, 0.0), (3.0, 1.0), (1.0, 3.0), (-1.0, 1.0)], 7.0);
    check("L", &[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)], 3.0);
    check("arrow", &[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (3.0, 1.0), (0.5, 0.5)], 4.5);
    check("points on an edge", &[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (0.0, 4.0)], 6.0);
    check(
        "comb",
        &[
            (0.0, 0.0),
            (5.0, 0.0),
            (5.0, 3.0),
            (4.0, 3.0),
            (4.0, 1.0),
            (3.0, 1.0),
            (3.0, 3.0),
            (2.0, 3.0),
            (2.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ],
        11.0,
    );
}

#[test]
fn a_hole_cut_open_is_covered_once() {
    let keyhole = [
        (0.0, 0.0),
        (4.0, 0.0),
        (4.0, 4.0),
        (0.0, 4.0),
        (0.0, 0.0),
        (1.0, 1.0),
        (1.0, 3.0),
        (3.0, 3.0),
        (3.0, 1.0),
        (1.0, 1.0),
    ];
    let points = in_plane(&keyhole);
    let cut = cut(&points);
    assert_eq!(cut.triangles.len(), 8);
    let areas = areas(&points, &cut, DVec3::Z);
    assert!((areas.iter().map(|area| area.abs()).sum::<f64>() - 12.0).abs() < 1e-9, "{areas:?}");
}

#[test]
fn polygons_that_have_no_inside_end_in_a_fan() {
    let crossed = in_plane(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0), (1.0, 5.0)]);
    assert_eq!(cut(&crossed).triangles.len(), 3);
    let line = in_plane(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (4.0, 0.0)]);
    let cut = cut(&line);
    assert!(!cut.simple);
    assert_eq!(cut.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn every_corner_is_used_and_every_triangle_turns_the_polygon_s_way_when_it_is_bent() {
    // A saddle: its best-fit plane is z = 0.
    let points: Vec<DVec3> = (0..12)
        .map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 12.0;
            DVec3::new(angle.cos(), angle.sin(), 0.3 * (2.0 * angle).cos())
        })
        .collect();
    let cut = cut(&points);
    assert!(cut.simple);
    assert!((0..12).all(|corner| cut.triangles.iter().flatten().any(|&used| used == corner)));
    assert!(areas(&points, &cut, DVec3::Z).iter().all(|area| *area > 0.0));
}
