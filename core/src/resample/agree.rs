//! Whole exponents that neighbors agree on.
//!
//! Faces of one shape can stand in one block, and an edge has no more samples than the coarser of its faces. So where an
//! exponent is about half way between two whole ones, it goes to that which lies nearer to what the neighbors want.

use crate::colors::Resolutions;
use crate::mesh::CanvasMesh;

use super::resolution::{WantedExponents, nearest};

/// An exponent is free to go up or down where it is so near to the middle.
const FREE: f32 = 0.25;
/// Times that all faces look at their neighbors, all at once: the order of faces does not matter.
const LOOKS: usize = 6;

impl WantedExponents {
    /// The nearest exponents, but of quads those half way ones that are nearer to those of their neighbors. `joinable`: by
    /// canvas edge whether the two faces of it could stand in one block.
    pub fn agreeing(&self, canvas: &CanvasMesh, joinable: &[bool]) -> Resolutions {
        let mut smooth = self.faces.clone();
        for _ in 0..LOOKS {
            let looked = |face: usize| {
                let mean = mean_around(canvas, joinable, &smooth, face);
                mean.map_or(smooth[face], |mean| {
                    [0, 1].map(|axis| 0.5 * (self.faces[face][axis] + mean[axis]))
                })
            };
            smooth = (0..self.faces.len()).map(looked).collect();
        }
        let whole = |(wanted, smooth): (&[f32; 2], &[f32; 2])| {
            [0, 1].map(|axis| {
                let is_free = (wanted[axis].fract() - 0.5).abs() < FREE;
                let [low, high] = [wanted[axis].floor(), wanted[axis].ceil()];
                nearest(if is_free { smooth[axis].clamp(low, high) } else { wanted[axis] })
            })
        };
        Resolutions { faces: self.faces.iter().zip(&smooth).map(whole).collect() }
    }
}

/// The mean over the neighbors of a quad, each turned to its axes.
fn mean_around(
    canvas: &CanvasMesh,
    joinable: &[bool],
    exponents: &[[f32; 2]],
    face: usize,
) -> Option<[f32; 2]> {
    let own = &canvas.faces[face];
    if own.is_triangle() {
        return None;
    }
    let mut sum = [0.0; 2];
    let mut count = 0.0;
    for (k, &edge) in own.edges.iter().enumerate().filter(|(_, edge)| joinable[**edge as usize]) {
        for side in canvas.sides(&canvas.edges[edge as usize]) {
            let other = side.face as usize;
            if other != face && !canvas.faces[other].is_triangle() {
                let along = usize::from(side.edge) % 2;
                sum[k % 2] += exponents[other][along];
                sum[1 - k % 2] += exponents[other][1 - along];
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}
