//! Levels in blocks: which format a level gets, and what comes back.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec4;
use half::f16;
use ktx2::{ColorModel, Format, Reader, TransferFunction};

use super::{channels, image, ranged};
use crate::asset::{Asset, Slot};
use crate::finished::{Finished, FinishedTexture};
use crate::image::{Image, LevelRange, Pixels, Transfer};
use crate::watch::Unwatched;
use crate::write::encode;
use crate::write::textures::{BlockFormat, Compressed, Source, TextureFormat, files, refit};

const ALL: [BlockFormat; 4] = [BlockFormat::Bc5, BlockFormat::Bc6h, BlockFormat::Bc7, BlockFormat::Astc];

fn compressed(finished: &Finished, formats: &[BlockFormat]) -> Compressed {
    Compressed::of(finished, &formats.iter().copied().collect(), &Unwatched).unwrap()
}

/// Formats by texture, of level 0 or of all levels.
fn formats(finished: &Finished, formats: &[BlockFormat]) -> Vec<Option<BlockFormat>> {
    let all = compressed(finished, formats);
    let of = |texture: usize| all.level(texture, 0).map(|blocks| blocks.format);
    (0..finished.textures.len()).map(of).collect()
}

#[test]
fn a_level_gets_the_first_format_that_fits() {
    let list: [(&[Slot], u8, u8); 7] = [
        (&[Slot::BaseColor], 3, 8),
        (&[Slot::Emissive], 2, 8),
        (&[Slot::Occlusion], 1, 8),
        (&[Slot::MetallicRoughness], 2, 8),
        (&[Slot::Normal], 3, 8),
        (&[Slot::Normal], 1, 8),
        (&[Slot::Occlusion], 3, 16),
    ];
    let (_, finished) = channels(&list);
    let [bc5, bc7, astc] = [BlockFormat::Bc5, BlockFormat::Bc7, BlockFormat::Astc].map(Some);
    assert_eq!(formats(&finished, &ALL), [bc7, bc7, bc7, bc5, bc5, bc7, None]);
    assert_eq!(formats(&finished, &[BlockFormat::Bc5]), [None, None, None, bc5, bc5, None, None]);
    assert_eq!(formats(&finished, &[BlockFormat::Astc]), [astc, astc, astc, astc, astc, astc, None]);
    for components in 1..=4 {
        let (_, finished) = ranged(components);
        let all = compressed(&finished, &ALL);
        let told: Vec<_> = (0..3).map(|level| all.level(0, level).map(|blocks| blocks.format)).collect();
        let bc6h = (components % 2 == 1).then_some(BlockFormat::Bc6h);
        assert_eq!(told, [bc7, bc6h, bc6h]);
    }
}

/// Smooth, so that blocks hold it well, and each component different.
fn waves(size: (u32, u32), components: u8) -> Image {
    let code = |at: u32| {
        let (texel, component) = (at / u32::from(components), at % u32::from(components));
        let (x, y) = ((texel % size.0) as f32, (texel / size.0) as f32);
        let phase = 0.11 * x + 0.07 * y * (1.0 + component as f32);
        (127.5 + 100.0 * (phase + component as f32).sin()) as u8
    };
    let codes = (0..size.0 * size.1 * u32::from(components)).map(code).collect();
    Image { width: size.0, height: size.1, components, pixels: Pixels::U8(codes) }
}

/// Root mean square of the differences of all texels, over the first components, of two images.
fn rms(a: &Image, b: &Image, components: usize, value: impl Fn(&Image, u32, u32) -> [f32; 4]) -> f32 {
    assert_eq!(a.size(), b.size());
    let mut sum = 0.0;
    for (x, y) in super::places((a.width, a.height)) {
        let (a, b) = (value(a, x, y), value(b, x, y));
        sum += (0..components).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>();
    }
    (sum / (a.texel_count() * components) as f32).sqrt()
}

#[test]
fn codes_come_back_nearly() {
    for format in [BlockFormat::Bc7, BlockFormat::Astc] {
        for slot in [Slot::BaseColor, Slot::MetallicRoughness] {
            for components in 1..=4 {
                let (_, mut finished) = channels(&[(&[slot], components, 8)]);
                // More than one strip, and no whole blocks.
                finished.textures[0].levels = vec![waves((37, 150), components), waves((1, 3), components)];
                let decoded = compressed(&finished, &[format]).decoded(&finished).unwrap();
                for (before, after) in finished.textures[0].levels.iter().zip(&decoded.textures[0].levels) {
                    assert_eq!(after.components, if components % 2 == 1 { 3 } else { 4 });
                    let codes = |image: &Image, x, y| image.normalized(x, y).map(|value| value * 255.0);
                    let rms = rms(before, after, 4, codes);
                    assert!(rms < 5.0, "{format:?} {slot:?}, {components} components: {rms} codes");
                }
                assert!(decoded.textures[0].ranges.is_empty());
            }
        }
    }
}

