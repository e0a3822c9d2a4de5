//! Attributes: channels of materials that core glTF has no slot for, each from an image file beside the model.

use std::collections::HashMap;

use super::images::{self, Wanted};
use super::text::quoted;
use super::{Context, bare, openexr};
use crate::asset::{Asset, AttributeName, EncodedImage, Slot, TextureRef, UvTransform};
use crate::error::{Error, ErrorCode, Result};
use crate::image::{Image, Wrap};
use crate::watch;

/// An image that one material, or all, show as an attribute.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttributeSource {
    pub name: AttributeName,
    /// By its name; `None`: all that have faces, and faces without one get glTF's default.
    pub material: Option<String>,
    /// Relative to the model, as URIs in glTF are: PNG, JPEG, WebP, KTX2 or OpenEXR.
    pub file: String,
    /// The set of texture coordinates that places it, which repeat.
    pub texcoord: usize,
}

/// How errors name the place of an attribute: the option that asks for it.
const POINTER: &str = "/channel";

/// Gives materials the attributes that were asked for.
///
/// # Errors
/// `InvalidOptions` where there is no such material, it has such an attribute already, mesh colors, or faces without that set of
/// coordinates; those of files and images.
pub(super) fn add(asset: &mut Asset, wanted: &[AttributeSource], context: &mut Context) -> Result<()> {
    if wanted.is_empty() {
        return Ok(());
    }
    let numbers = load(asset, wanted, context)?;
    if wanted.iter().any(|source| source.material.is_none()) {
        let Asset { document, meshes, materials, .. } = asset;
        bare::give_material(&mut document.json, meshes, materials, |_| true)?;
    }
    for (source, image) in wanted.iter().zip(numbers) {
        let materials = materials(asset, source)?;
        for material in materials {
            check_faces(asset, material, source)?;
            let texture = TextureRef {
                image,
                wrap: Wrap::default(),
                texcoord: source.texcoord,
                transform: UvTransform::default(),
            };
            let slots = &mut asset.materials[material].slots;
            if slots.insert(Slot::Attribute(source.name), texture).is_some() {
                return Err(refused(format!(
                    "material {} would have two channels {}; give each a name of its own",
                    quoted(&asset.materials[material].name),
                    source.name.as_str()
                )));
            }
        }
    }
    Ok(())
}

fn refused(detail: String) -> Error {
    Error::new(ErrorCode::InvalidOptions, detail).at(POINTER)
}

/// Appends the images, each file's once; returns the number of each source's.
fn load(asset: &mut Asset, wanted: &[AttributeSource], context: &mut Context) -> Result<Vec<usize>> {
    let decoded: u64 = asset.images.iter().map(|image| image.texel_count() as u64).sum();
    context.budget.take_pixels(decoded.saturating_sub(context.budget.pixels()))?;
    let mut known: HashMap<&str, usize> = HashMap::new();
    let mut numbers = Vec::with_capacity(wanted.len());
    for source in wanted {
        let number = match known.get(source.file.as_str()) {
            Some(number) => *number,
            None => {
                let place = format!("{POINTER}/{}", source.name.as_str());
                let image = image(&source.file, place, context)?;
                asset.images.push(image);
                asset.images.len() - 1
            }
        };
        known.insert(&source.file, number);
        numbers.push(number);
    }
    Ok(numbers)
}

fn image(file: &str, place: String, context: &mut Context) -> Result<Image> {
    watch::check(context.watch)?;
    let folder = context.resources.folder().to_owned();
    let (_, bytes) = context.resources.load_name(file.as_bytes(), &folder, &place, &mut context.budget)?;
    let image = if openexr::is_openexr(&bytes) {
        let [width, height] =
            openexr::size(&bytes, context.budget.limits, &place).map_err(|error| error.at(&place))?;
        context.budget.take_pixels(u64::from(width) * u64::from(height)).map_err(|error| error.at(&place))?;
        openexr::decode(&bytes).map_err(|error| error.at(&place))?
    } else {
        let encoded = [EncodedImage { media_type: String::new(), bytes }];
        let mut decoded = images::decode_all(&encoded, &[Wanted::Shared], |_| place.clone(), context)?;
        let image = decoded.images.pop().ok_or_else(|| Error::internal("an image was lost"))?;
        context.budget.take_pixels(image.texel_count() as u64).map_err(|error| error.at(&place))?;
        image
    };
    Ok(image)
}

/// Those of its name that have faces.
fn materials(asset: &Asset, source: &AttributeSource) -> Result<Vec<usize>> {
    let channel = source.name.as_str();
    let all = || asset.materials.iter().enumerate();
    let is_named = |name: &str| source.material.as_ref().is_none_or(|wanted| wanted == name);
    let named: Vec<usize> =
        all().filter(|(_, material)| is_named(&material.name)).map(|(number, _)| number).collect();
    if let (Some(wanted), true) = (&source.material, named.is_empty()) {
        let names: Vec<String> = all().take(8).map(|(_, material)| quoted(&material.name)).collect();
        let more = if asset.materials.len() > names.len() { ", …" } else { "" };
        return Err(refused(format!(
            "no material is called {}, which is to have channel {channel}; there are: {}{more}",
            quoted(wanted),
            names.join(", ")
        )));
    }
    let primitives = || asset.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let has_faces = |number: &usize| {
        primitives().any(|primitive| primitive.material == Some(*number) && !primitive.faces.is_empty())
    };
    let found: Vec<usize> = named.into_iter().filter(has_faces).collect();
    if found.is_empty() {
        let owner = source
            .material
            .as_ref()
            .map_or("the model".to_owned(), |name| format!("material {}", quoted(name)));
        return Err(refused(format!("{owner} has no face that channel {channel} could be on")));
    }
    Ok(found)
}

/// Whether all faces of a material have the coordinates that the attribute is placed by.
fn check_faces(asset: &Asset, material: usize, source: &AttributeSource) -> Result<()> {
    let (own, channel) = (&asset.materials[material], source.name.as_str());
    if own.mesh_colors.is_some() {
        return Err(refused(format!(
            "material {} has mesh colors already, to which channel {channel} cannot be added; add it as the textured model is \
             converted",
            quoted(&own.name)
        )));
    }
    for (number, mesh) in asset.meshes.iter().enumerate() {
        for (place, primitive) in mesh.primitives.iter().enumerate() {
            let is_shown = primitive.material == Some(material) && !primitive.faces.is_empty();
            if is_shown && primitive.texcoords.get(source.texcoord).is_none_or(Vec::is_empty) {
                let count = primitive.texcoords.len();
                let remedy =
                    if count == 0 { "give it some" } else { "choose one by #SET behind the file's name" };
                return Err(refused(format!(
                    "channel {channel} is placed by TEXCOORD_{}, and /meshes/{number}/primitives/{place} has {count} sets of texture \
                     coordinates; {remedy}, or name a material that has it",
                    source.texcoord,
                )));
            }
        }
    }
    Ok(())
}
