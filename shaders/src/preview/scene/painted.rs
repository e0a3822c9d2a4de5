//! A source with mesh colors: where the triangles of a batch stand among them. Such batches are drawn on the CPU alone, by
//! the filters of mesh colors themselves ([`meshcolor::filter`]).

use glam::{DMat3, Vec3};
use meshcolor::asset::{Asset, Face, Primitive};
use meshcolor::source::painted::{DrawnPlace, PaintedSource};

use super::geometry::Turn;
use crate::preview::PreviewError;

/// A primitive whose material has mesh colors.
#[derive(Clone, Copy)]
pub struct PaintedPrimitive<'a> {
    pub source: &'a PaintedSource<'a>,
    /// Mesh, and primitive of the mesh.
    pub place: [usize; 2],
}

impl PaintedPrimitive<'_> {
    /// Where the triangles stand that the primitive's faces are drawn as, in their order.
    pub fn places(&self, primitive: &Primitive) -> Vec<Option<DrawnPlace>> {
        let [mesh, number] = self.place;
        let faces = primitive.faces.iter().enumerate();
        let of_face = |(face, of): (usize, &Face)| {
            of.triangles().iter().map(move |corners| self.source.place([mesh, number, face], *corners))
        };
        faces.flat_map(of_face).collect()
    }
}

/// What a batch of such primitives has beside its records, by triangle.
#[derive(Default)]
pub struct PaintedTriangles {
    /// The face, and which of `turns`.
    faces: Vec<[u32; 2]>,
    /// Mesh space to view space, one for each primitive and instance.
    turns: Vec<Turn>,
}

impl PaintedTriangles {
    /// Triangles to come turn as this matrix does.
    pub fn begin(&mut self, to_view: DMat3) {
        self.turns.push(Turn::new(to_view));
    }

    pub fn add(&mut self, place: &DrawnPlace) {
        self.faces.push([place.face, self.turns.len() as u32 - 1]);
    }

    pub fn extend(&mut self, other: Self) {
        let before = self.turns.len() as u32;
        self.faces.extend(other.faces.into_iter().map(|[face, turn]| [face, turn + before]));
        self.turns.extend(other.turns);
    }

    /// Of the source's canvas.
    pub fn face(&self, triangle: usize) -> usize {
        self.faces[triangle][0] as usize
    }

    /// A normal in the mesh's space as the camera sees it, unit length.
    pub fn normal(&self, triangle: usize, normal: Vec3) -> Vec3 {
        self.turns[self.faces[triangle][1] as usize].normal(normal)
    }
}

/// Whether every face of a material with mesh colors has its place among them.
///
/// # Errors
/// `Inconsistent`, naming the first that has none.
pub fn check(asset: &Asset, painted: &[PaintedSource<'_>]) -> Result<(), PreviewError> {
    for (mesh, content) in asset.meshes.iter().enumerate() {
        for (number, primitive) in content.primitives.iter().enumerate() {
            let Some(source) = source_of(painted, primitive.material) else { continue };
            let places = PaintedPrimitive { source, place: [mesh, number] }.places(primitive);
            if let Some(lost) = places.iter().position(Option::is_none) {
                return Err(PreviewError::Inconsistent(format!(
                    "triangle {lost} of primitive {number} of mesh {mesh} has no place among its mesh colors"
                )));
            }
        }
    }
    Ok(())
}

/// The mesh colors of a material, if it has any.
pub fn source_of<'a>(
    painted: &'a [PaintedSource<'a>],
    material: Option<usize>,
) -> Option<&'a PaintedSource<'a>> {
    painted.iter().find(|source| Some(source.material) == material)
}
