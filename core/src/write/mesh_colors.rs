//! The model with its mesh colors, unpacked: `MCT_mesh_colors` (docs/mesh_colors.md).
//!
//! Everything is as in the source but the pictures of the slots that mesh colors stand for. One texel of their mean color
//! takes their place, for viewers that do not know the extension.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};

use crate::asset::{Asset, Face, MESH_COLORS_EXTENSION, MeshColorChannel, MeshColors, VERTEX_COLORS};
use crate::error::Result;
use crate::image::Image;
use crate::watch::{Watch, check};

use super::draft::{Draft, at, index, member, object, remove_extension};
use super::materials::variants;
use super::references::{TEXTURE_SOURCES, visit_texture_infos};
use super::{compact, extensions, images, primitives, vertices};

/// A material's mesh colors on their way into a file.
pub struct PaintedMaterial {
    pub material: usize,
    pub colors: MeshColors,
    /// By channel: one texel.
    pub stand_ins: Vec<Image>,
    /// Whether the base color holds the vertex colors, which the primitives lose.
    pub takes_colors: bool,
}

/// `remodeled`: where the asset's faces are not the document's any more, by mesh and primitive of the asset the primitive of
/// the document that it comes from.
///
/// # Errors
/// `Canceled`; `InvalidModel` where a part of the source that is kept lies outside of its buffer; `ModelTooLarge` beyond what a
/// GLB can hold.
pub fn mesh_colors_glb(
    asset: &Asset,
    painted: &[PaintedMaterial],
    remodeled: Option<&[Vec<usize>]>,
    watch: &dyn Watch,
) -> Result<Vec<u8>> {
    let mut draft = Draft::open(&asset.document)?;
    if let Some(origins) = remodeled {
        remodel(&mut draft, asset, origins);
    }
    images::embed_files(&mut draft, asset);
    for (mesh, own) in asset.meshes.iter().enumerate() {
        for (primitive, source) in own.primitives.iter().enumerate() {
            check(watch)?;
            primitives::write_data_once(&mut draft, asset, [mesh, primitive])?;
            let painted = painted.iter().find(|painted| source.material == Some(painted.material));
            if painted.is_some_and(|painted| painted.takes_colors) && !source.faces.is_empty() {
                member(draft.primitive(mesh, primitive), "attributes").shift_remove(VERTEX_COLORS);
            }
            let quads = if painted.is_some() { quads(&source.faces) } else { Vec::new() };
            if !quads.is_empty() {
                let accessor = vertices::add_numbers(&mut draft, &quads);
                let own = Map::from_iter([("quads".to_owned(), accessor.into())]);
                set_extension(draft.primitive(mesh, primitive), own);
            }
        }
    }
    let as_they_were = shown_as_they_were(&mut draft, asset);
    replace_images(&mut draft, painted, &as_they_were)?;
    draft.materials.iter_mut().for_each(|material| remove_extension(object(material), MESH_COLORS_EXTENSION));
    for painted in painted {
        check(watch)?;
        let own = material(&mut draft, &painted.colors);
        set_extension(object(at(&mut draft.materials, painted.material)), own);
    }
    compact::sweep(&mut draft, &asset.document)?;
    extensions::settle(&mut draft, &[MESH_COLORS_EXTENSION]);
    draft.into_glb()
}

/// Leaves of the document's primitives those that are named, without their data where they have faces.
fn remodel(draft: &mut Draft<'_>, asset: &Asset, origins: &[Vec<usize>]) {
    for (number, (mesh, origins)) in asset.meshes.iter().zip(origins).enumerate() {
        let before = std::mem::take(draft.primitives(number));
        for (place, (primitive, origin)) in mesh.primitives.iter().zip(origins).enumerate() {
            let own = before.get(*origin).and_then(Value::as_object).cloned().unwrap_or_default();
            *draft.primitive(number, place) =
                if primitive.faces.is_empty() { own } else { primitives::rest_of(&own) };
        }
    }
}

fn set_extension(holder: &mut Map<String, Value>, own: Map<String, Value>) {
    member(holder, "extensions").insert(MESH_COLORS_EXTENSION.to_owned(), Value::Object(own));
}

/// The numbers of the first triangles of quads.
fn quads(faces: &[Face]) -> Vec<u32> {
    let mut next = 0;
    let mut quads = Vec::new();
    for face in faces {
        if face.count == 4 {
            quads.push(next);
        }
        next += face.triangles().len() as u32;
    }
    quads
}

