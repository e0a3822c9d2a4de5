//! The materials of an OBJ file: libraries found, definitions matched to `usemtl`, image files named.

use std::collections::HashMap;

use glam::Vec3;

use super::super::Context;
use super::super::made_up::{ImageFiles, plain};
use super::super::text::quoted_bytes;
use super::super::uri::folder_of;
use super::mtl::{self, Definition, Map};
use super::parse::Parsed;
use super::ptex::{self, Kind, Uses};
use crate::asset::{AlphaMode, Material, Slot, TextureRef};
use crate::error::{Error, Result};
use crate::image::{Wrap, WrapMode};

/// A definition with the folder of its library.
struct Found {
    definition: Definition,
    folder: String,
}

/// Materials by number of first use, the image files that they name, and which of these are Ptex.
pub(super) fn read(
    parsed: &mut Parsed,
    file: &str,
    context: &mut Context,
) -> Result<(Vec<Material>, ImageFiles, Uses)> {
    let mut found = definitions(parsed, file, context)?;
    if let Some(definition) = ptex::beside(parsed, file, context)? {
        let folder = context.resources.folder().to_owned();
        found.insert(definition.name.clone(), Found { definition, folder });
    }
    let mut gathered = Gathered::default();
    let mut materials = Vec::new();
    let is_used = used(parsed);
    for (number, name) in parsed.materials.list.iter().enumerate() {
        materials.push(match found.get(name) {
            Some(found) => gathered.material(found, (number, is_used[number]), context)?,
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
    Ok((materials, gathered.files, gathered.ptex))
}

/// By material, whether a face has it.
fn used(parsed: &Parsed) -> Vec<bool> {
    let mut used = vec![false; parsed.materials.list.len()];
    for polygon in &parsed.soup.polygons {
        if let Some(used) = used.get_mut(polygon.material as usize) {
            *used = true;
        }
    }
    used
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

/// What materials name.
#[derive(Default)]
struct Gathered {
    files: ImageFiles,
    /// By number of a Ptex file: what it is for each kind of slot that reads it.
    kinds: HashMap<(usize, Kind), usize>,
    ptex: Uses,
}

impl Gathered {
    fn material(
        &mut self,
        found: &Found,
        (number, is_used): (usize, bool),
        context: &mut Context,
    ) -> Result<Material> {
        let definition = &found.definition;
        let mut material = plain(&definition.name);
        let maps = [
            (Slot::BaseColor, &definition.diffuse_map),
            (Slot::Normal, &definition.normal_map),
            (Slot::Emissive, &definition.emission_map),
        ];
        for (slot, map) in maps {
            let Some(map) = map else { continue };
            let kind = if slot == Slot::Normal { Kind::Normal } else { Kind::Color };
            let image = self.image(map, kind, &found.folder, context)?;
            if self.ptex.contains(image) {
                // Nobody could see it, and it has no faces to belong to.
                if is_used {
                    self.ptex.check(map, &mut context.warnings);
                    material.slots.insert(slot, self.ptex.reference(number, image));
                }
                continue;
            }
            self.ptex.keep_own(number);
            let mode = if map.clamp { WrapMode::ClampToEdge } else { WrapMode::Repeat };
            let wrap = Wrap { s: mode, t: mode };
            material.slots.insert(slot, TextureRef { image, wrap, texcoord: 0, transform: map.transform });
        }
        self.ptex.number_sets(number, &mut material);
        let [has_diffuse_map, has_emission_map] =
            [&definition.diffuse_map, &definition.emission_map].map(Option::is_some);

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

    /// A Ptex file is an image for each kind of slot that reads it.
    fn image(&mut self, map: &Map, kind: Kind, folder: &str, context: &mut Context) -> Result<usize> {
        let file = self.files.number(&map.file, folder, &map.place, context)?;
        if !self.files.is_apart(file) {
            return Ok(file);
        }
        if let Some(&known) = self.kinds.get(&(file, kind)) {
            return Ok(known);
        }
        let number = if self.ptex.contains(file) { self.files.copy(file) } else { file };
        self.kinds.insert((file, kind), number);
        self.ptex.add(number, kind);
        Ok(number)
    }
}
