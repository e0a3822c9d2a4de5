//! The source of one channel as `measure` reads it: its image, coordinates and frames; the edges where
//! its charts meet, and how they come apart down the ordinary mip chain.

use std::borrow::Cow;
use std::sync::LazyLock;

use glam::{Vec2, Vec3, Vec4};

use super::edges::{EdgePair, Side};
use super::figures::{Jumps, Survey, survey, weighted_mean};
use super::judge::{Judge, Meaning, Track};
use super::mips;
use super::report::{SourceLevel, Unit};
use super::surface::{Part, Surface};
use super::texels::Texels;
use crate::asset::{AlphaMode, Asset, Material, Slot, TextureRef, UvTransform};
use crate::error::Result;
use crate::finished::Frame;
use crate::image::{Image, Pixels, Wrap, WrapMode};
use crate::source::tangents;
use crate::watch::{self, Watch};

/// Coordinates that differ by less are one: the rounding of exporters.
const SAME_UV: f32 = 1e-6;

/// Two sides whose mean difference at level 0 is not above this agree: drift is measured there.
const AGREEMENT_CODES: f32 = 4.0;
const AGREEMENT_DEGREES: f32 = 2.0;

/// A channel's source over one surface.
pub struct Origin<'a> {
    pub image: &'a Image,
    /// How many of the image's components the material shows: an alpha that it ignores does not count.
    pub components: u8,
    pub texture: TextureRef,
    pub meaning: Meaning,
    /// Transformed coordinates of the vertices, part by part.
    uvs: Vec<Vec<Vec2>>,
    /// The frames of the triangles' corners, part by part; empty but for normals.
    frames: Vec<Vec<[Frame; 3]>>,
    /// The linear colors of the vertices, part by part, where they multiply the image; else empty.
    tints: Vec<Vec<Vec4>>,
}

/// What a channel without a texture shows before vertex colors multiply it.
static WHITE: LazyLock<Image> =
    LazyLock::new(|| Image { width: 1, height: 1, components: 3, pixels: Pixels::U8(vec![255; 3]) });

/// What a slot's texels stand for.
pub fn meaning(asset: &Asset, material: usize, slot: Slot) -> Meaning {
    match slot {
        Slot::Normal => {
            Meaning::Normal { scale: asset.materials.get(material).map_or(1.0, |m| m.normal_scale) }
        }
        slot if slot.is_color() => Meaning::Color,
        _ => Meaning::Data,
    }
}

impl<'a> Origin<'a> {
    /// `None` where the material has no texture in that slot, nor vertex colors instead. `takes_colors`: vertex colors multiply the
    /// material's base color.
    ///
    /// # Errors
    /// `Internal` where the surface's triangles are not those of the asset's faces.
    pub fn new(
        asset: &'a Asset,
        surface: &Surface<'_>,
        slot: Slot,
        takes_colors: bool,
    ) -> Result<Option<Self>> {
        let texture = asset.materials.get(surface.material).and_then(|material| material.slot(slot)).copied();
        let is_tinted = takes_colors && slot == Slot::BaseColor;
        let (texture, image) = match texture {
            Some(texture) => match asset.images.get(texture.image) {
                Some(image) => (texture, image),
                None => return Ok(None),
            },
            None if is_tinted => (bare_texture(), &*WHITE),
            None => return Ok(None),
        };
        let tints = if is_tinted { surface.parts.iter().map(part_tints).collect() } else { Vec::new() };
        let uvs = surface.parts.iter().map(|part| part_uvs(part, &texture)).collect();
        let meaning = meaning(asset, surface.material, slot);
        let frames = if matches!(meaning, Meaning::Normal { .. }) {
            surface.parts.iter().map(|part| part_frames(part, &texture)).collect::<Result<_>>()?
        } else {
            Vec::new()
        };
        let material = &asset.materials[surface.material];
        let has_vertex_alpha = is_tinted && surface.parts.iter().any(|part| part.geometry.has_vertex_alpha());
        let components = match is_tinted {
            true => 3 + u8::from(shows_alpha(material, slot) && (image.has_alpha() || has_vertex_alpha)),
            false => shown_components(material, slot, image),
        };
        Ok(Some(Self { image, components, texture, meaning, uvs, frames, tints }))
    }

