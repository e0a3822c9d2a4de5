//! What one mesh shows, on another.

use std::collections::BTreeMap;

use glam::Vec4;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Value, json};

use crate::asset::{Asset, Material, MeshColors, Slot};
use crate::colors::{ChannelTopology, Cuts, LevelNumbering, Shape};
use crate::error::{Error, ErrorCode, Result};
use crate::filter::Level;
use crate::mesh::{CanvasMesh, merge};
use crate::pipeline::painted::sample_counts;
use crate::pipeline::prepare::{canvas_of, joinable, normals_of};
use crate::read::Limits;
use crate::resample::{Resolution, pair_triangles_in_space, wanted_exponents};
use crate::watch::{self, Watch};

use super::compare::{Picture, errors, filtered};
use super::nearest::{Place, Surface};
use super::painting::{PaintedChannel, Painting, paintings};
use super::side::{Side, Spot, spots};
use super::{EditReport, Edited, MaterialEdit, written};

/// How well the target shows what the source showed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TransferReport {
    /// From samples of the target to the source's surface, in world units.
    pub distance_rms: f64,
    pub distance_max: f64,
    /// Diagonal of the box around the source, in world units: what distances are to be held against.
    pub source_diagonal: f64,
    pub channels: Vec<TransferError>,
}

/// Differences between both pictures, the largest component counting: in 8-bit codes (of color sRGB-encoded), of normals in
/// degrees.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TransferError {
    /// glTF slot names.
    pub slots: Vec<String>,
    pub unit: &'static str,
    /// In the middle of the target's cells, against the nearest point of the source: what the target's samples are too few for.
    pub on_target_rms: f64,
    pub on_target_max: f64,
    /// At the source's samples, against the nearest point of the target: what got lost, shapes that differ included.
    pub on_source_rms: f64,
    pub on_source_max: f64,
}

impl TransferReport {
    fn of_places(places: &[Place], source_diagonal: f64) -> Self {
        let squared: f64 = places.iter().map(|place| place.distance * place.distance).sum();
        Self {
            distance_rms: (squared / places.len().max(1) as f64).sqrt(),
            distance_max: places.iter().map(|place| place.distance).fold(0.0, f64::max),
            source_diagonal,
            channels: Vec::new(),
        }
    }
}

