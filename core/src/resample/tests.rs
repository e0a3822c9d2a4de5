use glam::{Vec2, Vec3, Vec4};

use super::{Resolution, Sampling, find_cuts, sample, wanted_exponents};
use crate::asset::{
    AlphaMode, Asset, Face, Instance, Material, Mesh, Primitive, Slot, TextureRef, UvTransform,
};
use crate::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions};
use crate::image::{Image, Pixels, Wrap};
use crate::mesh::{CanvasMesh, Polygons, build};
use crate::source::{SurfaceSource, channels};
use crate::watch::Unwatched;

/// Two triangles that share the edge from (1, 0) to (0, 1), each with texture coordinates of its own, as
/// data (linear codes).
pub(super) fn two_charts(image: Image, first: [[f32; 2]; 3], second: [[f32; 2]; 3]) -> Asset {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0), Vec3::Y, Vec3::X];
    let primitive = Primitive {
        material: Some(0),
        positions: corners.to_vec(),
        texcoords: vec![first.into_iter().chain(second).map(Vec2::from).collect()],
        faces: vec![Face::triangle([0, 1, 2]), Face::triangle([3, 4, 5])],
        ..Primitive::default()
    };
    let mut material = Material::default();
    material.slots.insert(
        Slot::MetallicRoughness,
        TextureRef { image: 0, wrap: Wrap::default(), texcoord: 0, transform: UvTransform::default() },
    );
    Asset {
        images: vec![image],
        materials: vec![material],
        meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
        instances: vec![Instance { mesh: 0, transform: glam::Affine3A::from_scale(Vec3::splat(3.0)) }],
        ..Asset::default()
    }
}

pub(super) fn canvas_of(asset: &Asset) -> CanvasMesh {
    let primitive = &asset.meshes[0].primitives[0];
    let mut faces = primitive.faces.iter().map(|face| (face.corners, face.count));
    build([Polygons { mesh: 0, primitive: 0, positions: &primitive.positions, faces: &mut faces }])
}

/// 16 by 16 texels of `code(x, y)`.
pub(super) fn image(code: impl Fn(u32, u32) -> u8) -> Image {
    let pixels = (0..256).flat_map(|k| [code(k % 16, k / 16); 3]).collect();
    Image { width: 16, height: 16, components: 3, pixels: Pixels::U8(pixels) }
}

fn samples(asset: &Asset, exponent: u8, kernel: Sampling) -> (Vec<Vec4>, Cuts) {
    let canvas = canvas_of(asset);
    let channels = channels(asset, 0, false);
    let source = SurfaceSource::new(&channels[0], asset, &canvas);
    let cuts = find_cuts(&source, &canvas, 8.0, &Unwatched).unwrap();
    let resolutions = Resolutions::uniform(vec![exponent; 2]);
    let topology = ChannelTopology::new(&canvas, &resolutions, &cuts);
    let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
    (sample(&source, &numbering, Vec::new(), kernel, &Unwatched).unwrap().values, cuts)
}

const LEFT: [[f32; 2]; 3] = [[0.1, 0.1], [0.4, 0.1], [0.1, 0.4]];
/// The same edge somewhere else: (1, 0) at the third corner, (0, 1) at the second.
const RIGHT: [[f32; 2]; 3] = [[0.9, 0.9], [0.6, 0.9], [0.9, 0.6]];

#[test]
fn agreeing_sides_are_joined_and_disagreeing_ones_cut() {
    let (_, cuts) = samples(&two_charts(image(|_, _| 90), LEFT, RIGHT), 2, Sampling::Filtered(None));
    assert!(cuts.edges.iter().all(|cut| !cut), "two charts of one color have nothing to part");
    let halves = image(|x, _| if x < 8 { 40 } else { 200 });
    let (values, cuts) = samples(&two_charts(halves, LEFT, RIGHT), 2, Sampling::Filtered(None));
    assert_eq!(cuts.edges.iter().filter(|cut| **cut).count(), 1, "only the shared edge can be a cut");
    // Nothing is averaged across: every sample is one of the two colors.
    assert!(values.iter().all(|v| (v.x * 255.0 - 40.0).abs() < 0.1 || (v.x * 255.0 - 200.0).abs() < 0.1));
}

#[test]
fn a_joined_edge_is_the_mean_of_what_its_faces_see() {
    let halves = image(|x, _| if x < 8 { 100 } else { 104 });
    let (values, cuts) = samples(&two_charts(halves, LEFT, RIGHT), 0, Sampling::Point);
    assert!(cuts.edges.iter().all(|cut| !cut));
    let mut codes: Vec<i32> = values.iter().map(|v| (v.x * 255.0 * 10.0).round() as i32).collect();
    codes.sort();
    assert_eq!(codes, [1000, 1020, 1020, 1040]);
}

/// A linear source is its own hat-weighted mean inside the faces.
#[test]
fn the_hat_keeps_what_is_linear() {
    let ramp = image(|x, y| (20 + 8 * x + 5 * y) as u8);
    for exponent in [2, 3, 4] {
        let asset = two_charts(ramp.clone(), LEFT, [[0.4, 0.4], [0.1, 0.4], [0.4, 0.1]]);
        let (point, cuts) = samples(&asset, exponent, Sampling::Point);
        let (hat, _) = samples(&asset, exponent, Sampling::Filtered(None));
        assert!(cuts.edges.iter().all(|cut| !cut), "one chart");
        let canvas = canvas_of(&asset);
        let resolutions = Resolutions::uniform(vec![exponent; 2]);
        let topology = ChannelTopology::new(&canvas, &resolutions, &cuts);
        let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
        for sample in numbering.shared_count()..numbering.sample_count() {
            let difference = (point[sample].x - hat[sample].x).abs() * 255.0;
            assert!(difference < 0.01, "exponent {exponent}, sample {sample}: {difference} codes");
        }
    }
}

