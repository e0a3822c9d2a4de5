//! Buffers and image files: bytes for every entry of the document that names some.

use super::super::Context;
use super::super::images::media_type_of;
use super::super::json::At;
use super::accessors::Store;
use super::meshopt;
use crate::asset::EncodedImage;
use crate::error::Result;
use crate::watch;

/// The bytes of each buffer, exactly `byteLength` of them; none of a fallback without a file.
pub(super) fn load(root: &At, bin: Option<&[u8]>, context: &mut Context) -> Result<Vec<Vec<u8>>> {
    let mut buffers = Vec::new();
    for (index, at) in root.objects("buffers")?.iter().enumerate() {
        watch::check(context.watch)?;
        let length = at.need_size("byteLength")?;
        let mut bytes = match (at.string("uri")?, bin) {
            (Some(uri), _) => {
                let pointer = format!("{}/uri", at.pointer);
                context.resources.load_uri(uri, &pointer, &mut context.budget)?.bytes
            }
            (None, Some(bin)) if index == 0 => {
                context.budget.take_bytes(bin.len() as u64, &at.pointer)?;
                bin.to_vec()
            }
            // What its views hold is unpacked from other buffers.
            (None, _) if meshopt::is_fallback(at)? => {
                buffers.push(Vec::new());
                continue;
            }
            _ => return Err(at.error("the buffer has no uri, and there is no binary chunk for it")),
        };
        if bytes.len() < length {
            return Err(at.error(format!("byteLength is {length}, but there are {} bytes", bytes.len())));
        }
        bytes.truncate(length);
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// The encoded bytes of each image.
pub(super) fn load_images(root: &At, store: &Store, context: &mut Context) -> Result<Vec<EncodedImage>> {
    let mut images = Vec::new();
    for at in &root.objects("images")? {
        watch::check(context.watch)?;
        images.push(load_image(at, store, context)?);
    }
    Ok(images)
}

fn load_image(at: &At, store: &Store, context: &mut Context) -> Result<EncodedImage> {
    let named = at.string("mimeType")?.map(str::to_owned);
    let (bytes, of_uri) = match (at.string("uri")?, at.index("bufferView", store.views.len(), "bufferViews")?)
    {
        (Some(uri), None) => {
            let pointer = format!("{}/uri", at.pointer);
            let loaded = context.resources.load_uri(uri, &pointer, &mut context.budget)?;
            (loaded.bytes, loaded.media_type)
        }
        (None, Some(view)) => {
            let bytes = store.view_bytes(store.views[view]);
            context.budget.take_bytes(bytes.len() as u64, &at.pointer)?;
            (bytes.to_vec(), None)
        }
        _ => return Err(at.error("an image has either a `uri` or a `bufferView`")),
    };
    // The first bytes are right where the words are wrong.
    let media_type = media_type_of(&bytes)
        .map(str::to_owned)
        .or(named)
        .or(of_uri)
        .unwrap_or_else(|| "application/octet-stream".to_owned());
    Ok(EncodedImage { media_type, bytes })
}
