//! UV textures as functions on the canvas.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use crate::asset::{AlphaMode, Asset, Primitive, Slot, TextureRef};
use crate::image::{Image, Transfer, Wrap, WrapMode, bilinear};
use crate::math::frame::Frame;
use crate::mesh::{CanvasMesh, surface_point};

use super::tangents;

/// One texture of one material: one thing stored over the surface, read by one or several slots.
#[derive(Clone, Debug)]
pub struct SourceChannel<'a> {
    pub material: usize,
    pub slots: Vec<Slot>,
    pub texture: TextureRef,
    pub image: &'a Image,
    pub transfer: Transfer,
    pub kind: ChannelKind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChannelKind {
    /// Components that are filtered as they are.
    Plain,
    /// Color with an alpha that weighs it.
    AlphaWeighted,
    /// Tangent-space normals with the material's scale; the canonical space is object space.
    Normal { scale: f32 },
}

/// The channels of a material, in slot order. Slots that read one image in one way are one channel.
pub fn channels(asset: &Asset, material: usize) -> Vec<SourceChannel<'_>> {
    let mut channels: Vec<SourceChannel<'_>> = Vec::new();
    let source = &asset.materials[material];
    for slot in Slot::ALL {
        let Some(texture) = source.slot(slot) else { continue };
        let image = &asset.images[texture.image];
        let transfer = if slot.is_color() { Transfer::Srgb } else { Transfer::Linear };
        let kind = match slot {
            Slot::Normal => ChannelKind::Normal { scale: source.normal_scale },
            Slot::BaseColor if image.has_alpha() && source.alpha_mode != AlphaMode::Opaque => {
                ChannelKind::AlphaWeighted
            }
            _ => ChannelKind::Plain,
        };
        let same = |known: &&mut SourceChannel<'_>| {
            known.texture == *texture && known.transfer == transfer && known.kind == kind
        };
        match channels.iter_mut().find(same) {
            Some(known) => known.slots.push(slot),
            None => {
                channels.push(SourceChannel {
                    material,
                    slots: vec![slot],
                    texture: *texture,
                    image,
                    transfer,
                    kind,
                });
            }
        }
    }
    channels
}

impl SourceChannel<'_> {
    pub fn is_alpha_weighted(&self) -> bool {
        self.kind == ChannelKind::AlphaWeighted
    }

    pub fn is_normal(&self) -> bool {
        matches!(self.kind, ChannelKind::Normal { .. })
    }

    /// The material's normal scale, of a normal map.
    pub fn normal_scale(&self) -> Option<f32> {
        match self.kind {
            ChannelKind::Normal { scale } => Some(scale),
            _ => None,
        }
    }

    /// Texture coordinates of a primitive's vertex in texels of the image, after the slot's transform.
    fn place_texels(&self, primitive: &Primitive, vertex: u32) -> Vec2 {
        let set = primitive.texcoords.get(self.texture.texcoord);
        let uv = set.map_or(Vec2::ZERO, |uvs| uvs[vertex as usize]);
        let size = Vec2::new(self.image.width as f32, self.image.height as f32);
        self.texture.transform.apply(uv) * size
    }
}

/// A channel bound to a canvas: its value at any point of any face.
pub struct SurfaceSource<'a> {
    pub channel: &'a SourceChannel<'a>,
    /// Corner places in texels, by face.
    places: Vec<[Vec2; 4]>,
    /// Corner frames by face; of normal channels only.
    pub(super) frames: Vec<[Frame; 4]>,
}

impl<'a> SurfaceSource<'a> {
    pub fn new(channel: &'a SourceChannel<'a>, asset: &Asset, canvas: &CanvasMesh) -> Self {
        let places = canvas.faces.iter().map(|face| {
            let primitive = &asset.meshes[face.mesh as usize].primitives[face.primitive as usize];
            let corners = &primitive.faces[face.face as usize].corners;
            near_origin(corners.map(|vertex| channel.place_texels(primitive, vertex)), channel)
        });
        let frames = if channel.is_normal() { corner_frames(channel, asset, canvas) } else { Vec::new() };
        Self { channel, places: places.collect(), frames }
    }

