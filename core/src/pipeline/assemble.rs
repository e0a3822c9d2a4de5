//! Converted materials to what is stored: drawn triangles with their coordinates, frames and cuts.

use std::sync::Arc;

use glam::Vec2;

use crate::asset::Asset;
use crate::finished::{
    Anchor, BlockClass, BlockTable, Coordinates, Finished, FinishedPrimitive, FinishedTriangle,
    PrimitiveCuts, TableLevel,
};
use crate::layout::{Class, ClassGrid, Layout, Page, TWIN_SHIFT};
use crate::mesh::{CanvasFace, CanvasMesh};
use crate::pack::{Packed, Spot};

use super::group::Group;
use super::material::MaterialConversion;

/// Takes the level images out of the conversions; everything else is read.
pub fn assemble(asset: &Asset, conversions: &mut [MaterialConversion], groups: &[Group]) -> Finished {
    let mut finished = Finished::default();
    for group in groups {
        let textures = Textures {
            first: finished.textures.len(),
            channel_count: conversions[group.members[0]].channels.len(),
            tables: group
                .packed
                .iter()
                .flat_map(|packed| &packed.pages)
                .map(|page| Arc::new(table(page)))
                .collect(),
        };
        finished.textures.extend(group.take_textures(conversions));
        for (number, &member) in group.members.iter().enumerate() {
            let conversion = &conversions[member];
            let naming = match &group.packed {
                None => Naming::Scaled(&conversion.layout),
                Some(packed) => {
                    Naming::Indexed { packed, spots: &packed.spots[number], tables: &textures.tables }
                }
            };
            finished.primitives.extend(primitives(asset, conversion, &naming, &textures));
        }
    }
    finished.primitives.sort_by_key(|piece| (piece.mesh, piece.primitive, piece.part));
    finished
}

/// A group's textures in [`Finished::textures`]: by part, and of each by channel.
struct Textures {
    first: usize,
    channel_count: usize,
    /// By part, with indexed coordinates.
    tables: Vec<Arc<BlockTable>>,
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

/// The material's primitives, part by part, with their triangles in the asset's order.
fn primitives(
    asset: &Asset,
    conversion: &MaterialConversion,
    naming: &Naming<'_>,
    textures: &Textures,
) -> Vec<FinishedPrimitive> {
    let mut places = drawn_places(&conversion.canvas);
    // Stable: the asset's order inside a part.
    places.sort_by_key(|place| (place.primitive, naming.part(place.canvas_face)));
    let key = |place: &DrawnPlace| (place.primitive, naming.part(place.canvas_face));
    let pieces = places.chunk_by(|a, b| key(a) == key(b));
    pieces.map(|places| primitive(asset, conversion, naming, textures, places)).collect()
}

/// The triangles of one primitive in one part.
fn primitive(
    asset: &Asset,
    conversion: &MaterialConversion,
    naming: &Naming<'_>,
    textures: &Textures,
    places: &[DrawnPlace],
) -> FinishedPrimitive {
    let (mesh, primitive) = (places[0].primitive.0 as usize, places[0].primitive.1 as usize);
    let part = naming.part(places[0].canvas_face);
    let texture = |channel: usize| textures.first + part * textures.channel_count + channel;
    let mut target = FinishedPrimitive {
        mesh,
        primitive,
        material: conversion.material,
        part,
        coordinates: naming.coordinates(part),
        triangles: Vec::with_capacity(places.len()),
        frames: Vec::new(),
        cuts: (0..conversion.channels.len())
            .map(|channel| PrimitiveCuts { texture: texture(channel), bits: Vec::new() })
            .collect(),
    };
    for place in places {
        let source = &asset.meshes[mesh].primitives[primitive].faces[place.face as usize];
        let number = place.canvas_face;
        target.triangles.push(FinishedTriangle {
            vertices: place.corners.map(|corner| source.corners[corner]),
            corners: naming.corners(number, place.canvas_corners),
            anchor: naming.anchor(number),
        });
        if let Some(frames) = &conversion.frames {
            target.frames.push(place.canvas_corners.map(|corner| frames.corners[number][corner]));
        }
        let face = &conversion.canvas.faces[number];
        for (cuts, channel) in target.cuts.iter_mut().zip(&conversion.channels) {
            let is_cut = |k: usize| {
                face.edge_between(place.canvas_corners[k], place.canvas_corners[(k + 1) % 3])
                    .is_some_and(|edge| channel.cuts.edges[edge as usize])
            };
            cuts.bits.push((0..3).map(|k| u8::from(is_cut(k)) << k).sum());
        }
    }
    target.cuts.retain(|cuts| cuts.bits.iter().any(|&bits| bits != 0));
    target
}

/// A class of a page in its table. Those with two triangles in a block come last.
fn in_table(page: &Page, class: u32) -> u32 {
    let first_of_two = page.classes.partition_point(|class| !class.has_two()) as u32;
    class + class.saturating_sub(first_of_two)
}

/// The table that finds blocks by their numbers. A class with two triangles in a block is two of the table's: the second for the
/// turned triangles of its blocks.
fn table(page: &Page) -> BlockTable {
    let shifts = |class: &Class| if class.has_two() { &[0, TWIN_SHIFT][..] } else { &[0] };
    let in_table = |class: &Class| {
        let class = *class;
        shifts(&class).iter().map(move |&shift| BlockClass {
            exponents: class.exponents,
            cells: class.cells,
            gap: [if class.has_two() { 1 + TWIN_SHIFT } else { 1 }, 1],
            shift: [shift, 0],
        })
    };
    let level = |grids: &Vec<ClassGrid>| {
        let all = || {
            (page.classes.iter().zip(grids)).flat_map(|(class, grid)| shifts(class).iter().map(move |_| grid))
        };
        TableLevel {
            columns: all().map(|grid| grid.columns).collect(),
            firsts: all().map(|grid| grid.first).collect(),
            origins: all().map(|grid| grid.origin).collect(),
        }
    };
    BlockTable {
        classes: page.classes.iter().flat_map(in_table).collect(),
        levels: page.grids.iter().map(level).collect(),
    }
}

/// How the faces of a material name texels.
enum Naming<'a> {
    Scaled(&'a Layout),
    Indexed {
        packed: &'a Packed,
        /// By face.
        spots: &'a [Spot],
        /// By part.
        tables: &'a [Arc<BlockTable>],
    },
}

impl Naming<'_> {
    fn part(&self, face: usize) -> usize {
        match self {
            Self::Scaled(layout) => layout.part(face),
            Self::Indexed { spots, .. } => spots[face].part as usize,
        }
    }

    fn coordinates(&self, part: usize) -> Coordinates {
        match self {
            Self::Scaled(_) => Coordinates::Scaled,
            Self::Indexed { tables, .. } => Coordinates::Indexed(tables[part].clone()),
        }
    }

    /// Of some corners of a face.
    fn corners(&self, face: usize, corners: [usize; 3]) -> [Vec2; 3] {
        corners.map(|corner| match self {
            Self::Scaled(layout) => layout.corner(face, corner),
            Self::Indexed { spots, .. } => {
                let [x, y] = spots[face].corners[corner];
                Vec2::new(x as f32, y as f32)
            }
        })
    }

    fn anchor(&self, face: usize) -> Anchor {
        match self {
            Self::Scaled(layout) => Anchor::Offset(layout.offset(face)),
            Self::Indexed { packed, spots, .. } => {
                let spot = &spots[face];
                let class = in_table(&packed.pages[spot.part as usize], spot.class);
                Anchor::Block { class: class + u32::from(spot.is_second), number: spot.number }
            }
        }
    }
}