    pub fn texels<'i>(&self, image: &'i Image) -> Texels<'i> {
        Texels::new(image, self.meaning.transfer(), self.texture.wrap)
    }

    pub fn corner_uvs(&self, part: usize, vertices: [u32; 3]) -> [Vec2; 3] {
        vertices.map(|vertex| self.uvs[part][vertex as usize])
    }

    /// Where a point stands in the image, texels.
    pub fn place(&self, part: usize, vertices: [u32; 3], at: Vec3, size_texels: Vec2) -> Vec2 {
        let [a, b, c] = self.corner_uvs(part, vertices);
        (a * at.x + b * at.y + c * at.z) * size_texels
    }

    /// The vertex colors of corners, where they multiply the image.
    pub fn corner_tints(&self, part: usize, vertices: [u32; 3]) -> Option<[Vec4; 3]> {
        self.tints.get(part).map(|tints| vertices.map(|vertex| tints[vertex as usize]))
    }

    /// A value of the image as a point of a triangle shows it.
    pub fn tinted(&self, part: usize, vertices: [u32; 3], at: Vec3, value: [f32; 4]) -> [f32; 4] {
        let Some([a, b, c]) = self.corner_tints(part, vertices) else { return value };
        (Vec4::from(value) * (a * at.x + b * at.y + c * at.z)).to_array()
    }

    pub fn corner_frames(&self, part: usize, triangle: usize) -> Option<&[Frame; 3]> {
        self.frames.get(part).map(|frames| &frames[triangle])
    }

    /// The pairs where charts meet: the stored coordinates of the two sides differ at an end, or the vertex colors.
    pub fn seam_pairs(&self, surface: &Surface<'_>) -> Vec<u32> {
        let stored = |side: &Side, ends: [usize; 2]| {
            let part = surface.part(side);
            let set = part.geometry.texcoords.get(self.texture.texcoord);
            let triangle = part.triangles[side.triangle as usize];
            ends.map(|k| set.and_then(|set| set.get(triangle[k] as usize)).copied().unwrap_or(Vec2::ZERO))
        };
        let tints = |side: &Side, ends: [usize; 2]| self.side_tints(surface, side, ends);
        let differs = |pair: &EdgePair| {
            let (a, b) = (stored(&pair.a, pair.a.ends()), stored(&pair.b, pair.ends_of_b()));
            let same_tints = tints(&pair.a, pair.a.ends()) == tints(&pair.b, pair.ends_of_b());
            !same_tints || (0..2).any(|end| (a[end] - b[end]).abs().max_element() > SAME_UV)
        };
        let numbered = surface.pairs.iter().enumerate();
        numbered.filter(|(_, pair)| differs(pair)).map(|(number, _)| number as u32).collect()
    }

    /// At both ends of a side.
    fn side_tints(&self, surface: &Surface<'_>, side: &Side, ends: [usize; 2]) -> Option<[Vec4; 2]> {
        let vertices = surface.part(side).triangles[side.triangle as usize];
        self.corner_tints(side.part as usize, vertices).map(|tints| ends.map(|k| tints[k]))
    }

    fn track(&self, surface: &Surface<'_>, side: &Side, ends: [usize; 2], size_texels: Vec2) -> Track {
        let triangle = side.triangle as usize;
        let uvs = self.corner_uvs(side.part as usize, surface.part(side).triangles[triangle]);
        let frames = self.corner_frames(side.part as usize, triangle).map(|frames| ends.map(|k| frames[k]));
        Track {
            image: 0,
            from: uvs[ends[0]],
            to: uvs[ends[1]],
            scale: size_texels,
            shift: Vec2::ZERO,
            frames,
            tints: self.side_tints(surface, side, ends),
        }
    }
}

/// The place of the white texel, which is everywhere.
fn bare_texture() -> TextureRef {
    let wrap = Wrap { s: WrapMode::ClampToEdge, t: WrapMode::ClampToEdge };
    TextureRef { image: usize::MAX, wrap, texcoord: usize::MAX, transform: UvTransform::default() }
}

/// White where a primitive has no colors.
fn part_tints(part: &Part<'_>) -> Vec<Vec4> {
    part.geometry.vertex_colors().unwrap_or_else(|| vec![Vec4::ONE; part.geometry.positions.len()])
}

