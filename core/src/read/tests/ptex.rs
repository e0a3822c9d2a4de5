//! Ptex files of OBJ models: who names them, which faces they are for, and meshes with faces of other than four corners.

use glam::{Vec2, Vec4};

use super::*;
use crate::asset::{Primitive, Slot};
use crate::image::{Pixels, Transfer, Wrap, bilinear};
use crate::read::ptex::tests::writer::{self, Face, Ptex, Stored};

const QUADS: &str = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n";

/// A gray file of `count` faces of `2 x 2` texels, face `k` of code `10 k + 5`; nothing is said of neighbours.
fn file(is_triangles: bool, count: usize) -> Ptex {
    let face = |k: usize| Face {
        log2: [1, 1],
        neighbours: [None; 4],
        is_subface: false,
        stored: Stored::Zipped,
        numbers: vec![(10 * k + 5) as f32; 4],
    };
    Ptex { is_triangles, data: writer::U8, channels: 1, alpha: None, faces: (0..count).map(face).collect() }
}

fn first(asset: &Asset) -> &Primitive {
    &asset.meshes[0].primitives[0]
}

/// What a slot shows in the middle of a face, or elsewhere on it, as an 8-bit code of data.
fn code(asset: &Asset, primitive: &Primitive, slot: Slot, face: usize, [s, t]: [f32; 2]) -> f32 {
    let material = &asset.materials[primitive.material.unwrap()];
    let reference = material.slot(slot).unwrap();
    let image = &asset.images[reference.image];
    let uv = |corner: usize| {
        primitive.texcoords[reference.texcoord][primitive.faces[face].corners[corner] as usize]
    };
    let size = Vec2::new(image.width as f32, image.height as f32);
    let [a, b] = [uv(0).lerp(uv(1), s), uv(3).lerp(uv(2), s)];
    let value: Vec4 = bilinear(image, Transfer::Linear, Wrap::default(), a.lerp(b, t) * size);
    crate::math::transfer::linear_to_srgb(value.x) * 255.0
}

const MIDDLE: [f32; 2] = [0.5, 0.5];

fn codes(asset: &Asset, primitive: &Primitive, slot: Slot) -> Vec<u32> {
    (0..primitive.faces.len()).map(|face| code(asset, primitive, slot, face, MIDDLE).round() as u32).collect()
}

#[test]
fn a_file_of_the_same_name_is_found_where_nothing_is_named() {
    let obj = format!("{QUADS}f 1 2 5 4\nf 2 3 6 5\n");
    let painted = file(false, 2).bytes();
    let asset = read_files(&[("folder/m.obj", obj.as_bytes()), ("folder/m.ptx", &painted)]).unwrap();
    assert_eq!((asset.materials.len(), asset.materials[0].name.as_str()), (1, "m"));
    assert_eq!(codes(&asset, first(&asset), Slot::BaseColor), [5, 15]);
    let Pixels::F32(of) = &asset.images[0].pixels else { panic!("values") };
    assert_eq!((of.bits, of.texels_per_painted, first(&asset).positions.len()), (8, 2, 8));
    // The neighbours that the file lacks.
    assert_eq!((asset.warnings[0].code.as_str(), asset.warnings[0].count), ("ptex_adjacency", 2));
    assert_eq!(asset.warnings[0].pointer, "m.ptx");
    assert_eq!(asset.document.json["images"][0]["mimeType"], "image/x-ptex");
    for files in [
        vec![("m.obj", obj.as_bytes()), ("n.ptx", &painted[..])],
        vec![("m.obj", obj.as_bytes()), ("m.ptx", b"no")],
    ] {
        assert!(read_files(&files).unwrap().materials.is_empty());
    }
    let named = format!("usemtl other\n{obj}");
    let asset = read_files(&[("m.obj", named.as_bytes()), ("m.ptx", &painted)]).unwrap();
    assert!(asset.images.is_empty(), "a model with materials names its files");
}

