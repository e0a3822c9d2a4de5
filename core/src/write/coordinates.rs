//! The coordinates of a converted primitive: its vertex attributes, and the table of indexed ones.

use glam::Vec2;
use serde_json::{Map, Value, json};

use super::draft::Draft;
use super::vertices::{self, Corner};
use crate::asset::Attribute;
use crate::finished::{
    Anchor, BLOCK_ATTRIBUTE, BlockClass, BlockTable, Coordinates, LOCAL_ATTRIBUTE, OFFSET_ATTRIBUTE,
    SCALED_ATTRIBUTE, TableLevel,
};

const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;

/// What a loader without the extension samples: places at level 0 over its size.
pub fn texcoords(coordinates: &Coordinates, corners: &[Corner], size: Vec2) -> Vec<[f32; 2]> {
    let place = |corner: &Corner| coordinates.map(corner.anchor, 0).place(corner.at) / size;
    corners.iter().map(|corner| place(corner).to_array()).collect()
}

/// Adds the extension's own attributes.
pub fn add(draft: &mut Draft<'_>, corners: &[Corner], attributes: &mut Map<String, Value>) {
    let anchors: Vec<[f32; 2]> = corners.iter().map(|corner| anchor(corner.anchor)).collect();
    let (names, at) = match corners.first().map(|corner| corner.anchor) {
        Some(Anchor::Block { .. }) => ([LOCAL_ATTRIBUTE, BLOCK_ATTRIBUTE], local(draft, corners)),
        _ => {
            let scaled: Vec<_> = corners.iter().map(|corner| corner.at.to_array()).collect();
            ([SCALED_ATTRIBUTE, OFFSET_ATTRIBUTE], vertices::add_floats(draft, &scaled))
        }
    };
    let anchors = vertices::add_floats(draft, &anchors);
    for (name, accessor) in names.into_iter().zip([at, anchors]) {
        attributes.insert(name.to_owned(), accessor.into());
    }
}

fn anchor(anchor: Anchor) -> [f32; 2] {
    match anchor {
        Anchor::Offset(offset) => offset.to_array(),
        // Checked before anything is written: both are exact.
        Anchor::Block { class, number } => [number as f32, class as f32],
    }
}

/// Local coordinates in the smallest type that holds them.
fn local(draft: &mut Draft<'_>, corners: &[Corner]) -> usize {
    let is_whole_up_to = |most: u16| {
        let mut values = corners.iter().flat_map(|corner| corner.at.to_array());
        values.all(|value| value.fract() == 0.0 && (0.0..=f32::from(most)).contains(&value))
    };
    let values = corners.iter().flat_map(|corner| corner.at.to_array());
    let (component_type, bytes): (u32, Vec<u8>) = if is_whole_up_to(u8::MAX.into()) {
        (UNSIGNED_BYTE, values.map(|value| value as u8).collect())
    } else if is_whole_up_to(u16::MAX) {
        (UNSIGNED_SHORT, values.flat_map(|value| (value as u16).to_le_bytes()).collect())
    } else {
        let values: Vec<_> = corners.iter().map(|corner| corner.at.to_array()).collect();
        return vertices::add_floats(draft, &values);
    };
    let element_bytes = if component_type == UNSIGNED_BYTE { 2 } else { 4 };
    let attribute = Attribute {
        semantic: LOCAL_ATTRIBUTE.to_owned(),
        component_type,
        kind: "VEC2".to_owned(),
        normalized: false,
        element_bytes,
        bytes,
    };
    vertices::add_whole(draft, &attribute)
}

/// The table as it stands in the primitive's extension.
pub fn table(table: &BlockTable) -> Value {
    let class = |class: &BlockClass| {
        let BlockClass { exponents: [r, s], cells, gap, shift } = class;
        json!({ "r": r, "s": s, "cells": cells, "gap": gap, "shift": shift })
    };
    let level = |TableLevel { columns, firsts, origins }: &TableLevel| json!({ "columns": columns, "first": firsts, "origin": origins });
    json!({
        "classes": table.classes.iter().map(class).collect::<Vec<_>>(),
        "levels": table.levels.iter().map(level).collect::<Vec<_>>(),
    })
}
