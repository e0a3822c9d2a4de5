//! Primitives with other vertices.

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use crate::asset::{Attribute, MorphTarget, Primitive};

const BYTE: u32 = 5120;
const UNSIGNED_BYTE: u32 = 5121;
const SHORT: u32 = 5122;
const UNSIGNED_SHORT: u32 = 5123;
const FLOAT: u32 = 5126;

/// Four vertices that a new one is the mean of. Of two each is named twice, first all, then all again.
pub type Parents = [u32; 4];

/// The primitive with the vertices that `parents` name, in their order; its faces are left out.
pub fn rebuilt(source: &Primitive, parents: &[Parents]) -> Primitive {
    // Two by two, so that the mean of two is the same from either side of an edge.
    let mean3 = |values: &[Vec3], p: &Parents| {
        let [a, b, c, d] = p.map(|vertex| values[vertex as usize]);
        ((a + b) + (c + d)) * 0.25
    };
    let unit = |value: Vec3, p: &Parents, first: Vec3| match is_copy(p) {
        true => first,
        false => value.try_normalize().unwrap_or(first),
    };
    let normal = |p: &Parents| unit(mean3(&source.normals, p), p, source.normals[p[0] as usize]);
    let tangent = |p: &Parents| {
        let [a, b, c, d] = p.map(|vertex| source.tangents[vertex as usize]);
        let mean: Vec4 = ((a + b) + (c + d)) * 0.25;
        unit(mean.xyz(), p, a.xyz()).extend(a.w)
    };
    let coordinates = |values: &Vec<Vec2>| {
        let mean = |p: &Parents| {
            let [a, b, c, d] = p.map(|vertex| values[vertex as usize]);
            ((a + b) + (c + d)) * 0.25
        };
        if values.is_empty() { Vec::new() } else { parents.iter().map(mean).collect() }
    };
    let all = |values: &[Attribute]| values.iter().map(|own| mean_attribute(own, parents)).collect();
    Primitive {
        material: source.material,
        positions: parents.iter().map(|p| mean3(&source.positions, p)).collect(),
        normals: if source.normals.is_empty() { Vec::new() } else { parents.iter().map(normal).collect() },
        tangents: if source.tangents.is_empty() { Vec::new() } else { parents.iter().map(tangent).collect() },
        texcoords: source.texcoords.iter().map(coordinates).collect(),
        attributes: all(&source.attributes),
        targets: source
            .targets
            .iter()
            .map(|target| MorphTarget { attributes: all(&target.attributes) })
            .collect(),
        faces: Vec::new(),
    }
}

fn is_copy(parents: &Parents) -> bool {
    parents.iter().all(|parent| *parent == parents[0])
}

/// Floats and normalized integers are averaged; other integers are names of something, and the first parent's is taken.
fn mean_attribute(source: &Attribute, parents: &[Parents]) -> Attribute {
    let size = source.element_bytes;
    let element = |vertex: u32| &source.bytes[vertex as usize * size..(vertex as usize + 1) * size];
    let mut bytes = Vec::with_capacity(parents.len() * size);
    for p in parents {
        if is_copy(p) || !(source.normalized || source.component_type == FLOAT) {
            bytes.extend_from_slice(element(p[0]));
            continue;
        }
        let component_bytes = match source.component_type {
            BYTE | UNSIGNED_BYTE => 1,
            SHORT | UNSIGNED_SHORT => 2,
            _ => 4,
        };
        for at in (0..size).step_by(component_bytes) {
            let own = p.map(|vertex| &element(vertex)[at..at + component_bytes]);
            bytes.extend(mean_component(source.component_type, own));
        }
    }
    Attribute { bytes, ..source.clone() }
}

fn mean_component(component_type: u32, own: [&[u8]; 4]) -> Vec<u8> {
    let whole = |decode: &dyn Fn(&[u8]) -> i32| {
        let sum: i32 = own.iter().map(|bytes| decode(bytes)).sum();
        // To the nearest, halves upwards.
        (sum + 2).div_euclid(4)
    };
    match component_type {
        BYTE => vec![whole(&|b| i32::from(b[0] as i8)) as u8],
        UNSIGNED_BYTE => vec![whole(&|b| i32::from(b[0])) as u8],
        SHORT => (whole(&|b| i32::from(i16::from_le_bytes([b[0], b[1]]))) as i16).to_le_bytes().to_vec(),
        UNSIGNED_SHORT => {
            (whole(&|b| i32::from(u16::from_le_bytes([b[0], b[1]]))) as u16).to_le_bytes().to_vec()
        }
        _ => {
            let [a, b, c, d] = own.map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            (((a + b) + (c + d)) * 0.25).to_le_bytes().to_vec()
        }
    }
}

/// Leaves out vertices that no face uses.
pub fn compacted(source: &Primitive) -> Primitive {
    let mut number = vec![u32::MAX; source.positions.len()];
    let mut parents = Vec::new();
    let mut faces = source.faces.clone();
    for corner in faces.iter_mut().flat_map(|face| &mut face.corners) {
        let slot = &mut number[*corner as usize];
        if *slot == u32::MAX {
            *slot = parents.len() as u32;
            parents.push([*corner; 4]);
        }
        *corner = *slot;
    }
    Primitive { faces, ..rebuilt(source, &parents) }
}
