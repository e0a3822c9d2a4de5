//! The pictures: agate bands with gold veins, and a hammered surface, both functions of the place in
//! space. Details are soft over a few texels, so that two grids that meet at a seam agree on them.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use meshcolor::image::{Image, Pixels};

use super::shape::{Island, Shape};

pub const COLOR_SIDE: u32 = 1024;
pub const NORMAL_SIDE: u32 = 512;
/// Texels that are painted beyond an island's border: enough for bilinear filtering and nothing more.
const PADDING_TEXELS: f32 = 2.0;
const BACKGROUND: [u8; 3] = [236, 24, 188];
const FLAT_NORMAL: [u8; 3] = [128, 128, 255];
/// One cycle of bands, sRGB codes.
const BANDS: [Vec3; 6] = [
    Vec3::new(12.0, 58.0, 74.0),
    Vec3::new(24.0, 108.0, 122.0),
    Vec3::new(238.0, 228.0, 208.0),
    Vec3::new(226.0, 150.0, 92.0),
    Vec3::new(150.0, 54.0, 42.0),
    Vec3::new(40.0, 34.0, 58.0),
];
const GOLD: Vec3 = Vec3::new(244.0, 198.0, 96.0);
/// Step of the height's central differences, world units; well below its finest wave.
const HEIGHT_STEP_WORLD: f32 = 2e-3;

/// The base color atlas, sRGB.
pub fn base_color(shape: &Shape) -> Image {
    atlas(shape, COLOR_SIDE, BACKGROUND, |island, uv| codes(color(position(island, uv))))
}

/// The normal map, in the tangent frames of the shape's vertices.
pub fn normal_map(shape: &Shape) -> Image {
    atlas(shape, NORMAL_SIDE, FLAT_NORMAL, |island, uv| {
        let corners = island.triangle_at(island.grid_place(uv));
        let mix = |value: &dyn Fn(&super::shape::Vertex) -> Vec3| -> Vec3 {
            corners.iter().map(|(vertex, weight)| value(vertex) * *weight).sum()
        };
        let normal = mix(&|vertex| vertex.normal).normalize();
        let tangent = mix(&|vertex| vertex.tangent.truncate()).normalize();
        let bitangent = normal.cross(tangent);
        let slope = height_slope(mix(&|vertex| vertex.position));
        let bent = (normal - (slope - normal * slope.dot(normal))).normalize();
        // A viewer adds up the three axes as they are, so they are inverted as they are.
        let frame = glam::Mat3::from_cols(tangent, bitangent, normal);
        let local = (frame.inverse() * bent).normalize();
        codes((local * 0.5 + 0.5) * 255.0)
    })
}

/// Paints every texel whose center lies in an island or in its padding.
fn atlas(shape: &Shape, side: u32, background: [u8; 3], paint: impl Fn(&Island, Vec2) -> [u8; 3]) -> Image {
    let mut texels = Vec::with_capacity((side * side * 3) as usize);
    for y in 0..side {
        for x in 0..side {
            let uv = (Vec2::new(x as f32, y as f32) + 0.5) / side as f32;
            texels.extend(owner(shape, uv, side).map_or(background, |island| paint(island, uv)));
        }
    }
    Image { width: side, height: side, components: 3, pixels: Pixels::U8(texels) }
}

/// The island that a place of the atlas belongs to.
fn owner(shape: &Shape, uv: Vec2, side: u32) -> Option<&Island> {
    shape.islands.iter().find(|island| is_painted(island, uv, side))
}

/// Whether the island's picture, padding included, covers a place of the atlas.
pub fn is_painted(island: &Island, uv: Vec2, side: u32) -> bool {
    island.distance(uv) * side as f32 <= PADDING_TEXELS
}

/// The place in space, on the triangle at `uv` or in its plane.
fn position(island: &Island, uv: Vec2) -> Vec3 {
    let corners = island.triangle_at(island.grid_place(uv));
    corners.iter().map(|(vertex, weight)| vertex.position * *weight).sum()
}

/// sRGB codes at a place in space.
fn color(at: Vec3) -> Vec3 {
    let swirl = Vec3::new(
        (1.7 * at.y + 0.6 * (2.3 * at.z).sin()).sin(),
        (1.9 * at.z + 1.3).sin(),
        (2.1 * at.x + 2.1).sin(),
    );
    let bent = at + swirl * 0.3;
    let along_bands = 0.62 * bent.x + 0.44 * bent.y + 0.81 * bent.z;
    let turns = 0.72 * along_bands + 0.05 * (3.7 * bent.y).sin();
    let phase = turns.rem_euclid(1.0) * BANDS.len() as f32;
    let band = phase as usize % BANDS.len();
    let base = BANDS[band].lerp(BANDS[(band + 1) % BANDS.len()], smooth(phase.fract()));
    let grain = (6.1 * bent.x + 2.0 * (2.9 * bent.z).sin()).sin() * (5.3 * bent.y - 4.1 * bent.z).sin();
    // Thin layers, as agate has them, running with the bands.
    let layers = (9.0 * TAU * turns).sin() * 0.08 + (13.0 * TAU * turns + 1.1 * grain).sin() * 0.035;
    let vein = (2.6 * bent.x + 1.9 * (1.7 * bent.z).sin()).sin() + (2.3 * bent.y + 1.4 * bent.x).sin();
    let gold = 1.0 - smooth((vein.abs() / 0.37).min(1.0));
    (base * (1.0 + 0.09 * grain + layers)).lerp(GOLD, 0.8 * gold)
}

/// Gradient of the height over space, by central differences.
fn height_slope(at: Vec3) -> Vec3 {
    let along = |axis: Vec3| {
        let step = axis * HEIGHT_STEP_WORLD;
        (height_world(at + step) - height_world(at - step)) / (2.0 * HEIGHT_STEP_WORLD)
    };
    Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z))
}

/// Height of the hammered surface, world units.
fn height_world(at: Vec3) -> f32 {
    let waves = [
        (Vec3::new(5.1, 3.3, -2.0), 0.3),
        (Vec3::new(-3.1, 4.7, 2.9), 1.9),
        (Vec3::new(1.3, -2.7, 5.6), 4.0),
    ];
    let sum: f32 = waves.iter().map(|(direction, phase)| (direction.dot(at) + phase).sin()).sum();
    0.022 * (sum + 0.4 * (sum * TAU / 3.0).sin())
}

fn smooth(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}

fn codes(color: Vec3) -> [u8; 3] {
    color.to_array().map(|value| value.round().clamp(0.0, 255.0) as u8)
}
