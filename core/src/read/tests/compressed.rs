//! Packed buffer views: what meshoptimizer's encoders make of a model reads as the model, and hostile ones are refused.

use ::meshopt::ffi;

use super::*;
use crate::asset::Primitive;
use crate::vertex_codec::{packed_attributes, packed_indices};

const EXTENSION: &str = "EXT_meshopt_compression";
const SIDE: usize = 20;
const COUNT: usize = SIDE * SIDE;

fn attributes(bytes: &[u8], stride: usize) -> Vec<u8> {
    packed_attributes(bytes, stride).unwrap()
}

fn triangles(indices: &[u32]) -> Vec<u8> {
    // SAFETY: `packed` has as many bytes as the encoder asks for.
    unsafe {
        let mut packed = vec![0; ffi::meshopt_encodeIndexBufferBound(indices.len(), COUNT)];
        let (target, source) = (packed.as_mut_ptr(), indices.as_ptr());
        let length = ffi::meshopt_encodeIndexBuffer(target, packed.len(), source, indices.len());
        packed.truncate(length);
        packed
    }
}

fn sequence(indices: &[u32]) -> Vec<u8> {
    packed_indices(indices).unwrap()
}

fn le(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// What a grid's vertices have: three floats, three of unit length, two.
struct Grid {
    positions: Vec<f32>,
    normals: Vec<f32>,
    texcoords: Vec<f32>,
    indices: Vec<u32>,
}

fn grid() -> Grid {
    let mut grid = Grid { positions: vec![], normals: vec![], texcoords: vec![], indices: vec![] };
    for vertex in 0..COUNT {
        let (x, y) = ((vertex % SIDE) as f32, (vertex / SIDE) as f32);
        grid.positions.extend([x, y, (x * 0.7).sin()]);
        grid.normals.extend(glam::Vec3::new((y * 0.3).cos(), (x * 0.3).sin(), 1.0).normalize().to_array());
        grid.texcoords.extend([x / SIDE as f32, y / SIDE as f32]);
    }
    for cell in (0..COUNT - SIDE).filter(|cell| cell % SIDE != SIDE - 1) {
        let [a, b, c, d] = [cell, cell + 1, cell + SIDE, cell + SIDE + 1].map(|vertex| vertex as u32);
        grid.indices.extend([a, b, d, a, d, c]);
    }
    grid
}

/// A document whose buffer 1 is a fallback.
struct Compressed {
    gltf: Gltf,
    fallback_bytes: usize,
}

impl Compressed {
    fn new() -> Self {
        let mut gltf = Gltf::triangle();
        gltf.bin.clear();
        for list in ["accessors", "bufferViews"] {
            gltf.json[list] = json!([]);
        }
        gltf.json["extensionsUsed"] = json!([EXTENSION]);
        gltf.json["extensionsRequired"] = json!([EXTENSION]);
        let fallback = json!({ "byteLength": 0, "extensions": { EXTENSION: { "fallback": true } } });
        gltf.push("buffers", fallback);
        gltf.primitive()["mode"] = json!(0);
        Self { gltf, fallback_bytes: 0 }
    }

    /// An accessor of a packed view.
    fn packed(&mut self, packed: &[u8], form: (&str, &str, usize), accessor: (&str, u32, usize)) -> usize {
        let ((mode, filter, stride), (kind, component, count)) = (form, accessor);
        let view = self.gltf.view(packed);
        let offset = self.gltf.json["bufferViews"][view]["byteOffset"].clone();
        let mut json = json!({
            "buffer": 1, "byteOffset": self.fallback_bytes, "byteLength": count * stride,
            "extensions": { EXTENSION: {
                "buffer": 0, "byteOffset": offset, "byteLength": packed.len(), "byteStride": stride,
                "count": count, "mode": mode, "filter": filter,
            } }
        });
        if mode == "ATTRIBUTES" {
            json["byteStride"] = json!(stride);
        }
        self.gltf.json["bufferViews"][view] = json;
        self.fallback_bytes += count * stride;
        self.gltf.json["buffers"][1]["byteLength"] = json!(self.fallback_bytes);
        let accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        self.gltf.push("accessors", accessor)
    }

    /// Floats of an attribute.
    fn floats(&mut self, semantic: &str, numbers: &[f32], width: usize) {
        let form = ("ATTRIBUTES", "NONE", 4 * width);
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][width];
        let index =
            self.packed(&attributes(&le(numbers), 4 * width), form, (kind, 5126, numbers.len() / width));
        self.gltf.primitive()["attributes"][semantic] = json!(index);
    }

    fn grid(mode: &str, index_bytes: usize) -> Self {
        let grid = grid();
        let mut this = Self::new();
        this.floats("POSITION", &grid.positions, 3);
        this.floats("NORMAL", &grid.normals, 3);
        this.floats("TEXCOORD_0", &grid.texcoords, 2);
        let packed = if mode == "TRIANGLES" { triangles(&grid.indices) } else { sequence(&grid.indices) };
        let component = if index_bytes == 2 { 5123 } else { 5125 };
        let index =
            this.packed(&packed, (mode, "NONE", index_bytes), ("SCALAR", component, grid.indices.len()));
        this.gltf.primitive()["indices"] = json!(index);
        this.gltf.primitive()["mode"] = json!(4);
        this
    }

    fn extension(&mut self, view: usize) -> &mut Value {
        &mut self.gltf.json["bufferViews"][view]["extensions"][EXTENSION]
    }

    fn primitive(&self) -> Primitive {
        self.gltf.read().unwrap().meshes.remove(0).primitives.remove(0)
    }
}