fn part_uvs(part: &Part<'_>, texture: &TextureRef) -> Vec<Vec2> {
    match part.geometry.texcoords.get(texture.texcoord) {
        Some(set) => set.iter().map(|uv| texture.transform.apply(*uv)).collect(),
        None => vec![texture.transform.apply(Vec2::ZERO); part.geometry.positions.len()],
    }
}

/// The source's frames by drawn triangle; each corner is found among its face's.
fn part_frames(part: &Part<'_>, texture: &TextureRef) -> Result<Vec<[Frame; 3]>> {
    let of_faces = tangents::frames(part.geometry, texture.texcoord, texture.transform);
    let corner_frames = |(triangle, face): (&[u32; 3], u32)| {
        let (face, frames) = (&part.geometry.faces[face as usize], &of_faces[face as usize]);
        triangle.map(|vertex| {
            let own = face.corners().iter().position(|&other| other == vertex);
            frames[own.unwrap_or(0)]
        })
    };
    Ok(part.triangles.iter().zip(part.faces()?).map(corner_frames).collect())
}

/// How the source's seams look at each level of its mip chain.
pub struct SourceSeams {
    /// Indices into the surface's pairs.
    pub seam: Vec<u32>,
    /// Indices into `seam`: edges whose two sides agree at level 0.
    pub agreed: Vec<u32>,
    pub levels: Vec<SeamLevel>,
}

pub struct SeamLevel {
    pub size: [u32; 2],
    pub survey: Survey,
}

fn shows_alpha(material: &Material, slot: Slot) -> bool {
    slot.is_attribute() || slot == Slot::BaseColor && material.alpha_mode != AlphaMode::Opaque
}

fn shown_components(material: &Material, slot: Slot, image: &Image) -> u8 {
    if image.has_alpha() && !shows_alpha(material, slot) { image.components - 1 } else { image.components }
}

impl SourceSeams {
    /// Surveys the first `level_limit` levels, or as many as the image has.
    pub fn survey(
        origin: &Origin<'_>,
        surface: &Surface<'_>,
        level_limit: usize,
        watch: &dyn Watch,
    ) -> Result<Self> {
        let seam = origin.seam_pairs(surface);
        let mut levels = Vec::new();
        let mut image = Cow::Borrowed(origin.image);
        while levels.len() < level_limit {
            watch::check(watch)?;
            let judge = Judge {
                images: vec![origin.texels(&image)],
                meaning: origin.meaning,
                components: origin.components,
            };
            let size_texels = origin.texels(&image).size_texels();
            let survey = survey(&surface.pairs, &seam, |pair| {
                let a = origin.track(surface, &pair.a, pair.a.ends(), size_texels);
                let b = origin.track(surface, &pair.b, pair.ends_of_b(), size_texels);
                let [jumps, _] = judge.jumps(&a, &b, false);
                jumps.unwrap_or(Jumps::Nothing)
            });
            levels.push(SeamLevel { size: image.size(), survey });
            match mips::halved(&image, origin.meaning.transfer()) {
                Some(next) if levels.len() < level_limit => image = Cow::Owned(next),
                _ => break,
            }
        }
        let limit = if origin.meaning.unit() == Unit::Degrees { AGREEMENT_DEGREES } else { AGREEMENT_CODES };
        let means = levels.first().map_or(&[][..], |level| &level.survey.edge_means);
        let agreed = (0..seam.len() as u32).filter(|&at| means[at as usize] <= limit).collect();
        Ok(Self { seam, agreed, levels })
    }

    /// The agreeing edges as indices into the surface's pairs.
    pub fn agreed_pairs(&self) -> Vec<u32> {
        self.agreed.iter().map(|&at| self.seam[at as usize]).collect()
    }

    /// The mean jump over the agreeing edges; `None` where there are none, or no such level.
    pub fn drift(&self, surface: &Surface<'_>, level: usize) -> Option<f64> {
        let means = &self.levels.get(level)?.survey.edge_means;
        let agreed = self.agreed_pairs();
        weighted_mean(&surface.pairs, &agreed, self.agreed.iter().map(|&at| means[at as usize]))
    }

    pub fn report(&self, surface: &Surface<'_>, level: usize) -> Option<SourceLevel> {
        let at = self.levels.get(level)?;
        let seams = (!self.seam.is_empty()).then_some(at.survey.figures);
        Some(SourceLevel { size: at.size, seams, drift: self.drift(surface, level) })
    }
}
