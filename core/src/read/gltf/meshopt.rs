//! `EXT_meshopt_compression`: buffer views that are packed become plain ones, each in a buffer of its own, before
//! anything else looks at them. No trace of the extension is left in the document but in its lists.

use serde_json::{Map, Value};

use super::super::Context;
use super::super::json::At;
use super::super::text::quoted;
use crate::error::Result;
use crate::vertex_codec::{Checked, EXTENSION, Filter, Form, Mode};
use crate::watch;

/// A view by its number, and its bytes.
pub(super) type Unpacked = Vec<(usize, Vec<u8>)>;

/// Whether a buffer only tells where views would lie if they were not packed.
pub(super) fn is_fallback(buffer: &At) -> Result<bool> {
    let extension = of(buffer)?;
    extension.map_or(Ok(false), |extension| extension.flag("fallback"))
}

fn of<'a>(at: &At<'a>) -> Result<Option<At<'a>>> {
    match at.object("extensions")? {
        Some(extensions) => extensions.object(EXTENSION),
        None => Ok(None),
    }
}

/// Unpacks every view that has the extension. `buffers` are empty for fallbacks without a file, and any other view
/// of one of those is refused.
pub(super) fn unpack(root: &At, buffers: &[Vec<u8>], context: &mut Context) -> Result<Unpacked> {
    let mut is_absent = Vec::new();
    for (at, bytes) in root.objects("buffers")?.iter().zip(buffers) {
        is_absent.push(bytes.is_empty() && is_fallback(at)?);
    }
    let mut unpacked = Vec::new();
    for (number, view) in root.objects("bufferViews")?.iter().enumerate() {
        if let Some(extension) = of(view)? {
            watch::check(context.watch)?;
            unpacked.push((number, unpack_view(view, &extension, buffers, context)?));
        } else if is_absent[view.need_index("buffer", buffers.len(), "buffers")?] {
            let detail = format!("the buffer is a fallback without bytes, and the view has no {EXTENSION}");
            return Err(view.error(detail));
        }
    }
    Ok(unpacked)
}

fn unpack_view(view: &At, at: &At, buffers: &[Vec<u8>], context: &mut Context) -> Result<Vec<u8>> {
    let packed = packed(at, buffers)?;
    let form = form(at)?;
    let checked = Checked::new(form, packed).map_err(|detail| at.error(detail))?;
    let length = view.need_size("byteLength")?;
    if length != checked.bytes() {
        return Err(view.error(format!(
            "byteLength is {length}, but the view is packed as {} elements of {} bytes",
            form.count, form.stride
        )));
    }
    if let Some(stride) = view.size("byteStride")?
        && stride != form.stride
    {
        return Err(
            view.error(format!("byteStride is {stride}, but the view is packed with {}", form.stride))
        );
    }
    context.budget.take_bytes(length as u64, &at.pointer)?;
    checked.unpack().map_err(|detail| at.error(detail))
}

fn packed<'b>(at: &At, buffers: &'b [Vec<u8>]) -> Result<&'b [u8]> {
    let buffer = at.need_index("buffer", buffers.len(), "buffers")?;
    let offset = at.size("byteOffset")?.unwrap_or(0);
    let length = at.need_size("byteLength")?;
    let available = buffers[buffer].len();
    let range = offset.checked_add(length).and_then(|end| buffers[buffer].get(offset..end));
    range.ok_or_else(|| {
        at.error(format!(
            "{length} bytes from byte {offset} reach past the end of buffer {buffer}, which has {available}"
        ))
    })
}

fn form(at: &At) -> Result<Form> {
    let mode = named(at, "mode", at.string("mode")?, &Mode::NAMED)?;
    let filter = named(at, "filter", Some(at.string("filter")?.unwrap_or("NONE")), &Filter::NAMED)?;
    Ok(Form { mode, filter, count: at.need_size("count")?, stride: at.need_size("byteStride")? })
}

fn named<T: Copy>(at: &At, member: &str, name: Option<&str>, all: &[(&str, T)]) -> Result<T> {
    let found = all.iter().find(|(own, _)| Some(*own) == name);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let found = name.map_or_else(|| "missing".to_owned(), quoted);
        let names: Vec<&str> = all.iter().map(|(own, _)| *own).collect();
        let allowed = names.join(", ");
        at.error(format!("`{member}` is {found}, not one of {allowed}"))
    })
}

/// Puts the unpacked views into the document.
pub(super) fn replace(json: &mut Value, buffers: &mut Vec<Vec<u8>>, unpacked: Unpacked) {
    for (number, bytes) in unpacked {
        if let Some(Value::Object(view)) = json["bufferViews"].get_mut(number) {
            view.insert("buffer".to_owned(), buffers.len().into());
            view.remove("byteOffset");
            forget(view);
        }
        if let Some(Value::Array(listed)) = json.get_mut("buffers") {
            listed.push(serde_json::json!({ "byteLength": bytes.len() }));
        }
        buffers.push(bytes);
    }
    if let Some(Value::Array(listed)) = json.get_mut("buffers") {
        listed.iter_mut().filter_map(Value::as_object_mut).for_each(forget);
    }
}

fn forget(object: &mut Map<String, Value>) {
    if let Some(Value::Object(extensions)) = object.get_mut("extensions") {
        extensions.remove(EXTENSION);
        if extensions.is_empty() {
            object.remove("extensions");
        }
    }
}
