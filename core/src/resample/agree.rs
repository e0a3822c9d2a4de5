//! Whole exponents that neighbors agree on.
//!
//! Faces of one shape can stand in one block, and an edge has no more samples than the coarser of its faces. So where an
//! exponent is about half way between two whole ones, the one that more neighbors have is taken.

use crate::colors::Resolutions;
use crate::mesh::CanvasMesh;

use super::resolution::{WantedExponents, nearest};

/// An exponent is free to go up or down where it is so near to the middle.
const FREE: f32 = 0.25;
/// Times that all faces look at their neighbors.
const SWEEPS: usize = 4;

impl WantedExponents {
    /// The nearest exponents, but of quads those half way ones that agree with most neighbors. `joinable`: by canvas
    /// edge whether the two faces of it could stand in one block.
    pub fn agreeing(&self, canvas: &CanvasMesh, joinable: &[bool]) -> Resolutions {
        let mut resolutions = self.nearest();
        for _ in 0..SWEEPS {
            let mut is_changed = false;
            for (face, &wanted) in self.faces.iter().enumerate() {
                if canvas.faces[face].is_triangle() || !wanted.iter().any(|&exponent| is_free(exponent)) {
                    continue;
                }
                let best = best(canvas, joinable, &resolutions, face, wanted);
                is_changed |= best != resolutions.faces[face];
                resolutions.faces[face] = best;
            }
            if !is_changed {
                break;
            }
        }
        resolutions
    }
}

fn is_free(exponent: f32) -> bool {
    (exponent.fract() - 0.5).abs() < FREE
}

/// Of a face's choices the one that most neighbors have, and of those the nearest.
fn best(
    canvas: &CanvasMesh,
    joinable: &[bool],
    resolutions: &Resolutions,
    face: usize,
    wanted: [f32; 2],
) -> [u8; 2] {
    let choices = wanted.map(|exponent| {
        let other = if exponent.fract() < 0.5 { exponent.ceil() } else { exponent.floor() };
        [nearest(exponent), if is_free(exponent) { other as u8 } else { nearest(exponent) }]
    });
    let agreeing = |exponents: [u8; 2]| {
        let edges = canvas.faces[face].edges.iter().enumerate();
        edges
            .filter(|&(_, &edge)| joinable[edge as usize])
            .filter(|&(k, &edge)| {
                let own = [exponents[k % 2], exponents[1 - k % 2]];
                canvas.sides(&canvas.edges[edge as usize]).iter().any(|side| {
                    let other = side.face as usize;
                    let along = resolutions.along(other, side.edge.into());
                    let across = resolutions.along(other, usize::from(side.edge) + 1);
                    other != face && !canvas.faces[other].is_triangle() && [along, across] == own
                })
            })
            .count()
    };
    let [[r, other_r], [s, other_s]] = choices;
    let all = [[r, s], [other_r, s], [r, other_s], [other_r, other_s]];
    let most = all.into_iter().map(agreeing).max().unwrap_or(0);
    all.into_iter().find(|&exponents| agreeing(exponents) == most).unwrap_or([r, s])
}