#[test]
fn maps_of_a_material_have_coordinates_of_their_own() {
    let obj = format!(
        "mtllib a.mtl\nusemtl m\n{QUADS}vt 0.25 0.5\nf 1/1 2/1 5/1 4/1\nf 2/1 3/1 6/1 5/1\nusemtl unused\n"
    );
    let mtl = "newmtl m\nmap_Kd a.ptx\nmap_Ke -s 2 2 b.ptx\nnorm n.png\nnewmtl unused\nmap_Kd c.ptx\n";
    let mut glow = file(false, 2);
    glow.faces[0].numbers = vec![200.0; 4];
    glow.faces[1] = Face { log2: [2, 0], ..glow.faces[1].clone() };
    let (color, glow) = (file(false, 2).bytes(), glow.bytes());
    let files = [
        ("m.obj", obj.as_bytes()),
        ("a.mtl", mtl.as_bytes()),
        ("a.ptx", &color),
        ("b.ptx", &glow),
        ("c.ptx", b"Ptex, and nothing more"),
        ("n.png", &png(2, 2)),
    ];
    let asset = read_files(&files).unwrap();
    let primitive = first(&asset);
    let material = &asset.materials[0];
    let sets =
        [Slot::Normal, Slot::BaseColor, Slot::Emissive].map(|slot| material.slot(slot).unwrap().texcoord);
    assert_eq!((sets, primitive.texcoords.len()), ([0, 1, 2], 3));
    assert_eq!(primitive.texcoords[0][0], Vec2::new(0.25, 0.5));
    assert_eq!(codes(&asset, primitive, Slot::BaseColor), [5, 15]);
    assert_eq!(codes(&asset, primitive, Slot::Emissive), [200, 15]);
    assert!(asset.materials[1].slots.is_empty(), "nothing shows it");
    let warned: Vec<_> = asset.warnings.iter().map(|w| (w.code.as_str(), w.pointer.as_str())).collect();
    assert_eq!(warned[0], ("ptex_transform", "a.mtl:3"));
}

/// One file as a color and as normals is two images.
#[test]
fn a_file_may_be_read_in_two_ways() {
    let obj = format!("mtllib a.mtl\nusemtl m\n{QUADS}f 1 2 5 4\nf 2 3 6 5\n");
    let color = file(false, 2).bytes();
    let mtl = b"newmtl m\nmap_Kd a.ptx\nmap_Ke a.ptx\nnorm a.ptx\n";
    let asset = read_files(&[("m.obj", obj.as_bytes()), ("a.mtl", mtl), ("a.ptx", &color)]).unwrap();
    let images = Slot::CORE.map(|slot| asset.materials[0].slot(slot).map(|reference| reference.image));
    assert_eq!(images, [Some(0), None, Some(1), None, Some(0)]);
    let value = |image: usize| asset.images[image].normalized(1, 1)[0];
    assert!(value(0) < value(1) && (value(1) * 255.0).fract() < 1e-3, "codes of normals are data");
}

#[test]
fn faces_are_those_of_all_or_of_the_materials() {
    let obj = format!("mtllib a.mtl\nusemtl n\n{QUADS}f 1 2 5 4\nusemtl m\nf 2 3 6 5\n");
    let read = |count: usize| {
        let painted = file(false, count).bytes();
        let mtl: &[u8] = b"newmtl m\nmap_Kd a.ptx\nnewmtl n\nKd 1 0 0\n";
        read_files(&[("m.obj", obj.as_bytes()), ("a.mtl", mtl), ("a.ptx", &painted)])
    };
    for (count, code) in [(2, 15), (1, 5)] {
        let asset = read(count).unwrap();
        assert_eq!(codes(&asset, &asset.meshes[0].primitives[1], Slot::BaseColor), [code]);
        assert!(asset.meshes[0].primitives[0].texcoords.is_empty());
    }
    let error = read(3).unwrap_err();
    assert_eq!((error.code, error.pointer.as_deref()), (ErrorCode::InvalidModel, Some("a.mtl:2")));
    for words in ["has 3 faces", "makes 2", "1 of them", "export"] {
        assert!(error.detail.contains(words), "{error}");
    }
}

#[test]
fn triangles_need_triangles() {
    let read = |faces: &str, painted: &Ptex| {
        let obj = format!("{QUADS}{faces}");
        read_files(&[("m.obj", obj.as_bytes()), ("m.ptx", &painted.bytes())])
    };
    let asset = read("f 1 2 5\nf 1 5 4\n", &file(true, 2)).unwrap();
    assert_eq!(first(&asset).texcoords[0].len(), 6);
    let error = read("f 1 2 5\nf 2 3 6 5\n", &file(true, 2)).unwrap_err();
    assert!(error.detail.contains("line 8") && error.detail.contains("has 4 corners"), "{error}");
    assert_eq!(error.pointer.as_deref(), Some("m.ptx"));
    let broken = read_files(&[("m.obj", format!("{QUADS}f 1 2 5 4\n").as_bytes()), ("m.ptx", b"Ptex")]);
    assert_eq!(broken.unwrap_err().pointer.as_deref(), Some("m.ptx"));
}

