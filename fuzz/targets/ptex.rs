//! A Ptex file beside meshes that have as many faces of its kind.
#![no_main]

use std::collections::BTreeMap;

use meshcolor::read::{MemoryFiles, Upload};
use meshcolor_fuzz::libfuzzer_sys::{fuzz_mutator, fuzz_target};
use meshcolor_fuzz::ptex::{mutate, word};

/// Where a header has the kind of mesh (0: triangles), the count of faces, and the format's minor version, which says nothing that is
/// read: its bits from the fifth on choose the mesh.
const KIND_AT: usize = 8;
const COUNT_AT: usize = 24;
const MINOR_AT: usize = 44;
/// Files that say more end in an error about their counts.
const FACES_MOST: u32 = 16;
const MTL: &[u8] = b"newmtl painted\nmap_Kd m.ptx\nnorm m.ptx\nnewmtl plain\nKd 1 0 0\n";

fuzz_target!(|file: &[u8]| {
    let is_quads = word(file, KIND_AT) != Some(0);
    let count = word(file, COUNT_AT).unwrap_or(1).clamp(1, FACES_MOST);
    let mesh = word(file, MINOR_AT).unwrap_or(0) >> 4;
    let obj = obj(is_quads, count, mesh).into_bytes();
    let files = [("m.obj", obj), ("m.mtl", MTL.to_vec()), ("m.ptx", file.to_vec())];
    let files: BTreeMap<_, _> = files.map(|(name, bytes)| (name.to_owned(), bytes)).into();
    let upload = Upload { main: "m.obj".to_owned(), files: Box::new(MemoryFiles(files)) };
    meshcolor_fuzz::read_with(&upload, &[]);
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    mutate(data, size, max_size, seed)
});

/// A row of faces in an OBJ file: quads or triangles, or polygons of which a file for quads has one face for each corner; with the
/// texture beside it or in a material, for colors and normals; all of them or half of them painted; side by side or over each other.
fn obj(is_quads: bool, count: u32, mesh: u32) -> String {
    let [has_polygons, has_material, is_half, is_folded] = [1, 2, 4, 8].map(|bit| mesh & bit != 0);
    let mut text = String::new();
    let columns = 2 * FACES_MOST;
    for x in (0..=columns).map(|x| if is_folded { x % 2 } else { x }) {
        text += &format!("v {x} 0 0\nv {x} 1 0\nv {x}.5 2 0\n");
    }
    if has_material {
        text += "mtllib m.mtl\nusemtl painted\n";
    }
    let (mut left, mut column) = (count, 0);
    while left > 0 {
        let corner_count = match (is_quads, has_polygons) {
            (true, true) => 3 + (column + 2) % 3,
            (true, false) => 4,
            (false, _) => 3,
        };
        let corner_count =
            if is_quads && corner_count != 4 && corner_count > left { 4 } else { corner_count };
        text += &face(column, corner_count);
        left -= if is_quads && corner_count != 4 { corner_count } else { 1 };
        column += 1;
    }
    if has_material && is_half {
        text += "usemtl plain\n";
        (0..column).for_each(|more| text += &face(column + more, 4));
    }
    text
}

/// The face between a column's vertices and the next one's.
fn face(column: u32, corner_count: u32) -> String {
    let [a, b, top, c, d] = [1, 2, 3, 4, 5].map(|vertex| vertex + 3 * column);
    match corner_count {
        3 => format!("f {a} {c} {d}\n"),
        4 => format!("f {a} {c} {d} {b}\n"),
        _ => format!("f {a} {c} {d} {top} {b}\n"),
    }
}
