//! Samples of a new canvas from what an old one showed.

use glam::{Vec4, Vec4Swizzles};

use crate::asset::{Asset, EXPONENT_MAX, MeshColorChannel, MeshColors};
use crate::colors::{ChannelTopology, Cuts, FaceGrid, LevelNumbering, Resolutions, Shape};
use crate::error::{Error, ErrorCode, Result};
use crate::mesh::{CanvasFace, CanvasMesh, merge};
use crate::pipeline::painted::{ModelFaces, cut_bits, sample_counts};
use crate::pipeline::prepare::canvas_of;
use crate::watch::{self, Watch};

use super::painting::{PaintedChannel, Painting};

/// Where a face lies in an old one: by corner, in halves of the old face's sides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    pub face: u32,
    pub corners: [[u8; 2]; 4],
}

/// The corners of a whole face, in halves of its sides.
pub fn whole(is_triangle: bool) -> [[u8; 2]; 4] {
    if is_triangle { [[0, 0], [2, 0], [0, 2], [0, 2]] } else { [[0, 0], [2, 0], [2, 2], [0, 2]] }
}

impl Origin {
    /// By face of the model: where it lies in the painting's faces, which are the same.
    pub fn of_model_faces(painting: &Painting, faces: &ModelFaces) -> Vec<Self> {
        let mut origins = vec![Self::default(); faces.places.len()];
        for (number, face) in (0u32..).zip(&painting.canvas.faces) {
            let whole = whole(face.is_triangle());
            let model_faces = faces.drawn(face);
            for (triangle, drawn) in face.drawn_corners().iter().enumerate() {
                let origin = &mut origins[model_faces[triangle] as usize];
                origin.face = number;
                for (own, corner) in face.drawn[triangle].corners.into_iter().zip(drawn) {
                    origin.corners[usize::from(own)] = whole[*corner];
                }
            }
        }
        origins
    }

    /// Half the length of an edge from a corner to the next, along both axes of the old face.
    fn step(&self, from: usize, to: usize) -> [i32; 2] {
        [0, 1].map(|axis| i32::from(self.corners[to][axis]) - i32::from(self.corners[from][axis]))
    }

    /// The edge of the old face that holds both corners.
    fn old_edge(&self, is_triangle: bool, from: usize, to: usize) -> Option<usize> {
        let both = |is_on: &dyn Fn([u8; 2]) -> bool| is_on(self.corners[from]) && is_on(self.corners[to]);
        let lines: [&dyn Fn([u8; 2]) -> bool; 4] = match is_triangle {
            true => [&|[_, y]| y == 0, &|[x, y]| x + y == 2, &|[x, _]| x == 0, &|_| false],
            false => [&|[_, y]| y == 0, &|[x, _]| x == 2, &|[_, y]| y == 2, &|[x, _]| x == 0],
        };
        lines.iter().position(|line| both(line))
    }

    /// What the old face showed at a point of the new face's grid.
    fn value(&self, old: &FaceGrid, shape: Shape, [i, j]: [u32; 2]) -> (Vec4, bool) {
        let last = if shape.is_triangle { 2 } else { 3 };
        let [x, y] = [0, 1].map(|axis| {
            let along = |from: u32, corner: usize, segments: u32| {
                from as f32 * self.step(0, corner)[axis] as f32 / segments as f32
            };
            // Exact: all are small multiples of powers of two.
            let halves = f32::from(self.corners[0][axis])
                + along(i, 1, shape.segments[0])
                + along(j, last, shape.segments[1]);
            halves * 0.5 * old.shape.segments[axis] as f32
        });
        if x.fract() == 0.0 && y.fract() == 0.0 {
            return (old.at(x as u32, y as u32), true);
        }
        (old.value(x, y), false)
    }
}

/// A material's faces after an edit.
pub struct Sketch {
    pub canvas: CanvasMesh,
    /// By face of the model.
    pub partners: Vec<Option<u32>>,
    pub resolutions: Resolutions,
    /// By face.
    origins: Vec<Origin>,
}

impl Sketch {
    /// `asset`, `partners` and `model_origins` (both by face of the model): after the edit. `raise`: how many exponents
    /// more a part of an old face has than it had.
    ///
    /// # Errors
    /// `InvalidOptions` where an exponent would be above the largest.
    pub fn new(
        old: &Painting,
        asset: &Asset,
        (partners, model_origins): (Vec<Option<u32>>, &[Origin]),
        raise: impl Fn(u32) -> u8,
    ) -> Result<Self> {
        let canvas = merge(&canvas_of(asset, old.material), &partners).canvas;
        let faces = ModelFaces::of(asset, old.material);
        let origin = |face: &CanvasFace| {
            let [one, other] = faces.drawn(face).map(|number| model_origins[number as usize]);
            let [a, b, c] = face.drawn[0].corners.map(|corner| one.corners[usize::from(corner)]);
            let d = if face.is_triangle() { c } else { other.corners[usize::from(face.drawn[1].corners[2])] };
            Origin { face: one.face, corners: [a, b, c, d] }
        };
        let origins: Vec<Origin> = canvas.faces.iter().map(origin).collect();
        let exponents = origins.iter().zip(&canvas.faces).map(|(origin, face)| {
            let of_old = old.resolutions.faces[origin.face as usize];
            let along = |from: usize, to: usize| {
                let step = origin.step(from, to);
                let is_half = step.iter().all(|length| length.abs() < 2);
                // Of a triangle both are the same.
                let axis = usize::from(step[0] == 0);
                (of_old[axis] + raise(origin.face)).saturating_sub(u8::from(is_half))
            };
            [along(0, 1), along(0, if face.is_triangle() { 2 } else { 3 })]
        });
        let resolutions = Resolutions { faces: exponents.collect() };
        if let Some(face) = resolutions.faces.iter().position(|pair| pair.iter().any(|e| *e > EXPONENT_MAX)) {
            let from = old.resolutions.faces[origins[face].face as usize];
            return Err(Error::new(
                ErrorCode::InvalidOptions,
                format!(
                    "face {} of material {} has the exponents {} and {}, and {EXPONENT_MAX} is the largest; raise it by less",
                    origins[face].face, old.material, from[0], from[1]
                ),
            ));
        }
        Ok(Self { canvas, partners, resolutions, origins })
    }

