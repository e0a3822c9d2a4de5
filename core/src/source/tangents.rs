//! The tangent frames that a source's normal map is stored in, one for each corner of each face.
//!
//! glTF 2.0, section 3.7.2.1: TANGENT where there is one, else MikkTSpace on the normal map's texture
//! coordinates; without NORMAL the faces are flat and TANGENT is ignored. MikkTSpace gets coordinates
//! with v up, as glTF's green channel points up in the image. It takes the square of the number of
//! faces at a vertex and recurses once for each, so faces at a vertex of more than [`FAN_LIMIT`] faces
//! are kept from it and use the gradient of their own texture coordinates.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

use crate::asset::{Face, Primitive, UvTransform};
use crate::finished::Frame;

/// Faces at one position. More: no bound on MikkTSpace's time; less: real models with poles differ from
/// what their author saw.
const FAN_LIMIT: u32 = 256;

/// A tangent whose part across the normal is shorter than this has no direction.
const SHORTEST_TANGENT: f32 = 1e-6;

/// The frames of each face's corners (a triangle's fourth repeats its third). Always finite, unit
/// normals and tangents; where the source defines none, any tangent across the normal, `w = 1`.
pub fn frames(primitive: &Primitive, texcoord: usize, transform: UvTransform) -> Vec<[Frame; 4]> {
    let normals: Vec<[Vec3; 4]> =
        primitive.faces.iter().map(|face| corner_normals(primitive, face)).collect();
    let stored = !primitive.normals.is_empty() && !primitive.tangents.is_empty();
    let tangents: Vec<[Option<Vec4>; 4]> = if stored {
        let at = |corner: u32| primitive.tangents.get(corner as usize).copied();
        primitive.faces.iter().map(|face| face.corners.map(at)).collect()
    } else {
        computed_tangents(primitive, &normals, texcoord, transform)
    };
    normals
        .iter()
        .zip(&tangents)
        .map(|(normals, tangents)| std::array::from_fn(|k| checked(normals[k], tangents[k])))
        .collect()
}

/// A frame that is safe to interpolate: the tangent as it is, or any across the normal.
fn checked(normal: Vec3, tangent: Option<Vec4>) -> Frame {
    let lost = Frame { normal, tangent: normal.any_orthonormal_vector().extend(1.0) };
    let Some(tangent) = tangent else { return lost };
    let along = tangent.truncate();
    let across = along - normal * normal.dot(along);
    if !across.is_finite() || across.length() < SHORTEST_TANGENT {
        return lost;
    }
    let handedness = if tangent.w < 0.0 { -1.0 } else { 1.0 };
    Frame { normal, tangent: along.normalize().extend(handedness) }
}

fn corner_normals(primitive: &Primitive, face: &Face) -> [Vec3; 4] {
    if primitive.normals.is_empty() {
        return [flat_normal(primitive, face); 4];
    }
    face.corners.map(|corner| {
        let stored = primitive.normals.get(corner as usize).copied().unwrap_or(Vec3::ZERO);
        stored.try_normalize().unwrap_or_else(|| flat_normal(primitive, face))
    })
}

/// Newell's normal, in f64 so that large and tiny faces have one too.
fn flat_normal(primitive: &Primitive, face: &Face) -> Vec3 {
    let [a, b, c, d] = face.corners.map(|corner| primitive.positions[corner as usize].as_dvec3());
    // The last corner of a triangle repeats the third, and its diagonals give its own normal.
    (c - a)
        .cross(d - b)
        .try_normalize()
        .or_else(|| (b - a).cross(c - a).try_normalize())
        .map_or(Vec3::Z, |n| n.as_vec3())
}

fn computed_tangents(
    primitive: &Primitive,
    normals: &[[Vec3; 4]],
    texcoord: usize,
    transform: UvTransform,
) -> Vec<[Option<Vec4>; 4]> {
    let crowded = crowded_vertices(primitive);
    let uvs = primitive.texcoords.get(texcoord);
    let uv = |corner: u32| {
        let uv = uvs.and_then(|set| set.get(corner as usize)).copied().unwrap_or(Vec2::ZERO);
        let moved = transform.apply(uv);
        Vec2::new(moved.x, 1.0 - moved.y)
    };
    let mut soup = Soup { polygons: Vec::new(), tangents: vec![[None; 4]; primitive.faces.len()] };
    for (number, face) in primitive.faces.iter().enumerate() {
        let Some((slots, count)) = distinct_corners(primitive, face) else { continue };
        let corner = |k: usize| {
            let vertex = face.corners[slots[k]];
            Corner {
                position: primitive.positions[vertex as usize],
                normal: normals[number][slots[k]],
                uv: uv(vertex),
            }
        };
        let polygon = Polygon { face: number, slots, count, corners: std::array::from_fn(corner) };
        if face.corners().iter().any(|&vertex| crowded[vertex as usize]) {
            soup.tangents[number] = polygon.own_tangents();
        } else {
            soup.polygons.push(polygon);
        }
    }
    if generate_tangents(&mut soup).is_err() {
        // Its error type has no values yet. Were there one, every face would go by its own gradient.
        for polygon in &soup.polygons {
            soup.tangents[polygon.face] = polygon.own_tangents();
        }
    }
    for (face, tangents) in primitive.faces.iter().zip(&mut soup.tangents) {
        share_with_twins(primitive, face, tangents);
    }
    soup.tangents
}

