//! Levels far beyond vertex colors: no model that fits a file has twenty of them, so layout, rules, solver and texels are
//! driven directly, with black and white vertices at each level as if no filter had come before.

use glam::{Vec3, Vec4};
use meshcolor::asset::{Asset, Face, Mesh, Primitive, Slot};
use meshcolor::assign::{Codec, LevelChannel, LevelValues, paint, rules};
use meshcolor::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions};
use meshcolor::finished::{
    Anchor, Coordinates, Finished, FinishedPrimitive, FinishedTexture, FinishedTriangle,
};
use meshcolor::image::{Image, Transfer};
use meshcolor::layout::{self, Layout, LayoutRequest, arrange};
use meshcolor::mesh::{CanvasMesh, Polygons, build};
use meshcolor::solve::{Problem, Solution, solve};
use meshcolor::watch::Unwatched;

use crate::patches::{Patch, Random};
use crate::reading::jumps_codes;

/// What one level came to.
#[derive(Debug)]
pub struct FarLevel {
    pub level: usize,
    /// Largest violation that the solver left, linear values.
    pub residual: f64,
    /// Largest jump over all edges, codes.
    pub jump_codes: f32,
    /// Largest difference of the shown and the solved vertices, codes.
    pub apart_codes: f32,
    /// Largest and mean change of a vertex, linear values.
    pub change_max: f64,
    pub change_mean: f64,
}

/// Faces of exponent 0, every level up to `last`. The picture is gray; `transfer` says how it is stored.
///
/// # Panics
/// Where a stage refuses.
pub fn far_levels(patch: &Patch, last: usize, transfer: Transfer, seed: u64) -> Vec<FarLevel> {
    let faces: Vec<Face> =
        patch.faces.iter().map(|corners| face(&corners.iter().map(|c| c.0).collect::<Vec<_>>())).collect();
    let canvas = build([Polygons {
        mesh: 0,
        primitive: 0,
        positions: &patch.positions,
        faces: &mut faces.iter().map(|face| (face.corners, face.count)),
    }]);
    let resolutions = Resolutions::uniform(vec![0; faces.len()]);
    let cuts = Cuts::none(&canvas);
    let layouts = arrange(&[LayoutRequest {
        canvas: &canvas,
        resolutions: &resolutions,
        diagonals: &vec![0; faces.len()],
        level_count: last + 1,
        side_limit: 16_384,
        part_side: 16_384,
        coordinates: layout::Coordinates::Scaled,
    }]);
    let layout = layouts.expect("a small layout").remove(0);
    let topology = ChannelTopology::new(&canvas, &resolutions, &cuts);
    let stages = Stages { patch, faces: &faces, canvas: &canvas, layout: &layout, cuts: &cuts, transfer };
    let mut random = Random::new(seed);
    let wanted: Vec<f64> = (0..topology.fan_count()).map(|_| random.below(2) as f64).collect();
    (0..=last)
        .map(|level| stages.level(&LevelNumbering::new(&canvas, &topology, &resolutions, level), &wanted))
        .collect()
}

fn face(corners: &[u32]) -> Face {
    match *corners {
        [a, b, c] => Face::triangle([a, b, c]),
        [a, b, c, d] => Face::quad([a, b, c, d]),
        _ => panic!("faces have three or four corners"),
    }
}

struct Stages<'a> {
    patch: &'a Patch,
    faces: &'a [Face],
    canvas: &'a CanvasMesh,
    layout: &'a Layout,
    cuts: &'a Cuts,
    transfer: Transfer,
}

