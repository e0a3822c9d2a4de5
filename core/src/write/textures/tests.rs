mod blocks;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;

use ::ktx2::{ColorModel, Format, Reader, SupercompressionScheme, TransferFunction};
use glam::Vec4;
use half::f16;

use super::{Source, TextureFormat, files};
use crate::asset::{Asset, Material, Slot};
use crate::finished::{Finished, FinishedTexture};
use crate::image::{Image, LevelRange, Pixels, Transfer};
use crate::watch::Unwatched;
use crate::write::{BundleFile, encode};

const ALL: [TextureFormat; 3] = [TextureFormat::Png, TextureFormat::Ktx2, TextureFormat::Exr];
const SIZES: [(u32, u32); 3] = [(13, 7), (8, 5), (1, 3)];

fn codes(count: usize, seed: u32) -> impl Iterator<Item = u32> {
    (0..count as u32).map(move |at| (at ^ seed).wrapping_mul(0x9e37_79b9).rotate_left(at % 31) >> 8)
}

fn image((width, height): (u32, u32), components: u8, bits: u8, seed: u32) -> Image {
    let codes = codes((width * height * u32::from(components)) as usize, seed);
    let pixels = match bits {
        8 => Pixels::U8(codes.map(|code| code as u8).collect()),
        _ => Pixels::U16(codes.map(|code| code as u16).collect()),
    };
    Image { width, height, components, pixels }
}

/// One material with a channel for each slot in the list.
fn channels(list: &[(&[Slot], u8, u8)]) -> (Asset, Finished) {
    let material = |name: &str| Material { name: name.to_owned(), ..Material::default() };
    let asset =
        Asset { materials: vec![material("Wood / \"dark\" №3 "), material("木")], ..Asset::default() };
    let texture = |&(slots, components, bits): &(&[Slot], u8, u8)| FinishedTexture {
        materials: vec![0],
        part: 0,
        slots: slots.to_vec(),
        transfer: if slots[0].is_color() { Transfer::Srgb } else { Transfer::Linear },
        levels: SIZES.map(|size| image(size, components, bits, 7)).to_vec(),
        ranges: BTreeMap::new(),
        value_scale: None,
    };
    (asset, Finished { textures: list.iter().map(texture).collect(), ..Finished::default() })
}

fn written(asset: &Asset, finished: &Finished, formats: &[TextureFormat]) -> Vec<BundleFile> {
    let pngs = encode(finished, &Unwatched).unwrap();
    let formats: BTreeSet<_> = formats.iter().copied().collect();
    files(&Source { asset, finished, pngs: &pngs, compressed: None }, &formats, &Unwatched).unwrap()
}

#[test]
fn names_are_unique_and_safe_for_every_file_system() {
    let (asset, mut finished) =
        channels(&[(&[Slot::BaseColor], 3, 8), (&[Slot::MetallicRoughness, Slot::Occlusion], 3, 8)]);
    let mut other = finished.textures[0].clone();
    other.materials = vec![1];
    finished.textures.push(other);
    assert_eq!(written(&asset, &finished, &[]), []);
    let files = written(&asset, &finished, &[TextureFormat::Exr, TextureFormat::Png]);
    let paths: Vec<&str> = files.iter().map(|file| file.path.as_str()).collect();
    assert_eq!(
        paths[..8],
        [
            "textures/00_Wood_dark_3/baseColor/level_00.png",
            "textures/00_Wood_dark_3/baseColor/level_00.exr",
            "textures/00_Wood_dark_3/baseColor/level_01.png",
            "textures/00_Wood_dark_3/baseColor/level_01.exr",
            "textures/00_Wood_dark_3/baseColor/level_02.png",
            "textures/00_Wood_dark_3/baseColor/level_02.exr",
            "textures/00_Wood_dark_3/metallicRoughness-occlusion/level_00.png",
            "textures/00_Wood_dark_3/metallicRoughness-occlusion/level_00.exr",
        ]
    );
    assert_eq!(paths[12], "textures/01/baseColor/level_00.png");
    assert_eq!(paths.iter().collect::<BTreeSet<_>>().len(), 18);

    finished.textures[2].materials = vec![0];
    finished.textures[2].part = 1;
    let second = written(&asset, &finished, &[TextureFormat::Png]);
    assert_eq!(second[6].path, "textures/00_Wood_dark_3_part_2/baseColor/level_00.png");
    finished.textures[2].part = 0;
    let pngs = encode(&finished, &Unwatched).unwrap();
    let source = Source { asset: &asset, finished: &finished, pngs: &pngs, compressed: None };
    let twice = super::files(&source, &BTreeSet::from(ALL), &Unwatched).unwrap_err();
    assert!(twice.detail.contains("two channels"), "{twice}");
}

