//! Pictures of Basis Universal. The files are from the reference encoder (version 2.50, by ktx2-encoder 0.6.0) with its
//! defaults, and the sums from what the reference transcoder made of them.

use super::*;
use crate::asset::Slot;
use crate::image::Pixels;

const EXTENSION: &str = "KHR_texture_basisu";

/// 32x16, RGB, with all levels.
const ETC1S: &[u8] = include_bytes!("basis/etc1s.ktx2");
/// 33x17, RGBA.
const ETC1S_ALPHA: &[u8] = include_bytes!("basis/etc1s_alpha.ktx2");
/// 20x12, RGBA.
const UASTC_ALPHA: &[u8] = include_bytes!("basis/uastc_alpha.ktx2");
/// 32x16, RGB, with all levels, packed by Zstandard.
const UASTC_ZSTD: &[u8] = include_bytes!("basis/uastc_zstd.ktx2");
/// 33x65, RGBA, bent by a fuzzer: a run length beyond 32 bits.
const LONG_RUN: &[u8] = include_bytes!("basis/etc1s_long_run.ktx2");
const ALL: [&[u8]; 4] = [ETC1S, ETC1S_ALPHA, UASTC_ALPHA, UASTC_ZSTD];

/// A model whose base color is image 0 by the extension alone.
fn model(bytes: &[u8]) -> Gltf {
    let mut gltf = Gltf::textured(bytes);
    gltf.json["textures"][0] = json!({ "extensions": { EXTENSION: { "source": 0 } } });
    gltf.json["images"][0]["mimeType"] = json!("image/ktx2");
    gltf.json["extensionsUsed"] = json!([EXTENSION]);
    gltf.json["extensionsRequired"] = json!([EXTENSION]);
    gltf
}

/// Files for the mutations.
pub(super) fn seeds() -> [Vec<u8>; 2] {
    [model(ETC1S_ALPHA).glb(), model(UASTC_ZSTD).glb()]
}

fn refused(bytes: &[u8], words: &str) {
    let error = model(bytes).refused(ErrorCode::InvalidModel, "/images/0");
    assert!(error.detail.contains(words), "{error}");
}

/// FNV-1a.
fn sum(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xCBF2_9CE4_8422_2325, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3))
}

/// What was painted at a texel.
fn painted(x: usize, y: usize, [width, height]: [usize; 2]) -> [u8; 4] {
    let blue = if ((x >> 3) ^ (y >> 3)) & 1 == 1 { 200 } else { 30 };
    [(x * 255 / (width - 1)) as u8, (y * 255 / (height - 1)) as u8, blue, (x * 3 + y * 5) as u8]
}

