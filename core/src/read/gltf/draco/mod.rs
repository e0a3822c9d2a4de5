//! `KHR_draco_mesh_compression`: compressed primitives become plain ones before anything else looks at them, in the bytes
//! and in the document's JSON, so that what is kept of the source is uncompressed as well.

mod arrays;
mod stream;
mod weights;

use std::collections::BTreeMap;

use ::gltf::accessor::DataType;
use serde_json::{Map, Value, json};

use super::super::Context;
use super::super::budget::Budget;
use super::super::json::At;
use super::views::{self, View};
use crate::error::Result;
use crate::watch;
use arrays::{Array, Form, triangles, vertices};
use stream::{Expected, Stream};

const EXTENSION: &str = "KHR_draco_mesh_compression";
const TRIANGLES: usize = 4;

/// What replaces the compressed data.
#[derive(Default)]
pub(super) struct Unpacked {
    /// By mesh and number.
    primitives: Vec<(usize, usize)>,
    /// By accessor.
    arrays: BTreeMap<usize, Array>,
    /// The views of the streams: nothing else is known to use them.
    views: Vec<usize>,
    /// What an accessor was unpacked from: the view and the attribute's id, no id for indices.
    origins: BTreeMap<usize, (usize, Option<u32>)>,
}

struct Source<'a> {
    accessors: Vec<At<'a>>,
    views: Vec<View>,
    buffers: &'a [Vec<u8>],
}

/// An attribute of a primitive by the id that it has in the stream.
struct Wanted {
    accessor: usize,
    id: u32,
    is_weights: bool,
}

/// Decodes every primitive that has no plain form. One that has is read from that, as if it had no other.
pub(super) fn unpack(root: &At, buffers: &[Vec<u8>], context: &mut Context) -> Result<Unpacked> {
    let mut unpacked = Unpacked::default();
    let mut source = None;
    for (mesh, mesh_at) in root.objects("meshes")?.iter().enumerate() {
        for (number, at) in mesh_at.objects("primitives")?.iter().enumerate() {
            watch::check(context.watch)?;
            let Some(extensions) = at.object("extensions")? else { continue };
            let Some(extension) = extensions.object(EXTENSION)? else { continue };
            let source = match &mut source {
                Some(source) => source,
                none => none.insert(Source {
                    accessors: root.objects("accessors")?,
                    views: views::read(root, buffers)?,
                    buffers,
                }),
            };
            if unpack_one(at, &extension, source, &mut unpacked, context)? {
                unpacked.primitives.push((mesh, number));
            }
        }
    }
    Ok(unpacked)
}

/// Whether the primitive was unpacked.
fn unpack_one(
    at: &At,
    extension: &At,
    source: &Source,
    unpacked: &mut Unpacked,
    context: &mut Context,
) -> Result<bool> {
    let accessor_count = source.accessors.len();
    let wanted = wanted(at, extension, accessor_count)?;
    let Some(indices) = at.index("indices", accessor_count, "accessors")? else {
        return Err(at.error("`indices` is missing: what Draco compresses are indexed triangles"));
    };
    let mut all = wanted.iter().map(|wanted| wanted.accessor).chain([indices]);
    if all.all(|accessor| source.accessors[accessor].get("bufferView").is_some()) {
        return Ok(false);
    }
    if at.size("mode")?.unwrap_or(TRIANGLES) != TRIANGLES {
        return Err(
            at.error("compressed by Draco are read triangles (mode 4) alone: export lists of triangles")
        );
    }
    let view = extension.need_index("bufferView", source.views.len(), "bufferViews")?;
    let index_form = Form::of(&source.accessors[indices])?;
    let expected = expected(at, &wanted, &index_form, source, context)?;
    let View { buffer, offset, length, .. } = source.views[view];
    // A stream may be decoded for many primitives.
    context.budget.take_bytes(length as u64, &extension.pointer)?;
    let stream = Stream::decode(&source.buffers[buffer][offset..offset + length], expected)
        .map_err(|detail| extension.error(detail))?;
    for &Wanted { accessor, id, .. } in &wanted {
        let form = Form::of(&source.accessors[accessor])?;
        if unpacked.is_new(accessor, (view, Some(id)), form.at)? {
            let array = vertices(&stream, id, &form).map_err(|detail| extension.error(detail))?;
            unpacked.arrays.insert(accessor, array);
        }
    }
    unpacked.normalize_weights(&wanted, source)?;
    if unpacked.is_new(indices, (view, None), index_form.at)? {
        unpacked.arrays.insert(indices, triangles(&stream, &index_form)?);
    }
    unpacked.views.push(view);
    Ok(true)
}

