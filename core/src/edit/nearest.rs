//! The point of a surface that is nearest to another point.

use glam::{DVec3, Vec2};
use rstar::primitives::GeomWithData;
use rstar::{AABB, PointDistance, RTree, RTreeObject};

use crate::mesh::CanvasMesh;

/// A face, and where on it: `(s, t)` of its unit domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub face: u32,
    pub at: Vec2,
    /// From the point that was asked about.
    pub distance: f64,
}

/// The drawn triangles of a canvas, to be searched.
pub struct Surface {
    tree: RTree<GeomWithData<Triangle, (u32, usize)>>,
}

#[derive(Clone, Copy, Debug)]
struct Triangle([DVec3; 3]);

impl Surface {
    /// `positions`: by vertex of the canvas.
    pub fn new(canvas: &CanvasMesh, positions: &[DVec3]) -> Self {
        let triangles = (0u32..).zip(&canvas.faces).flat_map(|(number, face)| {
            face.drawn_corners().iter().enumerate().map(move |(drawn, corners)| {
                let corners = corners.map(|k| positions[face.vertices[k] as usize]);
                GeomWithData::new(Triangle(corners), (number, drawn))
            })
        });
        Self { tree: RTree::bulk_load(triangles.collect()) }
    }

    /// `None` where there is no face.
    pub fn nearest(&self, canvas: &CanvasMesh, point: DVec3) -> Option<Place> {
        let found = self.tree.nearest_neighbor(point.to_array())?;
        let (face, drawn) = found.data;
        let (weights, squared) = found.geom().nearest(point);
        let [_, b, c] = weights.to_array();
        // The inverse of `mesh::surface_point`.
        let at = match (canvas.faces[face as usize].is_triangle(), drawn) {
            (true, _) => [b, c],
            (false, 0) => [b + c, c],
            (false, _) => [b, b + c],
        };
        Some(Place { face, at: Vec2::new(at[0] as f32, at[1] as f32), distance: squared.sqrt() })
    }
}

impl Triangle {
    /// Barycentrics of the nearest point, and its squared distance.
    fn nearest(&self, point: DVec3) -> (DVec3, f64) {
        let [a, b, c] = self.0;
        let (ab, ac, ap) = (b - a, c - a, point - a);
        let normal = ab.cross(ac);
        let area = normal.length_squared();
        if area > 0.0 {
            let v = ap.cross(ac).dot(normal) / area;
            let w = ab.cross(ap).dot(normal) / area;
            if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
                let weights = DVec3::new(1.0 - v - w, v, w);
                return (weights, self.at(weights).distance_squared(point));
            }
        }
        let along = |from: usize, to: usize| {
            let (start, side) = (self.0[from], self.0[to] - self.0[from]);
            let length = side.length_squared();
            let t = if length > 0.0 { ((point - start).dot(side) / length).clamp(0.0, 1.0) } else { 0.0 };
            let mut weights = DVec3::ZERO;
            weights[from] += 1.0 - t;
            weights[to] += t;
            (weights, self.at(weights).distance_squared(point))
        };
        let sides = [along(0, 1), along(1, 2), along(2, 0)];
        sides.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((DVec3::X, f64::INFINITY))
    }

    fn at(&self, weights: DVec3) -> DVec3 {
        self.0[0] * weights.x + self.0[1] * weights.y + self.0[2] * weights.z
    }
}

impl RTreeObject for Triangle {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(self.0.map(|corner| corner.to_array()).iter())
    }
}

impl PointDistance for Triangle {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        self.nearest(DVec3::from_array(*point)).1
    }
}