/// A quad with a triangle and a pentagon beside it: one face of the file, three and five.
const MIXED: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 4 1 0\nv 1 3 0\nv 0.5 3.5 0\nv -0.5 3 0\n\
    vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf 2/1/1 5/1/1 3/1/1\nf 4/1/1 3/1/1 6/1/1 7/1/1 8/1/1\n";

#[test]
fn faces_with_other_corners_split_the_mesh() {
    let mut painted = file(false, 9);
    // The quad grows brighter along u, as each subface does.
    painted.faces[0] = Face {
        log2: [2, 2],
        numbers: (0..16).map(|k| (k % 4 * 20 + 50) as f32).collect(),
        ..painted.faces[0].clone()
    };
    for face in &mut painted.faces[1..] {
        face.numbers = [0.0, 4.0, 0.0, 4.0].map(|more| face.numbers[0] + more).into();
    }
    let asset = read_files(&[("m.obj", MIXED.as_bytes()), ("m.ptx", &painted.bytes())]).unwrap();
    let primitive = first(&asset);
    assert_eq!(primitive.faces.len(), 12);
    assert!(primitive.faces.iter().all(|face| face.count == 4) && primitive.normals.len() == 48);
    // The mean of four texels: in linear light, near that of the codes.
    let shown = |face: usize, at: [f32; 2]| code(&asset, primitive, Slot::BaseColor, face, at);
    for (corner, expected) in [60.0, 100.0, 100.0, 60.0].into_iter().enumerate() {
        assert!((shown(corner, MIDDLE) - expected).abs() < 1.0, "{corner}: {}", shown(corner, MIDDLE));
    }
    for face in 4..12 {
        let expected = (10 * (face - 3) + 7) as f32;
        assert!((shown(face, MIDDLE) - expected).abs() < 0.2, "{face}: {}", shown(face, MIDDLE));
        assert!(shown(face, [0.75, 0.5]) > shown(face, [0.25, 0.5]), "{face}: u runs along the edge");
    }
    // Faces that were beside each other still are, and show the same there.
    let position = |vertex: u32| primitive.positions[vertex as usize];
    let sides: Vec<_> = (0..12).flat_map(|face| (0..4).map(move |edge| (face, edge))).collect();
    let ends = |(face, edge): (usize, usize)| {
        let corners = primitive.faces[face].corners;
        [position(corners[edge]), position(corners[(edge + 1) % 4])]
    };
    let at =
        |edge: usize, share: f32| [[share, 0.0], [1.0, share], [1.0 - share, 1.0], [0.0, 1.0 - share]][edge];
    let mut pair_count = 0;
    for &a in &sides {
        for &b in sides.iter().filter(|&&b| ends(a)[0] == ends(b)[1] && ends(a)[1] == ends(b)[0]) {
            pair_count += 1;
            for step in 0..=20 {
                let share = step as f32 / 20.0;
                let difference = shown(a.0, at(a.1, share)) - shown(b.0, at(b.1, 1.0 - share));
                assert!(difference.abs() < 0.01, "{a:?} {b:?} {share}: {difference}");
            }
        }
    }
    // Twelve about the three middles, and two halves of two inner edges, seen from both sides.
    assert_eq!(pair_count, 2 * (12 + 4));
}

#[test]
fn split_meshes_are_counted() {
    let obj = MIXED.as_bytes().to_vec();
    let painted = file(false, 9).bytes();
    let read = |limits: Limits| {
        let files = [("m.obj", obj.clone()), ("m.ptx", painted.clone())];
        let map = files.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect();
        let upload = Upload { main: "m.obj".to_owned(), files: Box::new(MemoryFiles(map)) };
        read(&upload, &limits, &Unwatched)
    };
    // Six triangles as they are, and 24 when split.
    assert!(read(Limits { triangles: 30, ..Limits::default() }).is_ok());
    assert_eq!(
        read(Limits { triangles: 20, ..Limits::default() }).unwrap_err().code,
        ErrorCode::TooManyTriangles
    );
    assert_eq!(
        read(Limits { vertices: 20, ..Limits::default() }).unwrap_err().code,
        ErrorCode::ModelTooLarge
    );
}
