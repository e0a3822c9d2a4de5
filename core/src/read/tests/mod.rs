//! Cases of reading, built in code: [`Gltf`] makes small documents, each test bends one thing.

mod accessors;
mod archives;
mod basis;
mod compressed;
mod containers;
mod draco;
mod images;
mod materials;
mod models;
mod mutations;
mod ngons;
mod obj;
mod openexr;
mod ply;
mod primitives;
mod ptex;
mod quantized;
mod scenes;
mod uris;
mod webp;

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::{Limits, MemoryFiles, Upload, read};
use crate::asset::Asset;
use crate::error::{Error, ErrorCode, Result};
use crate::watch::Unwatched;

/// A document under construction, with one buffer.
#[derive(Clone)]
struct Gltf {
    json: Value,
    bin: Vec<u8>,
}

impl Gltf {
    /// One triangle in one mesh at one node; accessor 0 is POSITION.
    fn triangle() -> Self {
        let mut gltf = Self {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0,
                "scenes": [{ "nodes": [0] }],
                "nodes": [{ "mesh": 0 }],
                "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
                "buffers": [{}], "bufferViews": [], "accessors": [],
            }),
            bin: Vec::new(),
        };
        gltf.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        gltf
    }

    /// The same with a texture on it: image 0 is `bytes`, in a view of the buffer.
    fn textured(bytes: &[u8]) -> Self {
        let mut gltf = Self::triangle();
        let uv = gltf.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        let view = gltf.view(bytes);
        gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
        gltf.primitive()["material"] = json!(0);
        gltf.json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        gltf.json["textures"] = json!([{ "source": 0 }]);
        gltf.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
        gltf
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        self.push("accessors", accessor)
    }

    fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.accessor(kind, 5126, numbers.len() / width, &bytes)
    }

    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"][0].get("byteLength").is_none() {
            json["buffers"][0]["byteLength"] = json!(self.bin.len());
        }
        glb(&[(b"JSON", json.to_string().as_bytes()), (b"BIN\0", &self.bin)])
    }

    fn read(&self) -> Result<Asset> {
        read_bytes(self.glb())
    }

    fn refused(&self, code: ErrorCode, pointer: &str) -> Error {
        let error = self.read().expect_err("must be refused");
        assert_eq!((error.code, error.pointer.as_deref()), (code, Some(pointer)), "{error}");
        error
    }
}

/// A GLB of these chunks, padded.
fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, data) in chunks {
        let length = data.len().next_multiple_of(4);
        body.extend((length as u32).to_le_bytes());
        body.extend_from_slice(*kind);
        body.extend_from_slice(data);
        body.resize(body.len() + length - data.len(), if *kind == b"JSON" { b' ' } else { 0 });
    }
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((12 + body.len() as u32).to_le_bytes());
    bytes.extend(body);
    bytes
}

fn read_bytes(bytes: Vec<u8>) -> Result<Asset> {
    read(&Upload::single("model", bytes), &Limits::default(), &Unwatched)
}

fn read_limited(bytes: Vec<u8>, limits: Limits) -> Result<Asset> {
    read(&Upload::single("model", bytes), &limits, &Unwatched)
}

/// An upload of these files; the first is the model.
fn read_files(files: &[(&str, &[u8])]) -> Result<Asset> {
    let map: BTreeMap<String, Vec<u8>> =
        files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec())).collect();
    let upload = Upload { main: files[0].0.to_owned(), files: Box::new(MemoryFiles(map)) };
    read(&upload, &Limits::default(), &Unwatched)
}

/// A PNG file of one color.
fn png(width: u32, height: u32) -> Vec<u8> {
    let picture = image::RgbImage::from_pixel(width, height, image::Rgb([10, 20, 30]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}
