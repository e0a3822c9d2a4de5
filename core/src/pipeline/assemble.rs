//! Converted materials to what is stored: drawn triangles with their coordinates, frames and cuts.

use std::sync::Arc;

use crate::asset::Asset;
use crate::finished::{
    Anchor, BlockClass, BlockTable, Coordinates, Finished, FinishedPrimitive, FinishedTexture,
    FinishedTriangle, PrimitiveCuts, TableLevel,
};
use crate::layout::{Class, ClassGrid, Layout, Place, TWIN_SHIFT};
use crate::mesh::{CanvasFace, CanvasMesh};

use super::material::MaterialConversion;

/// Takes the level images out of the conversions; everything else is read.
pub fn assemble(asset: &Asset, materials: &mut [MaterialConversion]) -> Finished {
    let mut finished = Finished::default();
    for conversion in materials {
        let first_texture = finished.textures.len();
        for channel in &mut conversion.channels {
            finished.textures.push(FinishedTexture {
                materials: vec![conversion.material],
                part: 0,
                slots: channel.slots.clone(),
                transfer: channel.transfer,
                levels: std::mem::take(&mut channel.levels),
                ranges: std::mem::take(&mut channel.ranges),
            });
        }
        finished.primitives.extend(primitives(asset, conversion, first_texture));
    }
    finished.primitives.sort_by_key(|piece| (piece.mesh, piece.primitive, piece.part));
    finished
}

/// A drawn triangle in the asset's order: its primitive, its face, and which of the face's triangles it is.
struct DrawnPlace {
    primitive: (u32, u32),
    face: u32,
    /// Corners of the asset's face.
    corners: [usize; 3],
    canvas_face: usize,
    /// Corners of the canvas' face.
    canvas_corners: [usize; 3],
}

/// The drawn triangles of the canvas, each with its corners in the order of the asset's.
fn drawn_places(canvas: &CanvasMesh) -> Vec<DrawnPlace> {
    let of_face = |(canvas_face, face): (usize, &CanvasFace)| {
        let face = *face;
        (face.drawn_corners().iter().zip(face.drawn)).map(move |(canvas_corners, drawn)| {
            let mut corners = drawn.corners.map(usize::from);
            let mut canvas_corners = *canvas_corners;
            if face.is_pair() {
                // A pair turns its triangles to where they meet, and over where they wind against each other.
                let order =
                    [0, 1, 2].map(|corner| corners.iter().position(|&own| own == corner).unwrap_or(0));
                corners = [0, 1, 2];
                canvas_corners = order.map(|k| canvas_corners[k]);
            }
            DrawnPlace {
                primitive: (face.mesh, drawn.primitive),
                face: drawn.face,
                corners,
                canvas_face,
                canvas_corners,
            }
        })
    };
    let mut places: Vec<DrawnPlace> = canvas.faces.iter().enumerate().flat_map(of_face).collect();
    places.sort_by_key(|place| (place.primitive, place.face));
    places
}

/// The material's primitives with their triangles in the asset's order.
fn primitives(
    asset: &Asset,
    conversion: &MaterialConversion,
    first_texture: usize,
) -> Vec<FinishedPrimitive> {
    let canvas = &conversion.canvas;
    let mut primitives: Vec<FinishedPrimitive> = Vec::new();
    let coordinates = coordinates(&conversion.layout);
    let places = drawn_places(canvas);
    for places in places.chunk_by(|a, b| a.primitive == b.primitive) {
        let (mesh, primitive) = (places[0].primitive.0 as usize, places[0].primitive.1 as usize);
        let mut target = FinishedPrimitive {
            mesh,
            primitive,
            material: conversion.material,
            part: 0,
            coordinates: coordinates.clone(),
            triangles: Vec::with_capacity(places.len()),
            frames: Vec::new(),
            cuts: (0..conversion.channels.len())
                .map(|channel| PrimitiveCuts { texture: first_texture + channel, bits: Vec::new() })
                .collect(),
        };
        for place in places {
            let source = &asset.meshes[mesh].primitives[primitive].faces[place.face as usize];
            let number = place.canvas_face;
            target.triangles.push(FinishedTriangle {
                vertices: place.corners.map(|corner| source.corners[corner]),
                corners: place.canvas_corners.map(|corner| conversion.layout.corner(number, corner)),
                anchor: anchor(&conversion.layout, number),
            });
            if let Some(frames) = &conversion.frames {
                target.frames.push(place.canvas_corners.map(|corner| frames.corners[number][corner]));
            }
            let face = &canvas.faces[number];
            for (cuts, channel) in target.cuts.iter_mut().zip(&conversion.channels) {
                let is_cut = |k: usize| {
                    face.edge_between(place.canvas_corners[k], place.canvas_corners[(k + 1) % 3])
                        .is_some_and(|edge| channel.cuts.edges[edge as usize])
                };
                cuts.bits.push((0..3).map(|k| u8::from(is_cut(k)) << k).sum());
            }
        }
        target.cuts.retain(|cuts| cuts.bits.iter().any(|&bits| bits != 0));
        primitives.push(target);
    }
    primitives
}

/// The table that finds blocks by their numbers, where the layout has one. A class of lone triangles is two of the
/// table's: the second for the turned triangles of its blocks.
fn coordinates(layout: &Layout) -> Coordinates {
    if layout.classes.is_empty() {
        return Coordinates::Scaled;
    }
    let shifts = |class: &Class| if class.is_lone { &[0, TWIN_SHIFT][..] } else { &[0] };
    let in_table = |class: &Class| {
        let class = *class;
        shifts(&class).iter().map(move |&shift| BlockClass {
            exponents: class.exponents,
            cells: [1, 1],
            gap: [if class.is_lone { 1 + TWIN_SHIFT } else { 1 }, 1],
            shift: [shift, 0],
        })
    };
    let level = |grids: &Vec<ClassGrid>| {
        let all = || {
            (layout.classes.iter().zip(grids))
                .flat_map(|(class, grid)| shifts(class).iter().map(move |_| grid))
        };
        TableLevel {
            columns: all().map(|grid| grid.columns).collect(),
            firsts: all().map(|grid| grid.first).collect(),
            origins: all().map(|grid| grid.origin).collect(),
        }
    };
    Coordinates::Indexed(Arc::new(BlockTable {
        classes: layout.classes.iter().flat_map(in_table).collect(),
        levels: layout.grids.iter().map(level).collect(),
    }))
}

fn anchor(layout: &Layout, face: usize) -> Anchor {
    match layout.block(face).place {
        Place::Scaled { .. } => Anchor::Offset(layout.offset(face)),
        Place::Indexed { class, number } => {
            let lone_before =
                layout.classes[..class as usize].iter().filter(|class| class.is_lone).count() as u32;
            let is_second = layout.placements[face].shift > 0;
            Anchor::Block { class: class + lone_before + u32::from(is_second), number }
        }
    }
}
