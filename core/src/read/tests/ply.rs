//! PLY: all three encodings, what is read and what is skipped, and hostile headers.

use std::fmt::Write;

use glam::{Vec2, Vec3};

use super::*;
use crate::asset::{AlphaMode, Primitive, Slot};

#[derive(Clone, Copy, Debug)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

use Encoding::{Ascii, Big, Little};

const ENCODINGS: [Encoding; 3] = [Ascii, Little, Big];

/// A file in the making.
struct Ply {
    encoding: Encoding,
    header: String,
    body: Vec<u8>,
}

impl Ply {
    fn new(encoding: Encoding) -> Self {
        let name = match encoding {
            Ascii => "ascii",
            Little => "binary_little_endian",
            Big => "binary_big_endian",
        };
        Self { encoding, header: format!("ply\nformat {name} 1.0\n"), body: Vec::new() }
    }

    fn say(&mut self, lines: &str) -> &mut Self {
        writeln!(self.header, "{lines}").unwrap();
        self
    }

    /// Numbers by the names of their types, in one line of a text.
    fn row(&mut self, numbers: &[(&str, f64)]) -> &mut Self {
        for &(kind, number) in numbers {
            let mut bytes = match kind {
                "uchar" => vec![number as u8],
                "short" => (number as i16).to_le_bytes().to_vec(),
                "ushort" => (number as u16).to_le_bytes().to_vec(),
                "int" => (number as i32).to_le_bytes().to_vec(),
                "uint" => (number as u32).to_le_bytes().to_vec(),
                "float" => (number as f32).to_le_bytes().to_vec(),
                "double" => number.to_le_bytes().to_vec(),
                other => panic!("{other}"),
            };
            match self.encoding {
                Ascii => self.body.extend(format!("{number} ").bytes()),
                Little => self.body.extend(bytes),
                Big => {
                    bytes.reverse();
                    self.body.extend(bytes);
                }
            }
        }
        if matches!(self.encoding, Ascii) {
            self.body.push(b'\n');
        }
        self
    }

    fn list(&mut self, length: &str, kind: &str, numbers: &[f64]) -> &mut Self {
        let mut row = vec![(length, numbers.len() as f64)];
        row.extend(numbers.iter().map(|&number| (kind, number)));
        self.row(&row)
    }

    fn bytes(&self) -> Vec<u8> {
        [self.header.as_bytes(), b"end_header\n", &self.body].concat()
    }
}

const SQUARE: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 2.0, 0.25]];

/// Everything that is read, among things that are not.
fn full(encoding: Encoding) -> Ply {
    let mut ply = Ply::new(encoding);
    ply.say("comment made by hand").say("obj_info nothing").say("element camera 2\nproperty float f");
    ply.say("property list uchar short s\nelement vertex 5\nproperty double x\nproperty float y");
    ply.say("property float z\nproperty float quality\nproperty list uchar int links");
    ply.say("property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha");
    ply.say("property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t");
    ply.say("element face 3\nproperty uchar flags\nproperty list uchar uint vertex_index");
    ply.say("element edge 1\nproperty int vertex1");
    ply.row(&[("float", 1.0)]).list("uchar", "short", &[-3.0, 4.0]);
    ply.row(&[("float", 2.0)]).list("uchar", "short", &[]);
    for ([x, y, z], number) in SQUARE.into_iter().zip(0..) {
        ply.row(&[("double", x), ("float", y), ("float", z), ("float", 9.0)]);
        ply.list("uchar", "int", &[7.0; 3][..number % 3]);
        ply.row(&[("uchar", 255.0), ("uchar", 128.0), ("uchar", 0.0), ("uchar", 51.0 * number as f64)]);
        ply.row(&[("float", 0.0), ("float", 0.0), ("float", 2.0), ("float", x), ("float", 0.25)]);
    }
    ply.row(&[("uchar", 1.0)]).list("uchar", "uint", &[0.0, 1.0, 2.0, 3.0]);
    ply.row(&[("uchar", 1.0)]).list("uchar", "uint", &[3.0, 2.0, 4.0]);
    ply.row(&[("uchar", 1.0)]).list("uchar", "uint", &[0.0, 1.0, 2.0, 4.0, 3.0]);
    ply.row(&[("int", 5.0)]);
    ply
}

