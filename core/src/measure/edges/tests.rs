use glam::Vec3;

use super::*;
use crate::asset::{Face, Primitive};
use crate::finished::Coordinates;

fn primitive(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Primitive {
    Primitive {
        positions: positions.iter().map(|p| Vec3::from_array(*p)).collect(),
        faces: triangles.iter().map(|t| Face::triangle(*t)).collect(),
        ..Primitive::default()
    }
}

fn part(mesh: usize, geometry: &Primitive) -> Part<'_> {
    let triangles = geometry.faces.iter().map(|f| [f.corners[0], f.corners[1], f.corners[2]]).collect();
    Part {
        mesh,
        primitive: 0,
        geometry,
        triangles,
        placed: &[],
        coordinates: &Coordinates::Scaled,
        finished: None,
    }
}

const A: [f32; 3] = [0.0, 0.0, 0.0];
const B: [f32; 3] = [2.0, 0.0, 0.0];
const C: [f32; 3] = [0.0, 1.0, 0.0];
const D: [f32; 3] = [0.0, -1.0, 0.0];

#[test]
fn sides_meet_by_position_with_either_zero() {
    let upper = primitive(&[A, B, C], &[[0, 1, 2]]);
    let lower = primitive(&[[0.0, -1.0, 0.0], [2.0, -0.0, 0.0], [-0.0, 0.0, -0.0]], &[[0, 1, 2]]);
    let found = pairs(&[part(0, &upper), part(0, &lower)]);
    let a = Side { part: 0, triangle: 0, corner: 0 };
    let b = Side { part: 1, triangle: 0, corner: 1 };
    assert_eq!(found, vec![EdgePair { a, b, opposed: true, length: 2.0 }]);
    assert_eq!((a.ends(), found[0].ends_of_b()), ([0, 1], [2, 1]));
}

#[test]
fn equal_directions_are_not_opposed() {
    let upper = primitive(&[A, B, C, D], &[[0, 1, 2], [0, 1, 3]]);
    let found = pairs(&[part(0, &upper)]);
    assert_eq!(found.len(), 1);
    assert!(!found[0].opposed);
    assert_eq!(found[0].ends_of_b(), [0, 1]);
}

#[test]
fn meshes_do_not_join() {
    let upper = primitive(&[A, B, C], &[[0, 1, 2]]);
    assert!(pairs(&[part(0, &upper), part(1, &upper)]).is_empty());
    assert_eq!(pairs(&[part(1, &upper), part(1, &upper)]).len(), 3);
}

#[test]
fn many_sides_are_judged_against_the_first() {
    let fins = primitive(&[A, B, C, D, [0.0, 0.0, 1.0]], &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    let found = pairs(&[part(0, &fins)]);
    let partners: Vec<_> =
        found.iter().map(|pair| (pair.a.triangle, pair.b.triangle, pair.opposed)).collect();
    assert_eq!(partners, vec![(0, 1, true), (0, 2, false)]);
}

#[test]
fn degenerate_triangles_do_not_meet_themselves() {
    // Sides A-B and B-A of one triangle, and a side without length.
    let needle = primitive(&[A, B, A, C], &[[0, 1, 2], [0, 1, 3]]);
    let found = pairs(&[part(0, &needle)]);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].a.triangle, found[0].b.triangle), (0, 1));
}

#[test]
fn parts_without_triangles_are_skipped() {
    let (empty, upper) = (primitive(&[A], &[]), primitive(&[A, B, C], &[[0, 1, 2]]));
    let found = pairs(&[part(0, &empty), part(0, &upper), part(0, &empty), part(0, &upper)]);
    assert_eq!(found.iter().map(|pair| (pair.a.part, pair.b.part)).collect::<Vec<_>>(), vec![(1, 3); 3]);
}

#[test]
fn a_grid_has_the_pairs_of_a_grid() {
    let n = 60u32;
    let positions: Vec<[f32; 3]> = (0..n * n).map(|i| [(i % n) as f32, (i / n) as f32, 0.0]).collect();
    let corner = |x: u32, y: u32| y * n + x;
    let cells = (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (x, y)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let grid = primitive(&positions, &triangles);
    let cells = (n - 1) as usize;
    assert_eq!(pairs(&[part(0, &grid)]).len(), cells * cells + 2 * cells * (cells - 1));
}
