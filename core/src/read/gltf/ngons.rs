//! `FB_ngon_encoding`: triangles in a row that begin with the same vertex are one polygon.
//!
//! The extension holds nothing; it only says that the order of triangles and of their corners has this meaning. Two such
//! triangles are a quad of ours. Polygons of five corners and more stay the triangles that they are drawn as.

use glam::Vec3;

use super::super::geometry;
use super::super::json::At;
use super::super::warnings::Warnings;
use crate::asset::{Face, NGON_EXTENSION, Primitive};
use crate::error::Result;

const NOT_A_FAN: &str = "two triangles in a row begin with one vertex, as those of a quad do, but are not a b c and a c d of four \
                         vertices, neighbors in different places; they stay two triangles";

/// Whether a primitive, or a mesh for all of its primitives, has the extension.
pub(super) fn is_marked(holder: &At) -> Result<bool> {
    match holder.object("extensions")? {
        Some(extensions) => Ok(extensions.object(NGON_EXTENSION)?.is_some()),
        None => Ok(false),
    }
}

/// Joins the triangles of quads. Faces are the triangles of a list, in its order.
pub(super) fn join_quads(primitive: &mut Primitive, pointer: &str, warnings: &mut Warnings) {
    let Primitive { faces, positions, .. } = primitive;
    let mut joined = Vec::with_capacity(faces.len());
    let mut broken_count = 0;
    for polygon in faces.chunk_by(|one, next| one.corners[0] == next.corners[0]) {
        match polygon {
            [one, other] => match quad(one, other, positions) {
                Some(quad) => joined.push(quad),
                None => {
                    broken_count += 1;
                    joined.extend_from_slice(polygon);
                }
            },
            _ => joined.extend_from_slice(polygon),
        }
    }
    *faces = joined;
    warnings.add_many("ngon_not_a_fan", pointer, NOT_A_FAN, broken_count);
}

fn quad(one: &Face, other: &Face, positions: &[Vec3]) -> Option<Face> {
    let ([a, b, c, _], [_, e, d, _]) = (one.corners, other.corners);
    let are_distinct = a != b && a != c && a != d && b != c && b != d && c != d;
    let corners = [a, b, c, d];
    let is_quad = c == e
        && are_distinct
        && !geometry::has_side_without_length(corners.map(|corner| positions[corner as usize]));
    is_quad.then(|| Face::quad(corners))
}
