//! Image files: kinds of pixels, sizes before decoding, truncation (B7 of the abuse list).

use std::io::Cursor;

use super::*;
use crate::image::{Image, Pixels};

fn first_image(bytes: &[u8]) -> Result<Image> {
    Gltf::textured(bytes).read().map(|mut asset| asset.images.remove(0))
}

fn encode(picture: image::DynamicImage, format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A PNG written chunk by chunk: color type, bits, palette, transparency.
fn raw_png(color: png::ColorType, depth: png::BitDepth, palette: &[u8], trns: &[u8], data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if !palette.is_empty() {
        encoder.set_palette(palette.to_vec());
    }
    if !trns.is_empty() {
        encoder.set_trns(trns.to_vec());
    }
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(data).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn every_kind_of_png() {
    use png::BitDepth::{Eight, One, Sixteen};
    use png::ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb, Rgba};
    let wide = |codes: &[u16]| Pixels::U16(codes.to_vec());
    let narrow = |codes: &[u8]| Pixels::U8(codes.to_vec());
    let palette = [1, 2, 3, 4, 5, 6];
    let cases = [
        (raw_png(Grayscale, Eight, &[], &[], &[7, 9]), 1, narrow(&[7, 9])),
        (raw_png(Grayscale, One, &[], &[], &[0x40]), 1, narrow(&[0, 255])),
        (raw_png(Grayscale, Eight, &[], &[0, 9], &[7, 9]), 2, narrow(&[7, 255, 9, 0])),
        (raw_png(GrayscaleAlpha, Eight, &[], &[], &[7, 1, 9, 2]), 2, narrow(&[7, 1, 9, 2])),
        (raw_png(Rgb, Eight, &[], &[], &[1, 2, 3, 4, 5, 6]), 3, narrow(&[1, 2, 3, 4, 5, 6])),
        (raw_png(Rgba, Eight, &[], &[], &[1, 2, 3, 4, 5, 6, 7, 8]), 4, narrow(&[1, 2, 3, 4, 5, 6, 7, 8])),
        (raw_png(Indexed, Eight, &palette, &[], &[1, 0]), 3, narrow(&[4, 5, 6, 1, 2, 3])),
        (raw_png(Indexed, Eight, &palette, &[8], &[1, 0]), 4, narrow(&[4, 5, 6, 255, 1, 2, 3, 8])),
        (raw_png(Grayscale, Sixteen, &[], &[], &[1, 2, 3, 4]), 1, wide(&[0x102, 0x304])),
        (
            raw_png(Rgb, Sixteen, &[], &[], &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]),
            3,
            wide(&[0x102, 0x304, 0x506, 0x708, 0x90a, 0xb0c]),
        ),
    ];
    for (number, (bytes, components, pixels)) in cases.into_iter().enumerate() {
        let image = first_image(&bytes).unwrap();
        assert_eq!((image.components, image.pixels), (components, pixels), "case {number}");
    }
}

#[test]
fn jpeg_in_color_and_gray() {
    let color = image::RgbImage::from_pixel(20, 10, image::Rgb([200, 100, 50]));
    let image = first_image(&encode(color.into(), image::ImageFormat::Jpeg)).unwrap();
    assert_eq!((image.size(), image.components), ([20, 10], 3));
    let at = image.normalized(7, 7).map(|code| code * 255.0);
    assert!(
        (at[0] - 200.0).abs() < 4.0 && (at[1] - 100.0).abs() < 4.0 && (at[2] - 50.0).abs() < 4.0,
        "{at:?}"
    );
    let gray = image::GrayImage::from_pixel(9, 9, image::Luma([77]));
    let image = first_image(&encode(gray.into(), image::ImageFormat::Jpeg)).unwrap();
    assert_eq!((image.size(), image.components), ([9, 9], 1));
}

#[test]
fn truncated_files_are_refused_at_every_length() {
    let picture =
        image::RgbImage::from_fn(33, 21, |x, y| image::Rgb([x as u8 * 7, y as u8 * 11, (x * y) as u8]));
    for format in [image::ImageFormat::Png, image::ImageFormat::Jpeg] {
        let bytes = encode(picture.clone().into(), format);
        assert!(first_image(&bytes).is_ok());
        // The last 12 bytes of a PNG are its end mark, after which nothing is missing.
        let end = if format == image::ImageFormat::Png { bytes.len() - 12 } else { bytes.len() - 1 };
        for length in (12..end).step_by(7).chain([end]) {
            let error = Gltf::textured(&bytes[..length]).read().expect_err("truncated");
            assert_eq!(error.pointer.as_deref(), Some("/images/0"), "{format:?} {length}: {error}");
        }
    }
}

fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = png(1, 1);
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    bytes
}

/// The first JPEG frame header, with a size of our own.
fn jpeg_header(width: u16, height: u16, components: u8) -> Vec<u8> {
    let picture = image::RgbImage::new(8, 8);
    let mut bytes = encode(picture.into(), image::ImageFormat::Jpeg);
    let frame = bytes.windows(2).position(|pair| pair == [0xFF, 0xC0]).unwrap();
    bytes[frame + 5..frame + 7].copy_from_slice(&height.to_be_bytes());
    bytes[frame + 7..frame + 9].copy_from_slice(&width.to_be_bytes());
    bytes[frame + 9] = components;
    bytes
}

