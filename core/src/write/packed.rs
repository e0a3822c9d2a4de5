//! Vertices and indices packed again (`EXT_meshopt_compression`), in the order that they have.

use std::borrow::Cow;
use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

use crate::error::Result;
use crate::vertex_codec::{self, Checked, Filter, Form, Mode, packed_attributes, packed_indices, rounded};
use crate::watch::{Watch, check};

use super::draft::{Draft, Packing, index};

/// How vertices and indices are stored in `asset.glb`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GeometryFormat {
    /// As they are.
    Plain,
    /// Packed; every bit is there again.
    Meshopt,
    /// Packed, with positions, normals, tangents and what the source had of texture coordinates rounded before, each
    /// number by itself: equal numbers stay equal, and so corners that are at one place. Nothing else is rounded.
    Quantized,
}

const FLOAT: u64 = 5126;
const UNSIGNED_INT: u64 = 5125;
const UNSIGNED_SHORT: u64 = 5123;
const ARRAY_BUFFER: u64 = 34962;
const ELEMENT_ARRAY_BUFFER: u64 = 34963;
/// Of a position or a texture coordinate: off by less than 1/32768 of itself.
const PLACE_BITS: u8 = 16;
/// Of a unit vector's component: off by less than 1/8192, about a hundredth of a degree.
const DIRECTION_BITS: u8 = 14;

/// Packs the views that hold nothing but elements of one size, where that makes them smaller.
pub fn pack(draft: &mut Draft<'_>, format: GeometryFormat, watch: &dyn Watch) -> Result<()> {
    if format == GeometryFormat::Plain {
        return Ok(());
    }
    let names = names(draft);
    let mut users = vec![Vec::new(); draft.views.len()];
    for (number, accessor) in draft.accessors.iter().enumerate() {
        if let Some(users) = index(accessor, "bufferView").and_then(|view| users.get_mut(view)) {
            users.push(number);
        }
    }
    let mut is_packed = false;
    for (view, users) in users.iter().enumerate() {
        check(watch)?;
        let target = draft.views[view].json.get("target").and_then(Value::as_u64);
        is_packed |= match target {
            Some(ARRAY_BUFFER) => pack_vertices(draft, view, users, (format, &names)).is_some(),
            Some(ELEMENT_ARRAY_BUFFER) => pack_indices(draft, view, users).is_some(),
            _ => false,
        };
    }
    if is_packed {
        for list in ["extensionsUsed", "extensionsRequired"] {
            let listed = draft.root.entry(list).or_insert_with(|| json!([]));
            if let Value::Array(listed) = listed
                && !listed.iter().any(|name| name == vertex_codec::EXTENSION)
            {
                listed.push(vertex_codec::EXTENSION.into());
            }
        }
    }
    Ok(())
}

/// By accessor: the attributes that it is; those of converted primitives' own coordinates have a star.
fn names(draft: &Draft<'_>) -> Vec<BTreeSet<String>> {
    let mut names = vec![BTreeSet::new(); draft.accessors.len()];
    let primitives = draft.meshes.iter().filter_map(|mesh| mesh.get("primitives")?.as_array()).flatten();
    for primitive in primitives {
        let attributes = primitive.get("attributes").and_then(Value::as_object);
        let is_converted = attributes.is_some_and(|all| all.keys().any(|name| name.starts_with("_MCT_")));
        let targets = primitive.get("targets").and_then(Value::as_array).into_iter().flatten();
        for all in attributes.into_iter().chain(targets.filter_map(Value::as_object)) {
            for (name, accessor) in all {
                let star = if is_converted && name == "TEXCOORD_0" { "*" } else { "" };
                let slot = accessor.as_u64().and_then(|number| names.get_mut(number as usize));
                slot.into_iter().for_each(|slot| {
                    slot.insert(format!("{name}{star}"));
                });
            }
        }
    }
    names
}

/// To how many bits an attribute may be rounded.
fn bits(name: &str) -> Option<u8> {
    match name {
        "POSITION" => Some(PLACE_BITS),
        "NORMAL" | "TANGENT" => Some(DIRECTION_BITS),
        _ if name.starts_with("TEXCOORD_") && !name.ends_with('*') => Some(PLACE_BITS),
        _ => None,
    }
}

