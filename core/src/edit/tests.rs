use std::collections::BTreeSet;

use glam::{DVec3, Vec2, Vec3, Vec4};

use super::nearest::Surface;
use super::painting::{PaintedChannel, Painting, paintings};
use super::side::{Side, spots};
use super::*;
use crate::asset::{Attribute, Face, Material, Mesh, MorphTarget, Primitive, Slot};
use crate::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions};
use crate::error::ErrorCode;
use crate::filter::{Level, MeshColors as Filtered, Triangles};
use crate::math::random::Random;
use crate::mesh::merge;
use crate::mip::{Beyond, Coarsener, MipFilter, Rungs};
use crate::pipeline::painted::sample_counts;
use crate::pipeline::prepare::canvas_of;
use crate::read::{Limits, Upload, read};
use crate::watch::Unwatched;

mod reshaped;
mod transferred;

/// A box of four quads, a pair of triangles and two triangles alone, with one cut edge; every sample another random value.
fn painted_box(seed: u64) -> Asset {
    let mut random = Random(seed);
    let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32 * 1.5, (k >> 2 & 1) as f32 * 2.0);
    let quads = [[0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = [[0, 2, 3], [3, 1, 0], [4, 5, 7], [7, 6, 4]];
    let faces = quads.map(Face::quad).into_iter().chain(triangles.map(Face::triangle)).collect();
    let positions: Vec<Vec3> = (0..8).map(corner).collect();
    let normals =
        positions.iter().map(|position| (*position - Vec3::new(0.5, 0.75, 1.0)).normalize()).collect();
    let primitive = Primitive { material: Some(0), positions, normals, faces, ..Primitive::default() };
    let mesh = Mesh { name: "box".into(), primitives: vec![primitive] };
    let material = Material { base_color_factor: Vec4::ONE, normal_scale: 1.0, ..Material::default() };
    let mut asset = Asset { meshes: vec![mesh], materials: vec![material], ..Asset::default() };
    let partners = vec![None, None, None, None, Some(5), Some(4), None, None];
    let canvas = merge(&canvas_of(&asset, 0), &partners).canvas;
    let exponents = canvas.faces.iter().map(|face| {
        let r = random.below(4) as u8;
        [r, if face.is_triangle() { r } else { random.below(4) as u8 }]
    });
    let resolutions = Resolutions { faces: exponents.collect() };
    let mut cuts = Cuts::none(&canvas);
    cuts.edges[random.below(canvas.edges.len() as u32) as usize] = true;
    let channel = |slot: Slot, components: u8, cuts: &Cuts, random: &mut Random| {
        let topology = ChannelTopology::new(&canvas, &resolutions, cuts);
        let count: u64 = sample_counts(&canvas, &resolutions, &topology).iter().sum();
        let samples: Vec<f32> = (0..count * u64::from(components)).map(|_| random.unit()).collect();
        MeshColorChannel {
            slots: vec![slot],
            components,
            bits: 8,
            cuts: crate::pipeline::painted::cut_bits(&canvas, cuts),
            samples,
            value_scale: None,
            tangents: Vec::new(),
        }
    };
    let channels = vec![
        channel(Slot::BaseColor, 3, &cuts, &mut random),
        channel(Slot::Occlusion, 1, &Cuts::none(&canvas), &mut random),
    ];
    let colors = MeshColors { partners, exponents: resolutions.faces.clone(), channels };
    asset.materials[0].mesh_colors = Some(colors);
    asset
}

/// What the file of an edit holds.
fn reread(edited: &Edited) -> Asset {
    read(&Upload::single("edited.glb", edited.glb.clone()), &Limits::default(), &Unwatched).unwrap()
}

fn painting(asset: &Asset) -> Painting {
    paintings(asset).unwrap().remove(0)
}

fn shown(painting: &Painting, channel: &PaintedChannel, places: &[(usize, Vec2)]) -> Vec<Vec4> {
    let numbering = painting.numbering(channel, 0);
    let level = [Level { numbering: &numbering, values: &channel.values }];
    let filter = Filtered::new(&level, Triangles::Linear).unwrap();
    places.iter().map(|&(face, at)| filter.linear(face, at, 0)).collect()
}

/// Random places of a face.
fn places(painting: &Painting, face: usize, random: &mut Random) -> Vec<(usize, Vec2)> {
    let is_triangle = painting.canvas.faces[face].is_triangle();
    let mut place = || {
        let at = Vec2::new(random.unit(), random.unit());
        (face, if is_triangle && at.x + at.y > 1.0 { Vec2::ONE - at } else { at })
    };
    (0..40).map(|_| place()).collect()
}

fn assert_near(before: &[Vec4], after: &[Vec4], what: &str) {
    for (place, (before, after)) in before.iter().zip(after).enumerate() {
        assert!((*before - *after).abs().max_element() < 2e-6, "{what}, place {place}: {before} {after}");
    }
}

/// Each old sample's bits, which are random, are among the new ones'.
fn assert_kept(before: &PaintedChannel, after: &PaintedChannel, what: &str) {
    let bits = |value: &Vec4| value.to_array().map(f32::to_bits);
    let after: BTreeSet<_> = after.values.iter().map(bits).collect();
    let lost = before.values.iter().filter(|value| !after.contains(&bits(value))).count();
    assert_eq!(lost, 0, "{what}: samples were lost of {}", before.values.len());
}

fn change(by: i8) -> ResolutionChange {
    ResolutionChange { by, filter: MipFilter::Uniform }
}

#[test]
fn finer_faces_show_what_they_showed() {
    for seed in 0..20 {
        let asset = painted_box(seed);
        let before = painting(&asset);
        let faces = if seed % 2 == 0 { None } else { Some(vec![[1, 3], [5, 5]]) };
        let selection = Selection { material: None, faces: faces.clone() };
        let by = 1 + (seed % 3) as i8;
        let edited = resolution(&asset, &selection, change(by), &Limits::default(), &Unwatched).unwrap();
        let after = painting(&reread(&edited));
        let mut random = Random(seed);
        for (old, new) in before.channels.iter().zip(&after.channels) {
            assert_kept(old, new, "finer");
            assert!(new.values.len() > old.values.len());
            for face in 0..before.canvas.faces.len() {
                let is_meant = faces.is_none() || [1, 2, 3, 5].contains(&face);
                let by = if is_meant { by as u8 } else { 0 };
                assert_eq!(after.resolutions.faces[face], before.resolutions.faces[face].map(|e| e + by));
                let places = places(&before, face, &mut random);
                assert_near(&shown(&before, old, &places), &shown(&after, new, &places), "finer");
            }
        }
    }
}

#[test]
fn coarser_faces_show_the_next_level() {
    for seed in 0..20 {
        let mut asset = painted_box(seed);
        // Two samples along every edge at least, so that no vertex is beyond vertex colors.
        let up =
            resolution(&asset, &Selection::default(), change(1), &Limits::default(), &Unwatched).unwrap();
        asset = reread(&up);
        let before = painting(&asset);
        let edited =
            resolution(&asset, &Selection::default(), change(-1), &Limits::default(), &Unwatched).unwrap();
        let after = painting(&reread(&edited));
        for (old, new) in before.channels.iter().zip(&after.channels) {
            let levels: [LevelNumbering; 2] = [0, 1].map(|level| before.numbering(old, level));
            let rungs = Rungs { filter: MipFilter::Uniform, beyond: Beyond::OneRing, by_alpha: false };
            let [fine, coarse] = levels.each_ref();
            let wanted =
                Coarsener::new(rungs).coarsen([fine, coarse], &old.values, Vec::new(), &Unwatched).unwrap();
            assert_eq!(wanted, new.values, "seed {seed}");
        }
    }
}

#[test]
fn beside_coarser_faces_the_others_keep_their_samples() {
    let asset = painted_box(3);
    let up = resolution(&asset, &Selection::default(), change(2), &Limits::default(), &Unwatched).unwrap();
    let asset = reread(&up);
    let before = painting(&asset);
    let selection = Selection { material: Some(0), faces: Some(vec![[2, 2]]) };
    let edited = resolution(&asset, &selection, change(-2), &Limits::default(), &Unwatched).unwrap();
    let after = painting(&reread(&edited));
    for (old, new) in before.channels.iter().zip(&after.channels) {
        let (from, to) = (before.numbering(old, 0), after.numbering(new, 0));
        for face in (0..before.canvas.faces.len()).filter(|face| *face != 2) {
            assert_eq!(old.values[from.face_range(face)], new.values[to.face_range(face)]);
        }
        // Every vertex has another face.
        let fans = old.topology.fan_count();
        assert_eq!(old.values[..fans], new.values[..fans]);
        assert!(new.values.len() < old.values.len());
    }
}

#[test]
fn what_cannot_be_is_said() {
    let asset = painted_box(1);
    let try_by = |faces: Option<Vec<[u32; 2]>>, material, by| {
        let selection = Selection { material, faces };
        resolution(&asset, &selection, change(by), &Limits::default(), &Unwatched).unwrap_err()
    };
    for (error, words) in [
        (try_by(None, None, 0), "changes nothing"),
        (try_by(None, None, 12), "12 is the largest"),
        (try_by(None, Some(3), 1), "material 3 has no mesh colors; materials that have: 0"),
        (try_by(Some(vec![[2, 7]]), None, 1), "numbered 0 to 6"),
    ] {
        assert_eq!(error.code, ErrorCode::InvalidOptions);
        assert!(error.detail.contains(words), "{}", error.detail);
    }
    let limits = Limits { job_pixels: 1000, ..Limits::default() };
    let error = resolution(&asset, &Selection::default(), change(5), &limits, &Unwatched).unwrap_err();
    assert_eq!((error.code, error.limit), (ErrorCode::ModelTooLarge, Some(1000)));
    let mut bare = asset.clone();
    bare.materials[0].mesh_colors = None;
    let error =
        resolution(&bare, &Selection::default(), change(1), &Limits::default(), &Unwatched).unwrap_err();
    assert_eq!(error.code, ErrorCode::NothingToConvert);
    assert!(error.detail.contains("--mesh-colors"));
}