#[test]
fn pngs_are_those_of_the_model() {
    let (asset, finished) = channels(&[(&[Slot::BaseColor], 4, 8), (&[Slot::Normal], 3, 16)]);
    let pngs = encode(&finished, &Unwatched).unwrap();
    let files = written(&asset, &finished, &[TextureFormat::Png]);
    assert!(files.iter().map(|file| &file.bytes).eq(pngs.iter().flatten()));
    let decoded = ::image::load_from_memory(&files[0].bytes).unwrap().into_rgba8();
    assert_eq!(Pixels::U8(decoded.into_raw()), finished.textures[0].levels[0].pixels);
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let (asset, finished) = channels(&[(&[Slot::BaseColor], 3, 8), (&[Slot::Normal], 3, 16)]);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| written(&asset, &finished, &ALL))
    };
    assert!(on(1) == on(4));
}

/// A KTX2 file by the library's reader: format, texels, keys.
struct Read {
    format: Format,
    transfer: TransferFunction,
    has_primaries: bool,
    bytes: Vec<u8>,
    keys: BTreeMap<String, String>,
}

fn read_ktx2(file: &BundleFile, size: (u32, u32)) -> Read {
    let reader = Reader::new(file.bytes.as_slice()).unwrap();
    let header = reader.header();
    assert_eq!((header.pixel_width, header.pixel_height, header.pixel_depth), (size.0, size.1, 0));
    assert_eq!((header.level_count, header.layer_count, header.face_count), (1, 0, 1));
    assert_eq!(header.supercompression_scheme, Some(SupercompressionScheme::Zstandard));
    let basic = reader.basic_dfd().unwrap();
    assert_eq!(basic.color_model, Some(ColorModel::RGBSDA));
    assert!(!reader.is_alpha_premultiplied().unwrap());
    let level = reader.levels().next().unwrap();
    let bytes = zstd::stream::decode_all(level.data).unwrap();
    assert_eq!(bytes.len() as u64, level.uncompressed_byte_length);
    let texel_bytes = usize::from(basic.bytes_planes[0]);
    assert_eq!(bytes.len(), (size.0 * size.1) as usize * texel_bytes);
    let pairs: Vec<(&str, &[u8])> = reader.key_value_data().collect();
    assert!(pairs.is_sorted_by_key(|(key, _)| *key), "{pairs:?}");
    assert!(reader.writer().unwrap().starts_with("meshcolor "));
    let text = |value: &[u8]| String::from_utf8(value.strip_suffix(b"\0").unwrap().to_vec()).unwrap();
    Read {
        format: header.format.unwrap(),
        transfer: reader.transfer_function().unwrap(),
        has_primaries: reader.color_primaries().is_some(),
        bytes,
        keys: pairs.into_iter().map(|(key, value)| (key.to_owned(), text(value))).collect(),
    }
}

/// The bytes of the codes with the value behind each third where four are stored instead.
fn stored(image: &Image, opaque: u16) -> Vec<u8> {
    let with_alpha = |at: usize| image.components == 3 && at % 3 == 2;
    match &image.pixels {
        Pixels::U8(codes) => {
            let bytes = codes.iter().enumerate();
            bytes
                .flat_map(|(at, &code)| {
                    [code, opaque as u8].into_iter().take(1 + usize::from(with_alpha(at)))
                })
                .collect()
        }
        Pixels::F32(_) => panic!("made of codes"),
        Pixels::U16(codes) => {
            let words = codes.iter().enumerate();
            words
                .flat_map(|(at, &code)| [code, opaque].into_iter().take(1 + usize::from(with_alpha(at))))
                .flat_map(u16::to_le_bytes)
                .collect()
        }
    }
}