/// Vertices without anything else.
fn square(encoding: Encoding) -> Ply {
    let mut ply = Ply::new(encoding);
    ply.say("element vertex 5\nproperty float x\nproperty float y\nproperty float z");
    for [x, y, z] in SQUARE {
        ply.row(&[("float", x), ("float", y), ("float", z)]);
    }
    ply
}

pub(super) fn seed(encoding: Encoding) -> Vec<u8> {
    full(encoding).bytes()
}

fn first(asset: &Asset) -> &Primitive {
    &asset.meshes[0].primitives[0]
}

fn corners(asset: &Asset) -> Vec<Vec<u32>> {
    first(asset).faces.iter().map(|face| face.corners().to_vec()).collect()
}

fn refused(bytes: Vec<u8>, code: ErrorCode, place: &str) {
    let error = read_bytes(bytes).expect_err(place);
    assert_eq!((error.code, error.pointer.as_deref()), (code, Some(place)), "{error}");
}

#[test]
fn all_encodings_say_the_same() {
    let wanted = read_bytes(full(Ascii).bytes()).unwrap();
    let primitive = first(&wanted);
    assert_eq!(primitive.positions, SQUARE.map(|[x, y, z]| Vec3::new(x as f32, y as f32, z as f32)));
    assert_eq!(primitive.normals, [Vec3::Z; 5]);
    assert_eq!(primitive.texcoords[0][1], Vec2::new(1.0, 0.75), "v runs downwards");
    assert_eq!(corners(&wanted)[..2], [vec![0, 1, 2, 3], vec![3, 2, 4]]);
    assert_eq!(corners(&wanted).len(), 2 + 3, "a polygon of five corners");
    let color = &primitive.attributes[0];
    assert_eq!((color.semantic.as_str(), color.kind.as_str(), color.bytes.len()), ("COLOR_0", "VEC4", 80));
    let component = |at: usize| f32::from_le_bytes(color.bytes[4 * at..4 * at + 4].try_into().unwrap());
    assert_eq!((component(0), component(2)), (1.0, 0.0));
    assert!((component(1) - 0.215_860_5).abs() < 1e-6, "sRGB code 128 in linear light");
    assert!((component(4 + 3) - 0.2).abs() < 1e-6, "alpha is linear");
    assert_eq!(wanted.materials[0].alpha_mode, AlphaMode::Blend);
    assert_eq!(wanted.warnings, []);
    for encoding in ENCODINGS {
        for (from, to) in [("", ""), ("\n", "\r\n"), ("\n", "\r")] {
            let ply = full(encoding);
            let header =
                (ply.header.clone() + "end_header\n").replace(from, if from.is_empty() { "" } else { to });
            let asset = read_bytes([header.as_bytes(), &ply.body].concat()).unwrap();
            assert_eq!(first(&asset).attributes, primitive.attributes, "{encoding:?} {to:?}");
            assert_eq!(corners(&asset), corners(&wanted));
            assert_eq!(asset.document.json, wanted.document.json);
        }
    }
}

#[test]
fn colors_of_all_types_are_srgb() {
    for (kind, full, half) in [("uchar", 255.0, 51.0), ("ushort", 65_535.0, 13_107.0), ("float", 1.0, 0.2)] {
        let mut ply = Ply::new(Little);
        ply.say("element vertex 3\nproperty float x\nproperty float y\nproperty float z");
        ply.say(&format!("property {kind} red\nproperty {kind} green\nproperty {kind} blue"));
        for [x, y, z] in &SQUARE[..3] {
            ply.row(&[("float", *x), ("float", *y), ("float", *z)]);
            ply.row(&[(kind, full), (kind, half), (kind, 0.0)]);
        }
        ply.say("element face 1\nproperty list uchar int vertex_indices").list(
            "uchar",
            "int",
            &[0.0, 1.0, 2.0],
        );
        let asset = read_bytes(ply.bytes()).unwrap();
        let color = &first(&asset).attributes[0];
        assert_eq!(color.kind, "VEC3");
        let green = f32::from_le_bytes(color.bytes[4..8].try_into().unwrap());
        assert!((green - 0.033_104_8).abs() < 1e-6, "{kind}: {green}");
    }
}

