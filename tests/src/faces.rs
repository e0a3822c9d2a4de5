//! What the faces of a converted patch show, by the patch's own faces and corners.

use glam::{Vec2, Vec3};
use meshcolor::pipeline::Conversion;

use crate::patches::Patch;
use crate::reading::shown_codes;

/// Weights of a face's corners at the points of a grid of `segments` a side.
pub fn grid(corner_count: usize, segments: usize) -> Vec<[f32; 4]> {
    let n = segments as f32;
    let points = (0..=segments).flat_map(|j| (0..=segments).map(move |i| (i, j)));
    let weights = |(i, j): (usize, usize)| {
        let (s, t) = (i as f32 / n, j as f32 / n);
        if corner_count == 3 {
            (i + j <= segments).then(|| [(segments - i - j) as f32 / n, s, t, 0.0])
        } else {
            Some([(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t])
        }
    };
    points.filter_map(weights).collect()
}

/// The first texture of a conversion, over the faces of the patch that was converted.
pub struct Faces<'a> {
    conversion: &'a Conversion,
    /// By face: its first triangle, and how many corners it has.
    faces: Vec<(usize, usize)>,
}

impl<'a> Faces<'a> {
    pub fn new(conversion: &'a Conversion, patch: &Patch) -> Self {
        let mut first = 0;
        let of = |corners: &Vec<_>| {
            let here = first;
            first += corners.len() - 2;
            (here, corners.len())
        };
        Self { conversion, faces: patch.faces.iter().map(of).collect() }
    }

    /// Segments a side of a face at level 0: its block is a square.
    pub fn segments(&self, face: usize) -> usize {
        let piece = &self.conversion.finished.primitives[0];
        let [first, second, third] = piece.coordinates.texels(&piece.triangles[self.faces[face].0]);
        let side = (second - first).abs().max_element();
        let other = (third - first).abs().max_element();
        side.max(other) as usize
    }

    fn place(&self, face: usize, corner: usize, level: usize) -> Vec2 {
        let (first, _) = self.faces[face];
        // A quad is drawn as the triangles of its fan.
        let (triangle, corner) = if corner == 3 { (first + 1, 2) } else { (first, corner) };
        self.conversion.finished.primitives[0].place(triangle, corner, level)
    }

    /// The color in codes at a level, at weights of the corners; corner `k` of these is corner `k - turn` here.
    pub fn shown(&self, face: usize, turn: usize, weights: &[f32; 4], level: usize) -> Vec3 {
        let count = self.faces[face].1;
        let at: Vec2 = (0..count).map(|k| self.place(face, k, level) * weights[(k + turn) % count]).sum();
        let texture = &self.conversion.finished.textures[0];
        shown_codes(&texture.levels[level], texture.transfer, at)
    }
}
