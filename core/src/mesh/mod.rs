//! The canvas mesh: the welded polygon mesh that mesh colors live on.
//!
//! One canvas covers all faces of one material. Vertices are welded by exact position inside one mesh of
//! the asset; edges know every face around them, in face order, however many there are.

mod build;
mod merge;
#[cfg(test)]
mod tests;

pub use build::{Polygons, build};
pub use merge::{Merged, merge};

use glam::Vec3;

/// Guarantees: indices are in range; `edges` is sorted by first appearance in face order; the sides of an
/// edge are in face order; an edge whose two ends are one vertex has exactly one side.
#[derive(Clone, Debug, Default)]
pub struct CanvasMesh {
    /// Welded vertices, mesh space.
    pub positions: Vec<Vec3>,
    pub faces: Vec<CanvasFace>,
    pub edges: Vec<CanvasEdge>,
    /// The sides of all edges; `CanvasEdge` holds its range.
    sides: Vec<Side>,
}

/// A triangle or quad: `vertices[..count]`; edge `k` runs from corner `k` to corner `k + 1`. A quad is a face of
/// the asset, or two of its triangles that [`merge`] made one.
#[derive(Clone, Copy, Debug)]
pub struct CanvasFace {
    pub vertices: [u32; 4],
    pub edges: [u32; 4],
    pub count: u8,
    /// Bit k set where edge k runs against its canvas edge (from `vertices[1]` to `vertices[0]`).
    pub reversed: u8,
    /// Mesh of the asset.
    pub mesh: u32,
    /// Where its triangles come from, those of [`CanvasFace::drawn_corners`]; a triangle's second repeats its first.
    pub drawn: [Drawn; 2],
    /// Mesh-space area of its drawn triangles.
    pub area: f32,
}

/// A drawn triangle as the asset has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// Primitive of the mesh, and face of the primitive.
    pub primitive: u32,
    pub face: u32,
    /// By corner of the drawn triangle: which corner of the asset's face it is.
    pub corners: [u8; 3],
}

/// An edge from the vertex of the lower number to the higher one.
#[derive(Clone, Copy, Debug)]
pub struct CanvasEdge {
    pub vertices: [u32; 2],
    first_side: u32,
    side_count: u32,
}

/// One face's use of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    pub face: u32,
    /// Which edge of the face.
    pub edge: u8,
}

impl CanvasFace {
    pub fn count(&self) -> usize {
        usize::from(self.count)
    }

    pub fn is_triangle(&self) -> bool {
        self.count == 3
    }

    /// Whether it is a pair of triangles of the asset.
    pub fn is_pair(&self) -> bool {
        let [a, b] = &self.drawn;
        (a.primitive, a.face) != (b.primitive, b.face)
    }

    /// The corners of each drawn triangle: a quad's diagonal runs from corner 0 to corner 2.
    pub fn drawn_corners(&self) -> &'static [[usize; 3]] {
        if self.is_triangle() { &DRAWN[..1] } else { &DRAWN }
    }

    /// The canvas edge between two corners; none between those of a quad's diagonal.
    pub fn edge_between(&self, one: usize, other: usize) -> Option<u32> {
        let follows = |from: usize, to: usize| to == (from + 1) % self.count();
        let first = if follows(one, other) { Some(one) } else { follows(other, one).then_some(other) };
        first.map(|corner| self.edges[corner])
    }

    pub fn is_reversed(&self, edge: usize) -> bool {
        self.reversed >> edge & 1 == 1
    }
}

impl CanvasMesh {
    /// Triangles of the asset that stand in pairs, two by two.
    pub fn pair_count(&self) -> u64 {
        self.faces.iter().filter(|face| face.is_pair()).count() as u64
    }

    pub fn sides(&self, edge: &CanvasEdge) -> &[Side] {
        let first = edge.first_side as usize;
        &self.sides[first..first + edge.side_count as usize]
    }

    /// The corner of a face that stands at the low end (`end` 0) or high end (`end` 1) of its edge.
    pub fn corner_at_end(&self, side: Side, end: usize) -> usize {
        let face = &self.faces[side.face as usize];
        let edge = usize::from(side.edge);
        let second = usize::from(face.is_reversed(edge)) != end;
        (edge + usize::from(second)) % face.count()
    }
}

const DRAWN: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// The drawn triangle (its number) and barycentrics of the point `(s, t)` of a face's unit domain. On a
/// triangle `s` and `t` weigh corners 1 and 2; a quad's unit square is drawn as two triangles over the
/// diagonal from corner 0 to corner 2, and the point lies on the drawn surface.
pub fn surface_point(corner_count: usize, s: f32, t: f32) -> (usize, Vec3) {
    if corner_count == 3 {
        (0, Vec3::new(1.0 - s - t, s, t))
    } else if t <= s {
        (0, Vec3::new(1.0 - s, s - t, t))
    } else {
        (1, Vec3::new(1.0 - t, s, t - s))
    }
}

/// The corners of the drawn triangles, by their number.
pub fn drawn_corners(triangle: usize) -> [usize; 3] {
    DRAWN[triangle]
}