    /// By edge: whether it lies on an edge that was a cut.
    fn cuts(&self, old: &Painting, channel: &PaintedChannel) -> Cuts {
        let mut cuts = Cuts::none(&self.canvas);
        for (face, origin) in self.canvas.faces.iter().zip(&self.origins) {
            let old_face = &old.canvas.faces[origin.face as usize];
            for k in 0..face.count() {
                let edge = origin.old_edge(old_face.is_triangle(), k, (k + 1) % face.count());
                let is_shared = self.canvas.sides(&self.canvas.edges[face.edges[k] as usize]).len() > 1;
                let is_cut = edge.is_some_and(|edge| channel.cuts.edges[old_face.edges[edge] as usize]);
                cuts.edges[face.edges[k] as usize] |= is_cut && is_shared;
            }
        }
        cuts
    }

    /// By face and corner. Where a corner is new any frame will do, for the face as a whole.
    fn tangents(&self, old: &Painting, channel: &PaintedChannel) -> Vec<[[f32; 4]; 4]> {
        let none = [[0.0; 4]; 4];
        let of_face = |origin: &Origin| {
            let whole = whole(old.canvas.faces[origin.face as usize].is_triangle());
            let mut tangents = none;
            for (tangent, corner) in tangents.iter_mut().zip(origin.corners) {
                let Some(old_corner) = whole.iter().position(|old| *old == corner) else { return none };
                *tangent = channel.tangents[origin.face as usize][old_corner];
            }
            tangents
        };
        if channel.tangents.is_empty() {
            return Vec::new();
        }
        let tangents: Vec<_> = self.origins.iter().map(of_face).collect();
        if tangents.iter().all(|own| *own == none) { Vec::new() } else { tangents }
    }

    /// The mesh colors of all channels.
    ///
    /// # Errors
    /// `Canceled`; `ModelTooLarge` beyond `samples_max` samples.
    pub fn colors(&self, old: &Painting, samples_max: u64, watch: &dyn Watch) -> Result<MeshColors> {
        let mut prepared = Vec::with_capacity(old.channels.len());
        let mut count = 0;
        for channel in &old.channels {
            let cuts = self.cuts(old, channel);
            let topology = ChannelTopology::new(&self.canvas, &self.resolutions, &cuts);
            count += sample_counts(&self.canvas, &self.resolutions, &topology).iter().sum::<u64>();
            prepared.push((cuts, topology));
        }
        if count > samples_max {
            let detail = format!(
                "material {} would have {count} samples, and {samples_max} are allowed",
                old.material
            );
            return Err(Error::new(ErrorCode::ModelTooLarge, detail).limit(samples_max, count));
        }
        let mut channels = Vec::with_capacity(old.channels.len());
        for (channel, (cuts, topology)) in old.channels.iter().zip(prepared) {
            watch::check(watch)?;
            channels.push(self.channel(old, channel, &cuts, &topology));
        }
        Ok(MeshColors {
            partners: self.partners.clone(),
            exponents: self.resolutions.faces.clone(),
            channels,
        })
    }

    fn channel(
        &self,
        old: &Painting,
        channel: &PaintedChannel,
        cuts: &Cuts,
        topology: &ChannelTopology,
    ) -> MeshColorChannel {
        let before = old.numbering(channel, 0);
        let after = LevelNumbering::new(&self.canvas, topology, &self.resolutions, 0);
        let mut values = vec![Vec4::NAN; after.sample_count()];
        let mut grid = FaceGrid::default();
        let mut filled = None;
        for (face, origin) in self.origins.iter().enumerate() {
            if filled != Some(origin.face) {
                before.fill(origin.face as usize, &channel.values, &mut grid);
                filled = Some(origin.face);
            }
            let shape = after.shape(face);
            for (i, j) in (0..=shape.segments[1]).flat_map(|j| (0..shape.point_count(j)).map(move |i| (i, j)))
            {
                let tap = after.tap(face, i, j);
                let value = &mut values[tap.samples[0] as usize];
                // A sample is found by each of its faces; a point between two of a coarser edge is none.
                if tap.second == 0.0 && value.is_nan() {
                    let (found, is_sample) = origin.value(&grid, shape, [i, j]);
                    *value = match channel.is_normal() && !is_sample {
                        true => found.xyz().try_normalize().map_or(Vec4::Z, |normal| normal.extend(1.0)),
                        false => found,
                    };
                }
            }
        }
        channel.with(&values, cut_bits(&self.canvas, cuts), self.tangents(old, channel))
    }
}