#[test]
fn faces_bring_coordinates_and_textures() {
    let mut ply = square(Big);
    ply.say("comment TextureFile one.png\ncomment TextureFile my two.png");
    ply.say("element face 4\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord");
    ply.say("property int texnumber");
    ply.list("uchar", "int", &[0.0, 1.0, 2.0]).list("uchar", "float", &[0.0, 0.0, 1.0, 0.0, 1.0, 0.25]);
    ply.row(&[("int", 1.0)]);
    ply.list("uchar", "int", &[0.0, 1.0, 2.0, 3.0]).list("uchar", "float", &[0.5; 8]).row(&[("int", 0.0)]);
    ply.list("uchar", "int", &[2.0, 3.0, 4.0]).list("uchar", "float", &[]).row(&[("int", -1.0)]);
    ply.list("uchar", "int", &[2.0, 3.0, 0.0]).list("uchar", "float", &[]).row(&[("int", 0.0)]);
    let (one, two) = (png(2, 2), png(3, 3));
    let files = [("f/m.ply", &ply.bytes()[..]), ("f/one.png", &one), ("f/my two.png", &two)];
    let asset = read_files(&files).unwrap();
    let shape: Vec<_> =
        asset.meshes[0].primitives.iter().map(|p| (p.material, p.faces.len(), p.texcoords.len())).collect();
    assert_eq!(shape, [(Some(1), 1, 1), (Some(0), 2, 1), (Some(2), 1, 0)]);
    assert_eq!(first(&asset).texcoords[0], [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.75)]);
    let images: Vec<_> =
        asset.materials.iter().map(|m| m.slot(Slot::BaseColor).map(|slot| slot.image)).collect();
    assert_eq!(images, [Some(0), Some(1), None]);
    assert_eq!(asset.images[1].size(), [3, 3]);
    assert_eq!(asset.document.json["images"][1]["name"], "f/my two.png");
    let codes: Vec<_> = asset.warnings.iter().map(|w| (w.code.as_str(), w.count)).collect();
    assert_eq!(codes, [("missing_texcoord", 3)]);

    let error = read_files(&files[..2]).unwrap_err();
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::MissingResource, Some("m.ply:8")));

    let mut bare = square(Ascii);
    bare.say("comment TextureFile ../x.png\nelement face 1\nproperty list uchar int vertex_indices");
    bare.list("uchar", "int", &[0.0, 1.0, 2.0]);
    let asset = read_bytes(bare.bytes()).unwrap();
    assert_eq!(asset.warnings[0].code, "unused_texture");
    assert!(asset.materials.len() == 1 && asset.images.is_empty());
    bare.header = bare.header.replace("float x\n", "float x\nproperty float u\nproperty float v\n");
    bare.body = b"0 0 0 0 0\n1 0 0 0 0\n0 0 0 1 0\n1 1 1 1 1\n1 1 1 1 1\n3 0 1 2\n".to_vec();
    refused(bare.bytes(), ErrorCode::UnsafeUri, "model:9");
}

#[test]
fn headers_are_checked() {
    let rest = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0\n3 0 1 2\n";
    let text = |head: &str| format!("ply\n{head}{rest}").into_bytes();
    read_bytes(text("format ascii 1.0\n")).unwrap();
    for (head, place) in [
        ("", "model:8"),
        ("format ascii 1.0\nelement x\n", "model:3"),
        ("format ascii 1.0\nelement x -1\n", "model:3"),
        ("format ascii 1.0\nelement x 99999999999999999999\n", "model:3"),
        ("format ascii 1.0\nproperty int a\n", "model:3"),
        ("format ascii 1.0\nelement x 0\nproperty quad a\n", "model:4"),
        ("format ascii 1.0\nelement x 0\nproperty int\n", "model:4"),
        ("format ascii 1.0\nelement x 0\nproperty list float int a\n", "model:4"),
        ("format ascii 1.0\nnonsense\n", "model:3"),
    ] {
        refused(text(head), ErrorCode::InvalidModel, place);
    }
    refused(text("format ascii 2.0\n"), ErrorCode::UnsupportedMediaType, "model:2");
    refused(b"ply\nformat ascii 1.0\nelement vertex 0\n".to_vec(), ErrorCode::InvalidModel, "model");
    refused([b"ply\n", &vec![b'\n'; 2 << 20][..]].concat(), ErrorCode::InvalidModel, "model");
    for many in ["element e 0\n", "property int p\n"] {
        let head = format!("format ascii 1.0\nelement e 0\n{}", many.repeat(300));
        assert!(read_bytes(text(&head)).is_err());
    }
    // An element without properties takes no room, however often it stands there.
    read_bytes(text("format ascii 1.0\nelement nothing 18446744073709551615\n")).unwrap();
}

