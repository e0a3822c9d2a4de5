//! Every face in four: a triangle by the middles of its edges, a quad by these and a point in its middle.

use std::collections::HashMap;

use crate::asset::{Face, Primitive};

use super::carry::Origin;
use super::geometry::{Parents, rebuilt};

/// How many faces become of one. The first ones have the corners of the face, in their order; a triangle's last lies in
/// the middle.
pub const PARTS: u32 = 4;
/// Of a triangle: the part in the middle.
pub const MIDDLE: u32 = 3;

/// Where the point in the middle of a quad lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Center {
    /// On the diagonal that it is drawn with, which keeps its shape.
    Diagonal,
    /// At the mean of its corners.
    Mean,
}

/// The primitive with every face in four; parts of face `f` are the faces from `PARTS f` on.
pub fn split(source: &Primitive, center: Center) -> Primitive {
    let mut parents: Vec<Parents> = (0..source.positions.len() as u32).map(|vertex| [vertex; 4]).collect();
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let mut faces = Vec::with_capacity(source.faces.len() * PARTS as usize);
    for face in &source.faces {
        let mut middle = |a: usize, b: usize| {
            let [a, b] = [face.corners[a], face.corners[b]];
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                parents.push([a, b, a, b]);
                parents.len() as u32 - 1
            })
        };
        let [a, b, c, d] = face.corners;
        if face.count == 3 {
            let [ab, bc, ca] = [middle(0, 1), middle(1, 2), middle(2, 0)];
            faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].map(Face::triangle));
        } else {
            let [ab, bc, cd, da] = [middle(0, 1), middle(1, 2), middle(2, 3), middle(3, 0)];
            let center = match center {
                Center::Diagonal => middle(0, 2),
                Center::Mean => {
                    parents.push([a, b, c, d]);
                    parents.len() as u32 - 1
                }
            };
            let quads = [[a, ab, center, da], [ab, b, bc, center], [center, bc, c, cd], [da, center, cd, d]];
            faces.extend(quads.map(Face::quad));
        }
    }
    Primitive { faces, ..rebuilt(source, &parents) }
}

/// Where the parts of a face lie in the old face that it lies in.
pub fn origins(origin: Origin, is_triangle: bool) -> [Origin; 4] {
    let [a, b, c, d] = origin.corners;
    let middle = |a: [u8; 2], b: [u8; 2]| [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
    let parts = if is_triangle {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca, ca], [ab, b, bc, bc], [ca, bc, c, c], [ab, bc, ca, ca]]
    } else {
        let [ab, bc, cd, da] = [middle(a, b), middle(b, c), middle(c, d), middle(d, a)];
        let center = middle(a, c);
        [[a, ab, center, da], [ab, b, bc, center], [center, bc, c, cd], [da, center, cd, d]]
    };
    parts.map(|corners| Origin { corners, ..origin })
}
