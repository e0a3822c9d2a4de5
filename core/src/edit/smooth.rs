//! The vertices of a mesh that was split, moved to where a subdivision surface has them.
//!
//! After every face was split in four, each vertex moves towards a mean of what is around it (J. Warren, S. Schaefer, "A
//! factored approach to subdivision surfaces", IEEE CG&A 24(3), 2004): every quad gives the mean of its corners, every
//! triangle a quarter of the vertex and 3/8 of the two others, weighted by the angles pi/2 and pi/3. On quads alone that is
//! Catmull-Clark, on triangles alone Loop (with his weights), and what lies between is Stam and Loop's mixture. Along a
//! border, and along an edge of more than two faces, a vertex moves as on a cubic spline; where such lines cross or end it stays.

use glam::{DVec3, Vec3};

use crate::asset::Mesh;
use crate::mesh::{CanvasMesh, Polygons, build};

/// Moves all vertices of the mesh's faces.
pub fn smooth(mesh: &mut Mesh) {
    let canvas = welded(mesh);
    let moved = positions(&canvas);
    for face in &canvas.faces {
        let primitive = &mut mesh.primitives[face.drawn[0].primitive as usize];
        let corners = primitive.faces[face.drawn[0].face as usize].corners;
        for (vertex, welded) in corners.into_iter().zip(face.vertices).take(face.count()) {
            primitive.positions[vertex as usize] = moved[welded as usize];
        }
    }
}

/// All faces of a mesh, whatever their materials.
fn welded(mesh: &Mesh) -> CanvasMesh {
    let mut faces: Vec<_> =
        mesh.primitives.iter().map(|p| p.faces.iter().map(|f| (f.corners, f.count))).collect();
    let parts = (0u32..).zip(&mesh.primitives).zip(&mut faces);
    build(parts.map(|((primitive, own), faces)| Polygons {
        mesh: 0,
        primitive,
        positions: &own.positions,
        faces,
    }))
}

#[derive(Clone, Copy, Default)]
struct Around {
    sum: DVec3,
    weight: f64,
    quads: u32,
    triangles: u32,
    /// Along lines that a spline follows: neighbors and how many.
    line: DVec3,
    line_count: u32,
}

fn positions(canvas: &CanvasMesh) -> Vec<Vec3> {
    let at = |vertex: u32| canvas.positions[vertex as usize].as_dvec3();
    let mut around = vec![Around::default(); canvas.positions.len()];
    for face in &canvas.faces {
        let vertices = &face.vertices[..face.count()];
        let sum: DVec3 = vertices.iter().map(|vertex| at(*vertex)).sum();
        for &vertex in vertices {
            let own = &mut around[vertex as usize];
            if face.is_triangle() {
                own.sum += ((sum - at(vertex)) * 0.375 + at(vertex) * 0.25) * 2.0;
                own.weight += 2.0;
                own.triangles += 1;
            } else {
                own.sum += sum * 0.25 * 3.0;
                own.weight += 3.0;
                own.quads += 1;
            }
        }
    }
    for edge in canvas.edges.iter().filter(|edge| canvas.sides(edge).len() != 2) {
        let [a, b] = edge.vertices;
        for (one, other) in [(a, b), (b, a)] {
            around[one as usize].line += at(other);
            around[one as usize].line_count += 1;
        }
    }
    let moved = |(own, before): (&Around, &Vec3)| {
        let v = before.as_dvec3();
        match own.line_count {
            0 if own.weight > 0.0 => (v + (own.sum / own.weight - v) * pull(own)).as_vec3(),
            2 => (v * 0.5 + own.line * 0.25).as_vec3(),
            _ => *before,
        }
    };
    around.iter().zip(&canvas.positions).map(moved).collect()
}

/// How far a vertex goes towards its mean.
fn pull(around: &Around) -> f64 {
    let [quads, triangles] = [around.quads, around.triangles].map(f64::from);
    if around.quads > 0 {
        return 12.0 / (3.0 * quads + 2.0 * triangles);
    }
    // C. Loop, "Smooth subdivision surfaces based on triangles", 1987: the ring's weight, of which the mean above has
    // three eighths (its neighbors are middles of edges).
    let cosine = 0.375 + 0.25 * (std::f64::consts::TAU / triangles).cos();
    (0.625 - cosine * cosine) / 0.375
}
