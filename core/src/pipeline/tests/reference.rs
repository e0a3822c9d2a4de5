//! What mesh colors are held against: their own samples, read from the model apart from the conversion.

use std::collections::BTreeMap;

use super::*;
use crate::asset::{MeshColorChannel, MeshColors};
use crate::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions};
use crate::measure::{ChannelReport, Extras};
use crate::mesh::{drawn_corners, surface_point};
use crate::pipeline::prepare::canvas_of;
use crate::pipeline::reference::{Reference, with_filters};

/// Corners of a cube, and of its faces.
const CORNERS: usize = 8;
const FACES: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// What a sample holds, by its place.
type Value = fn(Vec3) -> Vec3;

fn corner(number: usize) -> Vec3 {
    let at = |bit: usize| if number >> bit & 1 == 1 { 1.0 } else { -1.0 };
    Vec3::new(at(0), at(1), at(2))
}

/// A cube whose samples are a function of their place, in one channel.
fn cube(slot: Slot, bits: u8, exponents: [u8; 2], value: Value) -> Asset {
    let positions: Vec<Vec3> = (0..CORNERS).map(corner).collect();
    let normals = positions.iter().map(|position| position.normalize()).collect();
    let faces = FACES.map(Face::quad).to_vec();
    let primitive = Primitive { material: Some(0), positions, normals, faces, ..Primitive::default() };
    let mut asset = Asset {
        materials: vec![Material {
            base_color_factor: Vec4::ONE,
            normal_scale: 1.0,
            occlusion_strength: 1.0,
            ..Material::default()
        }],
        meshes: vec![Mesh { name: "cube".into(), primitives: vec![primitive] }],
        ..Asset::default()
    };
    let canvas = canvas_of(&asset, 0);
    let resolutions = Resolutions { faces: vec![exponents; FACES.len()] };
    let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
    let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
    let mut samples = vec![Vec3::NAN; numbering.sample_count()];
    for (number, face) in canvas.faces.iter().enumerate() {
        let shape = numbering.shape(number);
        for (i, j) in (0..=shape.segments[1]).flat_map(|j| (0..shape.point_count(j)).map(move |i| (i, j))) {
            let [s, t] = shape.unit(i, j);
            let (triangle, weights) = surface_point(face.count(), s, t);
            let at = drawn_corners(triangle).map(|k| canvas.positions[face.vertices[k] as usize]);
            let place = at[0] * weights.x + at[1] * weights.y + at[2] * weights.z;
            let tap = numbering.tap(number, i, j);
            if tap.second == 0.0 {
                samples[tap.samples[0] as usize] = value(place);
            }
        }
    }
    let channel = MeshColorChannel {
        slots: vec![slot],
        components: 3,
        bits,
        samples: samples.iter().flat_map(|sample| sample.to_array()).collect(),
        ..MeshColorChannel::default()
    };
    asset.materials[0].mesh_colors = Some(MeshColors {
        partners: vec![None; FACES.len()],
        exponents: resolutions.faces,
        channels: vec![channel],
    });
    asset
}

fn smooth(place: Vec3) -> Vec3 {
    Vec3::new(0.5 + 0.3 * place.x, 0.4 + 0.2 * (2.0 * place.y).sin(), 0.6 - 0.2 * place.z)
}

fn leaning(place: Vec3) -> Vec3 {
    (place.normalize() + Vec3::new((3.0 * place.y).sin(), 0.0, 0.2) * 0.3).normalize()
}

fn exact() -> Options {
    Options { range: Range::Unorm8, ..Options::default() }
}

/// What a report says of the one channel of a conversion, beside its source.
fn measured(asset: &Asset, finished: &Finished) -> ChannelReport {
    let references = Reference::finest(asset, &Unwatched).unwrap();
    let measured = with_filters(&references, |painted| {
        crate::measure::converted(asset, finished, painted, &Extras::default(), &Unwatched)
    });
    measured.unwrap().unwrap().channels.remove(0)
}

fn spoil(finished: &mut Finished, level: usize, by: u8) {
    let Pixels::U8(codes) = &mut finished.textures[0].levels[level].pixels else { panic!("8 bits") };
    codes.iter_mut().for_each(|code| *code = code.saturating_add(by));
}

