//! Tangents for a source that has a normal map and no TANGENT: MikkTSpace, as glTF 2.0 asks for.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

/// Corners of triangles, three in a row.
pub struct Corners {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
}

/// A tangent for each corner, `w` the handedness. A corner that MikkTSpace has none for (its triangle has
/// no area on the surface or in the texture) gets any direction across its normal.
pub fn tangents(corners: &Corners) -> Vec<Vec4> {
    let across = |normal: &Vec3| normal.any_orthonormal_vector().extend(1.0);
    let out = corners.normals.iter().map(across).collect();
    let mut builder = Builder { corners, out };
    // The one error is a mesh without a single usable face; the made-up directions are right for it.
    let _ = generate_tangents(&mut builder);
    builder.out
}

struct Builder<'a> {
    corners: &'a Corners,
    out: Vec<Vec4>,
}

impl Geometry for Builder<'_> {
    fn num_faces(&self) -> usize {
        self.corners.positions.len() / 3
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.corners.positions[3 * face + vert].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.corners.normals[3 * face + vert].to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.corners.uvs[3 * face + vert].to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, vert: usize) {
        let Some(space) = space else { return };
        // glTF's v runs down and its normal maps' green runs up, so the handedness turns round.
        let tangent = Vec4::from(space.tangent_encoded()) * Vec4::new(1.0, 1.0, 1.0, -1.0);
        if tangent.is_finite() && tangent.truncate().length_squared() > 0.25 {
            self.out[3 * face + vert] = tangent;
        }
    }
}