fn pack_vertices(
    draft: &mut Draft<'_>,
    view: usize,
    users: &[usize],
    (format, names): (GeometryFormat, &[BTreeSet<String>]),
) -> Option<()> {
    let sizes: BTreeSet<usize> =
        users.iter().map(|user| element_bytes(&draft.accessors[*user])).collect::<Option<_>>()?;
    let given = draft.views[view].json.get("byteStride").and_then(Value::as_u64);
    let stride = match (given, sizes.len()) {
        (Some(stride), _) => stride as usize,
        (None, 1) => *sizes.first()?,
        _ => return None,
    };
    let bytes = draft.views[view].bytes.clone()?;
    let mut filter = Filter::None;
    let mut elements = bytes.clone();
    if format == GeometryFormat::Quantized
        && let &[user] = users
        && let Some(bits) = bits_of(&draft.accessors[user], &names[user], stride)
    {
        let values: Vec<f32> = floats(&bytes).collect();
        elements = Cow::Owned(rounded(&values, stride, bits)?);
        filter = Filter::Exponential;
    }
    let packed = packed_attributes(&elements, stride)?;
    let form = Form { mode: Mode::Attributes, filter, count: bytes.len() / stride, stride };
    put(draft, view, (form, packed))?;
    draft.views[view].json.insert("byteStride".to_owned(), stride.into());
    if let (Filter::Exponential, &[user]) = (filter, users) {
        let unpacked = draft.views[view].bytes.as_ref().and_then(|packed| Checked::new(form, packed).ok());
        set_bounds(&mut draft.accessors[user], &unpacked?.unpack().ok()?, stride);
    }
    Some(())
}

/// The bits that all names of an accessor allow, if it fills its view with floats.
fn bits_of(accessor: &Value, names: &BTreeSet<String>, stride: usize) -> Option<u8> {
    let is_whole = element_bytes(accessor) == Some(stride) && accessor.get("sparse").is_none();
    let bits: Option<Vec<u8>> = names.iter().map(|name| bits(name)).collect();
    let is_float = accessor.get("componentType").and_then(Value::as_u64) == Some(FLOAT);
    bits?.into_iter().max().filter(|_| is_whole && is_float)
}

/// Bounds are exact in glTF, and rounding may move them.
fn set_bounds(accessor: &mut Value, unpacked: &[u8], stride: usize) {
    let per_element = stride / 4;
    for (member, better) in [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)] {
        if accessor.get(member).is_some() {
            let mut bounds: Vec<f32> = floats(unpacked).take(per_element).collect();
            for (number, value) in floats(unpacked).enumerate() {
                let bound = &mut bounds[number % per_element];
                *bound = better(*bound, value);
            }
            accessor[member] = bounds.into_iter().map(f64::from).collect();
        }
    }
}

fn pack_indices(draft: &mut Draft<'_>, view: usize, users: &[usize]) -> Option<()> {
    let &[user] = users else { return None };
    let bytes = draft.views[view].bytes.clone()?;
    let (stride, indices): (usize, Vec<u32>) =
        match draft.accessors[user].get("componentType").and_then(Value::as_u64)? {
            UNSIGNED_SHORT => {
                (2, bytes.chunks_exact(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]]))).collect())
            }
            UNSIGNED_INT => {
                (4, bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
            }
            _ => return None,
        };
    let form = Form { mode: Mode::Indices, filter: Filter::None, count: indices.len(), stride };
    if indices.len() * stride != bytes.len() {
        return None;
    }
    put(draft, view, (form, packed_indices(&indices)?))
}

/// Packs a view unless that makes it larger.
fn put(draft: &mut Draft<'_>, view: usize, (form, packed): (Form, Vec<u8>)) -> Option<()> {
    let unpacked_bytes = draft.views[view].bytes.as_ref()?.len();
    // What cannot be read back is not written.
    if packed.len() >= unpacked_bytes || Checked::new(form, &packed).ok()?.unpack().is_err() {
        return None;
    }
    let name = |of: Option<&'static str>| of.unwrap_or_default();
    let mut json = Map::from_iter([
        ("byteStride".to_owned(), form.stride.into()),
        ("count".to_owned(), form.count.into()),
        (
            "mode".to_owned(),
            name(Mode::NAMED.iter().find(|(_, own)| *own == form.mode).map(|own| own.0)).into(),
        ),
    ]);
    if form.filter != Filter::None {
        let filter = Filter::NAMED.iter().find(|(_, own)| *own == form.filter).map(|own| own.0);
        json.insert("filter".to_owned(), name(filter).into());
    }
    let own = &mut draft.views[view];
    own.packing = Some(Packing { json, unpacked_bytes });
    own.bytes = Some(packed.into());
    Some(())
}

fn floats(bytes: &[u8]) -> impl Iterator<Item = f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

/// Of an element as it is stored without padding.
fn element_bytes(accessor: &Value) -> Option<usize> {
    let component = match accessor.get("componentType")?.as_u64()? {
        5120 | 5121 => 1,
        5122 | UNSIGNED_SHORT => 2,
        UNSIGNED_INT | FLOAT => 4,
        _ => return None,
    };
    let count = match accessor.get("type")?.as_str()? {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        // Columns of small matrices are padded.
        _ => return None,
    };
    Some(component * count)
}
