//! Materials: the five core texture slots with sampler, set and transform, and the factors.

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Map, Value};

use super::super::images::Wanted;
use super::super::json::At;
use super::super::text::quoted;
use super::super::warnings::Warnings;
use super::primitives::TEXCOORD_SETS_MAX;
use crate::asset::{AlphaMode, AttributeName, Material, Slot, TEXTURE_EXTENSION, TextureRef, UvTransform};
use crate::error::Result;
use crate::image::{Wrap, WrapMode};

/// Components of a texture transform stay within this, so that texel numbers fit their type.
const TRANSFORM_MAX: f32 = 1e6;

/// Extensions that name an image of a format that the core lacks; the last that a texture has counts.
const SOURCES: [&str; 2] = ["KHR_texture_basisu", "EXT_texture_webp"];

/// A texture of the document: `None` where it has no image of a format that is read.
struct Texture {
    image: Option<usize>,
    wrap: Wrap,
}

pub(super) fn read(root: &At, warnings: &mut Warnings) -> Result<Vec<Material>> {
    let textures = read_textures(root)?;
    root.objects("materials")?.iter().map(|at| read_one(at, &textures, warnings)).collect()
}

/// A material that says nothing.
pub(in crate::read) fn blank() -> Result<Material> {
    read_one(&At::root(&Value::Object(Map::new())), &[], &mut Warnings::default())
}

/// The images that a core slot of a material reads, and the levels of converted ones, which are found by
/// their index in the document.
pub(super) fn wanted_images(root: &At, materials: &[Material], image_count: usize) -> Vec<Wanted> {
    let mut wanted = vec![Wanted::No; image_count];
    for slot in materials.iter().flat_map(|material| material.slots.values()) {
        wanted[slot.image] = Wanted::Shared;
    }
    for texture in root.value["textures"].as_array().into_iter().flatten() {
        let levels = &texture["extensions"][TEXTURE_EXTENSION]["levels"];
        let source = texture["source"].as_u64().and_then(|source| usize::try_from(source).ok());
        if !source.and_then(|source| wanted.get(source)).is_some_and(|wanted| *wanted != Wanted::No) {
            continue;
        }
        for level in levels.as_array().into_iter().flatten().filter_map(Value::as_u64) {
            if let Some(wanted) = usize::try_from(level).ok().and_then(|level| wanted.get_mut(level)) {
                *wanted = Wanted::InPlace;
            }
        }
    }
    wanted
}

fn read_textures(root: &At) -> Result<Vec<Texture>> {
    let image_count = root.list("images")?.len();
    let mut wraps = Vec::new();
    for at in &root.objects("samplers")? {
        wraps.push(Wrap { s: wrap_mode(at, "wrapS")?, t: wrap_mode(at, "wrapT")? });
    }
    let read = |at: &At| {
        let sampler = at.index("sampler", wraps.len(), "samplers")?;
        let wrap = sampler.map_or_else(Wrap::default, |sampler| wraps[sampler]);
        let core = at.index("source", image_count, "images")?;
        // Where there are both, the other one is for readers that do not know the extension.
        let mut image = core;
        if let Some(extensions) = at.object("extensions")? {
            for name in SOURCES {
                if let Some(extension) = extensions.object(name)? {
                    image = Some(extension.need_index("source", image_count, "images")?);
                }
            }
        }
        Ok(Texture { image, wrap })
    };
    root.objects("textures")?.iter().map(read).collect()
}

fn wrap_mode(at: &At, key: &str) -> Result<WrapMode> {
    match at.size(key)? {
        None | Some(10497) => Ok(WrapMode::Repeat),
        Some(33648) => Ok(WrapMode::MirroredRepeat),
        Some(33071) => Ok(WrapMode::ClampToEdge),
        Some(code) => Err(at.error(format!("{key} {code} is not one of 10497, 33648, 33071"))),
    }
}