#[test]
fn large_images_are_refused_by_their_header() {
    let cases = [
        (png_header(16_384, 16_384), Some(67_108_864), Some(16_384 * 16_384)),
        (png_header(16_385, 1), Some(16_384), Some(16_385)),
        (png_header(u32::MAX, u32::MAX), Some(16_384), Some(u32::MAX.into())),
        (png_header(10_000, 10_000), Some(67_108_864), Some(100_000_000)),
        (jpeg_header(65_535, 65_535, 3), Some(16_384), Some(65_535)),
    ];
    for (bytes, limit, actual) in cases {
        let error = Gltf::textured(&bytes).refused(ErrorCode::ImageTooLarge, "/images/0");
        assert_eq!((error.limit, error.actual), (limit, actual));
    }
    for bytes in [png_header(0, 1), jpeg_header(0, 8, 3), jpeg_header(8, 8, 4)] {
        Gltf::textured(&bytes).refused(ErrorCode::InvalidModel, "/images/0");
    }
    Gltf::textured(b"GIF89a").refused(ErrorCode::UnsupportedMediaType, "/images/0");
}

#[test]
fn jpegs_of_endless_scans_are_refused() {
    let picture = image::GrayImage::new(8, 8);
    let mut bytes = encode(picture.into(), image::ImageFormat::Jpeg);
    let scan = bytes.windows(2).position(|pair| pair == [0xFF, 0xDA]).unwrap();
    let scan = bytes[scan..bytes.len() - 2].to_vec();
    let end = bytes.split_off(bytes.len() - 2);
    for _ in 0..100 {
        bytes.extend_from_slice(&scan);
    }
    bytes.extend(end);
    let error = Gltf::textured(&bytes).refused(ErrorCode::InvalidModel, "/images/0");
    assert!(error.detail.contains("scans"), "{error}");
}

/// A color profile and a text of 64 MB of zeros each, which take 64 KB of the file.
#[test]
fn profiles_and_texts_are_not_unpacked_without_bound() {
    let zeros = vec![0; 64 << 20];
    let mut info = png::Info::with_size(1, 1);
    info.icc_profile = Some(zeros.clone().into());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::with_info(&mut bytes, info).unwrap();
    encoder.add_ztxt_chunk("Comment".to_owned(), String::from_utf8(zeros).unwrap()).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[5]).unwrap();
    writer.finish().unwrap();
    assert!(bytes.len() < 1 << 20);
    match first_image(&bytes) {
        Ok(image) => assert_eq!(image.pixels, Pixels::U8(vec![5])),
        Err(error) => assert_eq!(error.pointer.as_deref(), Some("/images/0")),
    }
}

#[test]
fn pixels_are_counted_over_all_decoded_images() {
    let mut gltf = Gltf::textured(&png(10, 10));
    let view = gltf.view(&png(10, 11));
    gltf.push("images", json!({ "bufferView": view }));
    gltf.push("textures", json!({ "source": 1 }));
    gltf.json["materials"][0]["emissiveTexture"] = json!({ "index": 1 });
    let limited = |pixels| read_limited(gltf.glb(), Limits { job_pixels: pixels, ..Limits::default() });
    assert!(limited(210).is_ok());
    let error = limited(209).unwrap_err();
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::ImageTooLarge, Some("/images/1")));
}

#[test]
fn equal_files_are_decoded_once_and_unused_ones_not_at_all() {
    let mut gltf = Gltf::textured(&png(10, 10));
    for _ in 0..7 {
        let view = gltf.view(&png(10, 10));
        let image = gltf.push("images", json!({ "bufferView": view }));
        let texture = gltf.push("textures", json!({ "source": image }));
        gltf.json["materials"][0]["normalTexture"] = json!({ "index": texture });
    }
    let view = gltf.view(b"not an image at all");
    gltf.push("images", json!({ "bufferView": view, "mimeType": "image/webp" }));
    let limits = Limits { job_pixels: 100, ..Limits::default() };
    let asset = read_limited(gltf.glb(), limits).unwrap();
    let sizes: Vec<[u32; 2]> = asset.images.iter().map(Image::size).collect();
    assert_eq!(sizes, [[10, 10], [1, 1], [1, 1], [1, 1], [1, 1], [1, 1], [1, 1], [1, 1], [1, 1]]);
    assert!(asset.materials[0].slots.values().all(|slot| slot.image == 0));
    assert_eq!(asset.document.encoded_images[7].bytes, png(10, 10));
    assert_eq!(asset.document.encoded_images[8].media_type, "image/webp");
}

#[test]
fn levels_of_converted_textures_are_decoded() {
    let mut gltf = Gltf::textured(&png(8, 8));
    for size in [4, 2] {
        let view = gltf.view(&png(size, size));
        gltf.push("images", json!({ "bufferView": view }));
    }
    gltf.json["textures"][0]["extensions"] = json!({ "MCT_mesh_color_texture": { "levels": [0, 1, 2] } });
    let asset = gltf.read().unwrap();
    assert_eq!(asset.images.iter().map(Image::size).collect::<Vec<_>>(), [[8, 8], [4, 4], [2, 2]]);
    // Equal levels of two textures are each at their place.
    let view = gltf.view(&png(4, 4));
    let image = gltf.push("images", json!({ "bufferView": view }));
    gltf.json["textures"][0]["extensions"]["MCT_mesh_color_texture"]["levels"] = json!([0, 1, 2, image]);
    assert_eq!(gltf.read().unwrap().images[image].size(), [4, 4]);
    let limits = Limits { job_pixels: 64 + 16 + 4 + 15, ..Limits::default() };
    assert_eq!(read_limited(gltf.glb(), limits).unwrap_err().code, ErrorCode::ImageTooLarge);
    gltf.json["images"].as_array_mut().unwrap().pop();
    gltf.refused(ErrorCode::InvalidModel, "/textures/0/extensions/MCT_mesh_color_texture/levels/3");
}
