use glam::{Vec3, Vec4};

use crate::asset::{Asset, Slot};
use crate::finished::Finished;
use crate::image::Pixels;
use crate::pipeline::tests::{finish, noise_asset};
use crate::pipeline::{Coordinates, Options, Range};

/// Two sheets of noise, of two materials: the second coarse, with a dark image of its own.
fn two_sheets() -> Asset {
    let mut asset = noise_asset(3, 6, Slot::BaseColor);
    let mut other = noise_asset(4, 3, Slot::BaseColor);
    let primitive = &mut other.meshes[0].primitives[0];
    primitive.material = Some(1);
    primitive.texcoords[0].iter_mut().for_each(|at| *at *= 0.1);
    primitive.positions.iter_mut().for_each(|at| at.x += 100.0);
    if let Pixels::U8(codes) = &mut other.images[0].pixels {
        codes.iter_mut().for_each(|code| *code /= 3);
    }
    asset.materials.append(&mut other.materials);
    asset.images.append(&mut other.images);
    asset.meshes.append(&mut other.meshes);
    if let Some(texture) = asset.materials[1].slots.get_mut(&Slot::BaseColor) {
        texture.image = 1;
    }
    asset
}

/// By drawn triangle of the asset: the value in its middle at a level, and the level's half step.
fn middles(finished: &Finished, level: usize) -> Vec<((u32, u32), Vec4)> {
    let mut values = Vec::new();
    for primitive in &finished.primitives {
        let texture = finished
            .textures
            .iter()
            .find(|texture| texture.is_of(primitive.material, primitive.part))
            .expect("a texture of every part");
        let (image, range) = (&texture.levels[level], texture.ranges.get(&level));
        for (number, triangle) in primitive.triangles.iter().enumerate() {
            let at = primitive.place_at(number, Vec3::splat(1.0 / 3.0), level) - 0.5;
            let (first, share) = (at.floor(), at - at.floor());
            let texel = |dx: u32, dy: u32| {
                let [x, y] =
                    [(first.x as u32 + dx).min(image.width - 1), (first.y as u32 + dy).min(image.height - 1)];
                image.value(x, y, texture.transfer, range)
            };
            let row = |dy: u32| texel(0, dy).lerp(texel(1, dy), share.x);
            values.push(((primitive.mesh as u32, triangle.vertices[0]), row(0).lerp(row(1), share.y)));
        }
    }
    values.sort_by_key(|(triangle, _)| *triangle);
    values
}

fn options(merges: bool, max_side: u32) -> Options {
    Options {
        coordinates: Coordinates::Scaled,
        range: Range::Scaled16,
        merges,
        max_side,
        ..Options::default()
    }
}

/// Two conversions show the same in the middles of triangles but for a few 8-bit codes: beyond vertex colors texels, and what
/// the solver changes to store them, depend on where a block stands. (Neighboring texels of the noise differ by up to 255.)
fn assert_alike([a, b]: [&Finished; 2]) {
    let level_count = [a, b].iter().flat_map(|finished| &finished.textures).map(|t| t.levels.len()).min();
    let of_level = |level: usize| {
        let [a, b] = [a, b].map(|finished| middles(finished, level));
        assert_eq!(a.len(), b.len());
        for ((of, a), (also_of, b)) in a.iter().zip(&b) {
            assert_eq!(of, also_of);
            assert!((*a - *b).abs().max_element() < 6.0 / 255.0, "level {level}, {of:?}: {a} and {b}");
        }
    };
    (0..level_count.unwrap()).for_each(of_level);
}

#[test]
fn merged_materials_read_what_each_alone_does() {
    let asset = two_sheets();
    let (alone, _) = finish(&asset, &options(false, 8192));
    let (merged, _) = finish(&asset, &options(true, 8192));
    assert_eq!((alone.textures.len(), merged.textures.len()), (2, 1));
    assert_eq!(merged.textures[0].materials, [0, 1]);
    assert_ne!(alone.textures[0].ranges, alone.textures[1].ranges);
    merged.check().unwrap();
    assert_alike([&alone, &merged]);
}

#[test]
fn parts_read_what_one_image_does() {
    let asset = two_sheets();
    for merges in [false, true] {
        let (whole, _) = finish(&asset, &options(merges, 8192));
        let (parted, _) = finish(&asset, &options(merges, 80));
        assert!(parted.textures.len() > whole.textures.len() + 1, "{}", parted.textures.len());
        for texture in &parted.textures {
            assert!(texture.levels.iter().all(|image| image.width.max(image.height) <= 80));
        }
        parted.check().unwrap();
        assert_alike([&whole, &parted]);
    }
}
