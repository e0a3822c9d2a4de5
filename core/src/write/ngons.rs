//! `FB_ngon_encoding` in converted files: it stays where the written triangles still say which polygons the source has.
//!
//! By its rule triangles in a row that begin with one vertex are one polygon. A quad's two triangles share the vertex of its first
//! corner here too. Those of a larger polygon are faces of their own, whose corners mostly become vertices of their own;
//! then the extension has to go.

use serde_json::{Value, json};

use crate::asset::{NGON_EXTENSION, Primitive};
use crate::finished::faces_of;

use super::draft::{Draft, at, member, object, remove_extension};
use super::geometry::Member;

/// What a mesh says of all of its primitives becomes what each of them says.
pub fn mark_primitives(draft: &mut Draft<'_>, mesh: usize) {
    let json = object(at(&mut draft.meshes, mesh));
    let own = json.get("extensions").and_then(|extensions| extensions.get(NGON_EXTENSION));
    if own.is_none() {
        return;
    }
    remove_extension(json, NGON_EXTENSION);
    for primitive in draft.primitives(mesh) {
        let primitive = object(primitive);
        let is_list = primitive.get("mode").and_then(Value::as_u64).is_none_or(|mode| mode == 4);
        if is_list {
            member(primitive, "extensions").insert(NGON_EXTENSION.to_owned(), json!({}));
        }
    }
}

/// By face of a primitive: its polygon.
fn polygons(source: &Primitive) -> Vec<usize> {
    let runs = source.faces.chunk_by(|one, next| one.corners[0] == next.corners[0]);
    runs.enumerate().flat_map(|(polygon, run)| vec![polygon; run.len()]).collect()
}

/// `indices`: three for each triangle of the member's piece.
pub fn are_kept(member: &Member<'_>, indices: &[u32]) -> bool {
    let Member { source, piece, .. } = member;
    let Some(faces) = faces_of(source, piece.triangles.iter().map(|triangle| triangle.vertices)) else {
        return false;
    };
    let polygons = polygons(source);
    let mut missing = vec![0i64; polygons.len()];
    for (face, polygon) in source.faces.iter().zip(&polygons) {
        missing[*polygon] += face.triangles().len() as i64;
    }
    let own: Vec<usize> = faces.iter().map(|face| polygons[*face as usize]).collect();
    own.iter().for_each(|polygon| missing[*polygon] -= 1);
    let firsts: Vec<u32> = indices.iter().step_by(3).copied().collect();
    let is_told = (own.windows(2).zip(firsts.windows(2)))
        .all(|(own, first)| (own[0] == own[1]) == (first[0] == first[1]));
    is_told && own.iter().all(|polygon| missing[*polygon] == 0)
}