pub(super) fn seed() -> Vec<u8> {
    Compressed::grid("TRIANGLES", 2).gltf.glb()
}

/// The grid without any extension.
fn plain() -> Primitive {
    let grid = grid();
    let mut gltf = Gltf::triangle();
    let indices: Vec<u8> = grid.indices.iter().flat_map(|index| index.to_le_bytes()).collect();
    let attributes = [("POSITION", "VEC3", &grid.positions), ("NORMAL", "VEC3", &grid.normals)];
    for (semantic, kind, numbers) in attributes.into_iter().chain([("TEXCOORD_0", "VEC2", &grid.texcoords)]) {
        let index = gltf.floats(kind, numbers);
        gltf.primitive()["attributes"][semantic] = json!(index);
    }
    let index = gltf.accessor("SCALAR", 5125, grid.indices.len(), &indices);
    gltf.primitive()["indices"] = json!(index);
    gltf.read().unwrap().meshes.remove(0).primitives.remove(0)
}

/// The corners of each face from its least vertex on: the codec of triangles turns them.
fn turned(primitive: &Primitive) -> Vec<Vec<u32>> {
    let turn = |corners: &[u32]| {
        let least = (0..corners.len()).min_by_key(|k| corners[*k]).unwrap();
        (0..corners.len()).map(|k| corners[(least + k) % corners.len()]).collect()
    };
    primitive.faces.iter().map(|face| turn(face.corners())).collect()
}

#[test]
fn packed_views_read_as_plain_ones() {
    let plain = plain();
    for (mode, index_bytes) in [("TRIANGLES", 2), ("TRIANGLES", 4), ("INDICES", 2), ("INDICES", 4)] {
        let compressed = Compressed::grid(mode, index_bytes);
        let asset = compressed.gltf.read().unwrap();
        let read = &asset.meshes[0].primitives[0];
        assert_eq!(read.positions, plain.positions);
        assert_eq!(read.normals, plain.normals);
        assert_eq!(read.texcoords, plain.texcoords);
        assert_eq!(turned(read), turned(&plain), "{mode} {index_bytes}");
        assert_eq!(asset.warnings, []);
        // The document is one without packed views.
        let document = &asset.document;
        assert!(!document.json["bufferViews"].to_string().contains(EXTENSION));
        assert!(!document.json["buffers"].to_string().contains(EXTENSION));
        assert_eq!(document.json["buffers"].as_array().unwrap().len(), document.buffers.len());
        let view = &document.json["bufferViews"][0];
        let buffer = view["buffer"].as_u64().unwrap() as usize;
        assert_eq!(document.buffers[buffer], le(&grid().positions));
    }
}

