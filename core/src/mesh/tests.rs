use glam::Vec3;

use super::{CanvasMesh, Polygons, build, surface_point};

fn canvas(positions: &[Vec3], faces: &[&[u32]]) -> CanvasMesh {
    let mut iterator = faces.iter().map(|face| {
        let mut corners = [0; 4];
        corners[..face.len()].copy_from_slice(face);
        (corners, face.len() as u8)
    });
    build([Polygons { mesh: 0, primitive: 0, positions, faces: &mut iterator }])
}

#[test]
fn welds_by_exact_position_and_finds_both_sides() {
    let positions = [
        Vec3::ZERO,
        Vec3::X,
        Vec3::Y,
        Vec3::new(1.0, -0.0, 0.0), // the same place as vertex 1
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::Y,
    ];
    let canvas = canvas(&positions, &[&[0, 1, 2], &[3, 4, 5]]);
    assert_eq!(canvas.positions.len(), 4);
    assert_eq!(canvas.edges.len(), 5);
    let shared: Vec<_> = canvas.edges.iter().filter(|edge| canvas.sides(edge).len() == 2).collect();
    assert_eq!(shared.len(), 1);
    for &side in canvas.sides(shared[0]) {
        for end in 0..2 {
            let corner = canvas.corner_at_end(side, end);
            assert_eq!(canvas.faces[side.face as usize].vertices[corner], shared[0].vertices[end]);
        }
    }
}

#[test]
fn edges_without_length_join_nothing() {
    let positions = [Vec3::ZERO, Vec3::X];
    let canvas = canvas(&positions, &[&[0, 0, 1], &[0, 0, 1]]);
    let degenerate = canvas.edges.iter().filter(|edge| edge.vertices[0] == edge.vertices[1]);
    assert!(degenerate.clone().all(|edge| canvas.sides(edge).len() == 1));
    assert_eq!(degenerate.count(), 2);
}

#[test]
fn a_quad_is_drawn_over_its_first_diagonal() {
    let at = |s, t| {
        let (corners, weights) = surface_point(4, s, t);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut place = [0.0; 2];
        for (corner, weight) in corners.into_iter().zip(weights.to_array()) {
            place[0] += square[corner][0] * weight;
            place[1] += square[corner][1] * weight;
        }
        place
    };
    for (s, t) in [(0.25, 0.75), (0.75, 0.25), (0.5, 0.5), (1.0, 0.0), (0.0, 1.0)] {
        assert_eq!(at(s, t), [s, t]);
    }
}
