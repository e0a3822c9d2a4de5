//! Converted materials to what is stored: drawn triangles with their coordinates, frames and cuts.

use crate::asset::Asset;
use crate::finished::{
    Anchor, Coordinates, Finished, FinishedPrimitive, FinishedTexture, FinishedTriangle, PrimitiveCuts,
};

use super::material::MaterialConversion;

/// Takes the level images out of the conversions; everything else is read.
pub fn assemble(asset: &Asset, materials: &mut [MaterialConversion]) -> Finished {
    let mut finished = Finished::default();
    for conversion in materials {
        let first_texture = finished.textures.len();
        for channel in &mut conversion.channels {
            finished.textures.push(FinishedTexture {
                material: conversion.material,
                slots: channel.slots.clone(),
                transfer: channel.transfer,
                levels: std::mem::take(&mut channel.levels),
                ranges: std::mem::take(&mut channel.ranges),
            });
        }
        finished.primitives.extend(primitives(asset, conversion, first_texture));
    }
    finished.primitives.sort_by_key(|primitive| (primitive.mesh, primitive.primitive));
    finished
}

/// The material's primitives in canvas order: faces of one primitive stand in a row.
fn primitives(
    asset: &Asset,
    conversion: &MaterialConversion,
    first_texture: usize,
) -> Vec<FinishedPrimitive> {
    let canvas = &conversion.canvas;
    let mut primitives: Vec<FinishedPrimitive> = Vec::new();
    for (number, face) in canvas.faces.iter().enumerate() {
        let (mesh, primitive) = (face.mesh as usize, face.primitive as usize);
        let is_new = primitives.last().is_none_or(|last| (last.mesh, last.primitive) != (mesh, primitive));
        if is_new {
            primitives.push(FinishedPrimitive {
                mesh,
                primitive,
                material: conversion.material,
                coordinates: Coordinates::Scaled,
                triangles: Vec::new(),
                frames: Vec::new(),
                cuts: (0..conversion.channels.len())
                    .map(|channel| PrimitiveCuts { texture: first_texture + channel, bits: Vec::new() })
                    .collect(),
            });
        }
        let Some(target) = primitives.last_mut() else { continue };
        let source = &asset.meshes[mesh].primitives[primitive].faces[face.face as usize];
        for corners in source.triangles() {
            target.triangles.push(FinishedTriangle {
                vertices: corners.map(|corner| source.corners[corner]),
                corners: corners.map(|corner| conversion.layout.scaled(number, corner)),
                anchor: Anchor::Offset(conversion.layout.offset(number)),
            });
            if let Some(frames) = &conversion.frames {
                target.frames.push(corners.map(|corner| frames.corners[number][corner]));
            }
            for (cuts, channel) in target.cuts.iter_mut().zip(&conversion.channels) {
                let is_cut = |k: usize| {
                    // A side of the drawn triangle is an edge of the face unless it is a quad's diagonal.
                    let (from, to) = (corners[k], corners[(k + 1) % 3]);
                    to == (from + 1) % face.count() && channel.cuts.edges[face.edges[from] as usize]
                };
                cuts.bits.push((0..3).map(|k| u8::from(is_cut(k)) << k).sum());
            }
        }
    }
    for primitive in &mut primitives {
        primitive.cuts.retain(|cuts| cuts.bits.iter().any(|&bits| bits != 0));
    }
    primitives
}
