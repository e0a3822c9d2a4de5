//! Vertex data: the distinct corners of a converted primitive, and accessors over tight or padded bytes.

use std::collections::HashMap;

use glam::{Vec2, Vec3};
use serde_json::{Value, json};

use crate::asset::Attribute;
use crate::finished::{Anchor, FinishedPrimitive, Frame};

use super::draft::Draft;

const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A vertex of a converted primitive.
#[derive(Clone, Copy)]
pub struct Corner {
    /// Vertex of the asset's primitive.
    pub vertex: u32,
    /// Its coordinate, and what that is told from.
    pub at: Vec2,
    pub anchor: Anchor,
    pub frame: Option<Frame>,
}

/// Distinct corners in the order of first use, and three indices for each triangle.
pub struct Corners {
    pub corners: Vec<Corner>,
    pub indices: Vec<u32>,
}

impl Corners {
    /// `firsts`: for each vertex of the source the one that is written for it.
    pub fn distinct(piece: &FinishedPrimitive, firsts: &[u32]) -> Self {
        let mut this = Self { corners: Vec::new(), indices: Vec::with_capacity(piece.triangles.len() * 3) };
        let mut numbers: HashMap<[u32; 12], u32> = HashMap::new();
        for (number, triangle) in piece.triangles.iter().enumerate() {
            for k in 0..3 {
                let corner = Corner {
                    vertex: firsts[triangle.vertices[k] as usize],
                    at: triangle.corners[k],
                    anchor: triangle.anchor,
                    frame: piece.frames.get(number).map(|frames| frames[k]),
                };
                let next = this.corners.len() as u32;
                let index = *numbers.entry(corner.key()).or_insert(next);
                if index == next {
                    this.corners.push(corner);
                }
                this.indices.push(index);
            }
        }
        this
    }

    pub fn vertices(&self) -> Vec<u32> {
        self.corners.iter().map(|corner| corner.vertex).collect()
    }
}

impl Corner {
    /// Bits, not values: a vertex is shared only where nothing at all differs.
    fn key(&self) -> [u32; 12] {
        let mut key = [0; 12];
        key[0] = self.vertex;
        // Coordinates of a primitive are all of one kind.
        let anchor = match self.anchor {
            Anchor::Offset(offset) => offset.to_array().map(f32::to_bits),
            Anchor::Block { class, number } => [class, number],
        };
        let frame = self.frame.map(|frame| (frame.normal.to_array(), frame.tangent.to_array()));
        let (normal, tangent) = frame.unwrap_or_default();
        let floats = self.at.to_array().into_iter().chain(normal).chain(tangent).map(f32::to_bits);
        for (slot, bits) in key[1..].iter_mut().zip(anchor.into_iter().chain(floats)) {
            *slot = bits;
        }
        key
    }
}

/// Adds a vertex attribute of floats.
pub fn add_floats<const N: usize>(draft: &mut Draft<'_>, values: &[[f32; N]]) -> usize {
    let bytes: Vec<u8> = values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let view = draft.add_view(bytes, Some(ARRAY_BUFFER), None);
    let kind = ["SCALAR", "SCALAR", "VEC2", "VEC3", "VEC4"][N.min(4)];
    add_accessor(
        draft,
        json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind
        }),
    )
}

/// Adds positions, with the bounds that glTF wants of them.
pub fn add_positions(draft: &mut Draft<'_>, positions: &[Vec3]) -> usize {
    let values: Vec<[f32; 3]> = positions.iter().map(Vec3::to_array).collect();
    let accessor = add_floats(draft, &values);
    let least = positions.iter().copied().reduce(Vec3::min).unwrap_or_default();
    let most = positions.iter().copied().reduce(Vec3::max).unwrap_or_default();
    draft.accessors[accessor]["min"] = floats(&least.to_array());
    draft.accessors[accessor]["max"] = floats(&most.to_array());
    accessor
}

/// Adds triangle indices, in 16 bits where they fit (65535 means primitive restart).
pub fn add_indices(draft: &mut Draft<'_>, indices: &[u32], vertex_count: usize) -> usize {
    let (component_type, bytes): (u32, Vec<u8>) = if vertex_count <= 65535 {
        (5123, indices.iter().flat_map(|index| (*index as u16).to_le_bytes()).collect())
    } else {
        (5125, indices.iter().flat_map(|index| index.to_le_bytes()).collect())
    };
    let view = draft.add_view(bytes, Some(ELEMENT_ARRAY_BUFFER), None);
    add_accessor(
        draft,
        json!({
            "bufferView": view, "componentType": component_type, "count": indices.len(), "type": "SCALAR"
        }),
    )
}

/// Adds one byte for each triangle, for the extension's own use.
pub fn add_bytes(draft: &mut Draft<'_>, bytes: &[u8]) -> usize {
    add_packed_bytes(draft, bytes, "SCALAR")
}

/// Adds elements of bytes, which are not vertices.
pub fn add_packed_bytes(draft: &mut Draft<'_>, bytes: &[u8], kind: &str) -> usize {
    add_packed(draft, bytes.to_vec(), (UNSIGNED_BYTE, kind), bytes.len())
}

