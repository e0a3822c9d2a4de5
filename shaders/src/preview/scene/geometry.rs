//! Corners as both renderers read them: one run of floats per primitive and instance, already in view
//! space, with the attributes that its surface asks for and no others.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3, Vec4};
use meshcolor::asset::{Primitive, Slot};
use meshcolor::finished::{Anchor, FinishedPrimitive, faces_of};
use meshcolor::source::tangents;

use super::painted::{PaintedPrimitive, PaintedTriangles};
use super::surface::{Coordinate, Surface};
use crate::twins::indexed::MctBlockTable;

/// Where a corner's attributes stand in its record, in floats. Position is at 0, normal at 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordLayout {
    pub stride: usize,
    /// Tangent with handedness, 4 floats.
    pub tangent: Option<usize>,
    /// `uv_set_count` times 2 floats.
    pub uv: usize,
    pub uv_set_count: usize,
    /// The mesh coordinate, 4 floats: scaled and offset, or local, number of the block and class.
    pub mesh: Option<usize>,
    /// Linear color with alpha, 4 floats.
    pub color: Option<usize>,
    /// The place in a face with mesh colors, 2 floats.
    pub painted: Option<usize>,
}

pub const NORMAL_AT: usize = 3;

impl RecordLayout {
    pub fn of(surface: &Surface) -> Self {
        let mut stride = 6;
        let mut take = |floats: usize| {
            stride += floats;
            stride - floats
        };
        let tangent = surface.binding(Slot::Normal).map(|_| take(4));
        let uv_set_count = surface.uv_sets.len();
        let uv = take(2 * uv_set_count);
        let mesh = surface.uses_mesh_coordinates().then(|| take(4));
        let color = surface.is_tinted.then(|| take(4));
        let painted = surface.painted.map(|_| take(2));
        Self { stride, tangent, uv, uv_set_count, mesh, color, painted }
    }
}

/// The drawn triangles of one primitive at one place.
pub struct Batch {
    pub surface: Surface,
    pub layout: RecordLayout,
    /// Of indexed coordinates.
    pub table: Option<Arc<MctBlockTable>>,
    /// Of a source with mesh colors.
    pub painted: PaintedTriangles,
    /// `3 * triangle_count` records. Fronts are counterclockwise.
    pub records: Vec<f32>,
}

impl Batch {
    pub fn triangle_count(&self) -> usize {
        self.records.len() / (3 * self.layout.stride)
    }

    /// The three records of a triangle.
    pub fn triangle(&self, number: usize) -> [&[f32]; 3] {
        let stride = self.layout.stride;
        std::array::from_fn(|corner| {
            let at = (3 * number + corner) * stride;
            &self.records[at..at + stride]
        })
    }
}

/// A primitive on its way into a batch.
pub struct BatchInput<'a> {
    pub primitive: &'a Primitive,
    /// Its coordinates; `None` on the source's side and for primitives that were not converted.
    pub finished: Option<&'a FinishedPrimitive>,
    /// The table of those, where they are indexed.
    pub table: Option<Arc<MctBlockTable>>,
    /// Of a source with mesh colors.
    pub painted: Option<PaintedPrimitive<'a>>,
    pub surface: Surface,
    /// Mesh space to view space.
    pub to_view: DAffine3,
    /// Triangles that lie wholly outside this box in view space are left out.
    pub keep: Option<[DVec3; 2]>,
}

/// The vertices of each drawn triangle, the same on both sides.
fn drawn_triangles(input: &BatchInput<'_>) -> Vec<[u32; 3]> {
    match input.finished {
        Some(finished) => finished.triangles.iter().map(|t| t.vertices).collect(),
        None => {
            let faces = input.primitive.faces.iter();
            faces.flat_map(|face| face.triangles().iter().map(|t| t.map(|c| face.corners[c]))).collect()
        }
    }
}

pub fn batch(input: BatchInput<'_>) -> Batch {
    let layout = RecordLayout::of(&input.surface);
    let triangles = drawn_triangles(&input);
    let positions: Vec<DVec3> =
        input.primitive.positions.iter().map(|p| input.to_view.transform_point3(p.as_dvec3())).collect();
    let frames = Frames::new(&input, &layout, &triangles);
    let colors = layout.color.and_then(|_| input.primitive.vertex_colors());
    let turn = Turn::new(input.to_view.matrix3);
    let places = input.painted.map(|painted| painted.places(input.primitive)).unwrap_or_default();
    let mut painted = PaintedTriangles::default();
    if input.painted.is_some() {
        painted.begin(input.to_view.matrix3);
    }
    let order = if turn.mirrors { [0, 2, 1] } else { [0, 1, 2] };
    let mut records = Vec::new();
    for (number, vertices) in triangles.iter().enumerate() {
        let at = vertices.map(|v| positions[v as usize]);
        if !input.keep.is_none_or(|keep| touches(&at, keep)) {
            continue;
        }
        let place = places.get(number).copied().flatten();
        place.iter().for_each(|place| painted.add(place));
        for corner in order {
            records.extend_from_slice(&at[corner].as_vec3().to_array());
            records.extend_from_slice(&turn.normal(frames.normal(number, corner)).to_array());
            if layout.tangent.is_some() {
                records.extend_from_slice(&turn.tangent(frames.tangent(number, corner)).to_array());
            }
            for set in &input.surface.uv_sets {
                let uvs = input.primitive.texcoords.get(set.texcoord);
                let uv = uvs.map_or(Vec2::ZERO, |uvs| uvs[vertices[corner] as usize]);
                records.extend_from_slice(&set.transform.apply(uv).to_array());
            }
            if let (Some(_), Some(finished)) = (layout.mesh, input.finished) {
                let triangle = &finished.triangles[number];
                records.extend_from_slice(&triangle.corners[corner].to_array());
                records.extend_from_slice(&match triangle.anchor {
                    Anchor::Offset(offset) => offset.to_array(),
                    Anchor::Block { class, number } => [number as f32, class as f32],
                });
            }
            if layout.color.is_some() {
                let color = colors.as_ref().map_or(Vec4::ONE, |colors| colors[vertices[corner] as usize]);
                records.extend_from_slice(&color.to_array());
            }
            if layout.painted.is_some() {
                let at = place.map_or(Vec2::ZERO, |place| place.corners[corner]);
                records.extend_from_slice(&at.to_array());
            }
        }
    }
    let table = input.table.filter(|_| layout.mesh.is_some());
    Batch { surface: input.surface, layout, table, painted, records }
}

