//! The real binary as a child process, and a small model to send it.
#![allow(dead_code)]

use std::io::{BufRead, BufReader, Cursor};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

use serde_json::json;
use tempfile::TempDir;

pub fn binary() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_meshcolor"));
    // Settings of whoever runs the tests are not part of them.
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("MESHCOLOR_"))
    {
        command.env_remove(name);
    }
    command
}

pub fn run(arguments: &[&str]) -> Output {
    binary().args(arguments).stdin(Stdio::null()).output().unwrap()
}

/// Goes away with everything in it.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn root(&self) -> &Path {
        self.0.path()
    }

    pub fn path(&self, name: &str) -> String {
        self.root().join(name).to_str().unwrap().to_owned()
    }
}

/// A service that is killed when the test is done with it.
pub struct Service {
    pub child: Child,
    pub base: String,
}

impl Service {
    pub fn start(data: &Path, more: &[&str]) -> Self {
        let mut child = binary()
            .args(["serve", "--bind", "127.0.0.1:0", "--data"])
            .arg(data)
            .args(more)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let mut said = Vec::new();
        let base = loop {
            let Some(line) = lines.next() else { panic!("the service did not start: {said:#?}") };
            let line = line.unwrap();
            if let Some((_, base)) = line.split_once("meshcolor serves ") {
                break base.to_owned();
            }
            said.push(line);
        };
        // A full pipe would stop the service.
        std::thread::spawn(move || lines.for_each(drop));
        Self { child, base }
    }

    pub fn address(&self) -> &str {
        self.base.strip_prefix("http://").unwrap()
    }

    /// `kill -9`.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Two triangles that meet in an edge whose texture coordinates differ, with a texture of noise.
pub fn model(seed: u64, side: u32) -> Vec<u8> {
    let mut state = seed;
    let noise = image::RgbImage::from_fn(side, side, |_, _| {
        let [r, g, b, ..] = next(&mut state).to_le_bytes();
        image::Rgb([r, g, b])
    });
    let mut png = Cursor::new(Vec::new());
    noise.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let positions: [[f32; 3]; 6] =
        [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    let places: [[f32; 2]; 6] = [[0.1, 0.1], [0.4, 0.1], [0.1, 0.4], [0.6, 0.6], [0.9, 0.6], [0.6, 0.9]];
    let mut binary: Vec<u8> = positions.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    binary.extend(places.iter().flatten().flat_map(|value| value.to_le_bytes()));
    let image_start = binary.len();
    binary.extend(png.get_ref());
    let image_length = binary.len() - image_start;
    binary.resize(binary.len().next_multiple_of(4), 0);
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "source": 0 }],
        "images": [{ "bufferView": 2, "mimeType": "image/png" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 6, "type": "VEC2" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 72 },
            { "buffer": 0, "byteOffset": 72, "byteLength": 48 },
            { "buffer": 0, "byteOffset": image_start, "byteLength": image_length },
        ],
        "buffers": [{ "byteLength": binary.len() }],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((12 + 8 + text.len() + 8 + binary.len()).to_le_bytes()[..4].iter());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
        glb.extend(chunk.len().to_le_bytes()[..4].iter());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

/// The next number of a fixed sequence (splitmix64).
pub fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}