#[test]
fn ktx2_holds_the_codes() {
    let unorm8 = [Format::R8_UNORM, Format::R8G8_UNORM, Format::R8G8B8A8_UNORM, Format::R8G8B8A8_UNORM];
    let unorm16 =
        [Format::R16_UNORM, Format::R16G16_UNORM, Format::R16G16B16A16_UNORM, Format::R16G16B16A16_UNORM];
    for components in 1..=4 {
        for (bits, formats) in [(8, unorm8), (16, unorm16)] {
            let (asset, finished) = channels(&[(&[Slot::Occlusion], components, bits)]);
            let files = written(&asset, &finished, &[TextureFormat::Ktx2]);
            for (number, file) in files.iter().enumerate() {
                let read = read_ktx2(file, SIZES[number]);
                assert_eq!(read.format, formats[usize::from(components) - 1]);
                assert_eq!((read.transfer, read.has_primaries), (TransferFunction::Linear, false));
                assert_eq!(read.bytes, stored(&finished.textures[0].levels[number], u16::MAX));
                assert_eq!(read.keys["MCTlevel"], number.to_string());
                assert!(!read.keys.contains_key("MCTrange"));
                let swizzle = ["rrr1", "rrrg"].get(usize::from(components) - 1).copied();
                assert_eq!(read.keys.get("KTXswizzle").map(String::as_str), swizzle);
            }
        }
    }
}

#[test]
fn ktx2_has_colors_that_gpus_filter() {
    for components in 1..=4 {
        let (asset, finished) =
            channels(&[(&[Slot::BaseColor], components, 8), (&[Slot::Emissive], components, 16)]);
        let files = written(&asset, &finished, &[TextureFormat::Ktx2]);
        let image = &finished.textures[0].levels[0];
        let read = read_ktx2(&files[0], SIZES[0]);
        assert_eq!((read.format, read.transfer), (Format::R8G8B8A8_SRGB, TransferFunction::SRGB));
        assert!(read.has_primaries && !read.keys.contains_key("KTXswizzle"));
        for (texel, (x, y)) in read.bytes.chunks_exact(4).zip(places(SIZES[0])) {
            let codes = image.normalized(x, y).map(|value| (value * 255.0).round() as u8);
            assert_eq!(texel, codes);
        }
        let image = &finished.textures[1].levels[1];
        let read = read_ktx2(&files[4], SIZES[1]);
        assert_eq!((read.format, read.transfer), (Format::R16G16B16A16_SFLOAT, TransferFunction::Linear));
        for (texel, (x, y)) in read.bytes.chunks_exact(8).zip(places(SIZES[1])) {
            let halves = image.linear(x, y, Transfer::Srgb).map(f16::from_f32);
            assert_eq!(texel, halves.map(f16::to_le_bytes).concat());
        }
    }
}

fn places((width, height): (u32, u32)) -> impl Iterator<Item = (u32, u32)> {
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// A color channel whose second level is scaled and whose third holds half floats.
fn ranged(components: u8) -> (Asset, Finished) {
    let (asset, mut finished) = channels(&[(&[Slot::BaseColor], components, 8)]);
    let texture = &mut finished.textures[0];
    let alpha = if components == 4 { (0.25, -2.0) } else { (1.0, 0.0) };
    let scale = Vec4::new(1.5, 0.1, 7.0, alpha.0);
    let bias = Vec4::new(-0.3, 0.7, 1e-3, alpha.1);
    texture.ranges = BTreeMap::from([(1, LevelRange::Scaled16 { scale, bias }), (2, LevelRange::Float16)]);
    texture.levels[1] = image(SIZES[1], components, 16, 3);
    texture.levels[2] = image(SIZES[2], components, 16, 9);
    let Pixels::U16(codes) = &mut texture.levels[2].pixels else { panic!("16 bits") };
    // The bits of a number under 2.
    codes.iter_mut().for_each(|code| *code &= 0xbfff);
    (asset, finished)
}

#[test]
fn ktx2_tells_ranges() {
    for components in 1..=4 {
        let (asset, finished) = ranged(components);
        let texture = &finished.textures[0];
        let files = written(&asset, &finished, &[TextureFormat::Ktx2]);
        let [scaled, half] = [1, 2].map(|level| read_ktx2(&files[level], SIZES[level]));
        assert_eq!((scaled.transfer, half.transfer), (TransferFunction::Linear, TransferFunction::Linear));
        assert_eq!(scaled.bytes, stored(&texture.levels[1], u16::MAX));
        assert_eq!(half.bytes, stored(&texture.levels[2], f16::ONE.to_bits()));
        assert_eq!((&*scaled.keys["MCTrange"], &*half.keys["MCTrange"]), ("scaled16", "float16"));
        assert!(!half.keys.contains_key("MCTscale") && !half.keys.contains_key("MCTbias"));
        // A reader that knows the keys alone gets the values.
        let numbers = |key: &str| -> Vec<f32> {
            scaled.keys[key].split(' ').map(|number| number.parse().unwrap()).collect()
        };
        let (scale, bias) = (numbers("MCTscale"), numbers("MCTbias"));
        let texels = scaled.bytes.chunks_exact(2 * scale.len());
        for (texel, (x, y)) in texels.zip(places(SIZES[1])) {
            let words = texel.chunks_exact(2).map(|word| u16::from_le_bytes([word[0], word[1]]));
            let values: Vec<f32> =
                words.enumerate().map(|(k, word)| f32::from(word) / 65535.0 * scale[k] + bias[k]).collect();
            let told = texture.ranges[&1].texel(&texture.levels[1], x, y);
            match *values {
                [gray] => assert_eq!(gray, told.x),
                [gray, alpha] => assert_eq!([gray, alpha], [told.x, told.w]),
                _ => assert_eq!(values, told.to_array()),
            }
        }
    }
}

/// The planes of an EXR file by name, as 32 bits, and whether they are stored as half floats.
fn read_exr(file: &BundleFile, size: (u32, u32)) -> BTreeMap<String, (bool, Vec<f32>)> {
    use ::exr::prelude::*;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(&file.bytes))
        .unwrap();
    let layer = image.layer_data;
    assert_eq!(layer.size, Vec2(size.0 as usize, size.1 as usize));
    assert_eq!(layer.encoding.compression, Compression::ZIP16);
    let plane = |channel: &AnyChannel<FlatSamples>| {
        let is_half = matches!(channel.sample_data, FlatSamples::F16(_));
        (channel.name.to_string(), (is_half, channel.sample_data.values_as_f32().collect()))
    };
    layer.channel_data.list.iter().map(plane).collect()
}