#[test]
fn one_color_is_exact() {
    for format in [BlockFormat::Bc7, BlockFormat::Astc] {
        for slot in [Slot::BaseColor, Slot::MetallicRoughness] {
            let (_, mut finished) = channels(&[(&[slot], 4, 8)]);
            let codes = [3, 77, 200, 131].repeat(9 * 5);
            let level = Image { width: 9, height: 5, components: 4, pixels: Pixels::U8(codes) };
            finished.textures[0].levels = vec![level];
            let decoded = compressed(&finished, &[format]).decoded(&finished).unwrap();
            let Pixels::U8(codes) = &decoded.textures[0].levels[0].pixels else { panic!("8 bits") };
            let worst = codes
                .chunks(4)
                .flat_map(|texel| texel.iter().zip([3u8, 77, 200, 131]).map(|(a, b)| a.abs_diff(b)));
            assert!(worst.max().unwrap() <= 1, "{format:?} {slot:?}: {:?}", &codes[..4]);
        }
    }
}

#[test]
fn normals_keep_their_direction_without_z() {
    let (_, mut finished) = channels(&[(&[Slot::Normal], 3, 8), (&[Slot::MetallicRoughness], 2, 8)]);
    let size = (22, 9);
    let normal = |(x, y): (u32, u32)| {
        let tilt =
            glam::Vec3::new((0.2 * x as f32).sin() * 0.6, (0.3 * y as f32).cos() * 0.5, 1.0).normalize();
        (tilt * 0.5 + 0.5).to_array().map(|value| (value * 255.0 + 0.5) as u8)
    };
    let codes = super::places(size).flat_map(normal).collect();
    finished.textures[0].levels =
        vec![Image { width: size.0, height: size.1, components: 3, pixels: Pixels::U8(codes) }];
    finished.textures[1].levels = vec![waves(size, 2)];
    let decoded = compressed(&finished, &[BlockFormat::Bc5]).decoded(&finished).unwrap();
    for (texture, components) in [(0, 3), (1, 4)] {
        let [before, after] = [&finished, &decoded].map(|of| &of.textures[texture].levels[0]);
        assert_eq!(after.components, before.components);
        let rms = rms(before, after, components, |image, x, y| image.normalized(x, y).map(|v| v * 255.0));
        assert!(rms < 1.5, "{rms} codes");
    }
}

#[test]
fn values_beyond_codes_come_back_nearly() {
    for components in [1, 3] {
        let (_, mut finished) = channels(&[(&[Slot::BaseColor], components, 16)]);
        let waves = waves((19, 21), components);
        let Pixels::U8(codes) = &waves.pixels else { panic!("8 bits") };
        // From -1.2 to 3.3.
        let values: Vec<f32> = codes.iter().map(|&code| f32::from(code) / 50.0 - 1.75).collect();
        let halves = values.iter().map(|value| f16::from_f32(*value).to_bits()).collect();
        let scaled = values.iter().map(|value| ((value + 2.0) / 6.0 * 65535.0) as u16).collect();
        let image = |codes: Vec<u16>| Image { pixels: Pixels::U16(codes), ..waves.clone() };
        let texture = &mut finished.textures[0];
        texture.levels = vec![image(halves), image(scaled)];
        let scaled16 = LevelRange::Scaled16 { scale: Vec4::splat(6.0), bias: Vec4::splat(-2.0) };
        texture.ranges = BTreeMap::from([(0, LevelRange::Float16), (1, scaled16)]);
        let all = compressed(&finished, &[BlockFormat::Bc6h]);
        let decoded = all.decoded(&finished).unwrap();
        for level in 0..2 {
            let [before, after] = [&finished, &decoded].map(|of| &of.textures[0]);
            assert_eq!((after.levels[level].components, after.ranges[&level]), (3, LevelRange::Float16));
            let value = |of: &FinishedTexture, x, y| of.ranges[&level].texel(&of.levels[level], x, y);
            let squares = super::places((19, 21))
                .map(|(x, y)| (value(before, x, y) - value(after, x, y)).truncate().length_squared() / 3.0);
            let rms = (squares.sum::<f32>() / (19.0 * 21.0)).sqrt();
            assert!(rms < 0.15, "level {level}, {components} components: {rms}");
        }
        // A reader that knows the keys alone can undo the shift.
        let keys: BTreeMap<_, _> = all.level(0, 0).unwrap().texels.keys.iter().cloned().collect();
        let bias: Vec<f32> = keys["MCTbias"].split(' ').map(|number| number.parse().unwrap()).collect();
        let least = values.iter().copied().fold(0.0, f32::min);
        assert!(bias[..3].iter().any(|bias| (bias - least).abs() < 2e-3) && bias[3] == 0.0, "{bias:?}");
        assert_eq!(keys["MCTscale"], "1 1 1 1");
    }
}