#[test]
fn level_0_is_what_the_reference_transcoder_makes_of_it() {
    // File, size, components, the codes that it is off at most, and its sum.
    type Case = (&'static [u8], [u32; 2], usize, u8, u64);
    let cases: [Case; 4] = [
        (ETC1S, [32, 16], 3, 34, 0x0518_3C35_9AE7_6FA9),
        (ETC1S_ALPHA, [33, 17], 4, 32, 0x5A58_E878_AF63_E58B),
        (UASTC_ALPHA, [20, 12], 4, 7, 0xD170_EDED_F56E_CF4D),
        (UASTC_ZSTD, [32, 16], 3, 1, 0xC17D_7D76_98D8_F3BD),
    ];
    for (file, size, components, worst, expected) in cases {
        let asset = model(file).read().unwrap();
        let image = &asset.images[0];
        assert_eq!((image.size(), usize::from(image.components)), (size, components));
        assert_eq!(
            (asset.document.encoded_images[0].media_type.as_str(), asset.warnings.len()),
            ("image/ktx2", 0)
        );
        let Pixels::U8(pixels) = &image.pixels else { panic!("8 bits") };
        assert_eq!(sum(pixels), expected, "{size:?} {components}");
        let size = size.map(|side| side as usize);
        for (texel, codes) in pixels.chunks(components).enumerate() {
            let painted = painted(texel % size[0], texel / size[0], size);
            let off = codes.iter().zip(painted).map(|(code, painted)| code.abs_diff(painted)).max();
            assert!(off.unwrap() <= worst, "texel {texel}: {codes:?} for {painted:?}");
        }
    }
}

#[test]
fn a_texture_reads_the_image_of_its_extension() {
    let mut gltf = model(ETC1S);
    let view = gltf.view(&png(2, 2));
    gltf.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    gltf.json["textures"][0]["source"] = json!(1);
    let asset = gltf.read().unwrap();
    assert_eq!(asset.materials[0].slot(Slot::BaseColor).unwrap().image, 0);
    gltf.json["textures"][0]["extensions"][EXTENSION]["source"] = json!(2);
    gltf.refused(ErrorCode::InvalidModel, &format!("/textures/0/extensions/{EXTENSION}/source"));
    gltf.json["textures"][0]["extensions"][EXTENSION] = json!({});
    gltf.refused(ErrorCode::InvalidModel, &format!("/textures/0/extensions/{EXTENSION}"));
}

#[test]
fn every_truncation_is_refused() {
    for file in ALL {
        for length in 12..file.len() {
            refused(&file[..length], "truncated");
        }
    }
}

#[test]
fn a_run_beyond_32_bits_ends_in_a_picture_or_an_error() {
    match model(LONG_RUN).read() {
        Ok(asset) => assert_eq!(asset.images[0].size(), [33, 65]),
        Err(error) => assert_eq!(error.code, ErrorCode::InvalidModel, "{error}"),
    }
}

fn changed(file: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    file[at..at + bytes.len()].copy_from_slice(bytes);
    file
}

#[test]
fn lies_of_the_container_are_refused() {
    const FAR: [u8; 8] = [0xFF; 8];
    let word = |word: u32| word.to_le_bytes();
    // Places in the header and in the index of levels.
    for (file, at, bytes, words) in [
        (ETC1S, 12, &word(37)[..], "vkFormat 37"),
        (ETC1S, 24, &word(0), "side of 0"),
        (ETC1S, 20, &word(1 << 16), "at most"),
        (ETC1S, 28, &word(1), "no single 2D picture"),
        (ETC1S, 32, &word(2), "no single 2D picture"),
        (ETC1S, 36, &word(6), "no single 2D picture"),
        (ETC1S, 40, &word(0), "levels"),
        (ETC1S, 40, &word(17), "levels"),
        (ETC1S, 40, &word(16), "truncated"),
        (ETC1S, 44, &word(2), "supercompression 2"),
        (UASTC_ALPHA, 44, &word(1), "supercompression 1"),
        (UASTC_ALPHA, 44, &word(3), "supercompression 3"),
        (ETC1S, 48, &word(u32::MAX), "truncated"),
        (ETC1S, 52, &word(28), "descriptor"),
        (ETC1S, 56, &word(u32::MAX), "truncated"),
        (ETC1S, 64, &FAR, "truncated"),
        (ETC1S, 72, &FAR, "truncated"),
        (ETC1S, 72, &word(150), "truncated"),
        (ETC1S, 80, &FAR, "truncated"),
        (ETC1S, 88, &FAR, "truncated"),
        (UASTC_ALPHA, 20, &word(24), "are 288"),
        (UASTC_ALPHA, 88, &word(239), "has 239 bytes"),
        (UASTC_ZSTD, 96, &FAR, "bytes; 32x16 in UASTC are 512"),
    ] {
        refused(&changed(file, at, bytes), words);
    }
    // Places in what the header points at.
    let at =
        |file: &[u8], field: usize| u32::from_le_bytes(file[field..field + 4].try_into().unwrap()) as usize;
    let (descriptor, pairs, global) = (at(ETC1S, 48), at(ETC1S, 56), at(ETC1S, 64));
    for (at, bytes, words) in [
        (descriptor + 12, &[162][..], "color model 162"),
        (descriptor + 31, &[4], "channels"),
        (pairs, &word(u32::MAX), "truncated"),
        (pairs, b"\x11\0\0\0KTXorientation\0ru\0", "\"ru\""),
        (pairs, b"\x10\0\0\0KTXswizzle\0grba\0", "\"grba\""),
        (global + 4, &word(u32::MAX), "truncated"),
        (global + 20, &word(2), "film"),
        (global + 24, &word(u32::MAX), "truncated"),
        (global + 28, &word(12), "truncated"),
    ] {
        refused(&changed(ETC1S, at, bytes), words);
    }
    let premultiplied = at(UASTC_ALPHA, 48) + 15;
    refused(&changed(UASTC_ALPHA, premultiplied, &[1]), "multiplied by alpha");
    let second_channel = at(ETC1S_ALPHA, 48) + 31 + 16;
    refused(&changed(ETC1S_ALPHA, second_channel, &[4]), "channels");
    let frame = at(UASTC_ZSTD, 80);
    refused(&changed(UASTC_ZSTD, frame, &[0; 4]), "Zstandard");
}

#[test]
fn sizes_are_limited_before_decoding() {
    let huge = changed(ETC1S, 20, &16384u32.to_le_bytes());
    let limits = Limits { image_side: 8192, ..Limits::default() };
    let error = read_limited(model(&huge).glb(), limits).unwrap_err();
    assert_eq!((error.code, error.limit, error.actual), (ErrorCode::ImageTooLarge, Some(8192), Some(16384)));
}

/// Bytes of every file changed one after the other: none is read beyond the limits, and none ends in a panic.
#[test]
fn a_changed_byte_ends_in_a_picture_or_an_error() {
    let limits = Limits { job_pixels: 1 << 16, ..Limits::default() };
    let mut read_count = 0;
    for file in ALL {
        for at in 12..file.len() {
            for byte in [0, 1, 0x7F, 0xFF, file[at] ^ 1, file[at] ^ 0x80] {
                match read_limited(model(&changed(file, at, &[byte])).glb(), limits.clone()) {
                    Ok(asset) => {
                        read_count += 1;
                        let image = &asset.images[0];
                        let [width, height] = image.size().map(|side| side as usize);
                        let Pixels::U8(pixels) = &image.pixels else { panic!("8 bits") };
                        assert_eq!(pixels.len(), width * height * usize::from(image.components));
                    }
                    Err(error) => {
                        assert!(matches!(error.code, ErrorCode::InvalidModel | ErrorCode::ImageTooLarge));
                        assert_eq!(error.pointer.as_deref(), Some("/images/0"), "{at} {byte}: {error}");
                    }
                }
            }
        }
    }
    assert!(read_count > 0);
}