/// Samples a painted model on the faces of another one, at the point of its surface that is nearest in the world (both
/// models as their scenes place them, by the first instance of each mesh). The target gets one painted material for all its
/// faces, no cuts, and about as many samples for an area as the source has, times `4^finer`.
///
/// # Errors
/// `NothingToConvert` where the source has no mesh colors or the target no faces; `InvalidOptions` where several of the source's
/// materials are painted and `material` does not say which one is meant; `ModelTooLarge`, `Canceled`.
pub fn transfer(
    source: &Asset,
    material: Option<usize>,
    target: &Asset,
    finer: u8,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<Edited> {
    let painting = the_one(paintings(source)?, material)?;
    let (asset, number) = with_material(target, source, painting.material);
    let canvas = canvas_of(&asset, number);
    if canvas.faces.is_empty() {
        let detail = "the model that is to be painted has no faces";
        return Err(Error::new(ErrorCode::NothingToConvert, detail).at("/meshes"));
    }
    let from = Side::new(source, &painting.canvas);
    let squares = painting.canvas.faces.iter().zip(&painting.resolutions.faces).map(|(face, exponents)| {
        let segments = exponents.map(|exponent| 1 << exponent);
        f64::from(Shape { is_triangle: face.is_triangle(), segments }.square_count())
    });
    let area = from.area();
    if area <= 0.0 || !area.is_finite() {
        return Err(Error::invalid(
            "the painted faces have no area, so there is no telling how many samples the other model needs",
        ));
    }
    let density = ((squares.sum::<f64>() / area).sqrt() * f64::from(1u32 << finer.min(12))) as f32;
    let partners = partners(&asset, &canvas, &painting, density);
    let canvas = merge(&canvas, &partners).canvas;
    let wanted = wanted_exponents(Resolution::Density(density), true, &asset, &canvas, &[]);
    let resolutions = wanted.nearest();
    let cuts = Cuts::none(&canvas);
    let topology = ChannelTopology::new(&canvas, &resolutions, &cuts);
    let count =
        sample_counts(&canvas, &resolutions, &topology).iter().sum::<u64>() * painting.channels.len() as u64;
    if count > limits.job_pixels {
        let detail = format!(
            "the model would get {count} samples, and {} are allowed; lower `finer`",
            limits.job_pixels
        );
        return Err(Error::new(ErrorCode::ModelTooLarge, detail).limit(limits.job_pixels, count));
    }
    let to = Side::new(&asset, &canvas);
    let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
    let surfaces = [Surface::new(&painting.canvas, &from.positions), Surface::new(&canvas, &to.positions)];
    let spots = spots(&numbering);
    let places = from.nearest_to(&surfaces[0], &to, &spots, watch)?;
    let mut report = TransferReport::of_places(&places, from.diagonal());
    let mut channels = Vec::with_capacity(painting.channels.len());
    for channel in &painting.channels {
        watch::check(watch)?;
        let shown = painting.numbering(channel, 0);
        let level = [Level { numbering: &shown, values: &channel.values }];
        let value = |(spot, place): (&Spot, &Place)| {
            let value = filtered(&level)?.linear(place.face as usize, place.at, 0);
            Ok(match channel.is_normal() {
                true => from.turned(value, place.face, &to, spot.face),
                false => channel.in_range(value),
            })
        };
        let values = spots.par_iter().zip(&places).map(value).collect::<Result<Vec<Vec4>>>()?;
        let painted = [Level { numbering: &numbering, values: &values }];
        let pictures = [Picture { side: &from, level: &level[0] }, Picture { side: &to, level: &painted[0] }];
        report.channels.push(errors(channel, &pictures, &surfaces, watch)?);
        channels.push(channel.with(&values, Vec::new(), Vec::new()));
    }
    let colors = MeshColors { partners, exponents: resolutions.faces.clone(), channels };
    let edit = MaterialEdit { material: number, ..MaterialEdit::of(&painting, &colors) };
    let glb = written(&asset, vec![(number, colors)], true, None, watch)?;
    Ok(Edited { glb, report: EditReport { materials: vec![edit], transfer: Some(report) } })
}

/// The triangles that become quads, of a model that is painted with `density` samples for a unit of length. A lone triangle's
/// texels are restricted by more than its samples, those of a quad are not.
fn partners(asset: &Asset, canvas: &CanvasMesh, painting: &Painting, density: f32) -> Vec<Option<u32>> {
    let has_normals = painting.channels.iter().any(PaintedChannel::is_normal);
    let normals = has_normals.then(|| normals_of(asset, canvas));
    let mut positions = Side::new(asset, canvas).positions;
    positions.iter_mut().for_each(|position| *position *= f64::from(density));
    pair_triangles_in_space(canvas, &positions, &joinable(canvas, &[], normals.as_deref()))
}

fn the_one(paintings: Vec<Painting>, material: Option<usize>) -> Result<Painting> {
    let numbers: Vec<String> = paintings.iter().map(|painting| painting.material.to_string()).collect();
    let count = paintings.len();
    let meant = |painting: &Painting| material.map_or(count == 1, |material| painting.material == material);
    paintings.into_iter().find(meant).ok_or_else(|| {
        let detail = format!("say by `material` which painted material is meant: {}", numbers.join(", "));
        Error::new(ErrorCode::InvalidOptions, detail)
    })
}

/// The target with one more material, of all its faces: the source's without its textures and extensions.
fn with_material(target: &Asset, source: &Asset, material: usize) -> (Asset, usize) {
    let mut asset = target.clone();
    let number = asset.materials.len();
    let old = &source.materials[material];
    asset.materials.push(Material { slots: BTreeMap::new(), mesh_colors: None, ..old.clone() });
    let mut own = source.document.json["materials"][material].clone();
    if let Some(own) = own.as_object_mut() {
        for slot in Slot::CORE {
            own.remove(slot.gltf_name());
        }
        // They have textures of their own, which stay behind.
        own.remove("extensions");
        if let Some(pbr) = own.get_mut("pbrMetallicRoughness").and_then(Value::as_object_mut) {
            for slot in Slot::CORE {
                pbr.remove(slot.gltf_name());
            }
        }
    }
    let document = &mut asset.document.json;
    if let Some(document) = document.as_object_mut() {
        let materials = document.entry("materials").or_insert_with(|| json!([]));
        materials.as_array_mut().into_iter().for_each(|materials| materials.push(own.clone()));
    }
    for (mesh, own) in asset.meshes.iter_mut().enumerate() {
        for (place, primitive) in
            own.primitives.iter_mut().enumerate().filter(|(_, own)| !own.faces.is_empty())
        {
            primitive.material = Some(number);
            let json = document.pointer_mut(&format!("/meshes/{mesh}/primitives/{place}"));
            if let Some(json) = json.and_then(Value::as_object_mut) {
                json.insert("material".to_owned(), number.into());
            }
        }
    }
    (asset, number)
}