fn touches(corners: &[DVec3; 3], [low, high]: [DVec3; 2]) -> bool {
    let least = corners[0].min(corners[1]).min(corners[2]);
    let most = corners[0].max(corners[1]).max(corners[2]);
    least.cmple(high).all() && most.cmpge(low).all()
}

/// Directions from mesh to view space.
pub struct Turn {
    matrix: DMat3,
    /// The cofactor matrix with the sign that keeps fronts in front: it turns normals, also where the
    /// matrix has no inverse.
    normal_matrix: DMat3,
    mirrors: bool,
}

impl Turn {
    pub fn new(matrix: DMat3) -> Self {
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let mirrors = matrix.determinant() < 0.0;
        let sign = if mirrors { -1.0 } else { 1.0 };
        let normal_matrix = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
        Self { matrix, normal_matrix, mirrors }
    }

    pub fn normal(&self, normal: Vec3) -> Vec3 {
        unit(self.normal_matrix * normal.as_dvec3(), DVec3::Z)
    }

    fn tangent(&self, tangent: Vec4) -> Vec4 {
        let handedness = if self.mirrors { -tangent.w } else { tangent.w };
        unit(self.matrix * tangent.truncate().as_dvec3(), DVec3::X).extend(handedness)
    }
}

fn unit(direction: DVec3, otherwise: DVec3) -> Vec3 {
    // Scaled first: matrices of tiny models would underflow the square of the length.
    let largest = direction.abs().max_element();
    if largest > 0.0 && largest.is_finite() {
        (direction / largest).normalize().as_vec3()
    } else {
        otherwise.as_vec3()
    }
}

/// The tangent frame of each drawn corner, in mesh space.
struct Frames<'a> {
    input: &'a Primitive,
    triangles: &'a [[u32; 3]],
    /// The converted side's own frames, where its normal map was converted.
    converted: Option<&'a FinishedPrimitive>,
    /// Normal of each triangle, where the source has no normals (glTF: flat shading).
    flat: Vec<Vec3>,
    /// Of each triangle's corners, where the source has no tangents and needs some.
    generated: Vec<[Vec4; 3]>,
}

impl<'a> Frames<'a> {
    fn new(input: &BatchInput<'a>, layout: &RecordLayout, triangles: &'a [[u32; 3]]) -> Self {
        let primitive = input.primitive;
        let normal_binding = input.surface.binding(Slot::Normal);
        let is_converted = normal_binding.is_some_and(|binding| binding.coordinate == Coordinate::Mesh);
        let converted = input.finished.filter(|f| is_converted && !f.frames.is_empty());
        let mut frames = Self { input: primitive, triangles, converted, flat: vec![], generated: vec![] };
        if primitive.normals.is_empty() && converted.is_none() {
            frames.flat = triangles.iter().map(|t| face_normal(primitive, t)).collect();
        }
        if layout.tangent.is_some() && converted.is_none() && primitive.tangents.is_empty() {
            let set = normal_binding.and_then(|binding| match binding.coordinate {
                Coordinate::Uv { set, .. } => input.surface.uv_sets.get(set),
                Coordinate::Mesh => None,
            });
            let (texcoord, transform) =
                set.map_or_else(Default::default, |set| (set.texcoord, set.transform));
            let by_face = tangents::frames(primitive, texcoord, transform);
            // A piece of a conversion may lack some of the faces.
            let faces = faces_of(primitive, triangles.iter().copied()).unwrap_or_default();
            frames.generated = (triangles.iter().zip(faces))
                .map(|(triangle, face)| {
                    let (face, frames) = (&primitive.faces[face as usize], &by_face[face as usize]);
                    triangle.map(|vertex| {
                        let corner = face.corners().iter().position(|own| *own == vertex);
                        frames[corner.unwrap_or(0)].tangent
                    })
                })
                .collect();
        }
        frames
    }

    fn normal(&self, triangle: usize, corner: usize) -> Vec3 {
        match self.converted {
            Some(finished) => finished.frames[triangle][corner].normal,
            None if self.flat.is_empty() => self.input.normals[self.triangles[triangle][corner] as usize],
            None => self.flat[triangle],
        }
    }

    fn tangent(&self, triangle: usize, corner: usize) -> Vec4 {
        match self.converted {
            Some(finished) => finished.frames[triangle][corner].tangent,
            None if self.generated.is_empty() => {
                self.input.tangents[self.triangles[triangle][corner] as usize]
            }
            None => self.generated[triangle][corner],
        }
    }
}

fn face_normal(primitive: &Primitive, vertices: &[u32; 3]) -> Vec3 {
    let [a, b, c] = vertices.map(|v| primitive.positions[v as usize].as_dvec3());
    unit((b - a).cross(c - a), DVec3::Z)
}
