//! Ptex: a texture for each face of a mesh, without coordinates (B. Burley and D. Lacewell, "Ptex: Per-Face Texture Mapping for
//! Production Rendering", 2008; the file format's description, version 1.3r1).
//!
//! A file becomes an ordinary texture: an image with a chart for each face, and coordinates for each corner of each face. What a
//! chart holds is in [`quads`] and [`triangles`]; both make the function on the surface continuous.

mod atlas;
mod bytes;
mod channels;
mod faces;
mod header;
mod quads;
mod texels;
mod topology;
mod triangles;

#[cfg(test)]
pub(super) mod tests;

use glam::{Vec2, Vec4};
use rayon::prelude::*;

use super::Context;
use crate::error::{Error, Result};
use crate::image::{Image, Pixels, Values};
use crate::watch;

use atlas::Atlas;
use faces::FaceInfo;
use header::{DataType, File};
use quads::Quads;
use texels::Texels;
use topology::Topology;
use triangles::Triangles;

/// Of images that come from a Ptex file.
pub const MEDIA_TYPE: &str = "image/x-ptex";

/// What the texels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// 8 and 16 bits are sRGB codes.
    Color,
    /// Normals in frames that differ from face to face: faces are not joined.
    Normal,
}

/// The mesh's faces, each with as many corners as [`Head::corner_count`] says.
pub struct Mesh {
    /// By face and corner; equal where positions are.
    pub vertices: Vec<u32>,
    /// What each face shows; where there is none, they are the file's faces in its order.
    pub parts: Option<Vec<Part>>,
}

/// What a face of the mesh shows of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    pub face: usize,
    /// The whole, or the quarter at this corner, which is the part's corner 0.
    pub quarter: Option<usize>,
}

/// A Ptex file as a texture.
#[derive(Debug)]
pub struct Painted {
    pub image: Image,
    /// By face and corner, in glTF's convention.
    pub texcoords: Vec<Vec2>,
}

/// What the header says of the mesh that a file belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    pub face_count: usize,
    pub corner_count: usize,
}

pub fn is_ptex(bytes: &[u8]) -> bool {
    bytes.starts_with(b"Ptex")
}

/// # Errors
/// `InvalidModel` where the header is not one of a Ptex file, or names blocks that the file does not have.
pub fn head(bytes: &[u8]) -> Result<Head> {
    let header = header::split(bytes)?.header;
    Ok(Head { face_count: header.face_count, corner_count: header.corner_count() })
}

/// Reads a file for a mesh with as many faces as its [`Head`] says.
///
/// # Errors
/// `InvalidModel` where the file breaks its format's rules, `ImageTooLarge` and `ModelTooLarge` where it is over a limit, `Canceled`.
pub fn read(bytes: &[u8], mesh: Mesh, kind: Kind, place: &str, context: &mut Context<'_>) -> Result<Painted> {
    let file = header::split(bytes)?;
    let corner_count = file.header.corner_count();
    check_mesh(&file, &mesh)?;
    let limits = context.budget.limits;
    let warnings = &mut context.warnings;
    let stored = faces::read(&file, limits)?;
    let topology = Topology::new(corner_count, mesh.vertices);
    let faces = match &mesh.parts {
        None => {
            topology.compare(&stored, place, warnings);
            stored.clone()
        }
        Some(parts) => parts.iter().map(|part| stored[part.face].part(part.quarter)).collect(),
    };
    if file.has_edits {
        let detail =
            "edits that were appended to the file; they are left out: write the file anew to apply them";
        warnings.add("ptex_edits", place, detail);
    }
    let channels = channels::choose(&file.header, place, warnings);
    let charts: Vec<[u32; 2]> = faces.iter().map(|face| chart_size(&file, face)).collect();
    let atlas = atlas::place(&charts, limits)?;
    context.budget.take_pixels(u64::from(atlas.size[0]) * u64::from(atlas.size[1]))?;
    watch::check(context.watch)?;
    let is_color = kind == Kind::Color;
    let (mut texels, range) = Texels::read(&file, &stored, (&channels, is_color), limits, context.watch)?;
    if let Some(parts) = &mesh.parts {
        texels = texels.parts(&stored, parts);
    }
    range.warn(place, &mut context.warnings);
    watch::check(context.watch)?;
    let topology = match kind {
        Kind::Color => topology,
        Kind::Normal => Topology::apart(corner_count, faces.len()),
    };
    let values = paint(&file, &faces, &texels, &topology, &atlas);
    let components = channels.taken.len() as u8;
    let bits = if file.header.data == DataType::U8 { 8 } else { 16 };
    let texels_per_painted = if file.header.is_triangles { 1 } else { 2 };
    let [width, height] = atlas.size;
    let pixels = Pixels::F32(Values { values, bits, texels_per_painted, scale: None });
    let texcoords = texcoords(&file, &charts, &atlas);
    Ok(Painted { image: Image { width, height, components, pixels }, texcoords })
}

