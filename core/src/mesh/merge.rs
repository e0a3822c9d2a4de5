//! Pairs of triangles that become quads.
//!
//! Two triangles over one edge are a quad with that edge as its drawn diagonal. So a pair has one grid of samples, filtered
//! and stored as that of any quad, and needs neither a diagonal of samples nor border texels (MCT Figure 6c).

use super::build::{area, link};
use super::{CanvasFace, CanvasMesh, Drawn};

/// A canvas whose pairs are quads.
#[derive(Clone, Debug)]
pub struct Merged {
    pub canvas: CanvasMesh,
    /// By edge of the new canvas, the old canvas' edge.
    pub old_edges: Vec<u32>,
    /// By face of the new canvas, the old canvas' face, and of a pair the other one.
    pub old_faces: Vec<(u32, Option<u32>)>,
}

/// Makes quads of pairs. `partner` names by face the one that it is to be a pair with, which has to be another triangle
/// at one of its edges, to name it in turn and to share no more than one edge with it. A quad stands where the lower of its two stood.
pub fn merge(canvas: &CanvasMesh, partner: &[Option<u32>]) -> Merged {
    let mut merged = CanvasMesh { positions: canvas.positions.clone(), ..CanvasMesh::default() };
    let mut old_faces = Vec::with_capacity(canvas.faces.len());
    // By new face and edge.
    let mut edges: Vec<[u32; 4]> = Vec::with_capacity(canvas.faces.len());
    for (number, face) in (0u32..).zip(&canvas.faces) {
        let pair = match partner[number as usize] {
            Some(other) if other < number => continue,
            Some(other) => pair(canvas, number, other),
            None => None,
        };
        let (face, old_edges, other) = match pair {
            Some((quad, old_edges)) => (quad, old_edges, partner[number as usize]),
            None => (CanvasFace { reversed: 0, ..*face }, face.edges, None),
        };
        merged.faces.push(face);
        edges.push(old_edges);
        old_faces.push((number, other));
    }
    link(&mut merged);
    let mut old_edges = vec![0; merged.edges.len()];
    for (face, old) in merged.faces.iter().zip(&edges) {
        for k in 0..face.count() {
            old_edges[face.edges[k] as usize] = old[k];
        }
    }
    Merged { canvas: merged, old_edges, old_faces }
}

/// The quad of two triangles and its old edges; `None` where they share no edge.
fn pair(canvas: &CanvasMesh, first: u32, second: u32) -> Option<(CanvasFace, [u32; 4])> {
    let [a, b] = [first, second].map(|face| &canvas.faces[face as usize]);
    let (ka, kb) =
        (0..3).flat_map(|ka| (0..3).map(move |kb| (ka, kb))).find(|&(ka, kb)| a.edges[ka] == b.edges[kb])?;
    // Corners of the first: the far end of its edge, what is opposite, and the near end: from the far end all
    // around the first triangle.
    let of_a = [(ka + 1) % 3, (ka + 2) % 3, ka];
    let [from, _, to] = of_a.map(|k| a.vertices[k]);
    let of_b = if b.vertices[kb] == to {
        [(kb + 1) % 3, kb, (kb + 2) % 3]
    } else {
        [kb, (kb + 1) % 3, (kb + 2) % 3]
    };
    debug_assert_eq!([b.vertices[of_b[0]], b.vertices[of_b[1]]], [from, to]);
    let vertices = [from, a.vertices[of_a[1]], to, b.vertices[of_b[2]]];
    let edges = [
        a.edge_between(of_a[0], of_a[1])?,
        a.edge_between(of_a[1], of_a[2])?,
        b.edge_between(of_b[1], of_b[2])?,
        b.edge_between(of_b[2], of_b[0])?,
    ];
    let drawn = |face: &CanvasFace, of: [usize; 3]| Drawn {
        corners: of.map(|k| face.drawn[0].corners[k]),
        ..face.drawn[0]
    };
    let quad = CanvasFace {
        vertices,
        edges: [0; 4],
        count: 4,
        reversed: 0,
        mesh: a.mesh,
        drawn: [drawn(a, of_a), drawn(b, of_b)],
        area: area(&canvas.positions, vertices, 4),
    };
    Some((quad, edges))
}
