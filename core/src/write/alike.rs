//! Vertices of a source that differ in nothing which is written: what only told the charts of a texture
//! apart does not keep corners apart any more.

use std::collections::HashMap;

use crate::asset::{Primitive, VERTEX_COLORS};

/// What is written of a source's vertices besides positions, further attributes and morph targets.
pub struct Kept<'a> {
    pub normals: bool,
    pub tangents: bool,
    pub colors: bool,
    /// Sets of texture coordinates.
    pub sets: &'a [usize],
}

/// For each vertex that is used the first of them that is written with the same bits; others stand for themselves.
pub fn firsts(source: &Primitive, kept: &Kept<'_>, used: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut known: HashMap<Vec<u8>, u32> = HashMap::new();
    let mut firsts: Vec<u32> = (0..source.positions.len() as u32).collect();
    let mut is_done = vec![false; firsts.len()];
    for vertex in used {
        if !std::mem::replace(&mut is_done[vertex as usize], true) {
            let first = *known.entry(bytes(source, kept, vertex as usize)).or_insert(vertex);
            firsts[vertex as usize] = first;
        }
    }
    firsts
}

/// Everything of a vertex that is written. What the primitive lacks adds nothing to any.
fn bytes(source: &Primitive, kept: &Kept<'_>, vertex: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut add = |values: Option<&[f32]>| {
        bytes.extend(values.into_iter().flatten().flat_map(|value| value.to_le_bytes()));
    };
    add(source.positions.get(vertex).map(|value| value.as_ref().as_slice()));
    add(source.normals.get(vertex).filter(|_| kept.normals).map(|value| value.as_ref().as_slice()));
    add(source.tangents.get(vertex).filter(|_| kept.tangents).map(|value| value.as_ref().as_slice()));
    for set in kept.sets {
        let values = source.texcoords.get(*set);
        add(values.and_then(|values| values.get(vertex)).map(|value| value.as_ref().as_slice()));
    }
    let targets = source.targets.iter().flat_map(|target| &target.attributes);
    let own = source.attributes.iter().filter(|own| kept.colors || own.semantic != VERTEX_COLORS);
    for attribute in own.chain(targets) {
        let start = vertex * attribute.element_bytes;
        let element = attribute.bytes.get(start..start + attribute.element_bytes);
        bytes.extend_from_slice(element.unwrap_or_default());
    }
    bytes
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3, Vec4};

    use super::*;
    use crate::asset::{Attribute, MorphTarget};

    /// Four vertices at one place.
    fn primitive() -> Primitive {
        Primitive {
            positions: vec![Vec3::ONE; 4],
            normals: vec![Vec3::Z; 4],
            tangents: vec![Vec4::X; 4],
            texcoords: vec![vec![Vec2::ZERO; 4], vec![Vec2::ZERO; 4]],
            ..Primitive::default()
        }
    }

    fn attribute(semantic: &str, bytes: [u8; 4]) -> Attribute {
        Attribute {
            semantic: semantic.to_owned(),
            component_type: 5121,
            kind: "SCALAR".to_owned(),
            normalized: false,
            element_bytes: 1,
            bytes: bytes.to_vec(),
        }
    }

    #[test]
    fn vertices_are_alike_that_differ_in_nothing_written() {
        let all = Kept { normals: true, tangents: true, colors: true, sets: &[0, 1] };
        let none = Kept { normals: false, tangents: false, colors: false, sets: &[] };
        assert_eq!(firsts(&primitive(), &all, 0..4), [0; 4]);
        type Change = fn(&mut Primitive);
        let optional: [Change; 4] = [
            |p| p.normals[2] = Vec3::X,
            |p| p.tangents[2] = Vec4::Y,
            |p| p.texcoords[1][2] = Vec2::X,
            |p| p.attributes.push(attribute(VERTEX_COLORS, [7, 7, 8, 7])),
        ];
        for change in optional {
            let mut changed = primitive();
            change(&mut changed);
            assert_eq!(firsts(&changed, &all, 0..4), [0, 0, 2, 0]);
            assert_eq!(firsts(&changed, &none, 0..4), [0; 4]);
        }
        let written: [Change; 3] = [
            |p| p.positions[2] = Vec3::X,
            |p| p.attributes.push(attribute("_WEAR", [7, 7, 8, 7])),
            |p| p.targets.push(MorphTarget { attributes: vec![attribute("_WEAR", [7, 7, 8, 7])] }),
        ];
        for change in written {
            let mut changed = primitive();
            change(&mut changed);
            assert_eq!(firsts(&changed, &none, 0..4), [0, 0, 2, 0]);
        }
    }
}
