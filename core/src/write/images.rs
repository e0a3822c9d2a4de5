//! Level images as PNG, and the source's image files that stay.

use png::{BitDepth, ColorType, Compression, Filter};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::asset::Asset;
use crate::error::{Error, Result};
use crate::finished::Finished;
use crate::image::{Image, Pixels};
use crate::watch::{Watch, check};

use super::draft::Draft;

/// One PNG for each texture and level.
pub fn encode_levels(finished: &Finished, watch: &dyn Watch) -> Result<Vec<Vec<Vec<u8>>>> {
    finished
        .textures
        .par_iter()
        .map(|texture| {
            let encode = |level: &Image| {
                check(watch)?;
                png(level)
            };
            texture.levels.par_iter().map(encode).collect()
        })
        .collect()
}

/// One image as PNG: its components and depth as they are, compressed fast.
///
/// # Errors
/// `Internal` where the image breaks its own guarantees.
pub fn png(image: &Image) -> Result<Vec<u8>> {
    let failed =
        |error: png::EncodingError| Error::internal(format!("an image could not be encoded: {error}"));
    let color = match image.components {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        4 => ColorType::Rgba,
        other => return Err(Error::internal(format!("an image has {other} components"))),
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width, image.height);
    encoder.set_color(color);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    match &image.pixels {
        Pixels::U8(codes) => {
            encoder.set_depth(BitDepth::Eight);
            let mut writer = encoder.write_header().map_err(failed)?;
            writer.write_image_data(codes).map_err(failed)?;
            writer.finish().map_err(failed)?;
        }
        Pixels::U16(codes) => {
            encoder.set_depth(BitDepth::Sixteen);
            let codes: Vec<u8> = codes.iter().flat_map(|code| code.to_be_bytes()).collect();
            let mut writer = encoder.write_header().map_err(failed)?;
            writer.write_image_data(&codes).map_err(failed)?;
            writer.finish().map_err(failed)?;
        }
        Pixels::F32(_) => return Err(Error::internal("a source's values are no level image")),
    }
    Ok(bytes)
}

/// Appends a PNG to the draft's images.
pub fn add(draft: &mut Draft<'_>, png: Vec<u8>, name: String) -> usize {
    let view = draft.add_view(png, None, None);
    draft.images.push(json!({ "name": name, "mimeType": "image/png", "bufferView": view }));
    draft.images.len() - 1
}

/// Moves image files into the GLB. An image that reading did not load keeps its URI: nothing that was
/// converted uses it.
pub fn embed_files<'a>(draft: &mut Draft<'a>, asset: &'a Asset) {
    for (number, file) in asset.document.encoded_images.iter().enumerate() {
        let image = draft.images.get_mut(number).and_then(Value::as_object_mut);
        let Some(image) = image.filter(|image| !file.bytes.is_empty() && !image.contains_key("bufferView"))
        else {
            continue;
        };
        image.remove("uri");
        image.insert("mimeType".to_owned(), file.media_type.clone().into());
        // The view's number is known before it is added: it becomes the last one.
        image.insert("bufferView".to_owned(), draft.views.len().into());
        draft.add_view(file.bytes.as_slice(), None, None);
    }
}
