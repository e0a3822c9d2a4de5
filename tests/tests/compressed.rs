//! A model packed by meshoptimizer, quantized, with a WebP texture, and one in a Draco stream with a texture of Basis
//! Universal: converted, and the files judged by the Khronos validator.

use std::io::Cursor;

use meshcolor::pipeline::{Options, convert};
use meshcolor::read::{Limits, Upload, read};
use meshcolor::vertex_codec::packed_attributes;
use meshcolor::watch::Unwatched;
use meshcolor_tests::gltf::container;
use meshcolor_tests::validator;
use meshopt::ffi;
use serde_json::{Value, json};

const SIDE: usize = 9;
const COUNT: usize = SIDE * SIDE;
const REQUIRED: [&str; 3] = ["KHR_mesh_quantization", "EXT_meshopt_compression", "EXT_texture_webp"];

/// A bent quad of four vertices with positions, normals, texture coordinates, colors and joints, by the reference encoder
/// (draco3d 1.5.7): 12 bits for positions and coordinates, 8 for normals.
const STREAM: &str = "\
     445241434f02020101000000040204020000011fff0111ff0111ff0111ff0111ff011105ff00010000000100000200000300000100090300\
     000201010903000103010309020002020102020300030101040404000401010101000d0301200110230110030030904a002000fe1f000000\
     00ff0f00000000000000000000000000000000803f0c060301000903011017013003002882d515d515c11f00ff0000007f000000ff024440\
     0805010100030301300110030024822600020000008002807000000000ff0f000000000000000000000000803f0c0101010105660110e701\
     100355054b55054b59150600e67c876f800a0000007800000001010100060b01200301200300e8835052fbff10c207c0000000002c010000";

fn packed_triangles(indices: &[u32]) -> Vec<u8> {
    // SAFETY: `packed` has as many bytes as the encoder asks for.
    unsafe {
        let mut packed = vec![0; ffi::meshopt_encodeIndexBufferBound(indices.len(), COUNT)];
        let (target, source) = (packed.as_mut_ptr(), indices.as_ptr());
        let length = ffi::meshopt_encodeIndexBuffer(target, packed.len(), source, indices.len());
        packed.truncate(length);
        packed
    }
}

/// A bent sheet: positions in 16 bits, normals in 8, texture coordinates in 16 (normalized), a morph target in 8.
fn model() -> Vec<u8> {
    let mut vertices: [Vec<u8>; 4] = Default::default();
    for vertex in 0..COUNT {
        let (x, y) = ((vertex % SIDE) as i16, (vertex / SIDE) as i16);
        let position = [x * 100, y * 100, (x - 4) * (x - 4) * 10, 0];
        vertices[0].extend(position.iter().flat_map(|code| code.to_le_bytes()));
        vertices[1].extend([0u8, 0, 127, 0]);
        let uv = [x, y].map(|code| (f32::from(code) / 8.0 * 65535.0) as u16);
        vertices[2].extend(uv.iter().flat_map(|code| code.to_le_bytes()));
        vertices[3].extend([0, 0, x as u8, 0]);
    }
    let mut indices = Vec::new();
    for cell in (0..COUNT - SIDE).filter(|cell| cell % SIDE != SIDE - 1) {
        let [a, b, c, d] = [cell, cell + 1, cell + SIDE, cell + SIDE + 1].map(|vertex| vertex as u32);
        indices.extend([a, b, d, a, d, c]);
    }
    let (mut bin, mut views, mut fallback_bytes) = (Vec::new(), Vec::new(), 0);
    let mut add = |packed: Vec<u8>, mode: &str, stride: usize, count: usize| {
        let extension = json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": packed.len(),
            "byteStride": stride, "count": count, "mode": mode });
        let mut view = json!({ "buffer": 1, "byteOffset": fallback_bytes, "byteLength": stride * count,
            "extensions": { "EXT_meshopt_compression": extension } });
        if mode == "ATTRIBUTES" {
            view["byteStride"] = stride.into();
        }
        views.push(view);
        bin.extend(packed);
        bin.resize(bin.len().next_multiple_of(4), 0);
        fallback_bytes += (stride * count).next_multiple_of(4);
    };
    for (bytes, stride) in vertices.iter().zip([8, 4, 4, 4]) {
        add(packed_attributes(bytes, stride).unwrap(), "ATTRIBUTES", stride, COUNT);
    }
    add(packed_triangles(&indices), "TRIANGLES", 2, indices.len());
    let picture = image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([x as u8 * 4, y as u8 * 4, 90]));
    let mut webp = Cursor::new(Vec::new());
    picture.write_to(&mut webp, image::ImageFormat::WebP).unwrap();
    let webp = webp.into_inner();
    views.push(json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": webp.len() }));
    bin.extend(webp);
    let accessor = |view: usize, component: u32, kind: &str, normalized: bool| {
        json!({ "bufferView": view, "componentType": component, "count": COUNT, "type": kind,
            "normalized": normalized })
    };
    let mut accessors = vec![
        accessor(0, 5122, "VEC3", false),
        accessor(1, 5120, "VEC3", true),
        accessor(2, 5123, "VEC2", true),
        accessor(3, 5120, "VEC3", false),
        json!({ "bufferView": 4, "componentType": 5123, "count": indices.len(), "type": "SCALAR" }),
    ];
    for (number, most) in [(0, [800, 800, 160]), (3, [0, 0, 8])] {
        accessors[number]["min"] = json!([0, 0, 0]);
        accessors[number]["max"] = json!(most);
    }
    let json = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": REQUIRED, "extensionsRequired": REQUIRED,
        "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "scale": [0.01, 0.01, 0.01] }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }, "indices": 4, "material": 0
        }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "extensions": { "EXT_texture_webp": { "source": 0 } } }],
        "images": [{ "bufferView": 5, "mimeType": "image/webp" }],
        "accessors": accessors, "bufferViews": views,
        "buffers": [
            { "byteLength": bin.len() },
            { "byteLength": fallback_bytes,
              "extensions": { "EXT_meshopt_compression": { "fallback": true } } }
        ],
    });
    container(&json, &bin)
}