fn material(draft: &mut Draft<'_>, colors: &MeshColors) -> Map<String, Value> {
    let mut own = Map::new();
    if colors.partners.iter().any(Option::is_some) {
        let partner = |(face, partner): (u32, &Option<u32>)| partner.unwrap_or(face);
        let partners: Vec<u32> = (0u32..).zip(&colors.partners).map(partner).collect();
        own.insert("partners".to_owned(), vertices::add_numbers(draft, &partners).into());
    }
    let exponents = colors.exponents.as_flattened();
    own.insert("exponents".to_owned(), vertices::add_packed_bytes(draft, exponents, "VEC2").into());
    let channels = colors.channels.iter().map(|channel| Value::Object(self::channel(draft, channel)));
    own.insert("channels".to_owned(), channels.collect());
    own
}

fn channel(draft: &mut Draft<'_>, channel: &MeshColorChannel) -> Map<String, Value> {
    let slots: Vec<&str> = channel.slots.iter().map(|slot| slot.gltf_name()).collect();
    let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][usize::from(channel.components - 1) % 4];
    let samples = match channel.value_scale {
        Some(scale) => Cow::Owned(channel.samples.iter().map(|value| value * scale).collect()),
        None => Cow::Borrowed(channel.samples.as_slice()),
    };
    let mut own = Map::from_iter([
        ("slots".to_owned(), json!(slots)),
        ("components".to_owned(), channel.components.into()),
        ("bits".to_owned(), channel.bits.into()),
        ("samples".to_owned(), vertices::add_packed_floats(draft, &samples, kind).into()),
    ]);
    own.extend(channel.value_scale.map(|scale| ("valueScale".to_owned(), scale.into())));
    if !channel.cuts.is_empty() {
        own.insert("cuts".to_owned(), vertices::add_packed_bytes(draft, &channel.cuts, "SCALAR").into());
    }
    if !channel.tangents.is_empty() {
        let tangents = channel.tangents.as_flattened().as_flattened();
        own.insert("tangents".to_owned(), vertices::add_packed_floats(draft, tangents, "VEC4").into());
    }
    own
}

/// Materials that something shows which is not converted: points and lines, and variants of primitives of another material.
fn shown_as_they_were(draft: &mut Draft<'_>, asset: &Asset) -> BTreeSet<usize> {
    let mut shown = BTreeSet::new();
    for (mesh, own) in asset.meshes.iter().enumerate() {
        for (primitive, source) in own.primitives.iter().enumerate() {
            shown.extend(source.material.filter(|_| source.faces.is_empty()));
            let variants = variants(draft.primitive(mesh, primitive));
            shown.extend(variants.into_iter().filter(|variant| source.material != Some(*variant)));
        }
    }
    shown
}

/// Puts stand-ins where no slot but those with mesh colors shows an image. `as_they_were`: materials that go on showing theirs
/// somewhere.
fn replace_images(
    draft: &mut Draft<'_>,
    painted: &[PaintedMaterial],
    as_they_were: &BTreeSet<usize>,
) -> Result<()> {
    let mut rest = draft.materials.clone();
    // By texture.
    let mut stand_ins: BTreeMap<usize, &Image> = BTreeMap::new();
    for painted in painted.iter().filter(|painted| !as_they_were.contains(&painted.material)) {
        for (channel, stand_in) in painted.colors.channels.iter().zip(&painted.stand_ins) {
            for slot in &channel.slots {
                let path = slot.path();
                let Some((last, path)) = path.split_last() else { continue };
                let mut holder = object(at(&mut rest, painted.material));
                for step in path {
                    holder = member(holder, step);
                }
                if let Some(texture) = holder.remove(*last).and_then(|info| index(&info, "index")) {
                    stand_ins.entry(texture).or_insert(stand_in);
                }
            }
        }
    }
    let mut shown = BTreeSet::new();
    for material in &mut rest {
        visit_texture_infos(material, &mut |_, info| {
            let texture = info.get("index").and_then(Value::as_u64).map(|index| index as usize);
            shown.extend(
                texture.and_then(|texture| draft.textures.get(texture)).into_iter().flat_map(sources),
            );
        });
    }
    for (texture, stand_in) in stand_ins {
        let Some(json) = draft.textures.get_mut(texture) else { continue };
        let own = sources(json);
        let Some(&image) = own.first().filter(|_| own.iter().all(|image| !shown.contains(image))) else {
            continue;
        };
        let json = object(json);
        json.insert("source".to_owned(), image.into());
        for name in TEXTURE_SOURCES {
            remove_extension(json, name);
        }
        let view = draft.add_view(images::png(stand_in)?, None, None);
        let json = object(at(&mut draft.images, image));
        json.remove("uri");
        json.insert("mimeType".to_owned(), "image/png".into());
        json.insert("bufferView".to_owned(), view.into());
    }
    Ok(())
}

/// The images that a texture may show.
fn sources(texture: &Value) -> Vec<usize> {
    let extended =
        TEXTURE_SOURCES.iter().filter_map(|name| index(texture.get("extensions")?.get(*name)?, "source"));
    index(texture, "source").into_iter().chain(extended).collect()
}
