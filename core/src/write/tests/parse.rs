//! A small reader of GLB files for tests, for what the writer writes: it trusts its input.

use glam::{Vec2, Vec3, Vec4};
use serde_json::Value;

use crate::asset::{Asset, Attribute, Document, EncodedImage, Face, Material, Mesh, MorphTarget, Primitive};
use crate::image::{Image, Pixels};

/// JSON and binary chunk, with the container's own rules checked.
pub fn split(glb: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(&glb[..4], b"glTF");
    assert_eq!(word(4), 2);
    assert_eq!(word(8), glb.len());
    let json_bytes = word(12);
    assert_eq!((json_bytes % 4, &glb[16..20]), (0, &b"JSON"[..]));
    let json = serde_json::from_slice(&glb[20..20 + json_bytes]).unwrap();
    let bin = 20 + json_bytes;
    if bin == glb.len() {
        return (json, Vec::new());
    }
    assert_eq!((word(bin) % 4, &glb[bin + 4..bin + 8]), (0, &b"BIN\0"[..]));
    assert_eq!(bin + 8 + word(bin), glb.len());
    (json, glb[bin + 8..].to_vec())
}

/// The asset of a file with triangles and points, tight or strided accessors.
pub fn asset(glb: &[u8]) -> Asset {
    let (json, bin) = split(glb);
    let list = |name: &str| json[name].as_array().cloned().unwrap_or_default();
    let encoded_images: Vec<EncodedImage> = list("images").iter().map(|i| encoded(&json, &bin, i)).collect();
    let meshes = list("meshes");
    let meshes = meshes.iter().map(|mesh| Mesh {
        name: String::new(),
        primitives: mesh["primitives"]
            .as_array()
            .unwrap()
            .iter()
            .map(|p| primitive(&json, &bin, p))
            .collect(),
    });
    Asset {
        meshes: meshes.collect(),
        images: encoded_images.iter().map(|file| decoded(&file.bytes)).collect(),
        materials: list("materials").iter().map(|_| Material::default()).collect(),
        document: Document { encoded_images, buffers: vec![bin.clone()], json },
        ..Asset::default()
    }
}

fn encoded(json: &Value, bin: &[u8], image: &Value) -> EncodedImage {
    EncodedImage {
        media_type: image["mimeType"].as_str().unwrap().to_owned(),
        bytes: view(json, bin, image["bufferView"].as_u64().unwrap() as usize).to_vec(),
    }
}

pub fn decoded(png: &[u8]) -> Image {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    bytes.truncate(info.buffer_size());
    let pixels = match info.bit_depth {
        png::BitDepth::Sixteen => {
            Pixels::U16(bytes.chunks_exact(2).map(|code| u16::from_be_bytes([code[0], code[1]])).collect())
        }
        _ => Pixels::U8(bytes),
    };
    let components = info.color_type.samples() as u8;
    Image { width: info.width, height: info.height, components, pixels }
}

fn view<'b>(json: &Value, bin: &'b [u8], number: usize) -> &'b [u8] {
    let view = &json["bufferViews"][number];
    let start = view["byteOffset"].as_u64().unwrap_or(0) as usize;
    &bin[start..start + view["byteLength"].as_u64().unwrap() as usize]
}

/// An accessor's elements, tight.
pub fn attribute(json: &Value, bin: &[u8], semantic: &str, number: usize) -> Attribute {
    let accessor = &json["accessors"][number];
    let component_type = accessor["componentType"].as_u64().unwrap() as u32;
    let kind = accessor["type"].as_str().unwrap().to_owned();
    let components = match kind.as_str() {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        other => panic!("{other}"),
    };
    let size = components * [1, 1, 2, 2, 0, 4, 4][component_type as usize - 5120];
    let count = accessor["count"].as_u64().unwrap() as usize;
    let bytes = match accessor["bufferView"].as_u64() {
        None => vec![0; size * count],
        Some(number) => {
            let stride = json["bufferViews"][number as usize]["byteStride"].as_u64().unwrap_or(size as u64);
            let start = accessor["byteOffset"].as_u64().unwrap_or(0) as usize;
            let bytes = &view(json, bin, number as usize)[start..];
            (0..count).flat_map(|i| bytes[i * stride as usize..][..size].to_vec()).collect()
        }
    };
    let normalized = accessor["normalized"].as_bool().unwrap_or(false);
    Attribute { semantic: semantic.to_owned(), component_type, kind, normalized, element_bytes: size, bytes }
}

fn floats<const N: usize>(attribute: &Attribute) -> Vec<[f32; N]> {
    assert_eq!((attribute.component_type, attribute.element_bytes), (5126, 4 * N));
    let value = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
    attribute
        .bytes
        .chunks_exact(4 * N)
        .map(|e| std::array::from_fn(|k| value(&e[4 * k..4 * k + 4])))
        .collect()
}

fn primitive(json: &Value, bin: &[u8], source: &Value) -> Primitive {
    let mut primitive = Primitive {
        material: source["material"].as_u64().map(|material| material as usize),
        ..Primitive::default()
    };
    for (name, number) in source["attributes"].as_object().unwrap() {
        let attribute = attribute(json, bin, name, number.as_u64().unwrap() as usize);
        match name.as_str() {
            "POSITION" => primitive.positions = floats(&attribute).into_iter().map(Vec3::from).collect(),
            "NORMAL" => primitive.normals = floats(&attribute).into_iter().map(Vec3::from).collect(),
            "TANGENT" => primitive.tangents = floats(&attribute).into_iter().map(Vec4::from).collect(),
            _ if name.starts_with("TEXCOORD_") => {
                primitive.texcoords.push(floats(&attribute).into_iter().map(Vec2::from).collect());
            }
            _ => primitive.attributes.push(attribute),
        }
    }
    for target in source["targets"].as_array().into_iter().flatten() {
        let attributes = target.as_object().unwrap().iter();
        let attributes = attributes.map(|(name, n)| attribute(json, bin, name, n.as_u64().unwrap() as usize));
        primitive.targets.push(MorphTarget { attributes: attributes.collect() });
    }
    if source["mode"].as_u64().unwrap_or(4) == 4 {
        let indices: Vec<u32> = match source["indices"].as_u64() {
            None => (0..primitive.positions.len() as u32).collect(),
            Some(number) => {
                let indices = attribute(json, bin, "", number as usize);
                let bytes = indices.bytes.chunks_exact(indices.element_bytes);
                bytes.map(|b| b.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))).collect()
            }
        };
        primitive.faces = indices.chunks_exact(3).map(|c| Face::triangle([c[0], c[1], c[2]])).collect();
    }
    primitive
}
