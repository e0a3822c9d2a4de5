//! `MCT_mesh_colors`: quads of a primitive, and the samples of a material (docs/mesh_colors.md).

use std::ops::RangeInclusive;

use ::gltf::accessor::Dimensions;

use super::super::Context;
use super::super::budget::Budget;
use super::super::json::At;
use super::super::text::quoted;
use super::accessors::{Accessor, Store};
use super::typed::{finite_floats, whole_numbers};
use crate::asset::{
    AttributeName, EXPONENT_MAX, Face, MESH_COLORS_EXTENSION, Material, Mesh, MeshColorChannel, MeshColors,
    Slot, VALUE_SCALES,
};
use crate::error::Result;

/// A tangent may be so much longer or shorter than 1.
const UNIT_TOLERANCE: f32 = 1e-3;

const OUT_OF_RANGE: &str = "channels with samples outside of [0, 1], which is all that a texture slot holds; the nearest in it are taken";
/// Lengths of normals that pass for unit: those between two others are shorter.
const UNIT_LENGTHS: RangeInclusive<f32> = 0.5..=1.01;
const NOT_UNIT: &str = "channels with normals far from unit length (shorter than 0.5 or longer than 1.01), which may be no normals at all; \
                        where they point is what is taken";

/// Joins triangles that a primitive names as quads; whether it names any.
pub(super) fn join_quads(
    primitive: &At,
    faces: &mut Vec<Face>,
    store: &Store,
    budget: &mut Budget,
) -> Result<bool> {
    let Some(own) = extension(primitive)? else { return Ok(false) };
    let Some((at, accessor)) = accessor(&own, "quads", store)? else { return Ok(false) };
    let firsts = whole_numbers(store, accessor, ("quads", Dimensions::Scalar), budget)?;
    let mut joined = Vec::with_capacity(faces.len());
    let mut next = 0;
    for first in firsts.into_iter().map(|first| first as usize) {
        let pair = first.checked_add(2).and_then(|end| faces.get(first..end)).filter(|_| first >= next);
        let Some([one, other]) = pair else {
            return Err(at.error(format!(
                "triangle {first} cannot begin a quad: its number has to be above those of the quads before it, and there \
                 are {} triangles",
                faces.len()
            )));
        };
        let ([a, b, c, _], [d, e, f, _]) = (one.corners, other.corners);
        if [a, c] != [d, e] {
            return Err(at.error(format!(
                "triangles {first} and {} are no quad: their vertex indices are {a} {b} {c} and {d} {e} {f}, and have to be a b c \
                 and a c d",
                first + 1
            )));
        }
        joined.extend_from_slice(&faces[next..first]);
        joined.push(Face::quad([a, b, c, f]));
        next = first + 2;
    }
    joined.extend_from_slice(&faces[next..]);
    *faces = joined;
    Ok(true)
}

/// Puts samples in their materials, and takes textures out of the slots that they are for.
pub(super) fn read(
    root: &At,
    store: &Store,
    meshes: &[Mesh],
    materials: &mut [Material],
    context: &mut Context,
) -> Result<()> {
    for (number, (at, material)) in root.objects("materials")?.iter().zip(materials).enumerate() {
        let Some(own) = extension(at)? else { continue };
        let primitives = meshes.iter().flat_map(|mesh| &mesh.primitives);
        let faces = primitives.filter(|primitive| primitive.material == Some(number));
        let counts: Vec<u8> = faces.flat_map(|primitive| &primitive.faces).map(|face| face.count).collect();
        let colors = read_colors(&own, &counts, store, &mut context.budget)?;
        let leaves_range = |channel: &&MeshColorChannel| {
            !channel.slots.contains(&Slot::Normal)
                && channel.value_scale.is_none()
                && channel.samples.iter().any(|value| !(0.0..=1.0).contains(value))
        };
        let is_far_from_unit = |normal: &[f32]| !UNIT_LENGTHS.contains(&length(normal));
        let has_odd_normals = |channel: &&MeshColorChannel| {
            channel.slots.contains(&Slot::Normal) && channel.samples.chunks_exact(3).any(is_far_from_unit)
        };
        for _ in colors.channels.iter().filter(leaves_range) {
            context.warnings.add("mesh_color_out_of_range", &own.pointer, OUT_OF_RANGE);
        }
        for _ in colors.channels.iter().filter(has_odd_normals) {
            context.warnings.add("mesh_color_not_unit", &own.pointer, NOT_UNIT);
        }
        for slot in colors.channels.iter().flat_map(|channel| &channel.slots) {
            material.slots.remove(slot);
        }
        material.mesh_colors = Some(colors);
    }
    Ok(())
}

fn extension<'a>(at: &At<'a>) -> Result<Option<At<'a>>> {
    match at.object("extensions")? {
        Some(extensions) => extensions.object(MESH_COLORS_EXTENSION),
        None => Ok(None),
    }
}

