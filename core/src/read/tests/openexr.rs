//! OpenEXR images as channels: every layout and packing gives the same numbers, and what is not read says why.

use std::io::Cursor;

use exr::meta::attribute::IntegerBounds;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, SmallVec, Vec2, WritableImage, f16,
};

use super::*;
use crate::asset::AttributeName;
use crate::image::Pixels;
use crate::read::{AttributeSource, read_with};

/// 8 by 8, bent by a fuzzer: differences of a B44 block that leave 16 bits.
const B44_WRAPS: &[u8] = include_bytes!("openexr/b44_wraps.exr");
/// 8 by 8, bent by a fuzzer: a tile of a level that the image does not have.
const TILE_OF_NO_LEVEL: &[u8] = include_bytes!("openexr/tile_of_no_level.exr");
/// 8 by 8, bent by a fuzzer: tiles of 65 602 by 65 536.
const HUGE_TILE: &[u8] = include_bytes!("openexr/huge_tile.exr");
const SIDE: usize = 12;
const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

fn number(texel: usize, channel: usize) -> f32 {
    (texel * (channel + 1)) as f32 * 0.25 - 9.0
}

fn layer(
    names: &[&str],
    encoding: Encoding,
    samples: impl Fn(usize) -> FlatSamples,
) -> Layer<AnyChannels<FlatSamples>> {
    let channels: SmallVec<_> =
        names.iter().enumerate().map(|(k, name)| AnyChannel::new(*name, samples(k))).collect();
    Layer::new((SIDE, SIDE), LayerAttributes::default(), encoding, AnyChannels::sort(channels))
}

fn halves(channel: usize) -> FlatSamples {
    FlatSamples::F16((0..SIDE * SIDE).map(|texel| f16::from_f32(number(texel, channel))).collect())
}

fn floats(channel: usize) -> FlatSamples {
    FlatSamples::F32((0..SIDE * SIDE).map(|texel| number(texel, channel)).collect())
}

fn written(layer: Layer<AnyChannels<FlatSamples>>) -> Vec<u8> {
    let mut bytes = Vec::new();
    Image::from_layer(layer).write().non_parallel().to_buffered(Cursor::new(&mut bytes)).unwrap();
    bytes
}

fn read_channel(image: &[u8]) -> Result<Asset> {
    let files =
        [("m.obj", TRIANGLE), ("a.exr", image)].map(|(name, bytes)| (name.to_owned(), bytes.to_vec()));
    let upload = Upload { main: "m.obj".to_owned(), files: Box::new(MemoryFiles(BTreeMap::from(files))) };
    let name = AttributeName::new("a").unwrap();
    let source = AttributeSource { name, material: None, file: "a.exr".to_owned(), texcoord: 0 };
    read_with(&upload, &[source], &Limits::default(), &Unwatched)
}

#[test]
fn all_packings_give_the_same_numbers() {
    let lines =
        |compression| Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let tiles = Blocks::Tiles(Vec2(5, 7));
    let encodings = [
        lines(Compression::Uncompressed),
        lines(Compression::RLE),
        lines(Compression::ZIP1),
        lines(Compression::ZIP16),
        lines(Compression::PIZ),
        Encoding { blocks: tiles, ..lines(Compression::ZIP16) },
        Encoding { line_order: LineOrder::Decreasing, ..lines(Compression::RLE) },
    ];
    for encoding in encodings {
        for (names, kind) in
            [(["R", "G", "B"], halves as fn(usize) -> FlatSamples), (["X", "Y", "Z"], floats)]
        {
            let asset = read_channel(&written(layer(&names, encoding, kind))).unwrap();
            let image = &asset.images[0];
            assert_eq!((image.size(), image.components), ([SIDE as u32; 2], 3));
            let Pixels::F32(of) = &image.pixels else { panic!("numbers") };
            assert_eq!(of.scale, Some(128.0));
            for (place, value) in of.values.iter().enumerate() {
                assert_eq!(value * 128.0, number(place / 3, place % 3), "{encoding:?} {names:?} {place}");
            }
        }
    }
}

#[test]
fn what_is_not_read_says_why() {
    let fast = Encoding::FAST_LOSSLESS;
    let good = written(layer(&["Y"], fast, halves));
    let whole = |_| FlatSamples::U32(vec![7; SIDE * SIDE]);
    let endless = |_| FlatSamples::F32(vec![f32::INFINITY; SIDE * SIDE]);
    let mut shifted = layer(&["Y"], fast, halves);
    shifted.attributes.layer_position = Vec2(3, 0);
    let window = IntegerBounds::from_dimensions((SIDE, SIDE));
    let mut out_of_window = Image::from_layer(shifted);
    out_of_window.attributes.display_window = window;
    let mut moved = Vec::new();
    out_of_window.write().non_parallel().to_buffered(Cursor::new(&mut moved)).unwrap();
    for (bytes, told) in [
        (written(layer(&["Y"], fast, whole)), "channel \"Y\" holds whole numbers"),
        (written(layer(&["Y"], fast, endless)), "holds inf in row 0 from the top"),
        (written(layer(&["R", "G", "B", "Z"], fast, halves)), "has 4 channels (\"B\", \"G\", \"R\", \"Z\")"),
        (moved, "data window is not its display window"),
        (good[..good.len() - 9].to_vec(), "cannot be decoded"),
        (good[..60].to_vec(), "cannot be decoded"),
    ] {
        let error = read_channel(&bytes).unwrap_err();
        assert_eq!(
            (error.code, error.pointer.as_deref()),
            (ErrorCode::InvalidModel, Some("/channel/a")),
            "{told}"
        );
        assert!(error.detail.contains(told), "{told}: {}", error.detail);
    }
}

/// A header alone takes no memory.
#[test]
fn sizes_are_checked_before_anything_is_decoded() {
    let mut bytes = written(layer(&["Y"], Encoding::UNCOMPRESSED, halves));
    for name in [&b"dataWindow\0box2i\0"[..], &b"displayWindow\0box2i\0"[..]] {
        let at = bytes.windows(name.len()).position(|own| own == name).unwrap() + name.len() + 4;
        for (k, corner) in [0, 0, 40_000_i32, 40_000].into_iter().enumerate() {
            bytes[at + 4 * k..][..4].copy_from_slice(&corner.to_le_bytes());
        }
    }
    let error = read_channel(&bytes).unwrap_err();
    assert_eq!((error.code, error.actual), (ErrorCode::ImageTooLarge, Some(40_001)), "{error}");
}

#[test]
fn what_fuzzing_found_is_no_panic() {
    let _ = read_channel(B44_WRAPS);
    let error = read_channel(TILE_OF_NO_LEVEL).unwrap_err();
    assert!(error.detail.contains("not exactly one value for each pixel"), "{error}");
    let error = read_channel(HUGE_TILE).unwrap_err();
    assert!(error.detail.contains("has tiles of "), "{error}");
    let good = written(layer(&["R", "G", "B", "A"], Encoding::SMALL_LOSSLESS, halves));
    for end in 0..good.len() {
        assert!(read_channel(&good[..end]).is_err(), "{end}");
    }
}
