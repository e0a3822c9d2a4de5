//! Coordinates of both kinds, and frames, from vertex attributes.

use std::sync::Arc;

use glam::Vec2;

use crate::asset::Attribute;
use crate::error::{Error, Result};
use crate::finished::{Anchor, Coordinates, FinishedTriangle, Frame};

use super::{
    BLOCK_ATTRIBUTE as BLOCK, LOCAL_ATTRIBUTE as LOCAL, OFFSET_ATTRIBUTE as OFFSET, Place,
    SCALED_ATTRIBUTE as SCALED, frame, table,
};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_BYTE: u32 = 5121;
/// Far beyond any texture, and small enough for whole texels to be exact in 32 bits.
const PLACE_MAX_TEXELS: f32 = 1e6;
/// Whole numbers up to here are told apart in 32 bits.
const WHOLE_MAX: f32 = 16_777_216.0;

/// The drawn triangles with their coordinates; those are indexed where the primitive has a table.
pub fn of(place: &Place<'_>) -> Result<(Coordinates, Vec<FinishedTriangle>)> {
    match table::of(place)? {
        None => Ok((Coordinates::Scaled, scaled(place)?)),
        Some(table) => Ok((Coordinates::Indexed(Arc::new(table)), indexed(place)?)),
    }
}

fn scaled(place: &Place<'_>) -> Result<Vec<FinishedTriangle>> {
    let scaled = Pairs::of(place, SCALED, &[FLOAT, UNSIGNED_SHORT])?;
    let offset = Pairs::of(place, OFFSET, &[FLOAT])?;
    let rule = format!("every value has to be finite and within ±{PLACE_MAX_TEXELS} texels");
    let at = |drawn: &Drawn<'_>, pairs: &Pairs<'_>, name: &str| -> Result<[Vec2; 3]> {
        let values = drawn.of(pairs);
        let sound = values.iter().all(|v| v.is_finite() && v.abs().max_element() <= PLACE_MAX_TEXELS);
        if sound { Ok(values) } else { Err(drawn.lie(name, &rule)) }
    };
    each_triangle(place, |drawn| {
        let offsets = at(&drawn, &offset, OFFSET)?;
        if offsets[1] != offsets[0] || offsets[2] != offsets[0] {
            return Err(drawn.lie(OFFSET, "the offset has to be the same at all three corners"));
        }
        Ok((at(&drawn, &scaled, SCALED)?, Anchor::Offset(offsets[0])))
    })
}

/// Whether the values fit the table is checked later.
fn indexed(place: &Place<'_>) -> Result<Vec<FinishedTriangle>> {
    let block = Pairs::of(place, BLOCK, &[FLOAT])?;
    let local = Pairs::of(place, LOCAL, &[FLOAT, UNSIGNED_BYTE, UNSIGNED_SHORT])?;
    each_triangle(place, |drawn| {
        let blocks = drawn.of(&block);
        let [number, class] = blocks[0].to_array();
        // Beyond 32 bits `as` would saturate.
        let is_whole = |value: f32| value.fract() == 0.0 && (0.0..=WHOLE_MAX).contains(&value);
        if !is_whole(number) || !is_whole(class) {
            return Err(drawn.lie(BLOCK, "number and class have to be whole numbers from 0 on"));
        }
        if blocks[1] != blocks[0] || blocks[2] != blocks[0] {
            return Err(drawn.lie(BLOCK, "number and class have to be the same at all three corners"));
        }
        Ok((drawn.of(&local), Anchor::Block { class: class as u32, number: number as u32 }))
    })
}

/// A triangle on its way: its place in the file, its number and its vertices.
struct Drawn<'a> {
    place: &'a Place<'a>,
    triangle: usize,
    vertices: [u32; 3],
}

impl Drawn<'_> {
    fn of(&self, pairs: &Pairs<'_>) -> [Vec2; 3] {
        self.vertices.map(|vertex| pairs.get(vertex as usize))
    }

    fn lie(&self, name: &str, rule: &str) -> Error {
        self.place.lie(&format!("/attributes/{name}"), format!("triangle {}: {rule}", self.triangle))
    }
}

fn each_triangle(
    place: &Place<'_>,
    coordinates: impl Fn(Drawn<'_>) -> Result<([Vec2; 3], Anchor)>,
) -> Result<Vec<FinishedTriangle>> {
    let faces = place.source().faces.iter();
    let drawn = faces.flat_map(|face| face.triangles().iter().map(|c| c.map(|corner| face.corners[corner])));
    drawn
        .enumerate()
        .map(|(triangle, vertices)| {
            let (corners, anchor) = coordinates(Drawn { place, triangle, vertices })?;
            Ok(FinishedTriangle { vertices, corners, anchor })
        })
        .collect()
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
        let size = element_bytes(attribute.component_type);
        let sound = attribute.kind == "VEC2"
            && component_types.contains(&attribute.component_type)
            && !attribute.normalized
            && attribute.element_bytes == size
            && attribute.bytes.len() == size * source.positions.len();
        if !sound {
            let types: Vec<&str> = component_types.iter().map(|&of| type_name(of)).collect();
            let rule =
                format!("it has to be VEC2 of {}, not normalized, one for each vertex", types.join(" or "));
            return Err(place.lie(&format!("/attributes/{name}"), rule));
        }
        Ok(Self(attribute))
    }

    fn get(&self, vertex: usize) -> Vec2 {
        let start = vertex * self.0.element_bytes;
        match self.0.bytes.get(start..start + self.0.element_bytes) {
            Some([a, b]) => Vec2::new(f32::from(*a), f32::from(*b)),
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

/// Of two components, tight.
fn element_bytes(component_type: u32) -> usize {
    match component_type {
        UNSIGNED_BYTE => 2,
        UNSIGNED_SHORT => 4,
        _ => 8,
    }
}

fn type_name(component_type: u32) -> &'static str {
    match component_type {
        UNSIGNED_BYTE => "UNSIGNED_BYTE",
        UNSIGNED_SHORT => "UNSIGNED_SHORT",
        _ => "FLOAT",
    }
}
