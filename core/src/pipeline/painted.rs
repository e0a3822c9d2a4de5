//! Mesh colors that a model brings along, and those that a conversion keeps: to and from samples by number.

use std::collections::{BTreeMap, BTreeSet};

use glam::{Vec3, Vec4};

use crate::asset::{Asset, MeshColorChannel, MeshColors, Slot};
use crate::colors::{ChannelTopology, Cuts, Resolutions, Shape};
use crate::error::{Error, Result};
use crate::image::{Image, Pixels};
use crate::math::frame::Frame;
use crate::measure::MeshColorsReport;
use crate::mesh::{CanvasFace, CanvasMesh, Side, merge};
use crate::write::PaintedMaterial;

use super::form::ChannelForm;
use super::material::MaterialConversion;
use super::prepare::canvas_of;

/// Mesh colors on their canvas, the samples of which are as many as its faces ask for.
pub struct Painted<'a> {
    pub colors: &'a MeshColors,
    pub resolutions: Resolutions,
}

/// What mesh colors make of a canvas.
pub struct Restored<'a> {
    /// With partners as quads.
    pub canvas: CanvasMesh,
    /// By channel.
    pub cuts: Vec<Cuts>,
    pub painted: Painted<'a>,
}

/// # Errors
/// `InvalidModel` where the mesh colors do not fit the faces, or other slots have textures.
pub fn restore(canvas: CanvasMesh, colors: &MeshColors, has_textures: bool) -> Result<Restored<'_>> {
    if has_textures {
        return Err(Error::invalid(
            "the material has mesh colors for some slots and textures for others, which is not understood; remove these \
             textures, or make mesh colors of them too",
        ));
    }
    check_partners(&canvas, &colors.partners)?;
    let canvas = merge(&canvas, &colors.partners).canvas;
    let resolutions = Resolutions { faces: colors.exponents.clone() };
    for (number, (face, [r, s])) in canvas.faces.iter().zip(&resolutions.faces).enumerate() {
        if face.is_triangle() && r != s {
            return Err(Error::invalid(format!(
                "face {number} is a triangle and has the exponents {r} and {s}; those of triangles are equal"
            )));
        }
    }
    let mut cuts = Vec::with_capacity(colors.channels.len());
    for (number, channel) in colors.channels.iter().enumerate() {
        let own = cuts_of(&canvas, channel).and_then(|cuts| {
            check_count(&canvas, &resolutions, &cuts, channel)?;
            Ok(cuts)
        });
        cuts.push(own.map_err(|error| Error {
            detail: format!("channel {number} ({}): {}", slot_names(channel), error.detail),
            ..error
        })?);
    }
    Ok(Restored { canvas, cuts, painted: Painted { colors, resolutions } })
}

/// Every channel of mesh colors of a model, each held against its faces.
///
/// # Errors
/// As [`restore`].
pub fn checked(asset: &Asset) -> Result<Vec<MeshColorsReport>> {
    let mut reports = Vec::new();
    for (material, properties) in asset.materials.iter().enumerate() {
        let Some(colors) = &properties.mesh_colors else { continue };
        let has_textures = !properties.slots.is_empty();
        let restored = restore(canvas_of(asset, material), colors, has_textures)
            .map_err(|error| error.at(format!("/materials/{material}")))?;
        let of_channel = |(channel, cuts): (&MeshColorChannel, &Cuts)| MeshColorsReport {
            material,
            slots: channel.slots.iter().map(|slot| slot.gltf_name().to_owned()).collect(),
            face_count: restored.canvas.faces.len() as u64,
            sample_count: (channel.samples.len() / usize::from(channel.components)) as u64,
            components: channel.components,
            cut_edge_count: cuts.edges.iter().filter(|cut| **cut).count() as u64,
        };
        reports.extend(colors.channels.iter().zip(&restored.cuts).map(of_channel));
    }
    Ok(reports)
}

fn slot_names(channel: &MeshColorChannel) -> String {
    channel.slots.iter().map(|slot| slot.gltf_name()).collect::<Vec<_>>().join(", ")
}

/// Whether each two partners are a quad.
fn check_partners(canvas: &CanvasMesh, partners: &[Option<u32>]) -> Result<()> {
    for (face, other) in (0u32..).zip(partners).filter_map(|(face, other)| Some((face, (*other)?))) {
        let [a, b] = [face, other].map(|face| &canvas.faces[face as usize]);
        let common = a.edges[..3].iter().filter(|edge| b.edges[..3].contains(edge));
        let is_over_two = common.clone().all(|&edge| canvas.sides(&canvas.edges[edge as usize]).len() == 2);
        if common.count() != 1 || !is_over_two {
            return Err(Error::invalid(format!(
                "triangles {face} and {other} are partners, but not the only two faces at one common edge"
            )));
        }
    }
    Ok(())
}