#[test]
fn exr_holds_linear_values() {
    let names: [&[(&str, usize)]; 4] = [
        &[("Y", 0)],
        &[("Y", 0), ("A", 3)],
        &[("R", 0), ("G", 1), ("B", 2)],
        &[("R", 0), ("G", 1), ("B", 2), ("A", 3)],
    ];
    for components in 1..=4u8 {
        let (asset, mut finished) = ranged(components);
        let list: [(&[Slot], u8, u8); 3] = [
            (&[Slot::Occlusion], components, 8),
            (&[Slot::Normal], components, 16),
            (&[Slot::Emissive], components, 16),
        ];
        finished.textures.extend(channels(&list).1.textures);
        let files = written(&asset, &finished, &[TextureFormat::Exr]);
        for (number, file) in files.iter().enumerate() {
            let (texture, level) = (&finished.textures[number / 3], number % 3);
            let planes = read_exr(file, SIZES[level]);
            let expected = names[usize::from(components) - 1];
            assert_eq!(planes.len(), expected.len());
            let image = &texture.levels[level];
            let is_half = number == 2 || matches!(image.pixels, Pixels::U8(_));
            for (name, component) in expected {
                let (half, plane) = &planes[*name];
                assert_eq!(*half, is_half, "{}", file.path);
                for (value, (x, y)) in plane.iter().zip(places(SIZES[level])) {
                    let told = match texture.ranges.get(&level) {
                        Some(range) => range.texel(image, x, y)[*component],
                        None => image.linear(x, y, texture.transfer)[*component],
                    };
                    let rounded = if is_half { f16::from_f32(told).to_f32() } else { told };
                    assert_eq!(*value, rounded, "{}", file.path);
                }
            }
        }
    }
}

#[test]
fn half_floats_give_back_every_code() {
    let codes: Vec<u8> = (0..=255).collect();
    let ramp = Image { width: 256, height: 1, components: 1, pixels: Pixels::U8(codes) };
    for (slot, transfer) in [(Slot::BaseColor, Transfer::Srgb), (Slot::Occlusion, Transfer::Linear)] {
        let (asset, mut finished) = channels(&[(&[slot], 1, 8)]);
        finished.textures[0].levels = vec![ramp.clone()];
        let files = written(&asset, &finished, &[TextureFormat::Exr]);
        let (is_half, values) = &read_exr(&files[0], (256, 1))["Y"];
        assert!(is_half);
        for (code, value) in values.iter().enumerate() {
            let encoded = match transfer {
                Transfer::Srgb => crate::math::transfer::linear_to_srgb(*value),
                Transfer::Linear => *value,
            };
            assert_eq!((encoded * 255.0).round() as usize, code);
        }
    }
}