#[test]
fn an_exact_conversion_has_next_to_no_error() {
    let kinds: [(Slot, u8, Value, f64); 4] = [
        (Slot::BaseColor, 8, smooth, 0.4),
        (Slot::MetallicRoughness, 8, smooth, 0.4),
        (Slot::MetallicRoughness, 16, smooth, 0.002),
        // Frames turn between texels, and with them what is stored there is mixed otherwise.
        (Slot::Normal, 16, leaning, 0.25),
    ];
    for (slot, bits, value, bound) in kinds {
        for exponents in [[4, 4], [5, 3]] {
            let asset = cube(slot, bits, exponents, value);
            let (finished, _) = finish(&asset, &exact());
            let channel = measured(&asset, &finished);
            let fidelity = channel.fidelity.unwrap();
            println!("{slot:?}, {bits} bits, {exponents:?}: {fidelity:?}");
            assert!(fidelity.rms > 0.0 && fidelity.rms < bound, "{slot:?} {bits}: {fidelity:?}");
            assert!(fidelity.max < 4.0 * bound && fidelity.psnr_db > 55.0, "{slot:?} {bits}: {fidelity:?}");
            assert_eq!((fidelity.yardstick_psnr_db, fidelity.yardstick_rms), (None, None));
            assert!(fidelity.point_count >= 1024);
            assert_eq!(channel.levels[0].mip_error, None);
            assert!(channel.levels[1..].iter().all(|level| level.mip_error.is_some()));
        }
    }
}

#[test]
fn spoiled_texels_are_found_at_their_level() {
    let asset = cube(Slot::MetallicRoughness, 8, [4, 4], smooth);
    let (finished, _) = finish(&asset, &exact());
    let whole = measured(&asset, &finished);
    let mut spoiled = finished.clone();
    spoil(&mut spoiled, 0, 7);
    let found = measured(&asset, &spoiled);
    assert!((found.fidelity.unwrap().rms - 7.0).abs() < 0.2, "{:?}", found.fidelity);
    assert_eq!(found.levels[1].mip_error, whole.levels[1].mip_error);
    let mut spoiled = finished.clone();
    spoil(&mut spoiled, 2, 30);
    let found = measured(&asset, &spoiled);
    assert_eq!(found.fidelity, whole.fidelity);
    let rms = |channel: &ChannelReport, level: usize| channel.levels[level].mip_error.unwrap().rms;
    assert!(rms(&whole, 2) < 12.0 && rms(&found, 2) > 20.0, "{} {}", rms(&whole, 2), rms(&found, 2));
    assert_eq!(rms(&found, 3), rms(&whole, 3));
}

/// Samples that are changed after the conversion are not what it shows.
#[test]
fn other_samples_are_another_source() {
    for (slot, value) in [(Slot::BaseColor, smooth as Value), (Slot::Normal, leaning)] {
        let mut asset = cube(slot, 8, [4, 4], value);
        let (finished, _) = finish(&asset, &exact());
        let before = measured(&asset, &finished).fidelity.unwrap();
        let turned = |n: &mut [f32]| n.rotate_left(1);
        let colors = asset.materials[0].mesh_colors.as_mut().unwrap();
        colors.channels[0].samples.chunks_exact_mut(3).for_each(turned);
        let after = measured(&asset, &finished).fidelity.unwrap();
        assert!(after.rms > 20.0 && before.rms < 1.0, "{slot:?}: {before:?} {after:?}");
    }
}

/// The references' levels are what a conversion stores, where it has nothing to change.
#[test]
fn levels_are_those_of_a_conversion() {
    for (slot, value) in [(Slot::BaseColor, smooth as Value), (Slot::Normal, leaning)] {
        let asset = cube(slot, 16, [4, 3], value);
        let (finished, materials) = finish(&asset, &exact());
        let channel = &materials[0].channels[0];
        assert!(channel.solver.is_empty(), "{slot:?}");
        let references = Reference::beside(&asset, &finished, &exact(), &Unwatched).unwrap();
        let seen = with_filters(&references, |painted| {
            let colors = &painted[0].channel(slot).unwrap().colors;
            let stored: &Vec<Vec<Vec4>> = &channel.samples;
            // Corner 0 of a face is its vertex's sample at every level.
            let fan = |face: usize| {
                let canvas = &materials[0].canvas;
                let topology = ChannelTopology::new(canvas, &materials[0].resolutions, &channel.cuts);
                topology.fan_of[face][0] as usize
            };
            let at = |level: usize| {
                (0..FACES.len())
                    .map(|face| (colors.linear(face, Vec2::ZERO, level), stored[level][fan(face)]))
                    .collect::<Vec<_>>()
            };
            (0..stored.len()).map(|level| (level, at(level))).collect::<BTreeMap<_, _>>()
        });
        let seen = seen.unwrap();
        assert!(seen.len() > 4);
        for (level, pairs) in seen {
            assert!(pairs.iter().all(|(reference, stored)| reference == stored), "{slot:?}, level {level}");
        }
    }
}

/// A model without mesh colors has no reference.
#[test]
fn textures_have_none() {
    assert!(Reference::finest(&noise_asset(1, 3, Slot::BaseColor), &Unwatched).unwrap().is_empty());
}
