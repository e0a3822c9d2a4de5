//! The grid points around a place, and what each counts for.

use glam::Vec2;

use crate::colors::Shape;

/// Points `(i, j)` of a face's grid with their weights, which sum to 1. A point of no weight may be there twice.
pub(super) type Points = [((u32, u32), f32); 4];

/// The points around a place of the unit domain. Of a triangle three; with a right angle (at this corner) four in each
/// cell that the edge across from it does not cut.
pub(super) fn points(shape: Shape, at: Vec2, right: Option<u8>) -> Points {
    let at = inside(shape.is_triangle, at);
    if shape.is_triangle {
        triangle(shape.segments[0], at, right)
    } else {
        let [n, m] = shape.segments;
        let ((i, x), (j, y)) = (cell_along(at.x * n as f32, n), cell_along(at.y * m as f32, m));
        bilinear(x, y).map(|([dx, dy], weight)| ((i + dx, j + dy), weight))
    }
}

/// The place itself, or one in the face where it lies outside.
pub(super) fn inside(is_triangle: bool, at: Vec2) -> Vec2 {
    let at = at.clamp(Vec2::ZERO, Vec2::ONE);
    if is_triangle { at / (at.x + at.y).max(1.0) } else { at }
}

/// MC 4.1 with the barycentrics of the two corners behind `right` for `i` and `j`; any corner will do where all cells
/// are cut.
fn triangle(n: u32, at: Vec2, right: Option<u8>) -> Points {
    let corner = usize::from(right.unwrap_or(0));
    let barycentrics = [1.0 - at.x - at.y, at.x, at.y];
    let [x, y] = [1, 2].map(|k| barycentrics[(corner + k) % 3].max(0.0) * n as f32);
    let (i, x) = cell_along(x, n);
    let (j, y) = cell_along(y, n - i);
    let is_cut = i + j + 1 == n;
    let weights = if right.is_some() && !is_cut {
        bilinear(x, y)
    } else if x + y <= 1.0 || is_cut {
        [([0, 0], 1.0 - x - y), ([1, 0], x), ([0, 1], y), ([0, 0], 0.0)]
    } else {
        [([0, 1], 1.0 - x), ([1, 0], 1.0 - y), ([1, 1], x + y - 1.0), ([1, 1], 0.0)]
    };
    weights.map(|([dx, dy], weight)| {
        let mut steps = [0; 3];
        steps[(corner + 1) % 3] = i + dx;
        steps[(corner + 2) % 3] = j + dy;
        steps[corner] = n - (i + dx) - (j + dy);
        ((steps[1], steps[2]), weight)
    })
}

/// The corners of a cell.
fn bilinear(x: f32, y: f32) -> [([u32; 2], f32); 4] {
    let along = |v: f32, far: u32| if far == 1 { v } else { 1.0 - v };
    [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[dx, dy]| ([dx, dy], along(x, dx) * along(y, dy)))
}

/// The cell of `count` that a distance in segments falls into, and where in it.
fn cell_along(distance: f32, count: u32) -> (u32, f32) {
    let cell = (distance as u32).min(count - 1);
    (cell, distance - cell as f32)
}
