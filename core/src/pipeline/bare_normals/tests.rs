use super::*;
use crate::asset::Slot;
use crate::assign::choose_frames;
use crate::colors::{ChannelTopology, Cuts, Resolutions};
use crate::image::Pixels;
use crate::mesh::{Polygons, build};
use crate::pipeline::tests::noise_asset;
use crate::pipeline::{Options, Range, Sampling, Solver, convert_asset};
use crate::read::Limits;
use crate::watch::Unwatched;

/// A normal map that says nothing keeps saying nothing at every level, however the mesh bends.
#[test]
fn a_flat_map_stays_flat_down_to_the_last_level() {
    let mut asset = noise_asset(3, 6, Slot::Normal);
    asset.images[0].pixels = Pixels::U16([32_768, 32_768, 65_535].repeat(64 * 64));
    // As it is filtered, before any texel has to be brought into range.
    let options = Options {
        sampling: Sampling::Point,
        solver: Solver::Clamp,
        range: Range::Unorm8,
        ..Options::default()
    };
    let conversion = convert_asset(asset, &options, &Limits::default(), &Unwatched).unwrap();
    let levels = &conversion.finished.textures[0].levels;
    assert!(levels.len() > 5);
    for (level, image) in levels.iter().enumerate() {
        let Pixels::U16(codes) = &image.pixels else { panic!("level {level} has 8 bits") };
        // Between two samples of a coarse edge a normal is shorter, not turned.
        let turned = codes.chunks(3).filter(|texel| **texel != [0; 3]).map(|texel| {
            let stored = Vec3::from_array([0, 1, 2].map(|k| f32::from(texel[k]) / 32_767.5 - 1.0));
            stored.angle_between(Vec3::Z).to_degrees()
        });
        let worst = turned.fold(0.0, f32::max);
        assert!(worst < 3.0, "level {level}: {worst} degrees");
    }
}

/// Row by row as point by point; and what was taken comes back.
#[test]
fn samples_lose_and_regain_the_normals_of_the_mesh() {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y, Vec3::new(2.0, 0.5, 0.0)];
    let mut faces = [([0, 1, 2, 3], 4), ([1, 4, 2, 0], 3)].into_iter();
    let canvas = build([Polygons { mesh: 0, primitive: 0, positions: &positions, faces: &mut faces }]);
    let at_vertex =
        |vertex: u32| Vec3::new((vertex as f32).sin(), (vertex as f32 * 2.0).cos(), 1.0).normalize();
    let normals: Vec<_> = canvas.faces.iter().map(|face| face.vertices.map(at_vertex)).collect();
    let frames = choose_frames(&canvas, &normals, 1.0);
    let resolutions = Resolutions { faces: vec![[4, 3], [3, 3]] };
    let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
    let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
    let mut values = vec![Vec4::W; numbering.sample_count()];
    take_bare(&numbering, &frames, &mut values);
    for (face, canvas_face) in canvas.faces.iter().enumerate() {
        let shape = numbering.shape(face);
        let points = (0..=shape.segments[1]).flat_map(|j| (0..shape.point_count(j)).map(move |i| (i, j)));
        for (i, j) in points {
            let [s, t] = shape.unit(i, j);
            let (triangle, weights) = surface_point(canvas_face.count(), s, t);
            let of = drawn_corners(triangle);
            let bare = (0..3).map(|k| normals[face][of[k]] * weights[k]).sum::<Vec3>().normalize();
            let taken = numbering.tap(face, i, j).value(&values);
            assert!((taken + bare.extend(-1.0)).length() < 1e-6, "face {face}, {i} {j}: {taken}, {bare}");
        }
    }
    let mut added = vec![Vec4::ZERO; numbering.sample_count()];
    show(&numbering, &frames, &mut added);
    for (shown, taken) in added.iter().zip(&values) {
        assert!((*shown + taken.with_w(-1.0)).length() < 1e-6, "{shown} {taken}");
    }
}
