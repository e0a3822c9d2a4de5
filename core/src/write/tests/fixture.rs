//! A source file with one of everything that the writer has to carry over, and conversions made up for it.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};

use super::parse;
use crate::asset::{Asset, Primitive, Slot};
use crate::finished::{
    Anchor, Coordinates, Finished, FinishedPrimitive, FinishedTexture, FinishedTriangle, Frame, PrimitiveCuts,
};
use crate::image::{Image, LevelRange, Pixels, Transfer};

/// Bytes with the accessors over them.
#[derive(Default)]
struct Store {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Store {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().div_ceil(4) * 4, 0);
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() }));
        self.bin.extend_from_slice(bytes);
        self.views.len() - 1
    }

    fn floats(&mut self, kind: &str, count: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.accessor(json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind }))
    }

    fn positions(&mut self, values: &[[f32; 3]]) -> usize {
        let number = self.floats("VEC3", values.len(), values.as_flattened());
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..3).map(|k| values.iter().map(|v| v[k]).reduce(pick).unwrap()).collect()
        };
        self.accessors[number]["min"] = json!(bound(f32::min));
        self.accessors[number]["max"] = json!(bound(f32::max));
        number
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.3]];

/// A quad of two triangles (with colors, joints, weights, a morph target and two sets of texture
/// coordinates), loose points of the same material, and a plain triangle of another; a skin, an
/// animation, a light, an unknown-free set of extensions.
pub fn source_glb() -> Vec<u8> {
    let mut store = Store::default();
    let position = store.positions(&CORNERS);
    let normal = store.floats("VEC3", 4, &[0.0, 0.0, 1.0].repeat(4));
    let tangent = store.floats("VEC4", 4, &[1.0, 0.0, 0.0, 1.0].repeat(4));
    let uv0 = store.floats("VEC2", 4, &[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
    let uv1 = store.floats("VEC2", 4, &[0.5, 0.5, 0.6, 0.5, 0.6, 0.6, 0.5, 0.6]);
    let color_view =
        store.view(&[[10u8, 20, 30, 0], [40, 50, 60, 0], [70, 80, 90, 0], [1, 2, 3, 0]].concat());
    store.views[color_view]["byteStride"] = 4.into();
    let color = store.accessor(json!({
        "bufferView": color_view, "componentType": 5121, "count": 4, "type": "VEC3", "normalized": true
    }));
    let joints_view = store.view(&[0u8; 16]);
    let joints = store
        .accessor(json!({ "bufferView": joints_view, "componentType": 5121, "count": 4, "type": "VEC4" }));
    let weights = store.floats("VEC4", 4, &[1.0, 0.0, 0.0, 0.0].repeat(4));
    let morph = store.positions(&CORNERS.map(|[x, y, _]| [0.1 * x, 0.2 * y, 0.3]));
    let morph_tangent = store.floats("VEC3", 4, &[0.0, 0.1, 0.0].repeat(4));
    let index_view = store.view(&[0u16, 1, 2, 0, 2, 3].map(u16::to_le_bytes).concat());
    let indices = store
        .accessor(json!({ "bufferView": index_view, "componentType": 5123, "count": 6, "type": "SCALAR" }));
    let inverse = store.floats("MAT4", 1, &glam::Mat4::IDENTITY.to_cols_array());
    let times = store.floats("SCALAR", 2, &[0.0, 1.0]);
    store.accessors[times]["min"] = json!([0.0]);
    store.accessors[times]["max"] = json!([1.0]);
    let moves = store.floats("VEC3", 2, &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let png = super::super::images::png(&noise(4, 4, 3, 7)).unwrap();
    let image_views = [store.view(&png), store.view(&png)];
    let json = json!({
        "asset": { "version": "2.0", "generator": "fixture" },
        "extensionsUsed": ["KHR_texture_transform", "KHR_materials_clearcoat", "KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point" }] } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "mesh": 0, "skin": 0, "extras": { "kept": [1, 2] } },
            { "name": "bone", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "mesh": 1 },
        ],
        "skins": [{ "joints": [1], "inverseBindMatrices": inverse }],
        "animations": [{
            "samplers": [{ "input": times, "output": moves }],
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } }]
        }],
        "materials": [
            {
                "name": "coat",
                "pbrMetallicRoughness": {
                    "baseColorTexture": {
                        "index": 0, "texCoord": 1,
                        "extensions": { "KHR_texture_transform": { "scale": [2.0, 2.0] } }
                    },
                    "metallicRoughnessTexture": { "index": 0 }
                },
                "normalTexture": { "index": 0, "scale": 0.5 },
                "occlusionTexture": { "index": 0, "strength": 0.7 },
                "extensions": { "KHR_materials_clearcoat": {
                    "clearcoatFactor": 0.5, "clearcoatTexture": { "index": 1, "texCoord": 1 }
                } }
            },
            { "name": "plain", "pbrMetallicRoughness": { "baseColorTexture": { "index": 1 } } }
        ],
        "textures": [{ "source": 0, "sampler": 0, "name": "old" }, { "source": 1, "sampler": 1 }],
        "samplers": [{ "wrapS": 33071 }, { "wrapS": 33648 }],
        "images": [
            { "bufferView": image_views[0], "mimeType": "image/png" },
            { "bufferView": image_views[1], "mimeType": "image/png" }
        ],
        "meshes": [
            {
                "weights": [0.5],
                "primitives": [
                    {
                        "attributes": {
                            "POSITION": position, "NORMAL": normal, "TANGENT": tangent, "TEXCOORD_0": uv0,
                            "TEXCOORD_1": uv1, "COLOR_0": color, "JOINTS_0": joints, "WEIGHTS_0": weights
                        },
                        "indices": indices,
                        "material": 0,
                        "targets": [{ "POSITION": morph, "TANGENT": morph_tangent }]
                    },
                    {
                        "attributes": {
                            "POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weights,
                            "TEXCOORD_0": uv0, "TEXCOORD_1": uv1
                        },
                        "mode": 0, "material": 0, "targets": [{ "POSITION": morph }]
                    }
                ]
            },
            { "primitives": [{
                "attributes": { "POSITION": position, "TEXCOORD_0": uv0 }, "indices": indices, "material": 1
            }] }
        ],
        "accessors": store.accessors,
        "bufferViews": store.views,
        "buffers": [{ "byteLength": store.bin.len() }],
    });
    container(&json, &store.bin)
}

