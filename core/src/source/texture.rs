//! UV textures as functions on the canvas.

use std::collections::{BTreeSet, HashMap};
use std::sync::LazyLock;

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use crate::asset::{AlphaMode, Asset, Primitive, Slot, TextureRef, UvTransform};
use crate::image::{Image, Pixels, Transfer, Wrap, WrapMode, bilinear};
use crate::math::frame::Frame;
use crate::mesh::{CanvasFace, CanvasMesh, Drawn, Merged, surface_point};

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
    /// Whether the vertex colors multiply it.
    pub is_tinted: bool,
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

/// The image of a channel that has no texture, only vertex colors: one white texel.
static WHITE: LazyLock<Image> =
    LazyLock::new(|| Image { width: 1, height: 1, components: 3, pixels: Pixels::U8(vec![255; 3]) });

/// The number of the white texel, which is no image of the asset's.
const NO_IMAGE: usize = usize::MAX;

/// Where the white texel stands, which is everywhere; there is no set of coordinates of this number.
fn no_texture() -> TextureRef {
    let wrap = Wrap { s: WrapMode::ClampToEdge, t: WrapMode::ClampToEdge };
    TextureRef { image: NO_IMAGE, wrap, texcoord: usize::MAX, transform: UvTransform::default() }
}

/// The channels of a material, in slot order. Slots that read one image in one way are one channel. `takes_colors`: vertex colors
/// multiply the base color, and are it where it has no texture.
pub fn channels(asset: &Asset, material: usize, takes_colors: bool) -> Vec<SourceChannel<'_>> {
    let mut channels: Vec<SourceChannel<'_>> = Vec::new();
    let source = &asset.materials[material];
    // Vertex colors may be a base color of their own.
    let slots: BTreeSet<Slot> = source.slots.keys().copied().chain([Slot::BaseColor]).collect();
    for slot in slots {
        let is_tinted = takes_colors && slot == Slot::BaseColor;
        let (texture, image) = match source.slot(slot) {
            Some(texture) => (*texture, &asset.images[texture.image]),
            None if is_tinted => (no_texture(), &*WHITE),
            None => continue,
        };
        let has_alpha = image.has_alpha() || is_tinted && has_vertex_alpha(asset, material);
        let transfer = if slot.is_color() { Transfer::Srgb } else { Transfer::Linear };
        let kind = match slot {
            Slot::Normal => ChannelKind::Normal { scale: source.normal_scale },
            Slot::BaseColor if has_alpha && source.alpha_mode != AlphaMode::Opaque => {
                ChannelKind::AlphaWeighted
            }
            _ => ChannelKind::Plain,
        };
        let same = |known: &&mut SourceChannel<'_>| {
            known.texture == texture
                && known.transfer == transfer
                && known.kind == kind
                && known.is_tinted == is_tinted
                && known.is_attribute() == slot.is_attribute()
        };
        match channels.iter_mut().find(same) {
            Some(known) => known.slots.push(slot),
            None => {
                channels.push(SourceChannel {
                    material,
                    slots: vec![slot],
                    texture,
                    image,
                    transfer,
                    kind,
                    is_tinted,
                });
            }
        }
    }
    channels
}

fn has_vertex_alpha(asset: &Asset, material: usize) -> bool {
    let primitives = asset.meshes.iter().flat_map(|mesh| &mesh.primitives);
    primitives.filter(|own| own.material == Some(material)).any(Primitive::has_vertex_alpha)
}

impl ChannelKind {
    pub fn is_alpha_weighted(self) -> bool {
        self == Self::AlphaWeighted
    }

    pub fn is_normal(self) -> bool {
        self.normal_scale().is_some()
    }

    /// The material's normal scale, of a normal map.
    pub fn normal_scale(self) -> Option<f32> {
        match self {
            Self::Normal { scale } => Some(scale),
            _ => None,
        }
    }
}

impl SourceChannel<'_> {
    pub fn is_alpha_weighted(&self) -> bool {
        self.kind.is_alpha_weighted()
    }

    pub fn is_normal(&self) -> bool {
        self.kind.is_normal()
    }

    /// The material's normal scale, of a normal map.
    pub fn normal_scale(&self) -> Option<f32> {
        self.kind.normal_scale()
    }

    pub fn is_attribute(&self) -> bool {
        self.slots.iter().any(Slot::is_attribute)
    }

    /// What samples stay within; normals have their length for it.
    pub fn bounds(&self) -> Option<[f32; 2]> {
        let low = if self.image.value_scale().is_some() { -1.0 } else { 0.0 };
        (!self.is_normal()).then_some([low, 1.0])
    }

    /// Whether there is no texture, only vertex colors.
    pub fn is_bare(&self) -> bool {
        self.texture.image == NO_IMAGE
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
    /// Corner places in texels, by face and drawn triangle.
    places: Vec<Drawings<Vec2>>,
    /// Corner frames by face and drawn triangle; of normal channels only.
    pub(super) frames: Vec<Drawings<Frame>>,
    /// Linear vertex colors by face and drawn triangle; of channels that they multiply only.
    pub(super) tints: Vec<Drawings<Vec4>>,
}

