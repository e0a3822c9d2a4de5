use glam::{Vec3, Vec4};

use super::{
    ChannelTopology, Cuts, FaceGrid, LEVEL_MAX, LevelNumbering, Resolutions, SampleAreas, level_count,
};
use crate::mesh::{CanvasMesh, Polygons, build};

fn two_triangles_and_a_quad() -> CanvasMesh {
    let positions = [
        Vec3::ZERO,
        Vec3::X,
        Vec3::Y,
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(0.0, 2.0, 0.0),
        Vec3::new(1.0, 2.0, 0.0),
    ];
    let faces = [([0, 1, 2, 0], 3), ([1, 3, 2, 0], 3), ([2, 3, 5, 4], 4)];
    build([Polygons { mesh: 0, primitive: 0, positions: &positions, faces: &mut faces.into_iter() }])
}

/// Every sample has exactly one number, every face sees its grid, and both sides see the same edge.
#[test]
fn numbers_are_dense_and_shared() {
    let canvas = two_triangles_and_a_quad();
    let resolutions = Resolutions { faces: vec![[2, 2], [3, 3], [1, 3]] };
    let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
    assert_eq!(topology.fan_count(), 6);
    for level in 0..5 {
        let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, level);
        let mut seen = vec![false; numbering.sample_count()];
        for face in 0..canvas.faces.len() {
            let shape = numbering.shape(face);
            for j in 0..=shape.segments[1] {
                for i in 0..shape.point_count(j) {
                    for sample in numbering.tap(face, i, j).samples {
                        seen[sample as usize] = true;
                    }
                }
            }
        }
        assert!(seen.into_iter().all(|s| s), "level {level} has samples that no face sees");
    }
}

/// Each face's area spread over its grid points, and from points of coarser edges over both samples.
#[test]
fn areas_are_what_faces_spread_over_their_samples() {
    let canvas = two_triangles_and_a_quad();
    let resolutions = Resolutions { faces: vec![[2, 2], [4, 4], [3, 1]] };
    let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
    for level in 0..5 {
        let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, level);
        let mut expected = vec![0.0; numbering.sample_count()];
        for (face, canvas_face) in canvas.faces.iter().enumerate() {
            let (shape, is_triangle) = (numbering.shape(face), canvas_face.is_triangle());
            let [n, m] = shape.segments;
            for (i, j) in (0..=m).flat_map(|j| (0..=n).map(move |i| (i, j))) {
                let corners = [(0, 0), (n, 0), (n, m), (0, m)];
                let share = match (is_triangle, corners.contains(&(i, j))) {
                    (true, _) if i + j > n => continue,
                    (true, true) => 1.0 / 6.0,
                    (true, false) if i == 0 || j == 0 || i + j == n => 0.5,
                    (false, true) => 0.25,
                    (false, false) if i == 0 || j == 0 || i == n || j == m => 0.5,
                    _ => 1.0,
                };
                let tap = numbering.tap(face, i, j);
                let area = share * canvas_face.area / shape.square_count();
                expected[tap.samples[0] as usize] += area * (1.0 - tap.second);
                expected[tap.samples[1] as usize] += area * tap.second;
            }
        }
        let areas = SampleAreas::new(&numbering);
        for (sample, expected) in expected.into_iter().enumerate() {
            let found = areas.of(&numbering, sample);
            assert!(
                (found - expected).abs() < 1e-6,
                "level {level}, sample {sample}: {found}, not {expected}"
            );
        }
    }
}

#[test]
fn a_finer_face_interpolates_the_coarser_edge() {
    let canvas = two_triangles_and_a_quad();
    let resolutions = Resolutions::uniform(vec![1, 3, 1]);
    let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
    let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
    // Edge 2 of face 1 and edge 1 of face 0 are the same edge, between vertices 1 and 2.
    let values: Vec<Vec4> = (0..numbering.sample_count()).map(|k| Vec4::splat((k * k) as f32)).collect();
    for along in 0..=8 {
        let fine = numbering.edge_tap(1, 2, along).value(&values);
        let coarse_at = (8 - along) as f32 / 4.0;
        let low = numbering.edge_tap(0, 1, coarse_at.floor() as u32).value(&values);
        let high = numbering.edge_tap(0, 1, (coarse_at.floor() as u32 + 1).min(2)).value(&values);
        assert!((fine - low.lerp(high, coarse_at.fract())).abs().max_element() < 1e-4);
    }
}

