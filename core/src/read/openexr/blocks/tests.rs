//! Blocks that become more than they are.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder, Vec2,
    WritableImage, f16,
};

use super::super::decode;
use super::*;
use crate::read::ptex::tests::writer::zipped;

const COUNT: usize = 32 * 32;

fn file(compression: Compression, blocks: Blocks, name: &str, samples: FlatSamples) -> Vec<u8> {
    let channels = AnyChannels::sort([AnyChannel::new(name, samples)].into_iter().collect());
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let layer = Layer::new((32, 32), LayerAttributes::default(), encoding, channels);
    let mut bytes = Vec::new();
    Image::from_layer(layer).write().non_parallel().to_buffered(Cursor::new(&mut bytes)).unwrap();
    bytes
}

fn halves(value: impl Fn(usize) -> usize) -> FlatSamples {
    FlatSamples::F16((0..COUNT).map(|texel| f16::from_f32(value(texel) as f32)).collect())
}

/// What varies too much for the cosine transform to leave it small.
fn rough() -> FlatSamples {
    halves(|texel| texel * 37 % 101)
}

/// The only block of a DWA file stands behind the list of blocks, which says where: its row, its size, its numbers.
fn numbers_at(bytes: &[u8]) -> usize {
    let starts = |at: usize| bytes[at - 8..at] == (at as u64).to_le_bytes();
    (8..bytes.len()).find(|&at| starts(at)).unwrap() + 8
}

#[test]
fn whatever_the_library_writes_is_read() {
    let noise = |texel: usize| f32::from_bits(0x3F80_0000 | (texel as u32).wrapping_mul(0x9E37_79B9) >> 9);
    let floats = || FlatSamples::F32((0..COUNT).map(noise).collect());
    for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(11, 9))] {
        for compression in [Compression::DWAA(None), Compression::DWAB(Some(1e-4))] {
            for samples in [rough(), halves(|texel| texel / 32), floats()] {
                decode(&file(compression, blocks, "Y", samples)).unwrap();
            }
        }
    }
}

fn refusal(bytes: &[u8]) -> String {
    decode(bytes).map(|_| "none").unwrap_err().detail
}

#[test]
fn parts_are_held_against_the_block() {
    let bytes = file(Compression::DWAA(None), Blocks::ScanLines, "Y", halves(|texel| texel / 32));
    let numbers = numbers_at(&bytes);
    for (place, most) in [(1, 2048), (6, 4096), (7, 2048), (8, 1024), (9, 16)] {
        let mut bytes = bytes.clone();
        let at = numbers + 8 * place;
        for huge in [most + 1, 1 << 40, u64::MAX >> 1] {
            bytes[at..at + 8].copy_from_slice(&huge.to_le_bytes());
            let detail = refusal(&bytes);
            assert!(detail.contains(&format!("is to unpack to {huge} of")), "{detail}");
            assert!(detail.contains(&format!("where it can have {most}")), "{detail}");
        }
    }
}

#[test]
fn runs_are_counted() {
    // Three bytes of their own, a run of one and one of 128.
    let runs = [0xFD, 1, 2, 3, 0, 7, 127, 9];
    check_runs(&runs, 132).unwrap();
    assert!(check_runs(&runs, 131).unwrap_err().detail.contains("unpack to 132"));
    // The file ends inside of it.
    check_runs(&[0xFD, 1], 3).unwrap();
    check_runs(&[5], 6).unwrap();
}

/// The library goes on behind the end of a block, as far as there are runs.
#[test]
fn runs_end_with_the_block() {
    let flat = || halves(|_| 1);
    let mut bytes = file(Compression::RLE, Blocks::ScanLines, "Y", flat());
    decode(&bytes).unwrap();
    let end = bytes.len();
    bytes[end - 2..].copy_from_slice(&[127, 0]);
    assert!(refusal(&bytes).contains("of runs"), "{}", refusal(&bytes));

    // Under DWA they are the last part of a block, of alpha, under zlib.
    let bytes = file(Compression::DWAA(None), Blocks::ScanLines, "A", flat());
    let numbers = numbers_at(&bytes);
    let length_at = numbers + NUMBER_BYTES * RUNS_PACKED_BYTES;
    let runs_bytes = usize::from(bytes[length_at]);
    let with_runs = |count: usize| {
        let runs = zipped(&[127, 0].repeat(count));
        let mut bytes = [&bytes[..bytes.len() - runs_bytes], &runs].concat();
        let length = (bytes.len() - numbers) as u32;
        bytes[numbers - 4..numbers].copy_from_slice(&length.to_le_bytes());
        bytes[length_at] = runs.len() as u8;
        bytes[length_at + NUMBER_BYTES] = 2 * count as u8;
        bytes
    };
    decode(&with_runs(16)).unwrap();
    assert!(refusal(&with_runs(17)).contains("2176 of runs"), "{}", refusal(&with_runs(17)));
}
