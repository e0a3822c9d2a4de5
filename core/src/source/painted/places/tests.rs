use glam::Vec3;

use super::*;
use crate::mesh::{Polygons, build, merge};

/// A quad, a triangle, and two triangles that are a quad, in a row along x.
fn canvas() -> CanvasMesh {
    let at = |x: u32, y: u32| Vec3::new(x as f32, y as f32, 0.0);
    let positions = [at(0, 0), at(1, 0), at(1, 1), at(0, 1), at(2, 0), at(2, 1)];
    let faces = [([0, 1, 2, 3], 4), ([4, 5, 2, 2], 3), ([1, 4, 2, 2], 3)];
    build([Polygons { mesh: 2, primitive: 1, positions: &positions, faces: &mut faces.into_iter() }])
}

#[test]
fn a_face_stands_where_its_corners_are() {
    let places = DrawnPlaces::new(&canvas());
    let quad = places.of([2, 1, 0], [0, 2, 3]).unwrap();
    assert_eq!(quad, DrawnPlace { face: 0, corners: [Vec2::ZERO, Vec2::ONE, Vec2::Y] });
    let triangle = places.of([2, 1, 1], [1, 2, 0]).unwrap();
    assert_eq!(triangle, DrawnPlace { face: 1, corners: [Vec2::X, Vec2::Y, Vec2::ZERO] });
    assert_eq!(triangle.at(Vec3::new(0.5, 0.25, 0.25)), Vec2::new(0.5, 0.25));
    for lost in [[2, 1, 3], [2, 0, 0], [0, 1, 0]] {
        assert_eq!(places.of(lost, [0, 1, 2]), None);
    }
    assert_eq!(places.of([2, 1, 1], [0, 1, 9]), None);
}

/// Both triangles of a pair stand in its quad, and agree where they meet.
#[test]
fn partners_stand_in_their_quad() {
    let merged = merge(&canvas(), &[None, Some(2), Some(1)]).canvas;
    let places = DrawnPlaces::new(&merged);
    let [one, other] = [1, 2].map(|face| places.of([2, 1, face], [0, 1, 2]).unwrap());
    assert_eq!((one.face, other.face), (1, 1));
    let quad = &merged.faces[1];
    assert_eq!(quad.count(), 4);
    // Vertices 4 5 2 and 1 4 2 of the primitive: the first and the last of one are the second and the third of the other.
    assert_eq!((one.corners[0], one.corners[2]), (other.corners[1], other.corners[2]));
    let all = [one.corners[0], one.corners[1], one.corners[2], other.corners[0]];
    let mut corners: Vec<_> = all.iter().map(|at| [at.x, at.y]).collect();
    corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(corners, [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]);
    for (place, number) in [(one, 1), (other, 2)] {
        let positions = [[4, 5, 2], [1, 4, 2]][number - 1];
        let at = |vertex: usize| {
            [
                Vec3::ZERO,
                Vec3::X,
                Vec3::new(1.0, 1.0, 0.0),
                Vec3::Y,
                Vec3::new(2.0, 0.0, 0.0),
                Vec3::new(2.0, 1.0, 0.0),
            ][vertex]
        };
        for (unit, vertex) in place.corners.into_iter().zip(positions) {
            let corner = (0..4).find(|&k| unit_corner(false, k) == unit).unwrap();
            assert_eq!(merged.positions[quad.vertices[corner] as usize], at(vertex));
        }
    }
}
