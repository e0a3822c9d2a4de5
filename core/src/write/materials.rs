//! Materials: converted slots point at level images, the others at the texture coordinate sets that
//! moved behind `TEXCOORD_0`.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec2;
use serde_json::{Map, Value, json};

use crate::asset::{Asset, MESH_COLORS_EXTENSION};
use crate::error::{Error, Result};
use crate::finished::{EXTENSION, Finished, FinishedTexture};
use crate::image::LevelRange;

use super::draft::{Draft, at, index, member, object, remove_extension};
use super::references::visit_texture_infos;
use super::united::{self, United};
use super::{images, parts};

const CLAMP_TO_EDGE: u32 = 33071;
const LINEAR: u32 = 9729;

/// What primitives have to know of a converted material, or of one of its parts.
#[derive(Clone)]
pub struct Converted {
    /// The glTF material.
    pub number: usize,
    /// Size of level 0, texels.
    pub size: Vec2,
    /// The same in all parts. Source sets that unconverted textures read: the one at `n` becomes `TEXCOORD_{n + 1}`.
    pub sets: Vec<usize>,
    /// Whether something that is not converted needs the source's tangents.
    pub keeps_tangents: bool,
    /// Whether the base color holds the vertex colors, which the primitives lose.
    pub takes_colors: bool,
}

pub struct Materials {
    source: Vec<Value>,
    /// By material and part.
    converted: BTreeMap<(usize, usize), Converted>,
    pub united: United,
    /// Copies of source materials, by source and the converted material whose sets they read.
    copies: BTreeMap<(usize, Option<usize>), usize>,
}

impl Materials {
    /// Adds the level images (`encoded`: PNG by texture and level) and rewrites the materials.
    pub fn convert(
        draft: &mut Draft<'_>,
        asset: &Asset,
        finished: &Finished,
        encoded: Vec<Vec<Vec<u8>>>,
    ) -> Result<Self> {
        parts::forget(draft);
        for material in &mut draft.materials {
            remove_extension(object(material), MESH_COLORS_EXTENSION);
        }
        let source = draft.materials.clone();
        let mut this =
            Self { source, converted: BTreeMap::new(), united: United::default(), copies: BTreeMap::new() };
        let first_new = draft.textures.len();
        let sampler = draft.samplers.len();
        if !finished.textures.is_empty() {
            draft.samplers.push(json!({
                "magFilter": LINEAR, "minFilter": LINEAR, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE
            }));
        }
        for (place, number) in parts::open(draft, asset, finished)? {
            let takes_colors = finished.vertex_colors.contains(&place.0);
            let (size, sets) = (Vec2::ZERO, Vec::new());
            let blank = Converted { number, size, sets, keeps_tangents: false, takes_colors };
            this.converted.insert(place, blank);
        }
        for (texture, levels) in finished.textures.iter().zip(encoded) {
            if texture.slots.is_empty() {
                return Err(Error::internal("a converted texture has no slots"));
            }
            let size = texture.levels.first().map(|level| Vec2::new(level.width as f32, level.height as f32));
            let size = size.ok_or_else(|| Error::internal("a converted texture has no levels"))?;
            let mut shown = Vec::with_capacity(texture.materials.len());
            for &material in &texture.materials {
                // A part that has no faces has no glTF material either.
                let Some(converted) = this.converted.get_mut(&(material, texture.part)) else { continue };
                converted.size = size;
                shown.push(converted.number);
            }
            if !shown.is_empty() {
                add_texture(draft, (texture, &shown), levels, sampler);
            }
        }
        this.settle_sets(draft, finished, first_new);
        this.united = united::unite(draft, finished, &mut this.converted);
        let numbers = this.converted.iter().map(|(place, converted)| (*place, converted.number));
        parts::follow(draft, &numbers.collect());
        Ok(this)
    }

    pub fn converted(&self, material: usize, part: usize) -> Option<&Converted> {
        self.converted.get(&(material, part))
    }

    pub fn is_converted(&self, material: usize) -> bool {
        self.sets(material).is_some()
    }

    fn sets(&self, material: usize) -> Option<&[usize]> {
        let mut parts = self.converted.range((material, 0)..=(material, usize::MAX));
        parts.next().map(|(_, converted)| converted.sets.as_slice())
    }

    /// A copy of the source's material: for primitives that keep their own coordinates (`None`), or
    /// for converted ones of the material `reads_sets_of`.
    pub fn copy(&mut self, draft: &mut Draft<'_>, source: usize, reads_sets_of: Option<usize>) -> usize {
        if let Some(copy) = self.copies.get(&(source, reads_sets_of)) {
            return *copy;
        }
        let mut material = self.source.get(source).cloned().unwrap_or_else(|| json!({}));
        if let Some(sets) = reads_sets_of.and_then(|material| self.sets(material)) {
            move_sets(&mut material, sets, usize::MAX);
        }
        draft.materials.push(material);
        let copy = draft.materials.len() - 1;
        self.copies.insert((source, reads_sets_of), copy);
        copy
    }

