use glam::{Vec2, Vec3};

use super::groups;
use crate::asset::{Asset, Face, Mesh, Primitive, Slot};
use crate::pack::Savings;
use crate::pipeline::tests::noise_asset;
use crate::pipeline::{Limits, Options, Progress, convert_materials};
use crate::watch::Unwatched;

/// A bent sheet of 4 by 4 squares under a normal map of noise, and its mirror image beside it, which shows the same.
fn mirrored_sheets() -> Asset {
    let mut asset = noise_asset(5, 1, Slot::Normal);
    let mut primitive = Primitive { material: Some(0), texcoords: vec![Vec::new()], ..Primitive::default() };
    for is_mirrored in [false, true] {
        let first = primitive.positions.len() as u32;
        let sign = if is_mirrored { -1.0 } else { 1.0 };
        for (x, y) in (0..5).flat_map(|y| (0..5).map(move |x| (x as f32, y as f32))) {
            primitive.positions.push(Vec3::new(sign * x, y, 0.1 * x * y));
            primitive.normals.push(Vec3::new(sign * -0.1 * y, -0.1 * x, 1.0).normalize());
            primitive.texcoords[0].push(Vec2::new(0.1 + 0.2 * x, 0.05 + 0.2 * y));
        }
        for cell in (0..4).flat_map(|y| (0..4).map(move |x| first + 5 * y + x)) {
            let [a, b, c, d] = [cell, cell + 1, cell + 6, cell + 5];
            primitive.faces.push(Face::quad(if is_mirrored { [a, d, c, b] } else { [a, b, c, d] }));
        }
    }
    asset.meshes = vec![Mesh { name: "two sheets".into(), primitives: vec![primitive] }];
    asset
}

fn savings(asset: &Asset, options: &Options) -> Savings {
    let mut progress = Progress::new(&Unwatched);
    let conversions =
        convert_materials(asset, options, &Limits::default(), &Unwatched, &mut progress).unwrap();
    let groups = groups(&conversions, options).unwrap();
    groups[0].packed.as_ref().unwrap().savings
}

/// Stored normals of a mirror image are the same in frames of the other handedness.
#[test]
fn mirror_images_share_their_normals() {
    let asset = mirrored_sheets();
    let shared = savings(&asset, &Options::default());
    assert_eq!(shared.shared_count, 16, "{shared:?}");
    let apart = savings(&asset, &Options { shares: false, ..Options::default() });
    assert_eq!((apart.shared_count, apart.shared_texels), (0, [0, 0]));
}