fn read_one(at: &At, textures: &[Texture], warnings: &mut Warnings) -> Result<Material> {
    let mut material = Material {
        name: at.string("name")?.unwrap_or_default().to_owned(),
        base_color_factor: Vec4::ONE,
        metallic_factor: 1.0,
        roughness_factor: 1.0,
        emissive_factor: at.numbers("emissiveFactor")?.map_or(Vec3::ZERO, Vec3::from_array),
        normal_scale: 1.0,
        occlusion_strength: 1.0,
        alpha_mode: alpha_mode(at)?,
        double_sided: at.flag("doubleSided")?,
        ..Material::default()
    };
    let pbr = at.object("pbrMetallicRoughness")?;
    if let Some(pbr) = &pbr {
        material.base_color_factor = pbr.numbers("baseColorFactor")?.map_or(Vec4::ONE, Vec4::from_array);
        material.metallic_factor = pbr.number("metallicFactor")?.unwrap_or(1.0);
        material.roughness_factor = pbr.number("roughnessFactor")?.unwrap_or(1.0);
    }
    for slot in Slot::CORE {
        let holder = if slot.path().len() > 1 { pbr.as_ref() } else { Some(at) };
        let Some(info) = holder.map(|holder| holder.object(slot.gltf_name())).transpose()?.flatten() else {
            continue;
        };
        match slot {
            Slot::Normal => material.normal_scale = info.number("scale")?.unwrap_or(1.0),
            Slot::Occlusion => material.occlusion_strength = info.number("strength")?.unwrap_or(1.0),
            _ => {}
        }
        material.slots.extend(texture_ref(&info, textures, warnings)?.map(|texture| (slot, texture)));
    }
    let extensions = at.object("extensions")?;
    let own = extensions.map(|extensions| extensions.object(TEXTURE_EXTENSION)).transpose()?.flatten();
    if let Some(channels) = own.map(|own| own.object("channels")).transpose()?.flatten() {
        attributes(&channels, textures, &mut material, warnings)?;
    }
    Ok(material)
}

/// The attributes of a converted file.
fn attributes(
    channels: &At,
    textures: &[Texture],
    material: &mut Material,
    warnings: &mut Warnings,
) -> Result<()> {
    for name in channels.value.as_object().into_iter().flat_map(Map::keys) {
        let slot = Slot::of_gltf_name(name).filter(Slot::is_attribute).ok_or_else(|| {
            let rule = AttributeName::RULE;
            channels.error(format!(
                "{} is no channel; channels are NAMETexture, where NAME has {rule}",
                quoted(name)
            ))
        })?;
        if let Some(info) = channels.object(name)? {
            material.slots.extend(texture_ref(&info, textures, warnings)?.map(|texture| (slot, texture)));
        }
    }
    Ok(())
}

fn alpha_mode(at: &At) -> Result<AlphaMode> {
    let cutoff = at.number("alphaCutoff")?.unwrap_or(0.5);
    match at.string("alphaMode")? {
        None | Some("OPAQUE") => Ok(AlphaMode::Opaque),
        Some("MASK") => Ok(AlphaMode::Mask(cutoff)),
        Some("BLEND") => Ok(AlphaMode::Blend),
        Some(other) => Err(at.error(format!("alphaMode {} is not OPAQUE, MASK or BLEND", quoted(other)))),
    }
}

fn texture_ref(info: &At, textures: &[Texture], warnings: &mut Warnings) -> Result<Option<TextureRef>> {
    let index = info.need_index("index", textures.len(), "textures")?;
    let mut texcoord = set(info)?.unwrap_or(0);
    let mut transform = UvTransform::default();
    if let Some(extensions) = info.object("extensions")?
        && let Some(at) = extensions.object("KHR_texture_transform")?
    {
        transform = read_transform(&at)?;
        texcoord = set(&at)?.unwrap_or(texcoord);
    }
    let Some(image) = textures[index].image else {
        let detail =
            "texture slots whose texture has no `source` in a format that is read; they count as empty";
        warnings.add("texture_without_image", &info.pointer, detail);
        return Ok(None);
    };
    Ok(Some(TextureRef { image, wrap: textures[index].wrap, texcoord, transform }))
}

fn set(at: &At) -> Result<Option<usize>> {
    let set = at.size("texCoord")?;
    match set {
        Some(set) if set >= TEXCOORD_SETS_MAX => Err(at.error(format!(
            "texCoord {set}: texture coordinate sets are numbered 0 to {}",
            TEXCOORD_SETS_MAX - 1
        ))),
        set => Ok(set),
    }
}

fn read_transform(at: &At) -> Result<UvTransform> {
    let pair = |key: &str| {
        let pair = at.numbers::<2>(key)?;
        match pair {
            Some(numbers) if numbers.iter().any(|number| number.abs() > TRANSFORM_MAX) => {
                Err(at.error(format!("`{key}` leaves ±{TRANSFORM_MAX:e}")))
            }
            _ => Ok(pair.map(Vec2::from_array)),
        }
    };
    Ok(UvTransform {
        offset: pair("offset")?.unwrap_or(Vec2::ZERO),
        rotation: at.number("rotation")?.unwrap_or(0.0),
        scale: pair("scale")?.unwrap_or(Vec2::ONE),
    })
}
