//! A model packed by meshoptimizer, quantized, with a WebP texture: converted, and the file judged by the Khronos
//! validator.

use std::ffi::c_void;
use std::io::Cursor;

use meshcolor::pipeline::{Options, convert};
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use meshcolor_tests::validator;
use meshopt::ffi;
use serde_json::{Value, json};

const SIDE: usize = 9;
const COUNT: usize = SIDE * SIDE;
const REQUIRED: [&str; 3] = ["KHR_mesh_quantization", "EXT_meshopt_compression", "EXT_texture_webp"];

/// Vertices as the extension packs them, in the encoder's version 0.
fn packed_vertices(bytes: &[u8], stride: usize) -> Vec<u8> {
    let count = bytes.len() / stride;
    // SAFETY: `bytes` has `count` elements of `stride` bytes, `packed` as many bytes as the encoder asks for.
    unsafe {
        let mut packed = vec![0; ffi::meshopt_encodeVertexBufferBound(count, stride)];
        let (target, vertices) = (packed.as_mut_ptr(), bytes.as_ptr().cast::<c_void>());
        let length =
            ffi::meshopt_encodeVertexBufferLevel(target, packed.len(), vertices, count, stride, 2, 0);
        packed.truncate(length);
        packed
    }
}

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
        add(packed_vertices(bytes, stride), "ATTRIBUTES", stride, COUNT);
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

fn container(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, pad, data) in [(b"JSON", b' ', json.to_string().as_bytes()), (b"BIN\0", 0, bin)] {
        let length = data.len().next_multiple_of(4);
        body.extend((length as u32).to_le_bytes());
        body.extend_from_slice(kind);
        body.extend_from_slice(data);
        body.resize(body.len() + length - data.len(), pad);
    }
    [b"glTF\x02\0\0\0", &(12 + body.len() as u32).to_le_bytes()[..], &body].concat()
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