fn written(asset: &Asset, finished: &Finished, compressed: &Compressed) -> Vec<Vec<u8>> {
    let pngs = encode(finished, &Unwatched).unwrap();
    let source = Source { asset, finished, pngs: &pngs, compressed: Some(compressed) };
    let files = files(&source, &BTreeSet::from([TextureFormat::Ktx2]), &Unwatched).unwrap();
    files.into_iter().map(|file| file.bytes).collect()
}

#[test]
fn ktx2_holds_whole_blocks() {
    let list: [(&[Slot], u8, u8); 4] = [
        (&[Slot::BaseColor], 3, 8),
        (&[Slot::Occlusion], 1, 8),
        (&[Slot::MetallicRoughness], 2, 8),
        (&[Slot::Normal], 3, 8),
    ];
    let (asset, finished) = channels(&list);
    let bc7 = |format, transfer| (format, ColorModel::BC7, transfer);
    let bc5 = (Format::BC5_UNORM_BLOCK, ColorModel::BC5, TransferFunction::Linear);
    let expected = [
        bc7(Format::BC7_SRGB_BLOCK, TransferFunction::SRGB),
        bc7(Format::BC7_UNORM_BLOCK, TransferFunction::Linear),
        bc5,
        bc5,
    ];
    let all = compressed(&finished, &[BlockFormat::Bc5, BlockFormat::Bc7]);
    for (number, bytes) in written(&asset, &finished, &all).iter().enumerate() {
        let (texture, level) = (number / 3, number % 3);
        let reader = Reader::new(bytes.as_slice()).unwrap();
        let header = reader.header();
        let (width, height) = super::SIZES[level];
        assert_eq!(header.pixel_width, width.next_multiple_of(4));
        assert_eq!(header.pixel_height, height.next_multiple_of(4));
        let told =
            (header.format.unwrap(), reader.color_model().unwrap(), reader.transfer_function().unwrap());
        assert_eq!(told, expected[texture]);
        let blocks = zstd::stream::decode_all(reader.levels().next().unwrap().data).unwrap();
        assert_eq!(blocks.len() as u32, header.pixel_width * header.pixel_height);
        assert_eq!(blocks, all.level(texture, level).unwrap().texels.bytes);
        let keys: BTreeMap<_, _> = reader.key_value_data().collect();
        assert_eq!(keys["MCTsize"], format!("{width} {height}\0").as_bytes());
        let swizzle = (texture == 2).then_some(&b"rrrg\0"[..]);
        assert_eq!(keys.get("KTXswizzle").copied(), swizzle);
    }
}

#[test]
fn blocks_do_not_depend_on_threads() {
    let (asset, mut finished) = channels(&[(&[Slot::BaseColor], 3, 8), (&[Slot::Normal], 3, 8)]);
    finished.textures[0].levels.push(image((70, 300), 3, 8, 5));
    finished.textures[0].transfer = Transfer::Srgb;
    for formats in [&ALL[..3], &ALL[3..]] {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| written(&asset, &finished, &compressed(&finished, formats)))
        };
        assert!(on(1) == on(4), "{formats:?}");
    }
}

#[test]
fn blocks_that_share_texels_draw_together() {
    let (_, mut finished) = channels(&[(&[Slot::BaseColor], 3, 8), (&[Slot::Normal], 3, 8)]);
    // The lower half begins with the last row of the upper one.
    let mut level = waves((64, 32), 3);
    let Pixels::U8(codes) = &mut level.pixels else { panic!("8 bits") };
    codes.copy_within(15 * 192..16 * 192, 16 * 192);
    let groups: Vec<Vec<u32>> = (0..64).map(|x| vec![15 * 64 + x, 16 * 64 + x]).collect();
    for texture in &mut finished.textures {
        texture.levels = vec![level.clone()];
    }
    let mut all = compressed(&finished, &[BlockFormat::Bc7]);
    let jump = |all: &Compressed| {
        let decoded = all.decoded(&finished).unwrap();
        let image = &decoded.textures[0].levels[0];
        let of_pair = |group: &Vec<u32>| {
            let [a, b] = [group[0], group[1]].map(|texel| image.normalized(texel % 64, texel / 64));
            (0..3).map(|k| (a[k] - b[k]).abs()).sum::<f32>()
        };
        groups.iter().map(of_pair).sum::<f32>()
    };
    let before = jump(&all);
    let mut fitted = refit(&finished, [0, 0], all.level(0, 0).unwrap(), &groups).unwrap().unwrap();
    all.swap([0, 0], &mut fitted);
    let after = jump(&all);
    assert!(after < 0.95 * before, "{before} has become {after}");
    all.swap([0, 0], &mut fitted);
    assert_eq!(jump(&all), before);
    assert!(refit(&finished, [1, 0], all.level(1, 0).unwrap(), &groups).unwrap().is_none());
    assert!(refit(&finished, [0, 0], all.level(0, 0).unwrap(), &[]).unwrap().is_none());
}