    /// Corner places of a face in texels.
    pub fn places(&self, face: usize) -> &[Vec2; 4] {
        &self.places[face]
    }

    /// The frame at a corner of a face; of normal channels only.
    pub fn frame(&self, face: usize, corner: usize) -> Option<&Frame> {
        self.frames.get(face).map(|frames| &frames[corner])
    }

    /// The value at `(s, t)` of the face's unit domain: linear light, data, or an object-space unit normal
    /// (with `w` 1).
    pub fn at(&self, canvas: &CanvasMesh, face: usize, s: f32, t: f32) -> Vec4 {
        let (corners, weights) = surface_point(canvas.faces[face].count(), s, t);
        self.at_weights(face, corners, weights)
    }

    /// The value at `t` in [0, 1] along an edge of the face, from its first corner.
    pub fn along_edge(&self, canvas: &CanvasMesh, face: usize, edge: usize, t: f32) -> Vec4 {
        let next = (edge + 1) % canvas.faces[face].count();
        self.at_weights(face, [edge, next, next], Vec3::new(1.0 - t, t, 0.0))
    }

    fn at_weights(&self, face: usize, corners: [usize; 3], weights: Vec3) -> Vec4 {
        let places = &self.places[face];
        let place =
            places[corners[0]] * weights.x + places[corners[1]] * weights.y + places[corners[2]] * weights.z;
        let value = bilinear(self.channel.image, self.channel.transfer, self.channel.texture.wrap, place);
        let ChannelKind::Normal { scale } = self.channel.kind else { return value };
        let frames = &self.frames[face];
        let frame = Frame::blend(corners.map(|corner| &frames[corner]), weights);
        decode_normal(value.xyz(), scale, frame).extend(1.0)
    }
}

/// A stored normal (codes in [0, 1]) to an object-space unit normal.
pub(super) fn decode_normal(stored: Vec3, scale: f32, frame: glam::Mat3) -> Vec3 {
    let tangent_space = (stored * 2.0 - 1.0) * Vec3::new(scale, scale, 1.0);
    (frame * tangent_space).try_normalize().unwrap_or(frame.z_axis)
}

/// Moves a face by whole images towards texel 0, so that large coordinates keep their fractions.
fn near_origin(mut places: [Vec2; 4], channel: &SourceChannel<'_>) -> [Vec2; 4] {
    let Wrap { s, t } = channel.texture.wrap;
    let period = |mode: WrapMode, size: u32| match mode {
        WrapMode::Repeat => size as f32,
        WrapMode::MirroredRepeat => 2.0 * size as f32,
        WrapMode::ClampToEdge => f32::INFINITY,
    };
    let period = Vec2::new(period(s, channel.image.width), period(t, channel.image.height));
    let whole = (places[0] / period).floor() * period;
    let whole = Vec2::select(whole.is_finite_mask(), whole, Vec2::ZERO);
    places.iter_mut().for_each(|place| *place -= whole);
    places
}

fn corner_frames(channel: &SourceChannel<'_>, asset: &Asset, canvas: &CanvasMesh) -> Vec<[Frame; 4]> {
    let mut by_primitive: HashMap<(u32, u32), Vec<[Frame; 4]>> = HashMap::new();
    let frames = canvas.faces.iter().map(|face| {
        let of_primitive = by_primitive.entry((face.mesh, face.primitive)).or_insert_with(|| {
            let primitive = &asset.meshes[face.mesh as usize].primitives[face.primitive as usize];
            tangents::frames(primitive, channel.texture.texcoord, channel.texture.transform)
        });
        of_primitive[face.face as usize]
    });
    frames.collect()
}
