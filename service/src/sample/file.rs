//! The sample as a GLB: one mesh, one material, two images.

use meshcolor::image::Image;
use serde_json::{Value, json};

use super::shape::{Shape, Vertex, triangles};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;

/// The binary chunk with what points into it.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

pub fn glb(shape: &Shape, color: &Image, normals: &Image) -> Vec<u8> {
    let vertices: Vec<&Vertex> = shape.islands.iter().flat_map(|island| &island.vertices).collect();
    let mut binary = Binary::default();
    let position = binary.floats("VEC3", vertices.iter().map(|vertex| vertex.position.to_array()));
    let least = vertices.iter().map(|vertex| vertex.position).reduce(glam::Vec3::min).unwrap_or_default();
    let most = vertices.iter().map(|vertex| vertex.position).reduce(glam::Vec3::max).unwrap_or_default();
    binary.accessors[position]["min"] = json!(least.to_array().map(f64::from));
    binary.accessors[position]["max"] = json!(most.to_array().map(f64::from));
    let normal = binary.floats("VEC3", vertices.iter().map(|vertex| vertex.normal.to_array()));
    let tangent = binary.floats("VEC4", vertices.iter().map(|vertex| vertex.tangent.to_array()));
    let uv = binary.floats("VEC2", vertices.iter().map(|vertex| vertex.uv.to_array()));
    let indices = binary.indices(shape);
    let images = [("knot color", color), ("knot normals", normals)].map(|(name, image)| {
        let view = binary.view(&png(image), None);
        json!({ "name": name, "mimeType": "image/png", "bufferView": view })
    });
    let json = json!({
        "asset": { "version": "2.0", "generator": "meshcolor demo" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "knot", "mesh": 0 }],
        "meshes": [{ "name": "knot", "primitives": [{
            "attributes": { "POSITION": position, "NORMAL": normal, "TANGENT": tangent, "TEXCOORD_0": uv },
            "indices": indices,
            "material": 0
        }] }],
        "materials": [{
            "name": "agate",
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": 0 }, "metallicFactor": 0.0, "roughnessFactor": 0.35
            },
            "normalTexture": { "index": 1 }
        }],
        "textures": [{ "source": 0, "sampler": 0 }, { "source": 1, "sampler": 0 }],
        "samplers": [{ "magFilter": 9729, "minFilter": 9987 }],
        "images": images,
        "accessors": binary.accessors,
        "bufferViews": binary.views,
        "buffers": [{ "byteLength": binary.bytes.len() }],
    });
    container(&json, binary.bytes)
}

impl Binary {
    /// Every view starts at a multiple of four bytes.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        pad(&mut self.bytes, 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn floats<const N: usize>(&mut self, kind: &str, values: impl Iterator<Item = [f32; N]>) -> usize {
        let bytes: Vec<u8> = values.flatten().flat_map(f32::to_le_bytes).collect();
        let count = bytes.len() / (4 * N);
        let view = self.view(&bytes, Some(34962));
        self.accessors
            .push(json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    fn indices(&mut self, shape: &Shape) -> usize {
        let mut bytes = Vec::new();
        let mut first = 0;
        for island in &shape.islands {
            for index in triangles().flatten() {
                bytes.extend_from_slice(&((first + index) as u16).to_le_bytes());
            }
            first += island.vertices.len();
        }
        let view = self.view(&bytes, Some(34963));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_SHORT, "count": bytes.len() / 2, "type": "SCALAR"
        }));
        self.accessors.len() - 1
    }
}

fn png(image: &Image) -> Vec<u8> {
    // The image is made here, with as many codes as its size says, which is all that can fail.
    meshcolor::write::png(image).unwrap_or_default()
}

fn container(json: &Value, mut binary: Vec<u8>) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    pad(&mut text, b' ');
    pad(&mut binary, 0);
    let mut glb = b"glTF".to_vec();
    let total = 12 + 8 + text.len() + 8 + binary.len();
    for word in [2, total as u32, text.len() as u32] {
        glb.extend_from_slice(&word.to_le_bytes());
    }
    glb.extend_from_slice(b"JSON");
    glb.extend_from_slice(&text);
    glb.extend_from_slice(&(binary.len() as u32).to_le_bytes());
    glb.extend_from_slice(b"BIN\0");
    glb.extend_from_slice(&binary);
    glb
}

fn pad(bytes: &mut Vec<u8>, with: u8) {
    bytes.resize(bytes.len().div_ceil(4) * 4, with);
}