/// What stands at the corners of a face's drawn triangles; a triangle's second repeats its first. Where a pair of
/// triangles became a quad, the two may differ at the ends of its diagonal.
pub type Drawings<T> = [[T; 3]; 2];

impl<'a> SurfaceSource<'a> {
    pub fn new(channel: &'a SourceChannel<'a>, asset: &Asset, canvas: &CanvasMesh) -> Self {
        let places = canvas.faces.iter().map(|face| {
            drawings(face, |drawn| {
                let primitive = &asset.meshes[face.mesh as usize].primitives[drawn.primitive as usize];
                let vertices = &primitive.faces[drawn.face as usize].corners;
                let place = |corner: u8| channel.place_texels(primitive, vertices[usize::from(corner)]);
                near_origin(drawn.corners.map(place), channel)
            })
        });
        let frames = if channel.is_normal() { corner_frames(channel, asset, canvas) } else { Vec::new() };
        let tints = if channel.is_tinted { corner_tints(asset, canvas) } else { Vec::new() };
        Self { channel, places: places.collect(), frames, tints }
    }

    /// The same channel on a canvas whose triangles stand in pairs.
    pub fn merged(&self, merged: &Merged) -> Self {
        Self {
            channel: self.channel,
            places: merged_drawings(&self.places, merged),
            frames: merged_drawings(&self.frames, merged),
            tints: merged_drawings(&self.tints, merged),
        }
    }

    /// Corner places of a face's drawn triangles in texels.
    pub fn places(&self, face: usize) -> &Drawings<Vec2> {
        &self.places[face]
    }

    /// Places of a face's drawn triangles, each once.
    pub fn triangles<'s>(&'s self, canvas: &CanvasMesh, face: usize) -> &'s [[Vec2; 3]] {
        &self.places[face][..canvas.faces[face].drawn_corners().len()]
    }

    /// Lengths of a quad's edges in texels of the image.
    pub fn quad_sides(&self, face: usize) -> [f32; 4] {
        let [[a, b, c], [d, e, f]] = self.places[face];
        [a.distance(b), b.distance(c), e.distance(f), f.distance(d)]
    }

    /// Area of a face in painted texels of the image, overlaps counted; of vertex colors alone, in what they need.
    pub fn area_texels(&self, canvas: &CanvasMesh, face: usize) -> f32 {
        if self.channel.is_bare() {
            return self.kink_texels(face, canvas.faces[face].is_triangle());
        }
        let doubled = |[a, b, c]: &[Vec2; 3]| (*b - *a).perp_dot(*c - *a).abs();
        let texels = 0.5 * self.triangles(canvas, face).iter().map(doubled).sum::<f32>();
        texels / f32::from(self.channel.image.texels_per_painted()).powi(2)
    }

    /// The frame at a corner of a drawn triangle; of normal channels only.
    pub fn frame(&self, face: usize, (triangle, corner): (usize, usize)) -> Option<&Frame> {
        self.frames.get(face).map(|frames| &frames[triangle][corner])
    }

    /// The vertex color at a corner of a drawn triangle; of channels that they multiply only.
    pub fn tint(&self, face: usize, (triangle, corner): (usize, usize)) -> Option<Vec4> {
        self.tints.get(face).map(|tints| tints[triangle][corner])
    }

    /// The value at `(s, t)` of the face's unit domain: linear light, data, or an object-space unit normal
    /// (with `w` 1).
    pub fn at(&self, canvas: &CanvasMesh, face: usize, s: f32, t: f32) -> Vec4 {
        let (triangle, weights) = surface_point(canvas.faces[face].count(), s, t);
        self.at_weights(face, triangle, weights)
    }

    /// The value at `t` in [0, 1] along an edge of the face, from its first corner.
    pub fn along_edge(&self, canvas: &CanvasMesh, face: usize, edge: usize, t: f32) -> Vec4 {
        let (triangle, [from, to]) = edge_ends(canvas.faces[face].count(), edge);
        let mut weights = Vec3::ZERO;
        weights[from] = 1.0 - t;
        weights[to] = t;
        self.at_weights(face, triangle, weights)
    }

    fn at_weights(&self, face: usize, triangle: usize, weights: Vec3) -> Vec4 {
        let [a, b, c] = self.places[face][triangle];
        let place = a * weights.x + b * weights.y + c * weights.z;
        let value = bilinear(self.channel.image, self.channel.transfer, self.channel.texture.wrap, place);
        let ChannelKind::Normal { scale } = self.channel.kind else {
            let Some(tints) = self.tints.get(face) else { return value };
            let [a, b, c] = tints[triangle];
            return value * (a * weights.x + b * weights.y + c * weights.z);
        };
        let frame = Frame::blend(self.frames[face][triangle].each_ref(), weights);
        decode_normal(value.xyz(), scale, frame).extend(1.0)
    }
}

