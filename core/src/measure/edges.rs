//! Which sides of triangles meet: by exactly equal end positions, found by sorting.
//!
//! An edge with k sides gives k - 1 pairs, each of the others with the first (in order of part, triangle,
//! corner): where all of these agree, all agree. Sides of zero length and pairs inside one degenerate
//! triangle are left out; sides alone are the boundary.

use rayon::prelude::*;

use super::surface::Part;

/// The side from corner `corner` to the next one of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// Index into the surface's parts.
    pub part: u32,
    pub triangle: u32,
    pub corner: u8,
}

impl Side {
    /// Its two corners, in the triangle's order.
    pub fn ends(&self) -> [usize; 2] {
        let corner = usize::from(self.corner);
        [corner, (corner + 1) % 3]
    }
}

/// Two sides of one edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePair {
    pub a: Side,
    pub b: Side,
    /// Whether `b` runs against `a` (it does between triangles of equal winding).
    pub opposed: bool,
    /// Mesh-space length, more than 0.
    pub length: f32,
}

impl EdgePair {
    /// The corners of `b` in the direction of `a`.
    pub fn ends_of_b(&self) -> [usize; 2] {
        let [from, to] = self.b.ends();
        if self.opposed { [to, from] } else { [from, to] }
    }
}

/// All pairs, mesh by mesh; `parts` in order of mesh. The order depends on the geometry alone.
pub fn pairs(parts: &[Part<'_>]) -> Vec<EdgePair> {
    let mut pairs = Vec::new();
    let mut first = 0;
    for group in parts.chunk_by(|a, b| a.mesh == b.mesh) {
        pairs_of_mesh(group, first, &mut pairs);
        first += group.len() as u32;
    }
    pairs
}

/// A side by its welded ends, `low < high`, and its number among the mesh's sides.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    low: u32,
    high: u32,
    serial: u32,
}

fn pairs_of_mesh(parts: &[Part<'_>], first_part: u32, pairs: &mut Vec<EdgePair>) {
    let places = welded(parts);
    let mut keys = Vec::with_capacity(parts.iter().map(|part| part.triangles.len() * 3).sum());
    let mut starts = Vec::with_capacity(parts.len());
    let mut serial = 0u32;
    for (part, places) in parts.iter().zip(&places) {
        starts.push(serial);
        for triangle in &part.triangles {
            for corner in 0..3 {
                let [from, to] = [triangle[corner], triangle[(corner + 1) % 3]].map(|v| places[v as usize]);
                if from != to {
                    keys.push(Key { low: from.min(to), high: from.max(to), serial });
                }
                serial += 1;
            }
        }
    }
    keys.par_sort_unstable();
    let side = |key: &Key| {
        let part = starts.partition_point(|&start| start <= key.serial) - 1;
        let within = key.serial - starts[part];
        (part, Side { part: first_part + part as u32, triangle: within / 3, corner: (within % 3) as u8 })
    };
    for run in keys.chunk_by(|x, y| (x.low, x.high) == (y.low, y.high)) {
        let [first, others @ ..] = run else { continue };
        if others.is_empty() {
            continue;
        }
        let (part_a, a) = side(first);
        let forward = |part: usize, side: &Side| {
            let triangle = parts[part].triangles[side.triangle as usize];
            places[part][triangle[usize::from(side.corner)] as usize] == first.low
        };
        let a_forward = forward(part_a, &a);
        let [from, to] = a.ends().map(|k| parts[part_a].corners(a.triangle as usize)[k].as_dvec3());
        let length = (from.distance(to) as f32).clamp(f32::MIN_POSITIVE, f32::MAX);
        for other in others {
            let (part_b, b) = side(other);
            if (b.part, b.triangle) != (a.part, a.triangle) {
                pairs.push(EdgePair { a, b, opposed: forward(part_b, &b) != a_forward, length });
            }
        }
    }
}

/// For each part, its vertices' places: one number for each position that occurs in the mesh.
fn welded(parts: &[Part<'_>]) -> Vec<Vec<u32>> {
    let mut order: Vec<([u32; 3], u32)> = Vec::new();
    for part in parts {
        let first = order.len();
        // Adding 0 makes -0 into 0.
        let bits = part.geometry.positions.iter().map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
        order.extend(bits.enumerate().map(|(vertex, bits)| (bits, (first + vertex) as u32)));
    }
    order.par_sort_unstable();
    let mut places = vec![0u32; order.len()];
    for (place, run) in order.chunk_by(|x, y| x.0 == y.0).enumerate() {
        run.iter().for_each(|(_, vertex)| places[*vertex as usize] = place as u32);
    }
    let mut rest = places.as_slice();
    let mut by_part = Vec::with_capacity(parts.len());
    for part in parts {
        let (own, after) = rest.split_at(part.geometry.positions.len());
        by_part.push(own.to_vec());
        rest = after;
    }
    by_part
}

#[cfg(test)]
mod tests;