/// By canvas edge. All faces around an edge have to agree.
fn cuts_of(canvas: &CanvasMesh, channel: &MeshColorChannel) -> Result<Cuts> {
    let mut cuts = Cuts::none(canvas);
    if channel.cuts.is_empty() {
        return Ok(cuts);
    }
    for (cut, edge) in cuts.edges.iter_mut().zip(&canvas.edges) {
        let sides = canvas.sides(edge);
        let is_cut = |side: &Side| channel.cuts[side.face as usize] >> side.edge & 1 == 1;
        if let Some(other) = sides.iter().find(|side| is_cut(side) != is_cut(&sides[0])) {
            return Err(Error::invalid(format!(
                "edge {} of face {} and edge {} of face {} are one edge, but only one of them is a cut",
                sides[0].edge, sides[0].face, other.edge, other.face
            )));
        }
        *cut = sides.len() > 1 && is_cut(&sides[0]);
    }
    Ok(cuts)
}

/// Whether there are as many samples as exponents and cuts ask for.
fn check_count(
    canvas: &CanvasMesh,
    resolutions: &Resolutions,
    cuts: &Cuts,
    channel: &MeshColorChannel,
) -> Result<()> {
    let topology = ChannelTopology::new(canvas, resolutions, cuts);
    let [vertices, on_edges, inside] = sample_counts(canvas, resolutions, &topology);
    let wanted = vertices + on_edges + inside;
    let count = (channel.samples.len() / usize::from(channel.components)) as u64;
    if wanted == count && u32::try_from(wanted).is_ok() {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "there are {count} samples, and {wanted} are needed: {vertices} at vertices, {on_edges} on edges and {inside} inside of \
         faces"
    )))
}

/// Samples of a channel at vertices, on edges and inside of faces.
pub fn sample_counts(canvas: &CanvasMesh, resolutions: &Resolutions, topology: &ChannelTopology) -> [u64; 3] {
    let on_edges = topology.strips.iter().map(|strip| (1u64 << strip.exponent) - 1).sum();
    let inside = |(face, exponents): (&CanvasFace, &[u8; 2])| {
        let shape =
            Shape { is_triangle: face.is_triangle(), segments: exponents.map(|exponent| 1 << exponent) };
        u64::from(shape.interior_count())
    };
    let inside = canvas.faces.iter().zip(&resolutions.faces).map(inside).sum();
    [topology.fan_count() as u64, on_edges, inside]
}

/// The samples of a channel by their numbers, as they are.
pub fn unpacked(channel: &MeshColorChannel) -> impl Iterator<Item = Vec4> {
    let sample = |stored: &[f32]| match *stored {
        [gray] => Vec4::new(gray, gray, gray, 1.0),
        [gray, alpha] => Vec4::new(gray, gray, gray, alpha),
        [r, g, b] => Vec4::new(r, g, b, 1.0),
        [r, g, b, alpha, ..] => Vec4::new(r, g, b, alpha),
        [] => Vec4::W,
    };
    channel.samples.chunks_exact(usize::from(channel.components)).map(sample)
}

impl Painted<'_> {
    /// The samples of a channel by their numbers, color and data within [0, 1].
    pub fn samples(&self, channel: usize) -> Vec<Vec4> {
        let channel = &self.colors.channels[channel];
        let is_bounded = !channel.slots.contains(&Slot::Normal) && channel.value_scale.is_none();
        let in_range = |value: Vec4| match is_bounded {
            true => value.clamp(Vec4::ZERO, Vec4::ONE),
            false => value,
        };
        unpacked(channel).map(in_range).collect()
    }

    /// By face: the frames that its normals are to be stored in, if it says.
    pub fn frames(&self, normals: &[[Vec3; 4]]) -> Vec<Option<[Frame; 4]>> {
        let given = self.colors.channels.iter().find(|channel| !channel.tangents.is_empty());
        let Some(given) = given else { return vec![None; normals.len()] };
        let of_face = |(tangents, normals): (&[[f32; 4]; 4], &[Vec3; 4])| {
            let is_given = tangents.iter().all(|tangent| tangent[3] != 0.0);
            let frame = |k: usize| Frame { normal: normals[k], tangent: Vec4::from_array(tangents[k]) };
            is_given.then(|| [0, 1, 2, 3].map(frame))
        };
        given.tangents.iter().zip(normals).map(of_face).collect()
    }
}

/// The mesh colors of all converted materials, whose samples were kept and are taken.
/// `takers`: those that took their vertex colors.
pub fn materials(
    asset: &Asset,
    conversions: &mut [MaterialConversion],
    takers: &BTreeSet<usize>,
) -> Vec<PaintedMaterial> {
    let one = |conversion: &mut MaterialConversion| {
        let colors = mesh_colors(asset, conversion);
        let stand_ins = conversion.channels.iter().zip(&colors.channels);
        let stand_ins = stand_ins.map(|(own, channel)| stand_in(&own.form, &channel.samples)).collect();
        let material = conversion.material;
        PaintedMaterial { material, colors, stand_ins, takes_colors: takers.contains(&material) }
    };
    conversions.iter_mut().map(one).collect()
}

