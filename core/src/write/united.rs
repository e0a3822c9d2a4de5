//! Converted materials that differ in nothing but their names: they become one glTF material, so that their primitives
//! can be drawn together.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use crate::asset::Mesh;
use crate::finished::{EXTENSION, Finished, FinishedPrimitive};

use super::draft::{Draft, index, remove_extension};
use super::materials::Converted;
use super::{extensions, parts, references};

/// Which materials became one.
#[derive(Default)]
pub struct United {
    /// Of each material but the first: the first.
    firsts: BTreeMap<usize, usize>,
    /// These, and the first ones.
    all: BTreeSet<usize>,
    /// glTF materials that nothing shows any more, and what stands for each.
    gone: BTreeMap<usize, usize>,
}

impl United {
    /// The material that stands for all that became one with this one.
    fn first(&self, material: usize) -> usize {
        self.firsts.get(&material).copied().unwrap_or(material)
    }

    /// Whether a material became one with others.
    pub fn contains(&self, material: usize) -> bool {
        self.all.contains(&material)
    }
}

/// Gives materials that share their textures and everything else the glTF materials of the first of them, part by part.
/// A material that is animated stays alone.
pub fn unite(
    draft: &mut Draft<'_>,
    finished: &Finished,
    converted: &mut BTreeMap<(usize, usize), Converted>,
) -> United {
    let shared = finished.textures.iter().filter(|texture| texture.materials.len() > 1);
    let candidates: BTreeSet<usize> = shared.flat_map(|texture| texture.materials.iter().copied()).collect();
    let animated = if candidates.is_empty() { BTreeSet::new() } else { parts::animated(draft) };
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    let mut united = United::default();
    for material in candidates.difference(&animated).copied() {
        let own = || converted.range((material, 0)..=(material, usize::MAX));
        if own().next().is_none() {
            continue;
        }
        let key = own().map(|((_, part), own)| format!("{part} {}\n", likeness(draft, own.number))).collect();
        let first = *known.entry(key).or_insert(material);
        if first == material {
            continue;
        }
        united.firsts.insert(material, first);
        united.all.extend([material, first]);
        let places: Vec<usize> = own().map(|((_, part), _)| *part).collect();
        for part in places {
            let Some(number) = converted.get(&(first, part)).map(|of_first| of_first.number) else {
                continue;
            };
            if let Some(own) = converted.get_mut(&(material, part)) {
                united.gone.insert(own.number, number);
                own.number = number;
            }
        }
    }
    united
}

/// All of a material but its name and place.
fn likeness(draft: &Draft<'_>, number: usize) -> String {
    let mut json = draft.materials.get(number).and_then(Value::as_object).cloned().unwrap_or_default();
    json.remove("name");
    remove_extension(&mut json, EXTENSION);
    let mut json = Value::Object(json);
    json.sort_all_objects();
    json.to_string()
}

/// By primitive and part: the sides of triangles where faces of materials meet that became one, one bit each. There
/// nothing was made to agree, and the file cannot tell these materials apart any more.
pub fn borders(
    mesh: &Mesh,
    united: &United,
    pieces: &[&FinishedPrimitive],
) -> BTreeMap<(usize, usize), Vec<u8>> {
    let own: Vec<_> = pieces.iter().filter(|piece| united.contains(piece.material)).collect();
    let mut sides = Vec::new();
    for (number, piece) in own.iter().enumerate() {
        let positions = &mesh.primitives[piece.primitive].positions;
        for (triangle, drawn) in piece.triangles.iter().enumerate() {
            // Adding 0 makes -0 into 0.
            let ends = drawn
                .vertices
                .map(|vertex| positions[vertex as usize].to_array().map(|x| (x + 0.0).to_bits()));
            for k in 0..3 {
                let (from, to) = (ends[k], ends[(k + 1) % 3]);
                sides.push((united.first(piece.material), from.min(to), from.max(to), number, triangle, k));
            }
        }
    }
    sides.sort_unstable();
    let mut bits: BTreeMap<(usize, usize), Vec<u8>> = BTreeMap::new();
    for edge in sides.chunk_by(|a, b| (a.0, a.1, a.2) == (b.0, b.1, b.2)) {
        let material = own[edge[0].3].material;
        if edge.iter().all(|side| own[side.3].material == material) {
            continue;
        }
        for &(_, _, _, number, triangle, k) in edge {
            let piece = own[number];
            let of_piece = bits.entry((piece.primitive, piece.part));
            of_piece.or_insert_with(|| vec![0; piece.triangles.len()])[triangle] |= 1 << k;
        }
    }
    bits
}

/// Removes the glTF materials that no primitive shows any more and moves all pointers to others; where the file has
/// pointers that are not known, they stay.
pub fn sweep(draft: &mut Draft<'_>, united: &United) {
    let gone = &united.gone;
    let names = extensions::names(draft);
    let is_known = |name: &String| references::understood(name) && name != parts::POINTER;
    if gone.is_empty() || !names.iter().all(is_known) {
        return;
    }
    let mut next = 0;
    let mut kept: Vec<usize> = Vec::with_capacity(draft.materials.len());
    for number in 0..draft.materials.len() {
        kept.push(next);
        next += usize::from(!gone.contains_key(&number));
    }
    let moved = |number: usize| kept.get(*gone.get(&number).unwrap_or(&number)).copied();
    let mut number = 0;
    draft.materials.retain(|_| {
        number += 1;
        !gone.contains_key(&(number - 1))
    });
    let set = |holder: &mut Value, name: &str| {
        if let Some(number) = index(holder, name).and_then(&moved) {
            holder[name] = number.into();
        }
    };
    for mesh in &mut draft.meshes {
        for primitive in list(mesh.get_mut("primitives")) {
            set(primitive, "material");
            let mappings = extension(primitive, "KHR_materials_variants").and_then(|e| e.get_mut("mappings"));
            list(mappings).iter_mut().for_each(|mapping| set(mapping, "material"));
        }
    }
    for material in &mut draft.materials {
        if let Some(own) = extension(material, EXTENSION) {
            set(own, "partOf");
        }
        for coarser in list(extension(material, "MSFT_lod").and_then(|lod| lod.get_mut("ids"))) {
            let number = coarser.as_u64().and_then(|number| moved(number as usize));
            if let Some(number) = number {
                *coarser = number.into();
            }
        }
    }
}

fn list(value: Option<&mut Value>) -> &mut [Value] {
    match value {
        Some(Value::Array(items)) => items,
        _ => &mut [],
    }
}

fn extension<'v>(value: &'v mut Value, name: &str) -> Option<&'v mut Value> {
    value.get_mut("extensions")?.get_mut(name)
}