#[test]
fn counts_are_held_against_the_file_and_the_limits() {
    for encoding in ENCODINGS {
        let announce = |lines: &str| {
            let mut ply = Ply::new(encoding);
            ply.say(lines).row(&[("float", 0.0); 9]);
            ply.bytes()
        };
        let vertex = "property float x\nproperty float y\nproperty float z";
        for count in ["4", "1000000000", "18446744073709551615"] {
            refused(announce(&format!("element vertex {count}\n{vertex}")), ErrorCode::InvalidModel, "model");
        }
        let other = format!("element other 9000000000\nproperty float a\nelement vertex 3\n{vertex}");
        refused(announce(&other), ErrorCode::InvalidModel, "model");
        let lists =
            format!("element vertex 3\n{vertex}\nelement face 1\nproperty list int int vertex_indices");
        for length in [-1.0, 3.0, 2_147_483_647.0] {
            let mut ply = Ply::new(encoding);
            ply.say(&lists).row(&[("float", 0.0); 9]).row(&[("int", length), ("int", 0.0)]);
            refused(ply.bytes(), ErrorCode::InvalidModel, "model, face 0");
        }
    }
    let limited = |limits: Limits| read_limited(seed(Little), limits).unwrap_err();
    let error = limited(Limits { vertices: 4, ..Limits::default() });
    assert_eq!((error.code, error.actual), (ErrorCode::ModelTooLarge, Some(5)));
    let error = limited(Limits { triangles: 5, ..Limits::default() });
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::TooManyTriangles, Some("model, face 2")));
    read_limited(seed(Little), Limits { vertices: 5, triangles: 6, ..Limits::default() }).unwrap();
}

#[test]
fn bodies_are_checked() {
    for (vertex, face, place) in [
        ("nan 0 0", "3 0 1 2", "model, vertex 3"),
        ("1e10 0 0", "3 0 1 2", "model, vertex 3"),
        ("x 0 0", "3 0 1 2", "model, vertex 3"),
        ("0 0 0", "3 0 1 4", "model, face 0"),
        ("0 0 0", "3 0 1 -1", "model, face 0"),
        ("0 0 0", "3 0 1 1.5", "model, face 0"),
        ("0 0 0", "2 0 1", "model, face 0"),
        ("0 0 0", "256 0 1 2", "model, face 0"),
        ("0 0 0", "3 0 1", "model, face 0"),
    ] {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n\
             0 0 0\n1 0 0\n0 1 0\n{vertex}\n{face}\n"
        );
        refused(text.into_bytes(), ErrorCode::InvalidModel, place);
    }
    refused(square(Big).bytes(), ErrorCode::NothingToConvert, "model");
    let mut early = Ply::new(Ascii);
    early.say("element face 0\nproperty list uchar int vertex_indices\nelement vertex 0\nproperty float x");
    refused(early.bytes(), ErrorCode::InvalidModel, "model");
    let mut flat = Ply::new(Ascii);
    flat.say("element vertex 0\nproperty float x\nproperty float y");
    refused(flat.bytes(), ErrorCode::InvalidModel, "model");
}

#[test]
fn a_zip_may_hold_one() {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.start_file("scan/a.PLY", zip::write::SimpleFileOptions::default()).unwrap();
    std::io::Write::write_all(&mut zip, &seed(Big)).unwrap();
    let asset = read_bytes(zip.finish().unwrap().into_inner()).unwrap();
    assert_eq!(asset.meshes[0].name, "a");
}