pub fn container(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = serde_json::to_vec(json).unwrap();
    text.resize(text.len().div_ceil(4) * 4, b' ');
    let bin_bytes = bin.len().div_ceil(4) * 4;
    let mut glb = b"glTF".to_vec();
    for word in [2, (28 + text.len() + bin_bytes) as u32, text.len() as u32] {
        glb.extend(word.to_le_bytes());
    }
    glb.extend(b"JSON");
    glb.extend(text);
    glb.extend((bin_bytes as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bin);
    glb.resize(glb.len().div_ceil(4) * 4, 0);
    glb
}

/// An image of pseudo-random codes.
pub fn noise(width: u32, height: u32, components: u8, seed: u32) -> Image {
    let mut state = seed;
    let count = (width * height * u32::from(components)) as usize;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as u16
    };
    let pixels = if seed.is_multiple_of(2) {
        Pixels::U16((0..count).map(|_| next()).collect())
    } else {
        Pixels::U8((0..count).map(|_| next() as u8).collect())
    };
    Image { width, height, components, pixels }
}

fn texture(material: usize, slots: &[Slot], components: u8, seed: u32) -> FinishedTexture {
    let transfer = if slots[0].is_color() { Transfer::Srgb } else { Transfer::Linear };
    let levels = [(16, 8), (9, 5), (6, 4)].map(|(w, h)| noise(w, h, components, seed));
    FinishedTexture {
        materials: vec![material],
        part: 0,
        slots: slots.to_vec(),
        transfer,
        levels: levels.to_vec(),
        ranges: BTreeMap::new(),
        value_scale: None,
    }
}

/// Every triangle of the primitives with textured materials, at places of no meaning.
pub fn finished(asset: &Asset) -> Finished {
    let textures = vec![
        texture(0, &[Slot::BaseColor], 4, 3),
        texture(0, &[Slot::MetallicRoughness, Slot::Occlusion], 3, 6),
        texture(0, &[Slot::Normal], 3, 9),
    ];
    let piece = |source: &Primitive| {
        let triangles: Vec<_> = source
            .faces
            .iter()
            .enumerate()
            .map(|(number, face)| FinishedTriangle {
                vertices: [face.corners[0], face.corners[1], face.corners[2]],
                corners: [Vec2::ZERO, Vec2::new(3.5, 0.25), Vec2::new(1.0 / 3.0, 2.0)],
                anchor: Anchor::Offset(Vec2::new(0.5 + number as f32 * 0.125, 1.7)),
            })
            .collect();
        let frame = Frame { normal: Vec3::Y, tangent: Vec4::new(0.0, 0.6, 0.8, -1.0) };
        let mut bits = vec![0; triangles.len()];
        bits[0] = 0b101;
        FinishedPrimitive {
            mesh: 0,
            primitive: 0,
            material: 0,
            part: 0,
            coordinates: Coordinates::Scaled,
            frames: vec![[frame; 3]; triangles.len()],
            cuts: vec![PrimitiveCuts { texture: 1, bits }],
            triangles,
        }
    };
    Finished { primitives: vec![piece(&asset.meshes[0].primitives[0])], textures, ..Finished::default() }
}

pub fn converted() -> (Asset, Finished, Vec<u8>) {
    let asset = parse::asset(&source_glb());
    let finished = finished(&asset);
    let glb = super::super::glb(&asset, &finished, &crate::watch::Unwatched).unwrap().bytes;
    (asset, finished, glb)
}

/// The same with ranges in every texture: level 1 scaled, level 2 of half floats.
pub fn ranged() -> (Asset, Finished) {
    let asset = parse::asset(&source_glb());
    let mut finished = finished(&asset);
    for texture in &mut finished.textures {
        let scale = Vec4::new(1.5, 0.1, 7.0, 0.25);
        let bias = Vec4::new(-0.3, 0.7, 1e-3, -2.0);
        // What is not stored has no range.
        let range = match texture.levels[1].components {
            3 => LevelRange::Scaled16 {
                scale: scale.truncate().extend(1.0),
                bias: bias.truncate().extend(0.0),
            },
            _ => LevelRange::Scaled16 { scale, bias },
        };
        texture.ranges = BTreeMap::from([(1, range), (2, LevelRange::Float16)]);
        let [_, scaled, half] = texture.levels.as_mut_slice() else { panic!("three levels") };
        deepen(scaled, |code| code.wrapping_mul(4093));
        // The bits of a number under 2.
        deepen(half, |code| code & 0x3fff);
    }
    (asset, finished)
}

fn deepen(image: &mut Image, change: impl Fn(u16) -> u16) {
    let codes: Vec<u16> = match &image.pixels {
        Pixels::U8(codes) => codes.iter().map(|&code| u16::from(code)).collect(),
        Pixels::U16(codes) => codes.clone(),
        Pixels::F32(_) => panic!("made of codes"),
    };
    image.pixels = Pixels::U16(codes.into_iter().map(change).collect());
}