    /// Finds which sets of the source each converted material still needs, and moves them.
    fn settle_sets(&mut self, draft: &mut Draft<'_>, finished: &Finished, first_new: usize) {
        let mut needs: BTreeMap<usize, Needs> = BTreeMap::new();
        for (&(material, _), converted) in &self.converted {
            let material = needs.entry(material).or_default();
            material.add(at(&mut draft.materials, converted.number), first_new);
        }
        for piece in &finished.primitives {
            let Some(needs) = needs.get_mut(&piece.material) else { continue };
            for variant in variants(draft.primitive(piece.mesh, piece.primitive)) {
                if let Some(material) = self.source.get_mut(variant).filter(|_| variant != piece.material) {
                    needs.add(material, usize::MAX);
                }
            }
        }
        for (&(material, _), converted) in &mut self.converted {
            let Some(needs) = needs.get(&material) else { continue };
            converted.sets = needs.sets.iter().copied().collect();
            converted.keeps_tangents = needs.tangents;
            move_sets(at(&mut draft.materials, converted.number), &converted.sets, first_new);
        }
    }
}

/// What the unconverted part of a material reads of its primitives.
#[derive(Default)]
struct Needs {
    sets: BTreeSet<usize>,
    tangents: bool,
}

impl Needs {
    fn add(&mut self, material: &mut Value, first_new: usize) {
        let extensions = material.get("extensions");
        self.tangents |= extensions.is_some_and(|all| all.get("KHR_materials_anisotropy").is_some());
        visit_texture_infos(material, &mut |name, info| {
            if is_converted(info, first_new) {
                return;
            }
            self.tangents |= name.ends_with("ormalTexture");
            self.sets.insert(number(info.get("texCoord")));
            if let Some(set) = transform(info).and_then(|transform| transform.get("texCoord")) {
                self.sets.insert(number(Some(set)));
            }
        });
    }
}

fn move_sets(material: &mut Value, sets: &[usize], first_new: usize) {
    let place = |set: usize| sets.iter().position(|own| *own == set).map_or(0, |place| place + 1);
    visit_texture_infos(material, &mut |_, info| {
        if is_converted(info, first_new) {
            return;
        }
        let set = place(number(info.get("texCoord")));
        info.insert("texCoord".to_owned(), set.into());
        if let Some(set) = transform(info).and_then(|transform| transform.get_mut("texCoord")) {
            *set = place(number(Some(set))).into();
        }
    });
}

/// Adds the images of a texture and shows it in glTF materials, at least one.
fn add_texture(
    draft: &mut Draft<'_>,
    (texture, shown): (&FinishedTexture, &[usize]),
    levels: Vec<Vec<u8>>,
    sampler: usize,
) {
    let number = draft.textures.len();
    let channel = texture.slots[0].gltf_name().trim_end_matches("Texture");
    let name = format!("{} {channel}", parts::name(draft, shown[0]));
    let mut source_name = None;
    for &material in shown {
        let material = object(at(&mut draft.materials, material));
        for slot in &texture.slots {
            let mut info = &mut *material;
            for step in slot.path() {
                info = member(info, step);
            }
            let source = info.insert("index".to_owned(), number.into());
            source_name = source_name.or(source);
            info.remove("texCoord");
            remove_extension(info, "KHR_texture_transform");
        }
    }
    let levels: Vec<usize> = levels
        .into_iter()
        .enumerate()
        .map(|(level, png)| images::add(draft, png, format!("{name} level {level}")))
        .collect();
    let mut json = Map::new();
    let source_name = source_name.and_then(|index| draft.textures.get(index.as_u64()? as usize)?.get("name"));
    if let Some(name) = source_name {
        json.insert("name".to_owned(), name.clone());
    }
    json.insert("sampler".to_owned(), sampler.into());
    json.insert("source".to_owned(), levels[0].into());
    let mut extension = Map::from_iter([("levels".to_owned(), levels.into())]);
    if !texture.ranges.is_empty() {
        extension.insert("ranges".to_owned(), ranges(texture));
    }
    extension.extend(texture.value_scale.map(|scale| ("valueScale".to_owned(), scale.into())));
    json.insert("extensions".to_owned(), json!({ EXTENSION: extension }));
    draft.textures.push(Value::Object(json));
}

/// The levels that hold other values than codes of [0, 1], by number.
fn ranges(texture: &FinishedTexture) -> Value {
    let entry = |(level, range): (&usize, &LevelRange)| match range {
        LevelRange::Float16 => json!({ "level": level, "format": range.name() }),
        LevelRange::Scaled16 { scale, bias } => {
            let stored: &[usize] = match texture.levels.get(*level).map_or(0, |image| image.components) {
                1 => &[0],
                2 => &[0, 3],
                3 => &[0, 1, 2],
                _ => &[0, 1, 2, 3],
            };
            let [scale, bias] = [scale, bias].map(|of| stored.iter().map(|&k| of[k]).collect::<Vec<f32>>());
            json!({ "level": level, "format": range.name(), "scale": scale, "bias": bias })
        }
    };
    texture.ranges.iter().map(entry).collect()
}

/// The materials that `KHR_materials_variants` maps a primitive to.
pub fn variants(primitive: &Map<String, Value>) -> Vec<usize> {
    let mappings = primitive
        .get("extensions")
        .and_then(|extensions| extensions.get("KHR_materials_variants")?.get("mappings")?.as_array());
    mappings.into_iter().flatten().filter_map(|mapping| index(mapping, "material")).collect()
}

fn is_converted(info: &Map<String, Value>, first_new: usize) -> bool {
    number(info.get("index")) >= first_new
}

fn transform(info: &mut Map<String, Value>) -> Option<&mut Value> {
    info.get_mut("extensions")?.get_mut("KHR_texture_transform")
}

/// A set or index; what is missing is 0, as glTF has it.
fn number(value: Option<&Value>) -> usize {
    value.and_then(Value::as_u64).map_or(0, |number| number as usize)
}
