//! What a viewer reads from a finished conversion, worked out from its coordinates alone: nothing here
//! knows how the conversion was made, and nothing is shared with `measure`.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use meshcolor::asset::Asset;
use meshcolor::finished::{Finished, FinishedPrimitive, FinishedTexture};
use meshcolor::image::{Image, LevelRange, Pixels, Transfer};

/// Points along an edge that are compared; no grid line falls on them.
const EDGE_POINTS: usize = 29;

/// The texels that some point of the triangle reads with a weight above zero: those whose open square of
/// two texels a side the triangle meets. Columns and rows may lie outside of the image.
pub fn texels_read(piece: &FinishedPrimitive, triangle: usize, level: usize) -> Vec<[i64; 2]> {
    let corners = [0, 1, 2].map(|corner| piece.place(triangle, corner, level).as_dvec2());
    let low = corners.iter().fold(corners[0], |low, corner| low.min(*corner)) - 1.5;
    let high = corners.iter().fold(corners[0], |high, corner| high.max(*corner)) + 0.5;
    let mut read = Vec::new();
    for y in low.y.floor() as i64..=high.y.ceil() as i64 {
        for x in low.x.floor() as i64..=high.x.ceil() as i64 {
            if meets(&corners, glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5)) {
                read.push([x, y]);
            }
        }
    }
    read
}

/// Whether a triangle meets the open square of half side 1 around `center`: no axis keeps them apart.
fn meets(corners: &[glam::DVec2; 3], center: glam::DVec2) -> bool {
    let sides = [0, 1, 2].map(|k| (corners[(k + 1) % 3] - corners[k]).perp());
    let axes = [glam::DVec2::X, glam::DVec2::Y].into_iter().chain(sides);
    axes.into_iter().all(|axis| {
        let along = corners.map(|corner| (corner - center).dot(axis));
        let reach = axis.x.abs() + axis.y.abs() - 1e-9;
        let least = along.iter().copied().fold(f64::INFINITY, f64::min);
        let most = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        least < reach && most > -reach
    })
}

/// The color that a GPU shows at a place of one image: decoded, mixed, encoded, in 8-bit codes.
pub fn shown_codes(image: &Image, transfer: Transfer, at_texels: Vec2) -> Vec3 {
    filtered_codes(image, transfer, at_texels, |texel| texel.map(|code| decode(code, transfer)))
}

/// The same at a level of a converted texture, in its range where it has one.
pub fn shown_codes_of(texture: &FinishedTexture, level: usize, at_texels: Vec2) -> Vec3 {
    let image = &texture.levels[level];
    let value = |code: f32, k: usize| match texture.ranges.get(&level) {
        None => decode(code, texture.transfer),
        Some(LevelRange::Scaled16 { scale, bias }) => code * scale[k] + bias[k],
        Some(range @ LevelRange::Float16) => range.decode(k, (code * 65535.0).round() as u16),
    };
    filtered_codes(image, texture.transfer, at_texels, |texel| {
        Vec3::new(value(texel.x, 0), value(texel.y, 1), value(texel.z, 2))
    })
}

fn filtered_codes(image: &Image, transfer: Transfer, at_texels: Vec2, value: impl Fn(Vec3) -> Vec3) -> Vec3 {
    let taps = taps(image, at_texels).into_iter().filter(|tap| tap.2 > 0.0);
    let sum: Vec3 = taps.map(|(x, y, weight)| value(Vec3::from(texel(image, x, y))) * weight).sum();
    sum.map(|value| encode(value, transfer)) * 255.0
}

/// The alpha that a GPU shows at a place of an image of four components of 8 bits, 0 to 1.
pub fn shown_alpha(image: &Image, at_texels: Vec2) -> f32 {
    let Pixels::U8(codes) = &image.pixels else { return f32::NAN };
    let alpha = |x: u32, y: u32| codes.get((y as usize * image.width as usize + x as usize) * 4 + 3).copied();
    let taps = taps(image, at_texels).into_iter();
    taps.map(|(x, y, weight)| alpha(x, y).map_or(f32::NAN, f32::from) / 255.0 * weight).sum()
}

/// The four texels around a place, kept inside of the image, with their weights.
fn taps(image: &Image, at_texels: Vec2) -> [(u32, u32, f32); 4] {
    let corner = at_texels - 0.5;
    let (floor, part) = (corner.floor(), corner - corner.floor());
    let inside = |at: f32, side: u32| at.clamp(0.0, side as f32 - 1.0) as u32;
    [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(dx, dy)| {
        let weight = |step: f32, part: f32| if step == 0.0 { 1.0 - part } else { part };
        let (x, y) = (inside(floor.x + dx, image.width), inside(floor.y + dy, image.height));
        (x, y, weight(dx, part.x) * weight(dy, part.y))
    })
}

