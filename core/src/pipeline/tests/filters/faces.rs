//! Where the faces of a converted material stand, found by the coordinates that were written alone.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};

use crate::asset::Asset;
use crate::finished::{Finished, FinishedPrimitive, FinishedTexture};
use crate::image::{Wrap, WrapMode, bilinear};
use crate::mesh::{CanvasFace, Drawn, surface_point};
use crate::pipeline::material::MaterialConversion;

const CLAMP: Wrap = Wrap { s: WrapMode::ClampToEdge, t: WrapMode::ClampToEdge };

/// Where the drawn triangles of a face stand: the piece, the triangle's number in it, and which corner of it each corner of
/// the canvas' drawn triangle is.
type Spots<'a> = [(&'a FinishedPrimitive, usize, [usize; 3]); 2];

/// A material's faces with their coordinates.
pub struct Faces<'a> {
    finished: &'a Finished,
    conversion: &'a MaterialConversion,
    spots: Vec<Spots<'a>>,
    /// By face: of a triangle the corner at its right angle.
    pub right: Vec<u8>,
}

impl<'a> Faces<'a> {
    /// Of an asset whose faces share no vertices.
    pub fn new(asset: &Asset, finished: &'a Finished, conversion: &'a MaterialConversion) -> Self {
        let mut by_vertices = BTreeMap::new();
        for piece in finished.primitives.iter().filter(|piece| piece.material == conversion.material) {
            for (number, triangle) in piece.triangles.iter().enumerate() {
                let mut key = triangle.vertices;
                key.sort_unstable();
                assert!(by_vertices.insert((piece.mesh, piece.primitive, key), (piece, number)).is_none());
            }
        }
        let spot = |mesh: u32, drawn: Drawn| {
            let (mesh, primitive) = (mesh as usize, drawn.primitive as usize);
            let face = &asset.meshes[mesh].primitives[primitive].faces[drawn.face as usize];
            let vertices = drawn.corners.map(|corner| face.corners[usize::from(corner)]);
            let mut key = vertices;
            key.sort_unstable();
            let (piece, number) = by_vertices[&(mesh, primitive, key)];
            let own = piece.triangles[number].vertices;
            (piece, number, vertices.map(|vertex| own.iter().position(|known| *known == vertex).unwrap()))
        };
        let spots_of = |face: &CanvasFace| {
            let [first, second] = face.drawn;
            let second = if face.is_triangle() { first } else { second };
            [first, second].map(|drawn| spot(face.mesh, drawn))
        };
        let spots: Vec<Spots<'_>> = conversion.canvas.faces.iter().map(spots_of).collect();
        let right = spots.iter().map(|[(piece, number, order), _]| {
            let corners = order.map(|corner| piece.triangles[*number].corners[corner]);
            let is_straight =
                |a: usize, b: usize| (corners[a % 3] - corners[b % 3]).to_array().contains(&0.0);
            (0..3).find(|&k| is_straight(k, k + 1) && is_straight(k, k + 2)).unwrap() as u8
        });
        Self { finished, conversion, right: right.collect(), spots }
    }

    /// The texture that a face reads of a channel.
    pub fn texture(&self, face: usize, channel: usize) -> &'a FinishedTexture {
        let part = self.spots[face][0].0.part;
        let slots = &self.conversion.channels[channel].form.slots;
        let mut all = self.finished.textures_of(self.conversion.material, part);
        all.find(|(_, texture)| texture.slots == *slots).unwrap().1
    }

    /// What a bilinear unit reads at `(s, t)` of a face.
    pub fn read(&self, face: usize, at: Vec2, channel: usize, level: usize) -> Vec4 {
        let (drawn, weights) = surface_point(self.conversion.canvas.faces[face].count(), at.x, at.y);
        let (piece, number, order) = self.spots[face][drawn];
        let mut own = Vec3::ZERO;
        order.into_iter().zip(weights.to_array()).for_each(|(corner, weight)| own[corner] = weight);
        let place = piece.place_at(number, own, level);
        let texture = self.texture(face, channel);
        let image = &texture.levels[level];
        match texture.ranges.get(&level) {
            None => bilinear(image, texture.transfer, CLAMP, place),
            Some(range) => {
                let (cell, part) = ((place - 0.5).floor().as_ivec2(), (place - 0.5).rem_euclid(Vec2::ONE));
                let texel = |dx: i32, dy: i32| {
                    let last = [image.width as i32 - 1, image.height as i32 - 1];
                    let (x, y) = ((cell.x + dx).clamp(0, last[0]), (cell.y + dy).clamp(0, last[1]));
                    range.texel(image, x as u32, y as u32)
                };
                texel(0, 0).lerp(texel(1, 0), part.x).lerp(texel(0, 1).lerp(texel(1, 1), part.x), part.y)
            }
        }
    }

    /// Whether texels around a face are extrapolated at a level.
    pub fn is_extrapolated(&self, face: usize, level: usize) -> bool {
        let (piece, number, _) = self.spots[face][0];
        piece.coordinates.is_extrapolated(&piece.triangles[number], level)
    }

    /// Whether nobody shares the edge that a triangle has across from its right angle.
    pub fn is_free(&self, face: usize, channel: usize) -> bool {
        let canvas = &self.conversion.canvas;
        let edge = canvas.faces[face].edges[(usize::from(self.right[face]) + 1) % 3] as usize;
        self.conversion.channels[channel].cuts.edges[edge] || canvas.sides(&canvas.edges[edge]).len() == 1
    }
}
