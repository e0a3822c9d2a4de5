use glam::Vec3;

use super::{CanvasMesh, Polygons, build, drawn_corners, merge, surface_point};

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
        let (triangle, weights) = surface_point(4, s, t);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut place = [0.0; 2];
        for (corner, weight) in drawn_corners(triangle).into_iter().zip(weights.to_array()) {
            place[0] += square[corner][0] * weight;
            place[1] += square[corner][1] * weight;
        }
        place
    };
    for (s, t) in [(0.25, 0.75), (0.75, 0.25), (0.5, 0.5), (1.0, 0.0), (0.0, 1.0)] {
        assert_eq!(at(s, t), [s, t]);
    }
}

/// Whichever corners two triangles begin with, and however they wind: their quad has the same corners in space as they
/// have, knows which triangle's corner each is, and its edges are theirs but for the shared one.
#[test]
fn a_pair_is_a_quad_over_its_shared_edge() {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.5), Vec3::new(3.0, 0.0, 0.0)];
    let turned = |[a, b, c]: [u32; 3], turn: usize| {
        [[a, b, c], [b, c, a], [c, a, b], [c, b, a], [b, a, c], [a, c, b]][turn]
    };
    for (turn_a, turn_b) in (0..6).flat_map(|a| (0..6).map(move |b| (a, b))) {
        let (a, b) = (turned([0, 1, 2], turn_a), turned([1, 3, 2], turn_b));
        let canvas = canvas(&positions, &[&a, &[1, 4, 3], &b]);
        let merged = merge(&canvas, &[Some(2), None, Some(0)]);
        assert_eq!(merged.old_faces, [(0, Some(2)), (1, None)]);
        let quad = &merged.canvas.faces[0];
        assert!(quad.is_pair() && quad.count == 4);
        for (corners, drawn) in quad.drawn_corners().iter().zip(&quad.drawn) {
            let face = &canvas.faces[drawn.face as usize];
            for (corner, own) in corners.iter().zip(drawn.corners) {
                assert_eq!(quad.vertices[*corner], face.vertices[usize::from(own)]);
            }
        }
        assert_eq!([quad.drawn[0].face, quad.drawn[1].face], [0, 2]);
        for (new, &old) in merged.canvas.edges.iter().zip(&merged.old_edges) {
            assert_eq!(new.vertices, canvas.edges[old as usize].vertices);
        }
        assert_eq!(merged.canvas.edges.len(), canvas.edges.len() - 1);
        let area: f32 = merged.canvas.faces.iter().map(|face| face.area).sum();
        assert!((area - canvas.faces.iter().map(|face| face.area).sum::<f32>()).abs() < 1e-6);
    }
}
