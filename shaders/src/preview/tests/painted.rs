//! Sources with mesh colors: their column is what the filters of mesh colors make of the samples.

use glam::{Vec2, Vec3};
use meshcolor::asset::{Asset, MeshColorChannel, MeshColors};
use meshcolor::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions};
use meshcolor::mesh::{Polygons, build};
use meshcolor::pipeline::convert_asset;
use meshcolor::read::Limits;

use super::*;

/// Along both sides of every quad.
const EXPONENT: u8 = 4;

/// The ball with mesh colors instead of textures.
fn painted_ball() -> Asset {
    let mut asset = sample::ball().asset;
    asset.images.clear();
    asset.materials[0].slots = Default::default();
    let primitive = &asset.meshes[0].primitives[0];
    let face_count = primitive.faces.len();
    let mut faces = primitive.faces.iter().map(|face| (face.corners, face.count));
    let positions = &primitive.positions;
    let canvas = build([Polygons { mesh: 0, primitive: 0, positions, faces: &mut faces }]);
    let resolutions = Resolutions::uniform(vec![EXPONENT; face_count]);
    let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
    let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
    let mut places = vec![Vec3::NAN; numbering.sample_count()];
    for face in 0..face_count {
        let shape = numbering.shape(face);
        for (i, j) in (0..=shape.segments[1]).flat_map(|j| (0..shape.point_count(j)).map(move |i| (i, j))) {
            let at = sample::on_ball(face, Vec2::from(shape.unit(i, j)));
            places[numbering.tap(face, i, j).samples[0] as usize] = at;
        }
    }
    let channel = |slot, value: &dyn Fn(Vec3) -> Vec3| MeshColorChannel {
        slots: vec![slot],
        components: 3,
        bits: 8,
        samples: places.iter().flat_map(|place| value(*place).to_array()).collect(),
        ..MeshColorChannel::default()
    };
    let color = |place: Vec3| sample::color(place, 0.0);
    asset.materials[0].mesh_colors = Some(MeshColors {
        partners: vec![None; face_count],
        exponents: resolutions.faces.clone(),
        channels: vec![
            channel(Slot::BaseColor, &color),
            channel(Slot::Normal, &sample::object_normal),
            channel(Slot::MetallicRoughness, &|place| {
                Vec3::new(0.0, 0.5 + 0.3 * place.x, 0.5 - 0.4 * place.y)
            }),
            channel(Slot::Occlusion, &|place| Vec3::splat(0.75 + 0.25 * place.z)),
            channel(Slot::Emissive, &|place| (0.1 * place).max(Vec3::ZERO)),
        ],
    });
    asset.materials[0].emissive_factor = Vec3::ONE;
    asset.materials[0].metallic_factor = 1.0;
    asset
}

fn converted(asset: Asset) -> Conversion {
    convert_asset(asset, &Options::default(), &Limits::default(), &Unwatched).expect("it converts")
}

/// Both sides of the whole asset, on the CPU.
fn pictures(conversion: &Conversion, look: Look, filter: Filter) -> [Picture; 2] {
    let references = references(conversion).expect("samples fit their faces");
    let drawn = with_filters(&references, |painted| {
        let scene = Scene::new(&conversion.asset, &conversion.finished, painted).expect("it is consistent");
        let View { subject, camera, size, .. } = whole(&scene, None);
        [Side::Source, Side::Converted].map(|side| {
            let batches = scene.batches(subject, &camera, side, look);
            let shot = Shot { batches: &batches, camera, size, filter, look, painted: scene.painted };
            cpu().draw(&scene.textures, &shot).expect("the CPU draws")
        })
    });
    drawn.expect("samples fit their numbering")
}

/// Mean, and share beyond eight codes.
fn apart(pictures: &[Picture; 2]) -> (f64, f64) {
    let difference = differences(&pictures[0], &pictures[1]);
    let count = difference.len() as f64;
    let far = difference.iter().filter(|d| **d > 8).count() as f64;
    (difference.iter().map(|d| f64::from(*d)).sum::<f64>() / count, far / count)
}

