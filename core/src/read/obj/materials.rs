//! The materials of an OBJ file: libraries found, definitions matched to `usemtl`, images loaded.

use std::collections::HashMap;

use glam::{Vec3, Vec4};

use super::super::images::Wanted;
use super::super::text::quoted_bytes;
use super::super::uri::folder_of;
use super::super::{Context, images};
use super::mtl::{self, Definition, Map};
use super::parse::Parsed;
use crate::asset::{AlphaMode, EncodedImage, Material, Slot, TextureRef};
use crate::error::{Error, Result};
use crate::image::{Image, Wrap, WrapMode};

/// Materials by number of first use, and the images that they read.
pub(super) struct Materials {
    pub materials: Vec<Material>,
    pub images: Vec<Image>,
    pub encoded: Vec<EncodedImage>,
    /// File names of the images.
    pub image_names: Vec<String>,
}

/// A definition with the folder of its library.
struct Found {
    definition: Definition,
    folder: String,
}

pub(super) fn read(parsed: &Parsed, file: &str, context: &mut Context) -> Result<Materials> {
    let found = definitions(parsed, file, context)?;
    let mut gathered = Gathered::default();
    let mut materials = Vec::new();
    for name in &parsed.materials.list {
        materials.push(match found.get(name) {
            Some(found) => gathered.material(found, context)?,
            None => {
                if !parsed.libraries.is_empty() {
                    let detail =
                        format!("no library defines the material {}; it is plain white", quoted_bytes(name));
                    context.warnings.add("unknown_material", file, &detail);
                }
                plain(name)
            }
        });
    }
    let Gathered { encoded, names, places, .. } = gathered;
    let wanted = vec![Wanted::Shared; encoded.len()];
    let decoded = images::decode_all(&encoded, &wanted, |index| places[index].clone(), context)?;
    for reference in materials.iter_mut().flat_map(|material| &mut material.slots).flatten() {
        reference.image = decoded.canonical[reference.image];
    }
    Ok(Materials { materials, images: decoded.images, encoded, image_names: names })
}

/// All definitions by name; of two with one name, the first counts.
fn definitions(parsed: &Parsed, file: &str, context: &mut Context) -> Result<HashMap<Vec<u8>, Found>> {
    let mut found = HashMap::new();
    for (names, line) in &parsed.libraries {
        let place = format!("{file}:{line}");
        for (path, bytes) in libraries(names, &place, context)? {
            let folder = folder_of(&path).to_owned();
            for definition in mtl::parse(&bytes, &path, &mut context.warnings)? {
                // A name that leaves the upload is refused even where nothing uses the material.
                for map in definition.maps() {
                    context.resources.check_name(&map.file, &folder, &map.place)?;
                }
                let folder = folder.clone();
                found.entry(definition.name.clone()).or_insert(Found { definition, folder });
            }
        }
    }
    Ok(found)
}

/// The files after `mtllib`: one name with spaces, or several names.
fn libraries(names: &[u8], place: &str, context: &mut Context) -> Result<Vec<(String, Vec<u8>)>> {
    if names.is_empty() {
        return Err(Error::invalid("`mtllib` names no file").at(place));
    }
    let folder = context.resources.folder().to_owned();
    if let Some(whole) = context.resources.find_name(names, &folder, place, &mut context.budget)? {
        return Ok(vec![whole]);
    }
    let names = names.split(u8::is_ascii_whitespace).filter(|name| !name.is_empty());
    names.map(|name| context.resources.load_name(name, &folder, place, &mut context.budget)).collect()
}

fn plain(name: &[u8]) -> Material {
    Material {
        name: String::from_utf8_lossy(name).into_owned(),
        base_color_factor: Vec4::ONE,
        metallic_factor: 0.0,
        roughness_factor: 1.0,
        normal_scale: 1.0,
        occlusion_strength: 1.0,
        ..Material::default()
    }
}

/// Image files in the order of first use, each loaded once.
#[derive(Default)]
struct Gathered {
    encoded: Vec<EncodedImage>,
    names: Vec<String>,
    places: Vec<String>,
    numbers: HashMap<(String, Vec<u8>), usize>,
}

impl Gathered {
    fn material(&mut self, found: &Found, context: &mut Context) -> Result<Material> {
        let definition = &found.definition;
        let mut material = plain(&definition.name);
        let mut slot = |slot: Slot, map: &Option<Map>| -> Result<bool> {
            let Some(map) = map else { return Ok(false) };
            let image = self.image(map, &found.folder, context)?;
            let mode = if map.clamp { WrapMode::ClampToEdge } else { WrapMode::Repeat };
            let reference =
                TextureRef { image, wrap: Wrap { s: mode, t: mode }, texcoord: 0, transform: map.transform };
            material.slots[slot as usize] = Some(reference);
            Ok(true)
        };
        let has_diffuse_map = slot(Slot::BaseColor, &definition.diffuse_map)?;
        slot(Slot::Normal, &definition.normal_map)?;
        let has_emission_map = slot(Slot::Emissive, &definition.emission_map)?;

        // Exporters write a gray Kd beside a map that is meant as it stands.
        let diffuse = definition.diffuse.filter(|_| !has_diffuse_map).unwrap_or(Vec3::ONE);
        let opacity = definition.opacity.unwrap_or(1.0);
        material.base_color_factor = diffuse.extend(opacity);
        if opacity < 1.0 {
            material.alpha_mode = AlphaMode::Blend;
        }
        let emission = definition.emission.filter(|emission| !has_emission_map || *emission != Vec3::ZERO);
        material.emissive_factor = emission.unwrap_or(if has_emission_map { Vec3::ONE } else { Vec3::ZERO });
        material.metallic_factor = definition.metallic.unwrap_or(material.metallic_factor);
        material.roughness_factor = definition.roughness.unwrap_or(material.roughness_factor);
        if let Some(map) = &definition.normal_map {
            material.normal_scale = map.bump_multiplier;
        }
        Ok(material)
    }

    fn image(&mut self, map: &Map, folder: &str, context: &mut Context) -> Result<usize> {
        let key = (folder.to_owned(), map.file.clone());
        if let Some(&known) = self.numbers.get(&key) {
            return Ok(known);
        }
        let (path, bytes) =
            context.resources.load_name(&map.file, folder, &map.place, &mut context.budget)?;
        let media_type = images::media_type_of(&bytes).unwrap_or("application/octet-stream").to_owned();
        self.encoded.push(EncodedImage { media_type, bytes });
        self.names.push(path);
        self.places.push(map.place.clone());
        self.numbers.insert(key, self.encoded.len() - 1);
        Ok(self.encoded.len() - 1)
    }
}