#[test]
fn octahedral_normals_are_within_their_step() {
    let grid = grid();
    let data: Vec<f32> = grid.normals.chunks(3).flat_map(|n| [n[0], n[1], n[2], 0.0]).collect();
    // Codes of 8 and 16 bits; the codec rounds twice, and each component of the octahedron moves three of the vector.
    for (stride, bits, component, step) in [(4, 8, 5120, 1.0 / 127.0), (8, 16, 5122, 1.0 / 32767.0)] {
        let mut filtered = vec![0u64; (COUNT * stride).div_ceil(8)];
        // SAFETY: the filter writes `COUNT` elements of `stride` bytes and reads four floats for each.
        unsafe {
            ffi::meshopt_encodeFilterOct(filtered.as_mut_ptr().cast(), COUNT, stride, bits, data.as_ptr());
        }
        let bytes: Vec<u8> = filtered.iter().flat_map(|word| word.to_ne_bytes()).collect();
        let mut this = Compressed::new();
        this.floats("POSITION", &grid.positions, 3);
        let form = ("ATTRIBUTES", "OCTAHEDRAL", stride);
        let index =
            this.packed(&attributes(&bytes[..COUNT * stride], stride), form, ("VEC3", component, COUNT));
        this.gltf.json["accessors"][index]["normalized"] = json!(true);
        this.gltf.primitive()["attributes"]["NORMAL"] = json!(index);
        this.gltf.json["extensionsUsed"] = json!([EXTENSION, "KHR_mesh_quantization"]);
        let read = this.primitive().normals;
        for (normal, exact) in read.iter().zip(grid.normals.chunks(3)) {
            let worst = (*normal - glam::Vec3::from_slice(exact)).abs().max_element();
            assert!(worst <= 2.0 * step, "{stride}: {worst}");
        }
    }
}

#[test]
fn rotations_and_exponents_are_within_their_step() {
    let grid = grid();
    let turns: Vec<f32> =
        (0..COUNT).flat_map(|k| glam::Quat::from_rotation_z(k as f32 * 0.01).to_array()).collect();
    let mut rotations = vec![0u64; COUNT];
    let mut exponents = vec![0u32; COUNT * 3];
    let mode = ffi::meshopt_EncodeExpMode_meshopt_EncodeExpSeparate;
    // SAFETY: the filters write `COUNT` elements of 8 and of 12 bytes and read four and three floats for each.
    unsafe {
        ffi::meshopt_encodeFilterQuat(rotations.as_mut_ptr().cast(), COUNT, 8, 16, turns.as_ptr());
        let (target, source) = (exponents.as_mut_ptr().cast(), grid.positions.as_ptr());
        ffi::meshopt_encodeFilterExp(target, COUNT, 12, 15, source, mode);
    }
    let rotations: Vec<u8> = rotations.iter().flat_map(|word| word.to_ne_bytes()).collect();
    let exponents: Vec<u8> = exponents.iter().flat_map(|word| word.to_ne_bytes()).collect();
    let mut this = Compressed::new();
    let form = ("ATTRIBUTES", "EXPONENTIAL", 12);
    let index = this.packed(&attributes(&exponents, 12), form, ("VEC3", 5126, COUNT));
    this.gltf.primitive()["attributes"]["POSITION"] = json!(index);
    let form = ("ATTRIBUTES", "QUATERNION", 8);
    let index = this.packed(&attributes(&rotations, 8), form, ("VEC4", 5122, COUNT));
    this.gltf.primitive()["attributes"]["_TURN"] = json!(index);
    let read = this.primitive();
    for (position, exact) in read.positions.iter().zip(grid.positions.chunks(3)) {
        for k in 0..3 {
            // Fifteen bits with the sign.
            assert!((position[k] - exact[k]).abs() <= exact[k].abs() / f32::from(1u16 << 13), "{position}");
        }
    }
    for (turn, exact) in read.attributes[0].bytes.chunks(8).zip(turns.chunks(4)) {
        let code = |k: usize| f32::from(i16::from_le_bytes([turn[2 * k], turn[2 * k + 1]])) / 32767.0;
        let dot: f32 = (0..4).map(|k| code(k) * exact[k]).sum();
        assert!((dot.abs() - 1.0).abs() < 1e-3, "{dot}");
    }
}

