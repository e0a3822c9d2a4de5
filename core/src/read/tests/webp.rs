//! WebP images of `EXT_texture_webp`.

use super::*;
use crate::asset::Slot;
use crate::image::{Image, Pixels};

const EXTENSION: &str = "EXT_texture_webp";
/// [`gradient`] by cwebp 1.2.4 at quality 90, without its alpha and with it.
const LOSSY: &[u8] = include_bytes!("webp/lossy.webp");
const LOSSY_ALPHA: &[u8] = include_bytes!("webp/lossy_alpha.webp");

fn picture() -> image::RgbImage {
    image::RgbImage::from_fn(13, 7, |x, y| image::Rgb([x as u8 * 19, y as u8 * 31, (x * y) as u8]))
}

/// Without loss.
fn webp() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture().write_to(&mut bytes, image::ImageFormat::WebP).unwrap();
    bytes.into_inner()
}

/// A model whose base color is image 0 by the extension alone.
fn model(bytes: &[u8]) -> Gltf {
    let mut gltf = Gltf::textured(bytes);
    gltf.json["textures"][0] = json!({ "extensions": { EXTENSION: { "source": 0 } } });
    gltf.json["images"][0]["mimeType"] = json!("image/webp");
    gltf.json["extensionsUsed"] = json!([EXTENSION]);
    gltf.json["extensionsRequired"] = json!([EXTENSION]);
    gltf
}

pub(super) fn seed() -> Vec<u8> {
    model(&webp()).glb()
}

fn refused(bytes: &[u8], words: &str) {
    let error = model(bytes).refused(ErrorCode::InvalidModel, "/images/0");
    assert!(error.detail.contains(words), "{error}");
}

/// Chunks in a file.
fn riff(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut body = b"WEBP".to_vec();
    for (name, data) in chunks {
        body.extend_from_slice(*name);
        body.extend((data.len() as u32).to_le_bytes());
        body.extend_from_slice(data);
        body.resize(body.len().next_multiple_of(2), 0);
    }
    [b"RIFF", &(body.len() as u32).to_le_bytes()[..], &body].concat()
}

/// The header of an extended file.
fn canvas(width: u32, height: u32) -> Vec<u8> {
    let side = |side: u32| (side - 1).to_le_bytes()[..3].to_vec();
    [vec![0; 4], side(width), side(height)].concat()
}

#[test]
fn a_texture_reads_the_image_of_its_extension() {
    let expected = Pixels::U8(picture().into_raw());
    let asset = model(&webp()).read().unwrap();
    assert_eq!(asset.images[0].pixels, expected);
    assert_eq!(asset.document.encoded_images[0].media_type, "image/webp");
    assert_eq!(asset.warnings, []);
    // Beside one for readers that do not know it.
    let mut gltf = model(&webp());
    let view = gltf.view(&png(2, 2));
    gltf.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    gltf.json["textures"][0]["source"] = json!(1);
    let asset = gltf.read().unwrap();
    assert_eq!(asset.materials[0].slot(Slot::BaseColor).unwrap().image, 0);
    assert_eq!(asset.images.iter().map(Image::size).collect::<Vec<_>>(), [[13, 7], [1, 1]]);
    gltf.json["textures"][0]["extensions"][EXTENSION]["source"] = json!(2);
    gltf.refused(ErrorCode::InvalidModel, &format!("/textures/0/extensions/{EXTENSION}/source"));
    gltf.json["textures"][0]["extensions"][EXTENSION] = json!({});
    gltf.refused(ErrorCode::InvalidModel, &format!("/textures/0/extensions/{EXTENSION}"));
}

/// Of 24 by 16 texels.
fn gradient(x: usize, y: usize) -> [u8; 4] {
    [40 + 8 * x, 200 - 8 * y, 60 + 2 * x + 4 * y, 17 * y].map(|code| code as u8)
}

/// Colors are stored by their brightness, with a hue for four of them; alpha has no loss.
#[test]
fn lossy_images_are_near_what_was_packed() {
    for (file, components) in [(LOSSY, 3), (LOSSY_ALPHA, 4)] {
        let asset = model(file).read().unwrap();
        let image = &asset.images[0];
        assert_eq!((image.size(), image.components), ([24, 16], components));
        let Pixels::U8(codes) = &image.pixels else { panic!("codes") };
        for (place, texel) in codes.chunks(usize::from(components)).enumerate() {
            let expected = gradient(place % 24, place / 24);
            for (component, code) in texel.iter().enumerate() {
                let most = if component == 3 { 0 } else { 12 };
                assert!(code.abs_diff(expected[component]) <= most, "{place}: {texel:?}, not {expected:?}");
            }
        }
    }
}

#[test]
fn files_that_make_no_sense_are_refused() {
    let whole = webp();
    for length in 12..whole.len() {
        let error = model(&whole[..length]).read().expect_err("truncated");
        assert_eq!(error.pointer.as_deref(), Some("/images/0"), "{length}: {error}");
    }
    let picture = &whole[20..];
    assert_eq!(&whole[12..16], b"VP8L");
    let sound = riff(&[(b"VP8X", &canvas(13, 7)), (b"VP8L", picture)]);
    assert_eq!(model(&sound).read().unwrap().images[0].size(), [13, 7]);
    // The picture is larger than its canvas says.
    refused(&riff(&[(b"VP8X", &canvas(2, 2)), (b"VP8L", picture)]), "differ in size");
    refused(&riff(&[(b"VP8X", &canvas(13, 7)), (b"ANIM", &[0; 6]), (b"VP8L", picture)]), "animated");
    refused(&riff(&[(b"VP8L", picture), (b"VP8L", picture)]), "more than one");
    refused(&riff(&[(b"VP8X", &canvas(13, 7))]), "no picture");
    refused(&riff(&[(b"VP8 ", &[0; 12])]), "no sound header");
    refused(&riff(&[(b"VP8L", &[0x30, 0, 0, 0, 0])]), "no sound header");
}

#[test]
fn sizes_are_limited_before_decoding() {
    let huge = riff(&[(b"VP8L", &[0x2F, 0xFF, 0xFF, 0xFF, 0x0F])]);
    let limits = Limits { image_side: 8192, ..Limits::default() };
    let error = read_limited(model(&huge).glb(), limits).unwrap_err();
    assert_eq!((error.code, error.limit, error.actual), (ErrorCode::ImageTooLarge, Some(8192), Some(16384)));
}