/// The stored codes of a texel as shares of the largest; gray in all three.
pub fn texel(image: &Image, x: u32, y: u32) -> [f32; 3] {
    let n = usize::from(image.components);
    let first = (y as usize * image.width as usize + x as usize) * n;
    [0, 1, 2].map(|k| {
        let at = if n < 3 { first } else { first + k };
        match &image.pixels {
            Pixels::U8(codes) => f32::from(codes[at]) / 255.0,
            Pixels::U16(codes) => f32::from(codes[at]) / 65535.0,
            Pixels::F32(of) => of.values[at],
        }
    })
}

fn decode(code: f32, transfer: Transfer) -> f32 {
    match transfer {
        Transfer::Linear => code,
        Transfer::Srgb if code <= 0.04045 => code / 12.92,
        Transfer::Srgb => ((code + 0.055) / 1.055).powf(2.4),
    }
}

fn encode(value: f32, transfer: Transfer) -> f32 {
    match transfer {
        Transfer::Linear => value,
        Transfer::Srgb if value <= 0.003_130_8 => value * 12.92,
        Transfer::Srgb => 1.055 * value.powf(1.0 / 2.4) - 0.055,
    }
}

/// One side of an edge: a primitive of the conversion, its triangle, the corner where the side begins.
type Side<'a> = (&'a FinishedPrimitive, usize, usize);
type PositionKey = [u32; 3];

/// Largest jump in codes by level, over all edges inside the materials that show a texture which are no cut in this
/// channel. Sides in other parts of the material read the texture of their part.
pub fn jumps_codes(asset: &Asset, finished: &Finished, texture: usize) -> Vec<f32> {
    let FinishedTexture { materials, slots, levels, .. } = &finished.textures[texture];
    let read_by = |piece: &FinishedPrimitive| -> (usize, &FinishedTexture) {
        let mut own = finished.textures_of(piece.material, piece.part);
        own.find(|(_, own)| own.slots == *slots).expect("every part has every channel")
    };
    let mut edges: BTreeMap<(usize, usize, [PositionKey; 2]), Vec<Side<'_>>> = BTreeMap::new();
    for piece in finished.primitives.iter().filter(|piece| materials.contains(&piece.material)) {
        for triangle in 0..piece.triangles.len() {
            for k in 0..3 {
                let mut key = [key(asset, piece, triangle, k), key(asset, piece, triangle, k + 1)];
                key.sort_unstable();
                if key[0] != key[1] {
                    let edge = (piece.material, piece.mesh, key);
                    edges.entry(edge).or_default().push((piece, triangle, k));
                }
            }
        }
    }
    let is_cut = |&(piece, triangle, k): &Side<'_>| {
        let texture = read_by(piece).0;
        let mut cuts = piece.cuts.iter().filter(|cuts| cuts.texture == texture);
        cuts.any(|cuts| cuts.bits[triangle] >> k & 1 == 1)
    };
    edges.retain(|_, sides| sides.len() > 1 && !sides.iter().any(is_cut));
    (0..levels.len())
        .map(|level| {
            let jump = |((_, _, ends), sides): (&(usize, usize, [PositionKey; 2]), &Vec<Side<'_>>)| {
                jump_codes(asset, |piece| read_by(piece).1, level, ends[0], sides)
            };
            edges.iter().map(jump).fold(0.0, f32::max)
        })
        .collect()
}

fn key(asset: &Asset, piece: &FinishedPrimitive, triangle: usize, corner: usize) -> PositionKey {
    let vertex = piece.triangles[triangle].vertices[corner % 3] as usize;
    let position = asset.meshes[piece.mesh].primitives[piece.primitive].positions[vertex] + 0.0;
    position.to_array().map(f32::to_bits)
}

fn jump_codes<'f>(
    asset: &Asset,
    read_by: impl Fn(&FinishedPrimitive) -> &'f FinishedTexture,
    level: usize,
    low: PositionKey,
    sides: &[Side<'_>],
) -> f32 {
    let shown = |&(piece, triangle, k): &Side<'_>, t: f32| {
        let t = if key(asset, piece, triangle, k) == low { t } else { 1.0 - t };
        let mut weights = Vec3::ZERO;
        weights[k] = 1.0 - t;
        weights[(k + 1) % 3] = t;
        let place = piece.place_at(triangle, weights, level);
        shown_codes_of(read_by(piece), level, place)
    };
    let mut worst: f32 = 0.0;
    for point in 0..=EDGE_POINTS {
        let t = point as f32 / EDGE_POINTS as f32;
        let first = shown(&sides[0], t);
        for side in &sides[1..] {
            worst = worst.max((first - shown(side, t)).abs().max_element());
        }
    }
    worst
}