/// The accessor that a member names, with the member's place.
fn accessor<'a, 's>(at: &At<'a>, key: &str, store: &'s Store) -> Result<Option<(At<'a>, &'s Accessor)>> {
    let Some(member) = at.get(key) else { return Ok(None) };
    let index = member.index_below(store.accessors.len(), "accessors")?;
    Ok(Some((member, &store.accessors[index])))
}

/// `counts`: corners of the faces of the model.
fn read_colors(at: &At, counts: &[u8], store: &Store, budget: &mut Budget) -> Result<MeshColors> {
    let partners = match accessor(at, "partners", store)? {
        Some((at, accessor)) => {
            partners(&at, &whole_numbers(store, accessor, ("partners", Dimensions::Scalar), budget)?, counts)?
        }
        None => vec![None; counts.len()],
    };
    let is_first = |(face, partner): (usize, &Option<u32>)| partner.is_none_or(|other| other as usize > face);
    let face_count = partners.iter().enumerate().filter(|pair| is_first(*pair)).count();
    let Some((place, exponents)) = accessor(at, "exponents", store)? else {
        return Err(at.error("`exponents` is missing"));
    };
    let exponents = whole_numbers(store, exponents, ("exponents", Dimensions::Vec2), budget)?;
    if exponents.len() != 2 * face_count {
        return Err(place.error(format!(
            "there are {} pairs of exponents for {face_count} faces (two triangles that are partners are one)",
            exponents.len() / 2
        )));
    }
    if let Some(&exponent) = exponents.iter().find(|&&exponent| exponent > EXPONENT_MAX.into()) {
        return Err(place.error(format!("exponent {exponent} is too large; allowed is 0..={EXPONENT_MAX}")));
    }
    let exponents = exponents.chunks_exact(2).map(|pair| [pair[0] as u8, pair[1] as u8]).collect();
    let mut channels: Vec<MeshColorChannel> = Vec::new();
    for channel in &at.objects("channels")? {
        let read = read_channel(channel, face_count, store, budget)?;
        let taken = |slot: &&Slot| channels.iter().any(|known| known.slots.contains(slot));
        if let Some(slot) = read.slots.iter().find(taken) {
            return Err(channel.error(format!("{} is in another channel already", slot.gltf_name())));
        }
        channels.push(read);
    }
    if channels.is_empty() {
        return Err(at.error("`channels` is missing or empty"));
    }
    Ok(MeshColors { partners, exponents, channels })
}

/// Each face names itself, or the triangle that it is a quad with.
fn partners(at: &At, numbers: &[u32], counts: &[u8]) -> Result<Vec<Option<u32>>> {
    if numbers.len() != counts.len() {
        return Err(at.error(format!(
            "there are {} partners for the {} triangles and quads of this material",
            numbers.len(),
            counts.len()
        )));
    }
    let partner = |(face, &number): (usize, &u32)| {
        if number as usize == face {
            return Ok(None);
        }
        let is_mutual = numbers.get(number as usize).is_some_and(|&back| back as usize == face);
        let are_triangles = [face, number as usize].iter().all(|&face| counts.get(face) == Some(&3));
        if is_mutual && are_triangles {
            return Ok(Some(number));
        }
        Err(at.error(format!(
            "face {face} names {number} as its partner: partners are two triangles that name each other, and a face without \
             one names itself"
        )))
    };
    numbers.iter().enumerate().map(partner).collect()
}

fn read_channel(at: &At, face_count: usize, store: &Store, budget: &mut Budget) -> Result<MeshColorChannel> {
    let slots = slots(at)?;
    let components = one_of(at, "components", &[1, 2, 3, 4])?;
    let bits = one_of(at, "bits", &[8, 16])?;
    if slots.contains(&Slot::Normal) && components != 3 {
        return Err(at.error(format!("normals have 3 components, not {components}")));
    }
    let Some((_, samples)) = accessor(at, "samples", store)? else {
        return Err(at.error("`samples` is missing"));
    };
    let dimensions = match components {
        1 => Dimensions::Scalar,
        2 => Dimensions::Vec2,
        3 => Dimensions::Vec3,
        _ => Dimensions::Vec4,
    };
    let mut samples = finite_floats(store, samples, ("samples", dimensions), budget)?;
    let value_scale = value_scale(at, &slots, bits)?;
    if let Some(scale) = value_scale {
        samples.iter_mut().for_each(|value| *value /= scale);
        check_sizes(at, &samples, scale)?;
    }
    let cuts = match accessor(at, "cuts", store)? {
        Some((at, accessor)) => {
            let cuts = whole_numbers(store, accessor, ("cuts", Dimensions::Scalar), budget)?;
            check_count(&at, cuts.len(), face_count, "one for each face")?;
            let bits = |&bits: &u32| {
                u8::try_from(bits).ok().filter(|bits| *bits < 16).ok_or_else(|| {
                    at.error(format!("{bits} is not a set of edges: bits 0 to 3 stand for edges 0 to 3"))
                })
            };
            cuts.iter().map(bits).collect::<Result<_>>()?
        }
        None => Vec::new(),
    };
    let tangents = match accessor(at, "tangents", store)? {
        Some((at, accessor)) => {
            let numbers = finite_floats(store, accessor, ("tangents", Dimensions::Vec4), budget)?;
            check_count(&at, numbers.len() / 4, 4 * face_count, "four for each face")?;
            tangents(&at, &numbers)?
        }
        None => Vec::new(),
    };
    Ok(MeshColorChannel { slots, components, bits, cuts, samples, value_scale, tangents })
}

