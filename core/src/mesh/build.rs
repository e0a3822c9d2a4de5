//! Welding and topology.

use std::collections::HashMap;

use glam::Vec3;

use super::{CanvasEdge, CanvasFace, CanvasMesh, Drawn, Side};

/// A polygon soup of one mesh and material, as [`build`] takes it in.
pub struct Polygons<'a> {
    pub mesh: u32,
    pub primitive: u32,
    pub positions: &'a [Vec3],
    /// Corner vertices of each face: 3 or 4.
    pub faces: &'a mut dyn Iterator<Item = ([u32; 4], u8)>,
}

/// Builds the canvas of several primitives. Primitives of the same `mesh` weld together.
pub fn build<'a>(parts: impl IntoIterator<Item = Polygons<'a>>) -> CanvasMesh {
    let mut canvas = CanvasMesh::default();
    let mut vertex_at: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    for part in parts {
        for (number, (corners, count)) in part.faces.enumerate() {
            let mut vertices = [0; 4];
            for (slot, &corner) in vertices.iter_mut().zip(&corners[..usize::from(count)]) {
                let position = part.positions[corner as usize] + 0.0; // turns -0.0 into 0.0
                let key = (part.mesh, position.to_array().map(f32::to_bits));
                *slot = *vertex_at.entry(key).or_insert_with(|| {
                    canvas.positions.push(position);
                    canvas.positions.len() as u32 - 1
                });
            }
            canvas.faces.push(CanvasFace {
                vertices,
                edges: [0; 4],
                count,
                reversed: 0,
                mesh: part.mesh,
                drawn: [[0, 1, 2], [0, 2, 3]].map(|corners| Drawn {
                    primitive: part.primitive,
                    face: number as u32,
                    corners,
                }),
                area: area(&canvas.positions, vertices, count),
            });
        }
    }
    link(&mut canvas);
    canvas
}

pub(super) fn area(positions: &[Vec3], vertices: [u32; 4], count: u8) -> f32 {
    let at = |k: usize| positions[vertices[k] as usize].as_dvec3();
    let triangle = |a: usize, b: usize, c: usize| 0.5 * (at(b) - at(a)).cross(at(c) - at(a)).length();
    let total = triangle(0, 1, 2) + if count == 4 { triangle(0, 2, 3) } else { 0.0 };
    total as f32
}

/// Finds the edges of faces that are complete but for them.
pub(super) fn link(canvas: &mut CanvasMesh) {
    let mut edge_at: HashMap<[u32; 2], u32> = HashMap::new();
    let mut side_edges = Vec::new();
    let CanvasMesh { faces, edges, .. } = canvas;
    for (number, face) in faces.iter_mut().enumerate() {
        for k in 0..face.count() {
            let (from, to) = (face.vertices[k], face.vertices[(k + 1) % face.count()]);
            let key = [from.min(to), from.max(to)];
            let mut add = || {
                edges.push(CanvasEdge { vertices: key, first_side: 0, side_count: 0 });
                edges.len() as u32 - 1
            };
            // An edge of no length joins nothing: each keeps a canvas edge of its own.
            let edge = if from == to { add() } else { *edge_at.entry(key).or_insert_with(add) };
            face.edges[k] = edge;
            face.reversed |= u8::from(from > to) << k;
            edges[edge as usize].side_count += 1;
            side_edges.push((edge, Side { face: number as u32, edge: k as u8 }));
        }
    }
    let mut next = 0;
    for edge in edges.iter_mut() {
        edge.first_side = next;
        next += edge.side_count;
    }
    let mut filled: Vec<u32> = edges.iter().map(|edge| edge.first_side).collect();
    canvas.sides = vec![Side { face: 0, edge: 0 }; side_edges.len()];
    for (edge, side) in side_edges {
        let slot = &mut filled[edge as usize];
        canvas.sides[*slot as usize] = side;
        *slot += 1;
    }
}