/// The model with a morph target that stays as it came.
fn morphing() -> Vec<u8> {
    let glb = model();
    let length = u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]) as usize;
    let mut json: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 3 }]);
    container(&json, &glb[20 + length + 8..])
}

#[test]
fn a_compressed_model_converts_to_a_plain_valid_file() {
    for (name, source, left) in [("plain", model(), None), ("morphing", morphing(), Some(REQUIRED[0]))] {
        let upload = Upload::single("sheet.glb", source);
        let conversion = convert(&upload, &Options::default(), &Limits::default(), &Unwatched).unwrap();
        let glb = conversion.files.iter().find(|file| file.path == "asset.glb").unwrap().bytes.clone();
        validator::expect_valid(name, &glb, true);
        let back = read(&Upload::single("asset.glb", glb), &Limits::default(), &Unwatched).unwrap();
        let required = back.document.json["extensionsRequired"].as_array().cloned().unwrap_or_default();
        assert_eq!(required, Vec::from_iter(left.map(Value::from)), "{name}");
        let most = back.meshes[0].primitives[0].positions.iter().copied().reduce(glam::Vec3::max).unwrap();
        assert_eq!(most, glam::Vec3::new(800.0, 800.0, 160.0));
    }
}

/// The quad in its stream. The texture is 32x16 in ETC1S, made by the reference encoder for the reader's tests.
fn streamed(texture: &[u8]) -> Vec<u8> {
    const NAMES: [&str; 2] = ["KHR_draco_mesh_compression", "KHR_texture_basisu"];
    let digits: Vec<u8> =
        STREAM.chars().filter_map(|digit| digit.to_digit(16)).map(|digit| digit as u8).collect();
    let mut bin: Vec<u8> = digits.chunks(2).map(|pair| pair[0] * 16 + pair[1]).collect();
    let stream_bytes = bin.len();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let image = json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": texture.len() });
    bin.extend(texture);
    let accessor =
        |component: u32, kind: &str| json!({ "componentType": component, "count": 4, "type": kind });
    let mut accessors = vec![accessor(5126, "VEC3"), accessor(5126, "VEC3"), accessor(5126, "VEC2")];
    accessors[0]["min"] = json!([0, 0, 0]);
    accessors[0]["max"] = json!([1, 1, 0.5]);
    accessors.push(json!({ "componentType": 5123, "count": 6, "type": "SCALAR" }));
    let attributes = json!({ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 });
    let json = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": NAMES, "extensionsRequired": NAMES,
        "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{
            "attributes": attributes, "indices": 3, "material": 0,
            "extensions": { NAMES[0]: { "bufferView": 0, "attributes": attributes } }
        }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "extensions": { NAMES[1]: { "source": 0 } } }],
        "images": [{ "bufferView": 1, "mimeType": "image/ktx2" }],
        "accessors": accessors,
        "bufferViews": [{ "buffer": 0, "byteLength": stream_bytes }, image],
        "buffers": [{ "byteLength": bin.len() }],
    });
    container(&json, &bin)
}

#[test]
fn a_draco_stream_with_a_basis_texture_converts_to_a_plain_valid_file() {
    let texture = include_bytes!("../../core/src/read/tests/basis/etc1s.ktx2");
    let upload = Upload::single("quad.glb", streamed(texture));
    let conversion = convert(&upload, &Options::default(), &Limits::default(), &Unwatched).unwrap();
    let glb = conversion.files.iter().find(|file| file.path == "asset.glb").unwrap().bytes.clone();
    validator::expect_valid("quad", &glb, true);
    let back = read(&Upload::single("asset.glb", glb), &Limits::default(), &Unwatched).unwrap();
    let json = &back.document.json;
    assert!(json.get("extensionsRequired").is_none());
    assert!(back.document.encoded_images.iter().all(|image| image.media_type == "image/png"));
    let corners = &back.meshes[0].primitives[0].positions;
    let most = corners.iter().copied().reduce(glam::Vec3::max).unwrap();
    // Half a step of 12 bits.
    assert!(most.distance(glam::Vec3::new(1.0, 1.0, 0.5)) < 1.0 / 4095.0, "{most}");
}
