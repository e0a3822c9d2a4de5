//! How the faces of a Ptex file hang together: by the mesh. Corners at one position are one vertex, sides between the
//! same two vertices are one edge, however many there are.

use super::super::warnings::Warnings;
use super::faces::FaceInfo;

/// Faces with equally many corners.
#[derive(Debug)]
pub struct Topology {
    pub corner_count: usize,
    /// By face and corner.
    pub vertices: Vec<u32>,
    pub vertex_count: usize,
    /// By face and edge; edge `k` runs from corner `k` to the next.
    pub edges: Vec<u32>,
    /// By edge, where its sides begin; and the end.
    first_side: Vec<u32>,
    sides: Vec<Side>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    pub face: usize,
    pub edge: usize,
    /// Runs from the vertex of the higher number to the lower one.
    pub is_reversed: bool,
}

impl Topology {
    /// `vertices` by face and corner.
    pub fn new(corner_count: usize, vertices: Vec<u32>) -> Self {
        let face_count = vertices.len() / corner_count;
        let mut keyed: Vec<([u32; 3], u32)> = Vec::with_capacity(vertices.len());
        for face in 0..face_count {
            for edge in 0..corner_count {
                let number = face * corner_count + edge;
                let [from, to] = ends(&vertices, corner_count, face, edge);
                // An edge without length joins nothing.
                let alone = if from == to { number as u32 + 1 } else { 0 };
                keyed.push(([from.min(to), from.max(to), alone], number as u32));
            }
        }
        keyed.sort_unstable();
        let mut topology = Self {
            corner_count,
            vertex_count: vertices.iter().max().map_or(0, |&most| most as usize + 1),
            edges: vec![0; vertices.len()],
            first_side: vec![0],
            sides: Vec::with_capacity(vertices.len()),
            vertices,
        };
        for sides in keyed.chunk_by(|a, b| a.0 == b.0) {
            let edge_number = topology.first_side.len() as u32 - 1;
            for &(_, side) in sides {
                topology.edges[side as usize] = edge_number;
                let (face, edge) = (side as usize / corner_count, side as usize % corner_count);
                let [from, to] = ends(&topology.vertices, corner_count, face, edge);
                topology.sides.push(Side { face, edge, is_reversed: from > to });
            }
            topology.first_side.push(topology.sides.len() as u32);
        }
        topology
    }

    /// The same faces with nothing in common.
    pub fn apart(corner_count: usize, face_count: usize) -> Self {
        Self::new(corner_count, (0..(face_count * corner_count) as u32).collect())
    }

    pub fn edge_count(&self) -> usize {
        self.first_side.len() - 1
    }

    pub fn sides(&self, edge: usize) -> &[Side] {
        &self.sides[self.first_side[edge] as usize..self.first_side[edge + 1] as usize]
    }

    /// Both vertices of an edge, the lower one first.
    pub fn edge_ends(&self, edge: usize) -> [u32; 2] {
        let side = self.sides(edge)[0];
        let [from, to] = ends(&self.vertices, self.corner_count, side.face, side.edge);
        [from.min(to), from.max(to)]
    }

    pub fn edge(&self, face: usize, edge: usize) -> usize {
        self.edges[face * self.corner_count + edge] as usize
    }

    pub fn is_reversed(&self, face: usize, edge: usize) -> bool {
        let [from, to] = ends(&self.vertices, self.corner_count, face, edge);
        from > to
    }

    /// Counts what the file says of neighbours and the mesh does not: the mesh is what counts. Where an edge has more than
    /// two faces any of the others will do, and of subfaces the file names one of two.
    pub fn compare(&self, faces: &[FaceInfo], place: &str, warnings: &mut Warnings) {
        let mut count = 0;
        let mut first = String::new();
        for (face, info) in faces.iter().enumerate() {
            for edge in 0..self.corner_count {
                let others = self.sides(self.edge(face, edge)).iter().filter(|side| side.face != face);
                let mut others = others.map(|side| (side.face as u32, side.edge as u8)).peekable();
                let stored = info.neighbours[edge];
                let agrees = match stored {
                    None => others.peek().is_none(),
                    Some(stored) => others.any(|other| other == stored),
                };
                if agrees {
                    continue;
                }
                if count == 0 {
                    let of = |neighbour: Option<(u32, u8)>| match neighbour {
                        Some((face, edge)) => format!("edge {edge} of face {face}"),
                        None => "no face".to_owned(),
                    };
                    let beyond = self.sides(self.edge(face, edge)).iter().find(|side| side.face != face);
                    let beyond = of(beyond.map(|side| (side.face as u32, side.edge as u8)));
                    first = format!(
                        "neighbours that the file has otherwise than the mesh, which is what counts; the first is edge \
                         {edge} of face {face}: the file has {}, the mesh {beyond}",
                        of(stored)
                    );
                }
                count += 1;
            }
        }
        warnings.add_many("ptex_adjacency", place, &first, count);
    }
}

fn ends(vertices: &[u32], corner_count: usize, face: usize, edge: usize) -> [u32; 2] {
    let first = face * corner_count;
    [vertices[first + edge], vertices[first + (edge + 1) % corner_count]]
}