/// Whoever calls has counted.
fn check_mesh(file: &File<'_>, mesh: &Mesh) -> Result<()> {
    let (count, corner_count) = (file.header.face_count, file.header.corner_count());
    let is_one = match &mesh.parts {
        None => mesh.vertices.len() == count.saturating_mul(corner_count),
        Some(parts) => {
            mesh.vertices.len() == parts.len() * corner_count && parts.iter().all(|part| part.face < count)
        }
    };
    if is_one { Ok(()) } else { Err(Error::internal("a Ptex file's faces are not those of its mesh")) }
}

/// Texels of a face's chart along u and along v.
fn chart_size(file: &File<'_>, face: &FaceInfo) -> [u32; 2] {
    let halves = if file.header.is_triangles { 1 } else { 2 };
    face.size().map(|texels| halves * texels as u32 + 1)
}

/// The image's values. v points up in a chart.
fn paint(
    file: &File<'_>,
    faces: &[FaceInfo],
    texels: &Texels,
    topology: &Topology,
    atlas: &Atlas,
) -> Vec<f32> {
    let components = texels.components;
    let row_values = atlas.size[0] as usize * components;
    let mut values = vec![0.0; row_values * atlas.size[1] as usize];
    // Charts of one shelf begin in one row; the shelves are painted at once, chart by chart.
    let mut order: Vec<usize> = (0..faces.len()).collect();
    order.sort_by_key(|&face| (atlas.places[face][1], atlas.places[face][0]));
    let mut shelves = Vec::new();
    let mut rest = &mut values[..];
    let mut top = 0;
    let runs: Vec<&[usize]> = order.chunk_by(|&a, &b| atlas.places[a][1] == atlas.places[b][1]).collect();
    for (number, run) in runs.iter().enumerate() {
        let next = runs.get(number + 1).map_or(atlas.size[1], |run| atlas.places[run[0]][1]);
        let (shelf, others) = rest.split_at_mut((next - top) as usize * row_values);
        shelves.push((*run, shelf));
        (rest, top) = (others, next);
    }
    let put = |shelf: &mut [f32], [x, y]: [usize; 2], row: &mut dyn Iterator<Item = Vec4>| {
        let to = &mut shelf[y * row_values + x * components..];
        for (texel, value) in to.chunks_exact_mut(components).zip(row) {
            texel.copy_from_slice(&value.to_array()[..components]);
        }
    };
    if file.header.is_triangles {
        let triangles = Triangles { faces, texels, topology };
        let joints = triangles.joints();
        shelves.into_par_iter().for_each(|(run, shelf)| {
            for &face in run {
                let side = faces[face].size()[0] + 1;
                let chart = triangles.chart(&joints, face);
                for (j, row) in chart.chunks_exact(side).enumerate() {
                    let at = [atlas.places[face][0] as usize, side - 1 - j];
                    put(shelf, at, &mut row.iter().copied());
                }
            }
        });
    } else {
        let quads = Quads { faces, texels, topology };
        let joints = quads.joints();
        shelves.into_par_iter().for_each(|(run, shelf)| {
            for &face in run {
                let height = 2 * faces[face].size()[1];
                for q in 0..=height {
                    let at = [atlas.places[face][0] as usize, height - q];
                    put(shelf, at, &mut quads.row(&joints, face, q));
                }
            }
        });
    }
    values
}

/// Corners stand on the centers of the charts' outermost texels.
fn texcoords(file: &File<'_>, charts: &[[u32; 2]], atlas: &Atlas) -> Vec<Vec2> {
    let corners: &[[u32; 2]] =
        if file.header.is_triangles { &[[0, 1], [1, 1], [0, 0]] } else { &[[0, 1], [1, 1], [1, 0], [0, 0]] };
    let size = atlas.size.map(f64::from);
    let of_chart = |(chart, place): (&[u32; 2], &[u32; 2])| {
        let (chart, place) = (*chart, *place);
        corners.iter().map(move |corner| {
            let at = |axis: usize| f64::from(place[axis] + corner[axis] * (chart[axis] - 1)) + 0.5;
            Vec2::new((at(0) / size[0]) as f32, (at(1) / size[1]) as f32)
        })
    };
    charts.iter().zip(&atlas.places).flat_map(of_chart).collect()
}