#[test]
fn a_cut_parts_the_strip_and_what_only_it_connects() {
    let canvas = two_triangles_and_a_quad();
    let resolutions = Resolutions::uniform(vec![1, 1, 1]);
    let mut cuts = Cuts::none(&canvas);
    let shared = canvas.edges.iter().position(|edge| edge.vertices == [1, 2]).unwrap();
    cuts.edges[shared] = true;
    let topology = ChannelTopology::new(&canvas, &resolutions, &cuts);
    // Vertices 1 and 2 each fall in two: face 0 against the others.
    assert_eq!(topology.fan_count(), 8);
    assert_ne!(topology.strip_of[0][1], topology.strip_of[1][2]);
    assert_eq!(topology.strip_of[1][1], topology.strip_of[2][0]);
}

#[test]
fn filling_a_grid_agrees_with_its_taps() {
    let canvas = two_triangles_and_a_quad();
    let resolutions = Resolutions { faces: vec![[2, 2], [3, 3], [1, 4]] };
    let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
    let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
    let values: Vec<Vec4> = (0..numbering.sample_count()).map(|k| Vec4::splat(k as f32)).collect();
    let mut grid = FaceGrid::default();
    for (face, canvas_face) in canvas.faces.iter().enumerate() {
        numbering.fill(face, &values, &mut grid);
        for j in 0..=grid.shape.segments[1] {
            for i in 0..grid.shape.point_count(j) {
                assert_eq!(grid.at(i, j), numbering.tap(face, i, j).value(&values));
            }
        }
        for edge in 0..canvas_face.count() {
            let (i, j) = grid.shape.edge_point(edge, 1);
            assert_eq!(grid.at(i, j), numbering.edge_tap(face, edge, 1).value(&values));
        }
    }
}

/// A square of `n * n` cells is one texel when `2^level` is its diagonal in cells; every face comes down to
/// vertex colors before; lengths enter as ratios.
#[test]
fn levels_go_on_to_where_everything_is_one_texel() {
    let square = |corner: Vec3| {
        let positions = [Vec3::ZERO, corner * Vec3::X, corner, corner * Vec3::Y];
        build([Polygons {
            mesh: 0,
            primitive: 0,
            positions: &positions,
            faces: &mut [([0, 1, 2, 3], 4)].into_iter(),
        }])
    };
    let count = |corner: Vec3, exponent| level_count(&square(corner), &Resolutions::uniform(vec![exponent]));
    for exponent in 0..=12 {
        // A diagonal of sqrt(2) 2^r cells is under one texel from level r + 1 on.
        assert_eq!(count(Vec3::ONE, exponent), usize::from(exponent) + 2);
        assert_eq!(count(Vec3::splat(1e-6), exponent), usize::from(exponent) + 2);
    }
    assert_eq!(count(Vec3::new(4096.0, 1.0, 0.0), 0), 6 + 2, "64 cells of a mean size in a row");
    assert_eq!(count(Vec3::new(1e18, 1e-6, 0.0), 3), LEVEL_MAX + 1);
    assert_eq!(count(Vec3::X, 3), 4, "no area: down to vertex colors");
    assert_eq!(level_count(&CanvasMesh::default(), &Resolutions::uniform(vec![])), 1);
}

/// Meshes have spaces of their own: that one lies far from another makes neither larger.
#[test]
fn each_mesh_is_measured_by_itself() {
    let triangle = |at: f32| [0.0, 1.0, 2.0].map(|k| Vec3::new(at + k % 2.0, (k / 2.0).floor(), 0.0));
    let [near, far] = [triangle(0.0), triangle(1e4)];
    let polygons = |meshes: [u32; 2]| {
        let mut faces = [[([0, 1, 2, 0], 3)].into_iter(), [([0, 1, 2, 0], 3)].into_iter()];
        let [first, second] = &mut faces;
        build([
            Polygons { mesh: meshes[0], primitive: 0, positions: &near, faces: first },
            Polygons { mesh: meshes[1], primitive: 1, positions: &far, faces: second },
        ])
    };
    let count = |meshes| level_count(&polygons(meshes), &Resolutions::uniform(vec![2, 2]));
    assert_eq!(count([0, 1]), 4);
    assert_eq!(count([0, 0]), 17);
}
