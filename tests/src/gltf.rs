//! Small glTF files, put together by hand.

use std::io::Cursor;

use image::{ImageFormat, RgbImage};
use serde_json::{Value, json};

/// A file in the making: one mesh at one node.
pub struct Gltf {
    pub json: Value,
    bin: Vec<u8>,
}

impl Default for Gltf {
    fn default() -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [] }], "bufferViews": [], "accessors": [],
        });
        Self { json, bin: Vec::new() }
    }
}

impl Gltf {
    fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    /// Adds elements of a component type; `normalized` where it is a whole one of colors.
    pub fn accessor(&mut self, kind: &str, component: u32, bytes: &[u8], normalized: bool) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let size = match component {
            5121 => 1,
            5123 => 2,
            _ => 4,
        };
        let view = self.view(bytes);
        let mut accessor = json!({
            "bufferView": view, "componentType": component, "count": bytes.len() / (width * size), "type": kind
        });
        if normalized {
            accessor["normalized"] = json!(true);
        }
        self.push("accessors", accessor)
    }

    pub fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.accessor(kind, 5126, &bytes, false)
    }

    pub fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let accessor = self.floats("VEC3", positions.as_flattened());
        let bound = |pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|k| positions.iter().map(|position| position[k]).reduce(pick).unwrap_or(0.0))
        };
        self.json["accessors"][accessor]["min"] = json!(bound(f32::min));
        self.json["accessors"][accessor]["max"] = json!(bound(f32::max));
        accessor
    }

    pub fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor("SCALAR", 5125, &bytes, false)
    }

    /// Adds a texture of a picture.
    pub fn texture(&mut self, picture: &RgbImage) -> usize {
        let mut png = Cursor::new(Vec::new());
        picture.write_to(&mut png, ImageFormat::Png).expect("a PNG");
        let view = self.view(png.get_ref());
        let image = self.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        self.push("textures", json!({ "source": image }))
    }

    pub fn material(&mut self, material: Value) -> usize {
        self.push("materials", material)
    }

    pub fn primitive(&mut self, primitive: Value) -> &mut Value {
        let primitives = self.json["meshes"][0]["primitives"].as_array_mut().expect("a list");
        primitives.push(primitive);
        primitives.last_mut().expect("one was added")
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        container(&json, &self.bin)
    }
}

/// A GLB of its two chunks.
pub fn container(json: &Value, bin: &[u8]) -> Vec<u8> {
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