/// The attributes that the stream has.
fn wanted(at: &At, extension: &At, accessor_count: usize) -> Result<Vec<Wanted>> {
    let attributes = at.object("attributes")?.ok_or_else(|| at.error("`attributes` is missing"))?;
    let listed = extension.object("attributes")?.ok_or_else(|| extension.error("`attributes` is missing"))?;
    let mut wanted = Vec::new();
    for (semantic, id) in listed.members() {
        let Some(accessor) = attributes.index(semantic, accessor_count, "accessors")? else {
            return Err(id.error("the primitive has no attribute of this name"));
        };
        let id =
            u32::try_from(id.whole()?).map_err(|_| id.error("is too large for the id of an attribute"))?;
        wanted.push(Wanted { accessor, id, is_weights: semantic.starts_with("WEIGHTS_") });
    }
    Ok(wanted)
}

/// What the stream has to hold, within the limits: nothing of it was decoded yet.
fn expected(
    at: &At,
    wanted: &[Wanted],
    index_form: &Form,
    source: &Source,
    context: &mut Context,
) -> Result<Expected> {
    let mut point_count = None;
    for Wanted { accessor, .. } in wanted {
        let form = Form::of(&source.accessors[*accessor])?;
        if *point_count.get_or_insert(form.count) != form.count {
            return Err(form.at.error("the attributes of a compressed primitive have unequal counts"));
        }
        let bytes = (form.count as u64).saturating_mul(form.stride() as u64);
        context.budget.take_bytes(bytes, &form.at.pointer)?;
    }
    let Some(point_count) = point_count else {
        return Err(at.error("no attribute is compressed"));
    };
    let index_count = index_form.count;
    context.budget.take_bytes((index_count as u64).saturating_mul(4), &index_form.at.pointer)?;
    // What the whole model has is counted where primitives are read.
    let mut alone = Budget::new(context.budget.limits);
    alone.take_vertices(point_count as u64, &at.pointer)?;
    alone.take_triangles(index_count as u64 / 3, &at.pointer)?;
    Ok(Expected { point_count, index_count, bytes_max: context.budget.limits.archive_bytes })
}

impl Unpacked {
    /// Of float weights alone: those of integers are the encoder's own.
    fn normalize_weights(&mut self, wanted: &[Wanted], source: &Source) -> Result<()> {
        let mut sets = Vec::new();
        for (accessor, array) in &mut self.arrays {
            if wanted.iter().any(|own| own.is_weights && own.accessor == *accessor) {
                let form = Form::of(&source.accessors[*accessor])?;
                if form.component == DataType::F32 && form.width == 4 {
                    sets.push(&mut array.bytes);
                }
            }
        }
        weights::normalize(&mut sets);
        Ok(())
    }

    /// Whether the accessor still lacks elements; an error where two streams would give it some.
    fn is_new(&mut self, accessor: usize, origin: (usize, Option<u32>), at: &At) -> Result<bool> {
        match self.origins.insert(accessor, origin) {
            None => Ok(true),
            Some(earlier) if earlier == origin => Ok(false),
            Some(_) => Err(at.error("two compressed primitives have different elements for this accessor")),
        }
    }
}

/// Puts the plain arrays into the document, the first in the place of the stream's view, and takes the extension off.
pub(super) fn replace(json: &mut Value, buffers: &mut Vec<Vec<u8>>, mut unpacked: Unpacked) {
    if unpacked.primitives.is_empty() {
        return;
    }
    unpacked.views.sort_unstable();
    unpacked.views.dedup();
    let mut free_views = unpacked.views.into_iter();
    for (accessor, array) in unpacked.arrays {
        let mut view =
            json!({ "buffer": buffers.len(), "byteLength": array.bytes.len(), "target": array.target });
        if let Some(stride) = array.stride {
            view["byteStride"] = stride.into();
        }
        push(json, "buffers", json!({ "byteLength": array.bytes.len() }));
        let slot = match free_views.next() {
            Some(slot) => {
                json["bufferViews"][slot] = view;
                slot
            }
            None => push(json, "bufferViews", view),
        };
        if let Some(Value::Object(accessor)) = json["accessors"].get_mut(accessor) {
            accessor.insert("bufferView".to_owned(), slot.into());
            accessor.remove("byteOffset");
            set_bounds(accessor, array.bounds());
        }
        buffers.push(array.bytes);
    }
    for (mesh, primitive) in unpacked.primitives {
        let primitive = &mut json["meshes"][mesh]["primitives"][primitive];
        if let Some(Value::Object(extensions)) = primitive.get_mut("extensions") {
            extensions.remove(EXTENSION);
            if extensions.is_empty()
                && let Value::Object(primitive) = primitive
            {
                primitive.remove("extensions");
            }
        }
    }
}

/// Those of the file are of the numbers before they were quantized.
fn set_bounds(accessor: &mut Map<String, Value>, bounds: Option<[Vec<f32>; 2]>) {
    let Some(bounds) = bounds else { return };
    for (name, bound) in ["min", "max"].into_iter().zip(bounds) {
        if accessor.contains_key(name) {
            accessor.insert(name.to_owned(), bound.into());
        }
    }
}

/// The item's place.
fn push(json: &mut Value, list: &str, item: Value) -> usize {
    if !json[list].is_array() {
        json[list] = json!([]);
    }
    let Value::Array(items) = &mut json[list] else { return 0 };
    items.push(item);
    items.len() - 1
}