/// Two instances stand there, one of them mirrored.
#[test]
fn mesh_colors_look_as_their_conversion() {
    let conversion = converted(painted_ball());
    let looks = [Look::Lit].into_iter().chain(Slot::CORE.map(Look::Flat));
    for look in looks {
        for filter in [Filter::Trilinear, Filter::Level(0), Filter::Level(2), Filter::Level(5)] {
            let pictures = pictures(&conversion, look, filter);
            let (mean, far) = apart(&pictures);
            println!("{look:?}, {filter:?}: mean {mean:.3} codes, {:.3} % beyond 8", far * 100.0);
            assert!(mean < 0.4 && far < 0.0005, "{look:?}, {filter:?}: {mean} {far}");
            assert!(
                pictures[0].rgb.chunks(3).any(|pixel| pixel != &pictures[0].rgb[..3]),
                "{look:?}: all is one"
            );
        }
    }
}

/// What is drawn are the samples, slot by slot, and not the conversion.
#[test]
fn other_samples_look_otherwise() {
    let mut conversion = converted(painted_ball());
    let slots: Vec<Slot> = Slot::CORE.to_vec();
    for (number, slot) in slots.into_iter().enumerate() {
        let before = pictures(&conversion, Look::Flat(slot), Filter::Level(0));
        let colors = conversion.asset.materials[0].mesh_colors.as_mut().expect("it has some");
        let channel = colors.channels.iter_mut().find(|channel| channel.slots.contains(&slot));
        let samples = &mut channel.expect("every slot has one").samples;
        let half = samples.len() / 2;
        samples[..half].chunks_exact_mut(3).for_each(|sample| match slot {
            Slot::Normal => sample.iter_mut().for_each(|value| *value = -*value),
            _ => sample.iter_mut().for_each(|value| *value = 1.0 - *value),
        });
        let after = pictures(&conversion, Look::Flat(slot), Filter::Level(0));
        assert!(before[1].rgb == after[1].rgb, "{number}");
        let (mean, _) = apart(&after);
        assert!(mean > 3.0, "{slot:?}: {mean}");
    }
}

/// By the CPU, also where there is a GPU.
#[test]
fn the_sheet_shows_and_names_mesh_colors() {
    let conversion = converted(painted_ball());
    let drawn = sheet_titled(&conversion, "Painted ball").expect("it is drawn");
    keep("painted_ball.png", &drawn);
    assert_eq!(drawn.renderer, FOR_MESH_COLORS);
    let words = |conversion: &Conversion| {
        let references = references(conversion).expect("samples fit their faces");
        let words = with_filters(&references, |painted| {
            let scene =
                Scene::new(&conversion.asset, &conversion.finished, painted).expect("it is consistent");
            (source_words(&scene), notes(conversion, &scene, false).join(" "))
        });
        words.expect("samples fit their numbering")
    };
    let (heading, notes) = words(&conversion);
    assert_eq!(heading, "mesh colors, filtered as they are");
    assert!(notes.contains("as their own filters read them"), "{notes}");
    assert_eq!(words(&sample::ball()).0, "ordinary mip maps");
}

/// Alpha of the samples decides what a mask shows.
#[test]
fn masks_are_tested_against_samples() {
    let mut asset = painted_ball();
    asset.materials[0].alpha_mode = AlphaMode::Mask(0.5);
    let channel = &mut asset.materials[0].mesh_colors.as_mut().expect("it has some").channels[0];
    channel.components = 4;
    let with_alpha =
        |sample: &[f32]| [sample[0], sample[1], sample[2], (20.0 * sample[0] - 3.0).clamp(0.0, 1.0)];
    channel.samples = channel.samples.chunks_exact(3).flat_map(with_alpha).collect();
    let conversion = converted(asset);
    for filter in [Filter::Level(0), Filter::Level(3)] {
        let pictures = pictures(&conversion, Look::Lit, filter);
        let (mean, far) = apart(&pictures);
        println!("{filter:?}: mean {mean:.3} codes, {:.3} % beyond 8", far * 100.0);
        assert!(mean < 0.4 && far < 0.001, "{filter:?}: {mean} {far}");
    }
}