/// Adds whole numbers, which are not vertices.
pub fn add_numbers(draft: &mut Draft<'_>, numbers: &[u32]) -> usize {
    let bytes = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    add_packed(draft, bytes, (UNSIGNED_INT, "SCALAR"), numbers.len())
}

/// Adds elements of floats, which are not vertices.
pub fn add_packed_floats(draft: &mut Draft<'_>, numbers: &[f32], kind: &str) -> usize {
    let bytes = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    add_packed(draft, bytes, (FLOAT, kind), numbers.len())
}

/// `number_count`: of all elements together.
fn add_packed(
    draft: &mut Draft<'_>,
    bytes: Vec<u8>,
    (component_type, kind): (u32, &str),
    number_count: usize,
) -> usize {
    let each = match kind {
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 1,
    };
    let view = draft.add_view(bytes, None, None);
    add_accessor(
        draft,
        json!({
            "bufferView": view, "componentType": component_type, "count": number_count / each, "type": kind
        }),
    )
}

/// Adds zeros without storing them.
pub fn add_zero_positions(draft: &mut Draft<'_>, count: usize) -> usize {
    let zero = floats(&[0.0; 3]);
    add_accessor(
        draft,
        json!({
            "componentType": FLOAT, "count": count, "type": "VEC3", "min": zero, "max": zero
        }),
    )
}

/// Adds all elements of an attribute.
pub fn add_whole(draft: &mut Draft<'_>, attribute: &Attribute) -> usize {
    let count = attribute.bytes.len() / attribute.element_bytes.max(1);
    let all: Vec<u32> = (0..count as u32).collect();
    add_run(draft, attribute, &[(attribute, &all)])
}

/// Adds an attribute's elements of the given vertices, each padded to four bytes. Runs are of one kind, each with an
/// attribute of its own; without runs nothing is added.
pub fn add_attribute(draft: &mut Draft<'_>, runs: &[(&Attribute, &[u32])]) -> Option<usize> {
    let (first, _) = runs.first()?;
    Some(add_run(draft, first, runs))
}

fn add_run(draft: &mut Draft<'_>, attribute: &Attribute, runs: &[(&Attribute, &[u32])]) -> usize {
    let size = attribute.element_bytes;
    let stride = size.div_ceil(4) * 4;
    let count: usize = runs.iter().map(|(_, vertices)| vertices.len()).sum();
    let mut bytes = Vec::with_capacity(count * stride);
    for (own, vertex) in
        runs.iter().flat_map(|(own, vertices)| vertices.iter().map(move |vertex| (own, vertex)))
    {
        let start = *vertex as usize * size;
        let element = own.bytes.get(start..start + size).unwrap_or_default();
        bytes.extend_from_slice(element);
        bytes.resize(bytes.len() + stride - element.len(), 0);
    }
    let bounds = (attribute.semantic == "POSITION").then(|| bounds(&bytes, stride, attribute));
    let view = draft.add_view(bytes, Some(ARRAY_BUFFER), (stride != size).then_some(stride));
    let mut accessor = json!({
        "bufferView": view,
        "componentType": attribute.component_type,
        "count": count,
        "type": attribute.kind,
    });
    if attribute.normalized {
        accessor["normalized"] = true.into();
    }
    if let Some((least, most)) = bounds {
        accessor["min"] = floats(&least);
        accessor["max"] = floats(&most);
    }
    add_accessor(draft, accessor)
}

/// Least and most stored value of three components.
fn bounds(bytes: &[u8], stride: usize, attribute: &Attribute) -> ([f32; 3], [f32; 3]) {
    let mut least = [f32::INFINITY; 3];
    let mut most = [f32::NEG_INFINITY; 3];
    for element in bytes.chunks_exact(stride.max(1)) {
        for k in 0..3 {
            let value = component(element, k, attribute.component_type);
            least[k] = least[k].min(value);
            most[k] = most[k].max(value);
        }
    }
    (least, most)
}

/// Component `k` of an element as stored (not scaled by `normalized`); 0 beyond its end.
fn component(element: &[u8], k: usize, component_type: u32) -> f32 {
    let bytes = |size: usize| element.get(k * size..(k + 1) * size).unwrap_or_default();
    match (component_type, bytes(1), bytes(2), bytes(4)) {
        (5120, [a], ..) => f32::from(*a as i8),
        (5121, [a], ..) => f32::from(*a),
        (5122, _, [a, b], _) => f32::from(i16::from_le_bytes([*a, *b])),
        (5123, _, [a, b], _) => f32::from(u16::from_le_bytes([*a, *b])),
        (5126, _, _, [a, b, c, d]) => f32::from_le_bytes([*a, *b, *c, *d]),
        _ => 0.0,
    }
}

fn floats(values: &[f32]) -> Value {
    values.iter().map(|value| f64::from(*value)).collect()
}

fn add_accessor(draft: &mut Draft<'_>, accessor: Value) -> usize {
    draft.accessors.push(accessor);
    draft.accessors.len() - 1
}