/// Of attributes alone.
fn value_scale(at: &At, slots: &[Slot], bits: u8) -> Result<Option<f32>> {
    let Some(scale) = at.number("valueScale")? else { return Ok(None) };
    if !slots.iter().all(Slot::is_attribute) || bits != 16 {
        return Err(
            at.error("`valueScale` is for channels of 16 bits beside the core slots (NAMETexture) alone")
        );
    }
    if (VALUE_SCALES[0]..=VALUE_SCALES[1]).contains(&scale) {
        return Ok(Some(scale));
    }
    let [low, high] = VALUE_SCALES;
    Err(at.error(format!("`valueScale` is {scale}; allowed is 2^-100 to 2^100 ({low:e} to {high:e})")))
}

fn check_sizes(at: &At, samples: &[f32], scale: f32) -> Result<()> {
    match samples.iter().position(|value| value.abs() > 1.0) {
        Some(number) => Err(at.error(format!(
            "number {number} of the samples is {}; `valueScale` says that none leaves ±{scale}",
            samples[number] * scale
        ))),
        None => Ok(()),
    }
}

fn slots(at: &At) -> Result<Vec<Slot>> {
    let mut slots = Vec::new();
    for name in at.list("slots")? {
        let name = name.as_str().ok_or_else(|| at.error("`slots` is a list of strings"))?;
        let slot = Slot::of_gltf_name(name).ok_or_else(|| {
            let names = Slot::CORE.each_ref().map(Slot::gltf_name).join(", ");
            let attributes = AttributeName::RULE;
            at.error(format!(
                "{} is not a slot; slots are {names}, and NAMETexture with a NAME of {attributes}",
                quoted(name)
            ))
        })?;
        slots.push(slot);
    }
    slots.sort_unstable();
    let count = slots.len();
    slots.dedup();
    if slots.is_empty() || slots.len() != count {
        return Err(at.error("`slots` has to name at least one slot, and each once"));
    }
    let kind = |slot: Slot| (slot.is_color(), slot.is_attribute());
    let is_apart = |one: Slot| one == Slot::Normal || kind(one) != kind(slots[0]);
    if slots[1..].iter().any(|&slot| is_apart(slot)) || slots.len() > 1 && slots[0] == Slot::Normal {
        return Err(at.error(
            "slots of one channel hold one kind of thing: color, data, normals, or what NAMETexture holds",
        ));
    }
    Ok(slots)
}

fn one_of(at: &At, key: &str, allowed: &[usize]) -> Result<u8> {
    let number = at.need_size(key)?;
    if allowed.contains(&number) {
        return Ok(number as u8);
    }
    let allowed: Vec<String> = allowed.iter().map(usize::to_string).collect();
    Err(at.error(format!("`{key}` is {number}; allowed: {}", allowed.join(", "))))
}

fn check_count(at: &At, count: usize, wanted: usize, rule: &str) -> Result<()> {
    if count == wanted {
        return Ok(());
    }
    Err(at.error(format!("there are {count} entries; {wanted} are needed, {rule}")))
}

fn length(vector: &[f32]) -> f32 {
    vector.iter().map(|x| x * x).sum::<f32>().sqrt()
}

/// Each all zero, or of unit length with a handedness.
fn tangents(at: &At, numbers: &[f32]) -> Result<Vec<[[f32; 4]; 4]>> {
    let tangent = |(number, four): (usize, &[f32])| {
        let tangent = [four[0], four[1], four[2], four[3]];
        let is_unit = (length(&four[..3]) - 1.0).abs() <= UNIT_TOLERANCE && four[3].abs() == 1.0;
        if is_unit || tangent == [0.0; 4] {
            return Ok(tangent);
        }
        Err(at.error(format!(
            "tangent {number} is neither zero nor of unit length with a handedness of 1 or -1"
        )))
    };
    let all: Vec<[f32; 4]> = numbers.chunks_exact(4).enumerate().map(tangent).collect::<Result<_>>()?;
    let of_face = |(face, four): (usize, &[[f32; 4]])| {
        let four = [four[0], four[1], four[2], four[3]];
        let handedness = four.map(|tangent| tangent[3]);
        if handedness.iter().any(|own| *own != handedness[0]) {
            return Err(at.error(format!("the tangents of face {face} differ in handedness")));
        }
        Ok(four)
    };
    all.chunks_exact(4).enumerate().map(of_face).collect()
}
