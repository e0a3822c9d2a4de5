//! A sheet with two charts, and images that somebody baked for it: smooth numbers and shares.

use std::collections::BTreeMap;
use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, SmallVec, WritableImage, f16,
};
use glam::{Vec2, Vec4};
use meshcolor::read::{MemoryFiles, Upload};
use serde_json::json;

use crate::gltf::Gltf;

/// Cells along a side of the sheet.
const CELLS: u32 = 6;
/// Texels along a side of the images.
const SIDE: u32 = 96;

/// Where a point of the left or the right half of the sheet stands in the image: the right one is turned.
fn uv(at: Vec2, is_right: bool) -> Vec2 {
    if is_right {
        Vec2::new(0.54 + 0.44 * at.y, 0.04 + 1.84 * (at.x - 0.5))
    } else {
        Vec2::new(0.02 + 0.88 * at.x, 0.04 + 0.92 * at.y)
    }
}

/// The point of the sheet that a place of the image is for; it goes on beyond the charts.
fn point(uv: Vec2) -> Vec2 {
    if uv.x > 0.5 {
        Vec2::new(0.5 + (uv.y - 0.04) / 1.84, (uv.x - 0.54) / 0.44)
    } else {
        Vec2::new((uv.x - 0.02) / 0.88, (uv.y - 0.04) / 0.92)
    }
}

/// Smooth numbers from -3 to 20, four of them.
pub fn number(at: Vec2) -> Vec4 {
    let [x, y] = at.to_array();
    Vec4::new(
        8.5 + 11.5 * (2.0 * x + y).sin(),
        20.0 * x * y - 3.0 * (1.0 - x),
        0.01 + 15.0 * (x - y).powi(2),
        1.0 + 3.0 * y - x,
    )
}

/// The same within [0, 1].
pub fn share(at: Vec2) -> Vec4 {
    ((number(at) + 8.0) / 40.0).clamp(Vec4::ZERO, Vec4::ONE)
}

fn texels(of: impl Fn(Vec2) -> Vec4) -> Vec<Vec4> {
    let center = |k: u32| Vec2::new((k % SIDE) as f32 + 0.5, (k / SIDE) as f32 + 0.5) / SIDE as f32;
    (0..SIDE * SIDE).map(|k| of(point(center(k)))).collect()
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depth {
    Half,
    Float,
}

/// An OpenEXR file of numbers, its channels so named.
pub fn openexr(names: &[&str], depth: Depth) -> Vec<u8> {
    let numbers = texels(number);
    let channel = |(k, name): (usize, &&str)| {
        let plane = numbers.iter().map(|number| number[k]);
        let samples = match depth {
            Depth::Half => FlatSamples::F16(plane.map(f16::from_f32).collect()),
            Depth::Float => FlatSamples::F32(plane.collect()),
        };
        AnyChannel::new(*name, samples)
    };
    written(SIDE, names.iter().enumerate().map(channel).collect())
}

/// An OpenEXR file of gray halves that are all alike, four along a side.
pub fn flat_half(value: f16) -> Vec<u8> {
    let channel = AnyChannel::new("Y", FlatSamples::F16(vec![value; 16]));
    written(4, [channel].into_iter().collect())
}

fn written(side: u32, channels: SmallVec<[AnyChannel<FlatSamples>; 4]>) -> Vec<u8> {
    let size = (side as usize, side as usize);
    let channels = AnyChannels::sort(channels);
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::SMALL_FAST_LOSSLESS, channels);
    let mut bytes = Vec::new();
    exr::prelude::Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .unwrap();
    bytes
}

fn png(color: image::ExtendedColorType, component: impl Fn(Vec4) -> Vec<u8>) -> Vec<u8> {
    let bytes: Vec<u8> = texels(share).into_iter().flat_map(component).collect();
    let mut png = Cursor::new(Vec::new());
    image::write_buffer_with_format(&mut png, &bytes, SIDE, SIDE, color, image::ImageFormat::Png).unwrap();
    png.into_inner()
}

pub fn gray16() -> Vec<u8> {
    png(image::ExtendedColorType::L16, |share| ((share.x * 65535.0).round() as u16).to_ne_bytes().to_vec())
}

pub fn rgba8() -> Vec<u8> {
    png(image::ExtendedColorType::Rgba8, |share| {
        share.to_array().map(|share| (share * 255.0).round() as u8).to_vec()
    })
}

/// A sheet of two charts, its coordinates in a set, of materials by halves where there are two.
pub fn sheet(materials: &[&str], set: usize) -> Vec<u8> {
    let mut gltf = Gltf::default();
    let numbers: Vec<usize> = materials.iter().map(|name| gltf.material(json!({ "name": name }))).collect();
    for is_right in [false, true] {
        let columns = if is_right { CELLS / 2..=CELLS } else { 0..=CELLS / 2 };
        let places: Vec<Vec2> = (0..=CELLS)
            .flat_map(|y| columns.clone().map(move |x| Vec2::new(x as f32, y as f32) / CELLS as f32))
            .collect();
        let width = CELLS / 2 + 1;
        let mut indices = Vec::new();
        for cell in (0..width * CELLS).filter(|cell| cell % width != width - 1) {
            let [a, b, c, d] = [cell, cell + 1, cell + width + 1, cell + width];
            indices.extend([a, b, c, a, c, d]);
        }
        let positions: Vec<[f32; 3]> = places.iter().map(|at| [at.x, at.y, 0.3 * at.x * at.y]).collect();
        let coordinates: Vec<f32> = places.iter().flat_map(|at| uv(*at, is_right).to_array()).collect();
        let zeros = vec![0.0; coordinates.len()];
        let mut attributes = json!({ "POSITION": gltf.positions(&positions) });
        for own in 0..=set {
            let numbers = if own == set { &coordinates } else { &zeros };
            attributes[format!("TEXCOORD_{own}")] = json!(gltf.floats("VEC2", numbers));
        }
        let indices = gltf.indices(&indices);
        let primitive = gltf.primitive(json!({ "attributes": attributes, "indices": indices }));
        if let Some(material) = numbers.get(usize::from(is_right) % numbers.len().max(1)) {
            primitive["material"] = json!(material);
        }
    }
    gltf.glb()
}

pub fn upload(glb: Vec<u8>, files: &[(&str, Vec<u8>)]) -> Upload {
    let files = files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.clone()));
    let all = files.chain([("models/sheet.glb".to_owned(), glb)]).collect::<BTreeMap<_, _>>();
    Upload { main: "models/sheet.glb".to_owned(), files: Box::new(MemoryFiles(all)) }
}