/// Which vertices stand where more than [`FAN_LIMIT`] faces meet, by exact position.
fn crowded_vertices(primitive: &Primitive) -> Vec<bool> {
    let mut face_counts = vec![0u32; primitive.positions.len()];
    for face in &primitive.faces {
        for &corner in face.corners() {
            face_counts[corner as usize] += 1;
        }
    }
    let key = |vertex: u32| primitive.positions[vertex as usize].to_array().map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..primitive.positions.len() as u32).collect();
    order.sort_unstable_by_key(|&vertex| (key(vertex), vertex));
    let mut crowded = vec![false; primitive.positions.len()];
    for run in order.chunk_by(|&a, &b| key(a) == key(b)) {
        let count: u64 = run.iter().map(|&vertex| u64::from(face_counts[vertex as usize])).sum();
        if count > u64::from(FAN_LIMIT) {
            run.iter().for_each(|&vertex| crowded[vertex as usize] = true);
        }
    }
    crowded
}

/// The corner numbers of a face that stand at different places: all of them, or three of a quad's four;
/// `None` where the face has no area for certain.
fn distinct_corners(primitive: &Primitive, face: &Face) -> Option<([usize; 4], usize)> {
    let at = |k: usize| primitive.positions[face.corners[k] as usize];
    let mut slots = [0; 4];
    let mut count = 0;
    for k in 0..face.corners().len() {
        if slots[..count].iter().all(|&other| at(other) != at(k)) {
            slots[count] = k;
            count += 1;
        }
    }
    // A quad whose opposite corners meet is folded flat: both of its triangles are lines.
    let folded = face.count == 4 && (at(0) == at(2) || at(1) == at(3));
    if count < 3 || folded {
        return None;
    }
    if count == 3 {
        slots[3] = slots[2];
    }
    Some((slots, count))
}

/// Corners that MikkTSpace did not see take the tangent of the corner at the same place.
fn share_with_twins(primitive: &Primitive, face: &Face, tangents: &mut [Option<Vec4>; 4]) {
    for k in 0..4 {
        if tangents[k].is_none() {
            let here = primitive.positions[face.corners[k] as usize];
            tangents[k] = (0..4)
                .filter(|&other| primitive.positions[face.corners[other] as usize] == here)
                .find_map(|other| tangents[other]);
        }
    }
}

#[derive(Clone, Copy)]
struct Corner {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
}

struct Polygon {
    face: usize,
    /// The face's corner behind each corner here.
    slots: [usize; 4],
    count: usize,
    corners: [Corner; 4],
}

impl Polygon {
    /// The direction of growing u on the face, across each corner's normal.
    fn own_tangents(&self) -> [Option<Vec4>; 4] {
        let [a, b, c, d] = self.corners;
        // A quad's diagonals, a triangle's two sides from its last corner.
        let (along, across) = if self.count == 4 { ((a, c), (b, d)) } else { ((c, a), (c, b)) };
        let (e, f) = (along.1.position - along.0.position, across.1.position - across.0.position);
        let (g, h) = (along.1.uv - along.0.uv, across.1.uv - across.0.uv);
        let area = g.perp_dot(h);
        let gradient = (e * h.y - f * g.y) * area.signum();
        let mut tangents = [None; 4];
        for k in 0..self.count {
            let normal = self.corners[k].normal;
            let tangent = (gradient - normal * normal.dot(gradient)).try_normalize();
            tangents[self.slots[k]] = tangent.filter(|_| area != 0.0).map(|t| t.extend(area.signum()));
        }
        tangents
    }
}

/// What MikkTSpace reads and writes.
struct Soup {
    polygons: Vec<Polygon>,
    /// By face of the primitive.
    tangents: Vec<[Option<Vec4>; 4]>,
}

impl Geometry for Soup {
    fn num_faces(&self) -> usize {
        self.polygons.len()
    }

    fn num_vertices_of_face(&self, face: usize) -> usize {
        self.polygons[face].count
    }

    fn position(&self, face: usize, vertex: usize) -> [f32; 3] {
        self.polygons[face].corners[vertex].position.to_array()
    }

    fn normal(&self, face: usize, vertex: usize) -> [f32; 3] {
        self.polygons[face].corners[vertex].normal.to_array()
    }

    fn tex_coord(&self, face: usize, vertex: usize) -> [f32; 2] {
        self.polygons[face].corners[vertex].uv.to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, vertex: usize) {
        let polygon = &self.polygons[face];
        self.tangents[polygon.face][polygon.slots[vertex]] =
            space.map(|space| Vec4::from_array(space.tangent_encoded()));
    }
}

#[cfg(test)]
mod tests;