impl Stages<'_> {
    fn level(&self, numbering: &LevelNumbering<'_>, wanted: &[f64]) -> FarLevel {
        let codec = Codec { transfer: self.transfer, components: 1, bits: 8 };
        let channel = LevelChannel { layout: self.layout, numbering, cuts: self.cuts, codec, frames: None };
        let rules = rules(&channel);
        let gray = |value: f64| Vec4::splat(value as f32).truncate().extend(1.0);
        let mut values = LevelValues::new(wanted.iter().map(|&value| gray(value)).collect(), wanted.len());
        let of_rules: Vec<f64> = rules.variables().iter().map(|&sample| wanted[sample as usize]).collect();
        let weights = vec![1.0; of_rules.len()];
        let problem = Problem {
            rules: &rules,
            wanted: &of_rules,
            weights: &weights,
            center: 0.5,
            bounds: Some([0.0, 1.0]),
        };
        let Solution { values: solved, residual, .. } = solve(&problem, &|| false);
        for (&sample, &value) in rules.variables().iter().zip(&solved) {
            (0..3).for_each(|component| values.set(sample as usize, component, value));
        }
        let image = paint(
            &channel,
            &values,
            meshcolor::assign::Storing { rounding: meshcolor::assign::Rounding::Rules, range: None },
            &Unwatched,
        )
        .expect("nobody cancels");
        let (asset, finished) = self.finished(image, numbering.level);
        let changes = || solved.iter().zip(&of_rules).map(|(solved, wanted)| (solved - wanted).abs());
        FarLevel {
            level: numbering.level,
            residual,
            jump_codes: jumps_codes(&asset, &finished, 0)[numbering.level],
            apart_codes: self.apart_codes(&finished, numbering, &values),
            change_max: changes().fold(0.0, f64::max),
            change_mean: changes().sum::<f64>() / wanted.len() as f64,
        }
    }

    /// As a conversion would end, all levels but the one being empty.
    fn finished(&self, image: Image, level: usize) -> (Asset, Finished) {
        let triangle = |(number, face): (usize, &Face)| {
            let one = |corners: &[usize; 3]| FinishedTriangle {
                vertices: corners.map(|corner| face.corners[corner]),
                corners: corners.map(|corner| self.layout.corner(number, corner)),
                anchor: Anchor::Offset(self.layout.offset(number)),
            };
            face.triangles().iter().map(one).collect::<Vec<_>>()
        };
        let triangles: Vec<_> = self.faces.iter().enumerate().flat_map(triangle).collect();
        let mut levels =
            vec![
                Image { width: 1, height: 1, components: 1, pixels: meshcolor::image::Pixels::U8(vec![0]) };
                level
            ];
        levels.push(image);
        let texture = FinishedTexture {
            materials: vec![0],
            part: 0,
            slots: vec![Slot::BaseColor],
            transfer: self.transfer,
            ranges: Default::default(),
            value_scale: None,
            levels,
        };
        let piece = FinishedPrimitive {
            mesh: 0,
            primitive: 0,
            material: 0,
            part: 0,
            coordinates: Coordinates::Scaled,
            triangles,
            frames: vec![],
            cuts: vec![],
        };
        let primitive =
            Primitive { material: Some(0), positions: self.patch.positions.clone(), ..Primitive::default() };
        let mesh = Mesh { name: String::new(), primitives: vec![primitive] };
        let asset = Asset { meshes: vec![mesh], ..Asset::default() };
        (asset, Finished { textures: vec![texture], primitives: vec![piece], ..Finished::default() })
    }

    /// What the surface shows at corners against what the solver said.
    fn apart_codes(&self, finished: &Finished, numbering: &LevelNumbering<'_>, values: &LevelValues) -> f32 {
        let texture = &finished.textures[0];
        let encoded = |value: f32| {
            if self.transfer == Transfer::Srgb {
                meshcolor::math::transfer::linear_to_srgb(value)
            } else {
                value
            }
        };
        let piece = &finished.primitives[0];
        let mut triangles = 0..piece.triangles.len();
        let mut worst: f32 = 0.0;
        for (number, face) in self.canvas.faces.iter().enumerate() {
            for (corners, triangle) in self.faces[number].triangles().iter().zip(&mut triangles) {
                for (k, &corner) in corners.iter().enumerate() {
                    let fan = numbering.topology.fan_of[number][corner % face.count()] as usize;
                    let place = piece.place_at(triangle, Vec3::AXES[k], numbering.level);
                    let shown =
                        crate::reading::shown_codes(&texture.levels[numbering.level], self.transfer, place).x;
                    worst = worst.max((shown - encoded(values.fans[fan].x as f32) * 255.0).abs());
                }
            }
        }
        worst
    }
}
