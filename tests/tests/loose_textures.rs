//! Loose level files of a conversion, read by foreign readers.

use std::collections::BTreeMap;

use meshcolor::finished::FinishedTexture;
use meshcolor::image::{LevelRange, Transfer};
use meshcolor::pipeline::{Conversion, Options, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_tests::{openimageio, validator};

// Numbers of Vulkan's formats.
const RGBA8_UNORM: u32 = 37;
const RGBA8_SRGB: u32 = 43;
const RGBA16_FLOAT: u32 = 97;

fn converted(settings: &[(&str, &str)]) -> Conversion {
    let mut options = Options::default();
    for (name, value) in settings {
        options.set(name, value).unwrap();
    }
    let upload = Upload::single("sample.glb", meshcolor_service::sample::model());
    convert(&upload, &options, &Limits::default(), &Unwatched).unwrap()
}

/// In the order of the loose files.
fn levels(conversion: &Conversion) -> impl Iterator<Item = (&FinishedTexture, usize)> + Clone {
    let textures = conversion.finished.textures.iter();
    textures.flat_map(|texture| (0..texture.levels.len()).map(move |level| (texture, level)))
}

#[test]
fn loose_files_come_along_and_change_nothing_else() {
    let plain = converted(&[]);
    let loose = converted(&[("textures", "png,ktx2,exr")]);
    let level_count: usize = loose.finished.textures.iter().map(|texture| texture.levels.len()).sum();
    assert_eq!((plain.files.len(), loose.files.len()), (2, 2 + 3 * level_count));
    assert!(plain.files[0] == loose.files[0], "the model has changed");
    let mut report = loose.report.clone();
    report.options = plain.report.options.clone();
    assert_eq!(report, plain.report);
}

#[test]
fn ktx_parse_reads_what_was_written() {
    // 4D coordinates have levels in ranges of their own.
    let conversion = converted(&[("textures", "ktx2"), ("coordinates", "4d")]);
    let files: Vec<&[u8]> = conversion.files[2..].iter().map(|file| file.bytes.as_slice()).collect();
    let Some(read) = validator::ktx(&files) else {
        println!("skipped: no ktx-parse; tests/run installs it");
        return;
    };
    let levels = levels(&conversion);
    assert_eq!(read.len(), levels.clone().count());
    let mut ranged_count = 0;
    for ((file, bytes), (texture, level)) in read.iter().zip(files).zip(levels) {
        let range = texture.ranges.get(&level);
        let (format, bits) = match (range, texture.transfer) {
            (Some(LevelRange::Float16), _) => (RGBA16_FLOAT, 16),
            (_, Transfer::Srgb) => (RGBA8_SRGB, 8),
            (_, Transfer::Linear) => (RGBA8_UNORM, 8),
        };
        let texel_bytes = u64::from(bits) / 2;
        let image = &texture.levels[level];
        assert_eq!((file.format, file.size), (format, image.size()));
        assert_eq!((file.type_size, file.supercompression), (bits / 8, 2));
        assert_eq!(file.depth_layers_faces, [0, 0, 1]);
        let [[packed, unpacked]] = file.levels[..] else { panic!("{} levels", file.levels.len()) };
        assert!(packed < bytes.len() as u64);
        assert_eq!(unpacked, image.texel_count() as u64 * texel_bytes);
        // Of the data format: RGBSDA, straight alpha; BT.709 or nothing; linear or sRGB.
        let is_color = texture.transfer == Transfer::Srgb;
        let is_encoded = is_color && range.is_none();
        assert_eq!((file.model, file.primaries), (1, u8::from(is_color)));
        assert_eq!(file.transfer, 1 + u8::from(is_encoded));
        assert_eq!((file.plane_bytes, file.block.as_slice()), (texel_bytes, &[0, 0, 0, 0][..]));
        let samples: Vec<_> = (0..4).map(|sample| [sample * bits, bits - 1]).collect();
        assert_eq!(file.samples, samples);
        let mut keys =
            BTreeMap::from([("KTXorientation", "rd"), ("MCTlevel", &level.to_string())].map(owned));
        keys.insert("KTXwriter".into(), file.keys["KTXwriter"].clone());
        keys.extend(range.map(|range| owned(("MCTrange", range.name()))));
        assert_eq!(file.keys, keys);
        ranged_count += usize::from(range.is_some());
    }
    assert!(ranged_count > 0, "no level of the sample has a range");
}

/// OpenEXR's own library reads linear light, and the values of ranges.
#[test]
fn openimageio_reads_what_was_written() {
    let conversion = converted(&[("textures", "exr"), ("coordinates", "4d")]);
    let files: Vec<Vec<u8>> = conversion.files[2..].iter().map(|file| file.bytes.clone()).collect();
    let Some(read) = openimageio::read("exr", &files) else {
        println!("skipped: no OpenImageIO; tests/run installs it");
        return;
    };
    for ((texture, level), parts) in levels(&conversion).zip(&read) {
        let image = &texture.levels[level];
        let [part] = parts.as_slice() else { panic!("{} parts", parts.len()) };
        assert_eq!(
            (part.size.map(|side| side as u32), part.channels),
            (image.size(), image.components.into())
        );
        for (k, found) in part.values.chunks(part.channels).enumerate() {
            let (x, y) = (k as u32 % image.width, k as u32 / image.width);
            let expected = image.value(x, y, texture.transfer, texture.ranges.get(&level)).to_array();
            for (found, expected) in found.iter().zip(expected) {
                let found = found.expect("a finite number");
                assert!(
                    (found - expected).abs() <= expected.abs() / 2048.0,
                    "{:?} {level}, {x} {y}",
                    texture.slots[0]
                );
            }
        }
    }
}

fn owned((key, value): (&str, &str)) -> (String, String) {
    (key.to_owned(), value.to_owned())
}