/// One texel: the mean of all samples, or a normal that changes nothing.
fn stand_in(form: &ChannelForm, samples: &[f32]) -> Image {
    let components = usize::from(form.codec.components);
    let count = (samples.len() / components).max(1) as f64;
    let mut mean = Vec4::ONE;
    for (place, &component) in form.codec.stored().iter().enumerate() {
        let sum: f64 = samples.iter().skip(place).step_by(components).map(|&value| f64::from(value)).sum();
        mean[component] = (sum / count) as f32;
    }
    if form.kind.is_normal() {
        mean = Vec4::new(0.5, 0.5, 1.0, 1.0);
    }
    let codes: Vec<u16> = form.codec.codes(mean).collect();
    let pixels = match form.codec.bits {
        8 => Pixels::U8(codes.into_iter().map(|code| code as u8).collect()),
        _ => Pixels::U16(codes),
    };
    Image { width: 1, height: 1, components: form.codec.components, pixels }
}

fn mesh_colors(asset: &Asset, conversion: &mut MaterialConversion) -> MeshColors {
    let partners = partners(asset, &conversion.canvas, conversion.material);
    let MaterialConversion { canvas, resolutions, channels, given_frames, .. } = conversion;
    let channels = channels.iter_mut().map(|channel| {
        let tangent = |frames: &Option<[Frame; 4]>| match frames {
            Some(frames) => frames.map(|frame| frame.tangent.to_array()),
            None => [[0.0; 4]; 4],
        };
        let is_given = channel.form.kind.is_normal() && given_frames.iter().any(Option::is_some);
        MeshColorChannel {
            slots: channel.form.slots.clone(),
            components: channel.form.codec.components,
            bits: channel.form.codec.bits,
            cuts: cut_bits(canvas, &channel.cuts),
            samples: std::mem::take(&mut channel.finest_samples),
            value_scale: channel.form.value_scale,
            tangents: if is_given { given_frames.iter().map(tangent).collect() } else { Vec::new() },
        }
    });
    let channels = channels.collect();
    MeshColors { partners, exponents: resolutions.faces.clone(), channels }
}

/// By face: which of its edges are cuts; empty where none is.
pub fn cut_bits(canvas: &CanvasMesh, cuts: &Cuts) -> Vec<u8> {
    let bits = |face: &CanvasFace| {
        (0..face.count()).map(|k| u8::from(cuts.edges[face.edges[k] as usize]) << k).sum()
    };
    let bits: Vec<u8> = canvas.faces.iter().map(bits).collect();
    if bits.iter().all(|bits| *bits == 0) { Vec::new() } else { bits }
}

/// The faces of the model that show a material, in the order of meshes, primitives and faces.
pub struct ModelFaces {
    /// By mesh and primitive: the number of its first.
    firsts: BTreeMap<(u32, u32), u32>,
    /// By number: mesh, primitive and face.
    pub places: Vec<[u32; 3]>,
}

impl ModelFaces {
    pub fn of(asset: &Asset, material: usize) -> Self {
        let mut this = Self { firsts: BTreeMap::new(), places: Vec::new() };
        for (mesh_number, mesh) in (0u32..).zip(&asset.meshes) {
            for (number, primitive) in (0u32..).zip(&mesh.primitives) {
                if primitive.material == Some(material) {
                    this.firsts.insert((mesh_number, number), this.places.len() as u32);
                    let faces = 0..primitive.faces.len() as u32;
                    this.places.extend(faces.map(|face| [mesh_number, number, face]));
                }
            }
        }
        this
    }

    /// The numbers of a face's drawn triangles.
    pub fn drawn(&self, face: &CanvasFace) -> [u32; 2] {
        face.drawn.map(|drawn| self.firsts[&(face.mesh, drawn.primitive)] + drawn.face)
    }
}

/// By face of the model.
fn partners(asset: &Asset, canvas: &CanvasMesh, material: usize) -> Vec<Option<u32>> {
    let faces = ModelFaces::of(asset, material);
    let mut partners = vec![None; faces.places.len()];
    for face in canvas.faces.iter().filter(|face| face.is_pair()) {
        let [one, other] = faces.drawn(face);
        partners[one as usize] = Some(other);
        partners[other as usize] = Some(one);
    }
    partners
}

/// The components that a channel stores, of all samples one after the other.
pub fn stored(form: &ChannelForm, values: &[Vec4]) -> Vec<f32> {
    values.iter().flat_map(|value| form.codec.stored().iter().map(|&component| value[component])).collect()
}
