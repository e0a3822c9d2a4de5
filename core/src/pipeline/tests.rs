//! Invariants of the whole conversion, on random meshes with random textures: the worst that a source can be.

mod filters;
mod reference;
mod told;

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::*;
use crate::asset::{
    Attribute, Face, Material, Mesh, Primitive, Slot, TextureRef, UvTransform, VERTEX_COLORS,
};
use crate::image::{Image, Pixels, Transfer, Wrap, WrapMode, bilinear};
use crate::watch::Unwatched;

/// A small generator of our own: the same cases everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() * end as f32) as usize % end
    }
}

/// A sheet of `side * side` cells, some of them quads, with holes, random texture coordinates of widely
/// different sizes, and noise for a texture.
pub(super) fn noise_asset(seed: u64, side: usize, slot: Slot) -> Asset {
    let mut random = Random(seed);
    let mut primitive = Primitive { material: Some(0), texcoords: vec![Vec::new()], ..Primitive::default() };
    let point = |x: usize, y: usize| Vec3::new(x as f32, y as f32, ((x * 7 + y * 13) % 5) as f32 * 0.3);
    for y in 0..side {
        for x in 0..side {
            let square = [point(x, y), point(x + 1, y), point(x + 1, y + 1), point(x, y + 1)];
            let faces: &[&[usize]] = match random.below(5) {
                0 => &[&[0, 1, 2, 3]],
                1 => &[&[0, 1, 3], &[1, 2, 3]],
                2 => &[&[0, 1, 2]],
                _ => &[&[0, 1, 2], &[0, 2, 3]],
            };
            for face in faces {
                let scale = 0.5f32.powi(random.below(7) as i32);
                let first = primitive.positions.len() as u32;
                for &corner in *face {
                    primitive.positions.push(square[corner]);
                    primitive.texcoords[0].push(Vec2::new(random.next(), random.next()) * scale);
                    let bend = Vec3::new(square[corner].z, -square[corner].z, 2.0);
                    primitive.normals.push(bend.normalize());
                }
                primitive.faces.push(match face.len() {
                    3 => Face::triangle([first, first + 1, first + 2]),
                    _ => Face::quad([first, first + 1, first + 2, first + 3]),
                });
            }
        }
    }
    let codes = (0..64 * 64 * 3).map(|_| if random.next() < 0.5 { 0 } else { (random.next() * 255.0) as u8 });
    let image = Image { width: 64, height: 64, components: 3, pixels: Pixels::U8(codes.collect()) };
    let mut material = Material {
        base_color_factor: Vec4::ONE,
        normal_scale: 1.0,
        occlusion_strength: 1.0,
        ..Material::default()
    };
    material.slots.insert(
        slot,
        TextureRef { image: 0, wrap: Wrap::default(), texcoord: 0, transform: UvTransform::default() },
    );
    Asset {
        images: vec![image],
        materials: vec![material],
        meshes: vec![Mesh { name: "sheet".into(), primitives: vec![primitive] }],
        ..Asset::default()
    }
}

pub(super) fn finish(asset: &Asset, options: &Options) -> (Finished, Vec<MaterialConversion>) {
    let mut progress = Progress::new(&Unwatched);
    let (mut materials, sets) =
        convert_materials(asset, options, &Limits::default(), &Unwatched, &mut progress).unwrap();
    let groups = groups(&materials, sets, options).unwrap();
    (assemble(asset, &mut materials, &groups), materials)
}

/// Both sides of every uncut edge, sampled as a GPU does: the largest difference in codes by level.
fn jumps(asset: &Asset, finished: &Finished) -> Vec<f32> {
    let clamp = Wrap { s: WrapMode::ClampToEdge, t: WrapMode::ClampToEdge };
    let texture = &finished.textures[0];
    let mut sides: HashMap<[[u32; 3]; 2], Vec<(usize, usize)>> = HashMap::new();
    let primitive = &finished.primitives[0];
    let positions = &asset.meshes[0].primitives[0].positions;
    let at = |triangle: usize, corner: usize| {
        positions[primitive.triangles[triangle].vertices[corner % 3] as usize].to_array().map(f32::to_bits)
    };
    for triangle in 0..primitive.triangles.len() {
        for k in 0..3 {
            let is_cut = primitive.cuts.first().is_some_and(|cuts| cuts.bits[triangle] >> k & 1 == 1);
            let mut key = [at(triangle, k), at(triangle, k + 1)];
            key.sort();
            if !is_cut {
                sides.entry(key).or_default().push((triangle, k));
            }
        }
    }
    let level_jump = |level: usize| {
        let image = &texture.levels[level];
        let value = |(triangle, k): (usize, usize), low: [u32; 3], t: f32| {
            let t = if at(triangle, k) == low { t } else { 1.0 - t };
            let mut weights = Vec3::ZERO;
            weights[k] = 1.0 - t;
            weights[(k + 1) % 3] = t;
            let value =
                bilinear(image, texture.transfer, clamp, primitive.place_at(triangle, weights, level));
            match texture.transfer {
                Transfer::Srgb => value.xyz().map(crate::math::transfer::linear_to_srgb) * 255.0,
                Transfer::Linear => value.xyz() * 255.0,
            }
        };
        let mut worst: f32 = 0.0;
        for (key, sides) in &sides {
            for other in &sides[1..] {
                for step in 0..24 {
                    let t = (step as f32 + 0.37) / 24.0;
                    worst = worst
                        .max((value(sides[0], key[0], t) - value(*other, key[0], t)).abs().max_element());
                }
            }
        }
        worst
    };
    (0..texture.levels.len()).map(level_jump).collect()
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 24,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Invariant 1, continuity: with every edge joined, noise has no seam at any level but rounding.
    #[test]
    fn uncut_edges_are_continuous(seed in any::<u64>(), color in any::<bool>()) {
        let asset = noise_asset(seed, 6, if color { Slot::BaseColor } else { Slot::MetallicRoughness });
        let options = Options { cut_codes: 255.0, range: Range::Unorm8, ..Options::default() };
        let (finished, materials) = finish(&asset, &options);
        prop_assert!(finished.primitives[0].cuts.is_empty());
        for report in &materials[0].channels[0].solver {
            prop_assert!(report.residual <= 2e-6, "unsolved: {report:?}");
        }
        for (level, jump) in jumps(&asset, &finished).into_iter().enumerate() {
            prop_assert!(jump <= 1.5, "level {level} jumps by {jump} codes");
        }
    }
}
