//! 4D coordinates and frames from vertex attributes.

use glam::Vec2;

use crate::asset::Attribute;
use crate::error::Result;
use crate::finished::{FinishedTriangle, Frame};

use super::{OFFSET_ATTRIBUTE as OFFSET, Place, SCALED_ATTRIBUTE as SCALED, frame};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
/// Far beyond any texture, and small enough for whole texels to be exact in 32 bits.
const PLACE_MAX_TEXELS: f32 = 1e6;

/// The drawn triangles with their places.
pub fn triangles(place: &Place<'_>) -> Result<Vec<FinishedTriangle>> {
    let source = place.source();
    let scaled = Pairs::of(place, SCALED, &[FLOAT, UNSIGNED_SHORT])?;
    let offset = Pairs::of(place, OFFSET, &[FLOAT])?;
    let mut triangles = Vec::with_capacity(source.faces.len());
    for face in &source.faces {
        for corners in face.triangles() {
            let vertices = corners.map(|corner| face.corners[corner]);
            let number = triangles.len();
            let lie = |name: &str, rule: &str| {
                place.lie(&format!("/attributes/{name}"), format!("triangle {number}: {rule}"))
            };
            let at = |pairs: &Pairs<'_>, name: &str| -> Result<[Vec2; 3]> {
                let values = vertices.map(|vertex| pairs.get(vertex as usize));
                let sound = values.iter().all(|v| v.is_finite() && v.abs().max_element() <= PLACE_MAX_TEXELS);
                let rule = format!("every value has to be finite and within ±{PLACE_MAX_TEXELS} texels");
                if sound { Ok(values) } else { Err(lie(name, &rule)) }
            };
            let offsets = at(&offset, OFFSET)?;
            if offsets[1] != offsets[0] || offsets[2] != offsets[0] {
                return Err(lie(OFFSET, "the offset has to be the same at all three corners"));
            }
            let scaled = at(&scaled, SCALED)?;
            triangles.push(FinishedTriangle { vertices, scaled, offset: offsets[0] });
        }
    }
    Ok(triangles)
}

/// The frames of a primitive that has a converted normal map.
pub fn frames(place: &Place<'_>, triangles: &[FinishedTriangle]) -> Result<Vec<[Frame; 3]>> {
    let source = place.source();
    if source.normals.is_empty() || source.tangents.is_empty() {
        let rule = "a converted normal map needs the NORMAL and TANGENT that it was encoded in";
        return Err(place.lie("/attributes", rule));
    }
    let frame = |vertex: u32| {
        frame(source, vertex)
            .ok_or_else(|| place.lie("/attributes", "NORMAL and TANGENT have to be complete"))
    };
    triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.vertices;
            Ok([frame(a)?, frame(b)?, frame(c)?])
        })
        .collect()
}

/// A VEC2 attribute.
struct Pairs<'a>(&'a Attribute);

impl<'a> Pairs<'a> {
    fn of(place: &Place<'a>, name: &str, component_types: &[u32]) -> Result<Self> {
        let source = place.source();
        let attribute = source.attributes.iter().find(|attribute| attribute.semantic == name);
        let attribute = attribute.ok_or_else(|| {
            place.lie("/attributes", format!("{name} is missing, and the material has converted textures"))
        })?;
        let size = if attribute.component_type == FLOAT { 8 } else { 4 };
        let sound = attribute.kind == "VEC2"
            && component_types.contains(&attribute.component_type)
            && !attribute.normalized
            && attribute.element_bytes == size
            && attribute.bytes.len() == size * source.positions.len();
        if !sound {
            let types = if component_types.len() > 1 { "FLOAT or UNSIGNED_SHORT" } else { "FLOAT" };
            let rule = format!("it has to be VEC2 of {types}, not normalized, one for each vertex");
            return Err(place.lie(&format!("/attributes/{name}"), rule));
        }
        Ok(Self(attribute))
    }

    fn get(&self, vertex: usize) -> Vec2 {
        let start = vertex * self.0.element_bytes;
        match self.0.bytes.get(start..start + self.0.element_bytes) {
            Some([a, b, c, d]) => {
                Vec2::new(f32::from(u16::from_le_bytes([*a, *b])), f32::from(u16::from_le_bytes([*c, *d])))
            }
            Some([a, b, c, d, e, f, g, h]) => {
                Vec2::new(f32::from_le_bytes([*a, *b, *c, *d]), f32::from_le_bytes([*e, *f, *g, *h]))
            }
            // Vertices are in range by the asset's guarantee; a value that is refused above all the same.
            _ => Vec2::NAN,
        }
    }
}