#[test]
fn lies_about_packed_views_are_refused() {
    let cases: &[(usize, &str, Value)] = &[
        (0, "count", json!(0)),
        (0, "count", json!(COUNT + 1)),
        (0, "count", json!(4_000_000_000u64)),
        (0, "count", json!(u64::MAX)),
        (0, "count", json!(-1)),
        (0, "byteStride", json!(0)),
        (0, "byteStride", json!(10)),
        (0, "byteStride", json!(16)),
        (0, "byteStride", json!(260)),
        (0, "byteStride", json!(u64::MAX)),
        (0, "byteLength", json!(0)),
        (0, "byteLength", json!(40)),
        (0, "byteLength", json!(u64::MAX)),
        (0, "byteOffset", json!(1)),
        (0, "byteOffset", json!(u64::MAX)),
        (0, "buffer", json!(1)),
        (0, "buffer", json!(2)),
        (0, "mode", json!("TRIANGLES")),
        (0, "mode", json!("POINTS")),
        (0, "mode", Value::Null),
        (0, "filter", json!("OCTAHEDRAL")),
        (0, "filter", json!("QUATERNION")),
        (0, "filter", json!("COLOR")),
        (3, "filter", json!("EXPONENTIAL")),
        (3, "count", json!(2)),
        (3, "byteStride", json!(1)),
        (3, "byteStride", json!(4)),
        (3, "mode", json!("INDICES")),
        (3, "mode", json!("ATTRIBUTES")),
    ];
    for (view, key, value) in cases {
        let mut this = Compressed::grid("TRIANGLES", 2);
        this.extension(*view)[*key] = value.clone();
        let error = this.gltf.read().expect_err(key);
        assert_eq!(error.code, ErrorCode::InvalidModel, "{key} {value}: {error}");
        let pointer = error.pointer.as_deref().unwrap();
        assert!(pointer.starts_with(&format!("/bufferViews/{view}")), "{key} {value}: {error}");
    }
    let mut this = Compressed::grid("TRIANGLES", 2);
    this.gltf.json["bufferViews"][0]["byteStride"] = json!(16);
    this.gltf.refused(ErrorCode::InvalidModel, "/bufferViews/0");
}

/// A tiny file that asks for as much as its least packed form allows is refused by the limit, before memory is taken.
#[test]
fn counts_are_held_against_the_bytes_and_the_limits() {
    let mut this = Compressed::grid("TRIANGLES", 2);
    let huge = 1u64 << 40;
    this.extension(0)["count"] = json!(huge);
    this.gltf.json["bufferViews"][0]["byteLength"] = json!(huge * 12);
    this.gltf.json["buffers"][1]["byteLength"] = json!(huge * 16);
    let error = this.gltf.refused(ErrorCode::InvalidModel, &format!("/bufferViews/0/extensions/{EXTENSION}"));
    assert!(error.detail.contains("no less than"), "{error}");
    // A fallback takes no memory, whatever it says of its length.
    let mut this = Compressed::grid("TRIANGLES", 2);
    this.gltf.json["buffers"][1]["byteLength"] = json!(huge);
    assert!(this.gltf.read().is_ok());
    let glb = this.gltf.glb();
    let limits = |bytes| Limits { archive_bytes: bytes, ..Limits::default() };
    let error = read_limited(glb.clone(), limits(glb.len() as u64 + 100)).unwrap_err();
    assert_eq!(error.code, ErrorCode::ModelTooLarge, "{error}");
    assert_eq!(error.pointer.unwrap(), format!("/bufferViews/0/extensions/{EXTENSION}"));
}

#[test]
fn a_view_of_a_fallback_must_be_packed() {
    let mut this = Compressed::grid("TRIANGLES", 2);
    this.gltf.json["bufferViews"][1].as_object_mut().unwrap().remove("extensions");
    let error = this.gltf.refused(ErrorCode::InvalidModel, "/bufferViews/1");
    assert!(error.detail.contains("fallback"), "{error}");
    // A buffer that is no fallback has bytes.
    let mut this = Compressed::grid("TRIANGLES", 2);
    this.gltf.json["buffers"][1]["extensions"][EXTENSION]["fallback"] = json!(false);
    this.gltf.refused(ErrorCode::InvalidModel, "/buffers/1");
}

/// Every length and many bent bytes of the packed data alone: an error or other numbers, no more.
#[test]
fn bent_packed_bytes_never_end_the_process() {
    let plain = Compressed::grid("TRIANGLES", 2);
    for view in 0..4 {
        let at = plain.gltf.json["bufferViews"][view]["extensions"][EXTENSION].clone();
        let [offset, length] = ["byteOffset", "byteLength"].map(|key| at[key].as_u64().unwrap() as usize);
        for k in (0..length).step_by(3) {
            let mut bent = Compressed { gltf: plain.gltf.clone(), fallback_bytes: 0 };
            bent.extension(view)["byteLength"] = json!(k);
            assert_eq!(bent.gltf.read().unwrap_err().code, ErrorCode::InvalidModel, "{view}: {k} bytes");
            let mut bent = plain.gltf.clone();
            bent.bin[offset + k] ^= 0x55 ^ (k as u8);
            if let Err(error) = bent.read() {
                assert_eq!(error.code, ErrorCode::InvalidModel, "{view}: byte {k}: {error}");
            }
        }
    }
}
