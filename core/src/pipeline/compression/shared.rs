//! Which texels of a level hold the same sample: on the two sides of an edge that is no cut, where both sides
//! have their samples on texel centers. Of indexed coordinates that is everywhere, of 4D coordinates it is up to
//! vertex colors.

use std::collections::BTreeMap;

use glam::Vec2;

use crate::asset::Asset;
use crate::finished::{Finished, FinishedPrimitive};
use crate::math::partition::Partition;

/// How far a sample may stand from a texel's center, texels.
const OFF_CENTER: f32 = 1e-3;

/// One side of an edge: a triangle, the corner that the edge starts at, and whether it is walked backwards.
#[derive(Clone, Copy)]
struct Side<'a> {
    piece: &'a FinishedPrimitive,
    triangle: usize,
    corner: usize,
    is_reversed: bool,
}

/// The two positions of an edge, the lesser first, by their bits.
type Ends = [[u32; 3]; 2];

/// The edges of one texture that have several sides and are no cuts.
pub struct Edges<'a>(Vec<Vec<Side<'a>>>);

impl<'a> Edges<'a> {
    pub fn of(asset: &Asset, finished: &'a Finished, texture: usize) -> Self {
        let shown = &finished.textures[texture];
        // By mesh and both positions; an edge is a cut when one of its sides says so.
        let mut edges: BTreeMap<(usize, Ends), (bool, Vec<Side<'a>>)> = BTreeMap::new();
        for piece in finished.primitives.iter().filter(|piece| shown.is_of(piece.material, piece.part)) {
            let positions = &asset.meshes[piece.mesh].primitives[piece.primitive].positions;
            let cuts = piece.cuts.iter().find(|cuts| cuts.texture == texture);
            for (number, triangle) in piece.triangles.iter().enumerate() {
                // Adding 0 makes -0 the same as 0.
                let ends =
                    triangle.vertices.map(|v| (positions[v as usize] + 0.0).to_array().map(f32::to_bits));
                for corner in 0..3 {
                    let [from, to] = [ends[corner], ends[(corner + 1) % 3]];
                    if from == to {
                        // A side without length has no direction.
                        continue;
                    }
                    let is_reversed = to < from;
                    let key = if is_reversed { [to, from] } else { [from, to] };
                    let edge = edges.entry((piece.mesh, key)).or_default();
                    edge.0 |= cuts.is_some_and(|cuts| cuts.bits[number] >> corner & 1 == 1);
                    edge.1.push(Side { piece, triangle: number, corner, is_reversed });
                }
            }
        }
        let joined = edges.into_values().filter(|(is_cut, sides)| !is_cut && sides.len() > 1);
        Self(joined.map(|(_, sides)| sides).collect())
    }

    /// Groups of two texels or more of a level with the given size; a texel is `y · width + x`.
    pub fn groups(&self, level: usize, [width, height]: [u32; 2]) -> Vec<Vec<u32>> {
        let mut partition = Partition::new(width as usize * height as usize);
        let mut touched = Vec::new();
        for sides in &self.0 {
            let tracks: Vec<[Vec2; 2]> = sides.iter().map(|side| side.track(level)).collect();
            let Some(count) = tracks.iter().map(sample_count).min().flatten() else { continue };
            for sample in 0..=count {
                let share = sample as f32 / count as f32;
                let texels = tracks.iter().map(|[from, to]| texel(from.lerp(*to, share), [width, height]));
                let Some(texels) = texels.collect::<Option<Vec<u32>>>() else { continue };
                texels[1..].iter().for_each(|&texel| partition.join(texels[0], texel));
                touched.extend(texels);
            }
        }
        touched.sort_unstable();
        touched.dedup();
        let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for texel in touched {
            groups.entry(partition.root(texel)).or_default().push(texel);
        }
        groups.into_values().filter(|texels| texels.len() > 1).collect()
    }
}

impl Side<'_> {
    /// Both ends in texels, in the direction that all sides of the edge have.
    fn track(&self, level: usize) -> [Vec2; 2] {
        let ends = [self.corner, (self.corner + 1) % 3];
        let [from, to] = ends.map(|corner| self.piece.place(self.triangle, corner, level));
        if self.is_reversed { [to, from] } else { [from, to] }
    }
}

/// Segments of a side whose ends stand on texel centers; `None` beyond vertex colors.
fn sample_count([from, to]: &[Vec2; 2]) -> Option<u32> {
    let count = (*to - *from).abs().max_element().round();
    let is_centered = [from, to].into_iter().all(|end| is_center(*end));
    (is_centered && count >= 1.0).then_some(count as u32)
}

fn is_center(at: Vec2) -> bool {
    let off = at - at.floor() - 0.5;
    off.abs().max_element() <= OFF_CENTER
}

/// The texel whose center this is.
fn texel(at: Vec2, [width, height]: [u32; 2]) -> Option<u32> {
    let is_inside = at.cmpge(Vec2::ZERO).all() && at.cmplt(Vec2::new(width as f32, height as f32)).all();
    (is_inside && is_center(at)).then(|| at.y as u32 * width + at.x as u32)
}

#[cfg(test)]
mod tests;