#[test]
fn wrapped_coordinates_read_what_the_sampler_reads() {
    let noise = image(|x, y| (x * 37 + y * 91) as u8);
    let shifted = |by: f32| LEFT.map(|[u, v]| [u + by, v - by]);
    let (near, _) = samples(&two_charts(noise.clone(), LEFT, RIGHT), 3, Sampling::Point);
    let (far, _) = samples(&two_charts(noise, shifted(1000.0), RIGHT), 3, Sampling::Point);
    let worst = near.iter().zip(&far).map(|(a, b)| (a.x - b.x).abs() * 255.0).fold(0.0, f32::max);
    // Coordinates of 1000 have 1/16384 left for their fraction.
    assert!(worst < 1.0, "{worst} codes");
}

#[test]
fn what_is_transparent_has_no_vote_about_cuts() {
    let mut pixels = Vec::new();
    for k in 0..256u32 {
        let left = k % 16 < 8;
        pixels.extend(if left { [40, 40, 40, 0] } else { [200, 200, 200, 255] });
    }
    let rgba = Image { width: 16, height: 16, components: 4, pixels: Pixels::U8(pixels) };
    let mut asset = two_charts(rgba, LEFT, RIGHT);
    asset.materials[0].alpha_mode = AlphaMode::Blend;
    let slots = &mut asset.materials[0].slots;
    if let Some(texture) = slots.remove(&Slot::MetallicRoughness) {
        slots.insert(Slot::BaseColor, texture);
    }
    let (values, cuts) = samples(&asset, 1, Sampling::Filtered(None));
    assert!(cuts.edges.iter().all(|cut| !cut));
    let edge = values.iter().find(|v| v.w > 0.2 && v.w < 0.8).expect("the shared edge is half transparent");
    assert!((edge.x - crate::math::transfer::srgb_to_linear(200.0 / 255.0)).abs() < 1e-3, "{edge}");
}

#[test]
fn exponents_follow_their_rule() {
    let asset = two_charts(image(|_, _| 0), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], LEFT);
    let canvas = canvas_of(&asset);
    let channels = channels(&asset, 0, false);
    let sources = [SurfaceSource::new(&channels[0], &asset, &canvas)];
    let with = |rule| wanted_exponents(rule, true, &asset, &canvas, &sources).nearest().faces;
    // Half of 256 texels is half of n² cells at n = 16; 0.3 of that side is 4.8 texels.
    assert_eq!(with(Resolution::Area(1.0)), [[4; 2], [2; 2]]);
    assert_eq!(with(Resolution::Area(4.0)), [[5; 2], [3; 2]]);
    assert_eq!(with(Resolution::Fixed(3)), [[3; 2], [3; 2]]);
    // Sides of 1 unit stand at three times that in the scene.
    assert_eq!(with(Resolution::Density(10.0)), [[5; 2], [5; 2]]);
    // A flattened instance has no volume, but its faces have their area.
    let mut flat = asset.clone();
    flat.instances[0].transform = glam::Affine3A::from_scale(Vec3::new(3.0, 3.0, 0.0));
    let flattened = wanted_exponents(Resolution::Density(10.0), true, &flat, &canvas, &sources).nearest();
    assert_eq!(flattened.faces, [[5; 2]; 2]);
}

/// Models of any size, down to none at all, are sampled alike.
#[test]
fn faces_without_area_still_show_their_texture() {
    for size in [0.0, 1e-15, 1e6] {
        let mut asset = two_charts(image(|_, _| 90), LEFT, RIGHT);
        asset.meshes[0].primitives[0].positions.iter_mut().for_each(|position| *position *= size);
        for kernel in [Sampling::Point, Sampling::Filtered(None)] {
            let (values, _) = samples(&asset, 2, kernel);
            assert!(values.iter().all(|v| (v.x * 255.0 - 90.0).abs() < 0.01), "size {size}: {values:?}");
        }
    }
}

/// Faces of more than one window: rows agree with single fetches, and strata with the mean of the source.
#[test]
fn large_faces_are_read_as_small_ones() {
    let noise = image(|x, y| (x * 37 + y * 91) as u8);
    for uvs in [LEFT, [[-3.0, 0.2], [7.0, 4.0], [1.0, 9.0]]] {
        let asset = two_charts(noise.clone(), uvs, RIGHT);
        let canvas = canvas_of(&asset);
        let channels = channels(&asset, 0, false);
        let source = SurfaceSource::new(&channels[0], &asset, &canvas);
        let resolutions = Resolutions::uniform(vec![6; 2]);
        let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
        let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
        let point = sample(&source, &numbering, Vec::new(), Sampling::Point, &Unwatched).unwrap().values;
        for (i, j) in (1..64).flat_map(|j| (1..64 - j).map(move |i| (i, j))) {
            let found = point[numbering.tap(0, i, j).samples[0] as usize];
            let wanted = source.at(&canvas, 0, i as f32 / 64.0, j as f32 / 64.0);
            assert!((found - wanted).abs().max_element() < 3e-4, "{i} {j}: {found}, {wanted}");
        }
        let [coarse, fine] = [4, 16].map(|k| {
            sample(&source, &numbering, Vec::new(), Sampling::Filtered(Some(k)), &Unwatched).unwrap().values
        });
        let worst = coarse.iter().zip(&fine).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
        assert!(worst > 0.0 && worst < 0.05, "{worst}");
    }
}