/// Which drawn triangle has an edge of the face, and between which of its corners.
pub fn edge_ends(corner_count: usize, edge: usize) -> (usize, [usize; 2]) {
    match (corner_count, edge) {
        (3, _) => (0, [edge, (edge + 1) % 3]),
        (_, 0 | 1) => (0, [edge, edge + 1]),
        (_, 2) => (1, [1, 2]),
        _ => (1, [2, 0]),
    }
}

fn drawings<T: Copy>(face: &CanvasFace, of: impl Fn(&Drawn) -> [T; 3]) -> Drawings<T> {
    let first = of(&face.drawn[0]);
    if face.is_triangle() { [first; 2] } else { [first, of(&face.drawn[1])] }
}

/// What stands at the corners of faces, by the faces of a canvas whose triangles stand in pairs; nothing where there is nothing.
fn merged_drawings<T: Copy>(old: &[Drawings<T>], merged: &Merged) -> Vec<Drawings<T>> {
    if old.is_empty() {
        return Vec::new();
    }
    let of_face = |(face, &(first, second)): (&CanvasFace, &(u32, Option<u32>))| {
        let Some(second) = second else { return old[first as usize] };
        let turned = |triangle: usize, of: u32| {
            face.drawn[triangle].corners.map(|corner| old[of as usize][0][usize::from(corner)])
        };
        [turned(0, first), turned(1, second)]
    };
    merged.canvas.faces.iter().zip(&merged.old_faces).map(of_face).collect()
}

/// A stored normal (codes in [0, 1]) to an object-space unit normal.
pub(super) fn decode_normal(stored: Vec3, scale: f32, frame: glam::Mat3) -> Vec3 {
    let tangent_space = (stored * 2.0 - 1.0) * Vec3::new(scale, scale, 1.0);
    (frame * tangent_space).try_normalize().unwrap_or(frame.z_axis)
}

/// Moves a triangle by whole images towards texel 0, so that large coordinates keep their fractions.
fn near_origin(mut places: [Vec2; 3], channel: &SourceChannel<'_>) -> [Vec2; 3] {
    let period = period_texels(channel);
    let whole = (places[0] / period).floor() * period;
    let whole = Vec2::select(whole.is_finite_mask(), whole, Vec2::ZERO);
    places.iter_mut().for_each(|place| *place -= whole);
    places
}

/// After how many texels a texture repeats.
pub(super) fn period_texels(channel: &SourceChannel<'_>) -> Vec2 {
    let Wrap { s, t } = channel.texture.wrap;
    let period = |mode: WrapMode, size: u32| match mode {
        WrapMode::Repeat => size as f32,
        WrapMode::MirroredRepeat => 2.0 * size as f32,
        WrapMode::ClampToEdge => f32::INFINITY,
    };
    Vec2::new(period(s, channel.image.width), period(t, channel.image.height))
}

fn corner_frames(channel: &SourceChannel<'_>, asset: &Asset, canvas: &CanvasMesh) -> Vec<Drawings<Frame>> {
    let mut by_primitive: HashMap<(u32, u32), Vec<[Frame; 4]>> = HashMap::new();
    for face in &canvas.faces {
        for drawn in &face.drawn {
            by_primitive.entry((face.mesh, drawn.primitive)).or_insert_with(|| {
                let primitive = &asset.meshes[face.mesh as usize].primitives[drawn.primitive as usize];
                tangents::frames(primitive, channel.texture.texcoord, channel.texture.transform)
            });
        }
    }
    let of_drawn = |face: &CanvasFace| {
        drawings(face, |drawn| {
            let frames = &by_primitive[&(face.mesh, drawn.primitive)][drawn.face as usize];
            drawn.corners.map(|corner| frames[usize::from(corner)])
        })
    };
    canvas.faces.iter().map(of_drawn).collect()
}

/// White where a primitive has no colors.
fn corner_tints(asset: &Asset, canvas: &CanvasMesh) -> Vec<Drawings<Vec4>> {
    let mut by_primitive: HashMap<(u32, u32), Option<Vec<Vec4>>> = HashMap::new();
    let primitive = |mesh: u32, number: u32| &asset.meshes[mesh as usize].primitives[number as usize];
    for face in &canvas.faces {
        for drawn in &face.drawn {
            by_primitive
                .entry((face.mesh, drawn.primitive))
                .or_insert_with(|| primitive(face.mesh, drawn.primitive).vertex_colors());
        }
    }
    let of_drawn = |face: &CanvasFace| {
        drawings(face, |drawn| {
            let vertices = &primitive(face.mesh, drawn.primitive).faces[drawn.face as usize].corners;
            let colors = by_primitive[&(face.mesh, drawn.primitive)].as_ref();
            drawn.corners.map(|corner| {
                colors.map_or(Vec4::ONE, |colors| colors[vertices[usize::from(corner)] as usize])
            })
        })
    };
    canvas.faces.iter().map(of_drawn).collect()
}
