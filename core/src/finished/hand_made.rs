//! A flat sheet with indexed coordinates, made by hand: every shape of block that there is, its texels a
//! linear function of position, so that a sound table shows no seam at any level.

mod parts;

pub use parts::split;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec2;

use super::{
    Anchor, BlockClass, BlockTable, Coordinates, Finished, FinishedPrimitive, FinishedTexture,
    FinishedTriangle, TableLevel,
};
use crate::asset::{Asset, Face, Material, Mesh, Primitive, Slot, TextureRef, UvTransform};
use crate::image::{Image, Pixels, Transfer, Wrap};

/// Two levels beyond the finest face.
pub const LEVEL_COUNT: usize = 6;
/// Unit squares of the sheet along x and y; those without a face are left out.
pub const SIZE: [u32; 2] = [5, 3];

/// A block on its way: its class and number, and where local (0, 0) lies on the sheet. Locals are as long as
/// the sheet's own units.
struct Block {
    class: u32,
    number: u32,
    at: [u32; 2],
}

/// By class: single quads, a merged pair, lone triangles and their twins, a block of 2 × 2 quads, an elongated
/// quad.
pub const CLASSES: [BlockClass; 6] = [
    class([3, 3], [1, 1], [1, 1], [0, 0]),
    class([2, 2], [1, 1], [1, 1], [0, 0]),
    class([2, 2], [1, 1], [4, 1], [0, 0]),
    class([2, 2], [1, 1], [4, 1], [3, 0]),
    class([1, 1], [2, 2], [1, 1], [0, 0]),
    class([3, 1], [1, 1], [1, 1], [0, 0]),
];

const fn class(exponents: [u8; 2], cells: [u32; 2], gap: [u32; 2], shift: [u32; 2]) -> BlockClass {
    BlockClass { exponents, cells, gap, shift }
}

const BLOCKS: [Block; 7] = [
    Block { class: 0, number: 0, at: [0, 0] },
    Block { class: 0, number: 1, at: [1, 0] },
    Block { class: 1, number: 0, at: [2, 0] },
    Block { class: 2, number: 0, at: [3, 0] },
    Block { class: 3, number: 0, at: [3, 0] },
    Block { class: 4, number: 0, at: [0, 1] },
    Block { class: 5, number: 0, at: [4, 0] },
];

/// Rows of blocks one under the other: at level 0 the two single quads too, at others beside each other.
pub fn table() -> BlockTable {
    let level = |level: usize| {
        let mut own = TableLevel::default();
        let mut y = 0;
        for (number, class) in CLASSES.iter().enumerate() {
            let columns = if number == 0 && level > 0 { 2 } else { 1 };
            // Before the last class one block of another might stand.
            let first = u32::from(number + 1 == CLASSES.len());
            let rows = first + if number == 0 && level == 0 { 2 } else { 1 };
            // Twins stand in the grid of the class before.
            if number == 3 {
                own.origins.push(own.origins[2]);
            } else {
                own.origins.push([number as u32 % 3, y]);
                y += rows * (class.cells[1] * (1 << class.exponents[1].saturating_sub(level as u8)) + 1);
            }
            own.columns.push(columns);
            own.firsts.push(first);
        }
        own
    };
    BlockTable { classes: CLASSES.to_vec(), levels: (0..LEVEL_COUNT).map(level).collect() }
}

/// The sheet's colors: whole codes at all samples.
pub fn value(x: f32, y: f32) -> [u8; 3] {
    [8.0 + 16.0 * x + 24.0 * y, 200.0 - 32.0 * x + 8.0 * y, 40.0 * y].map(|code| code as u8)
}

/// The sheet as faces with a texture, and its conversion.
pub fn sheet() -> (Asset, Finished) {
    let mut primitive = Primitive { material: Some(0), ..Primitive::default() };
    let corners = (0..=SIZE[1]).flat_map(|y| (0..=SIZE[0]).map(move |x| Vec2::new(x as f32, y as f32)));
    primitive.positions = corners.clone().map(|at| at.extend(0.0)).collect();
    // The source's image goes half a unit beyond the sheet: filtering does not wrap around.
    let uv = |at: Vec2| (at + 0.5) / Vec2::new(SIZE[0] as f32 + 1.0, SIZE[1] as f32 + 1.0);
    primitive.texcoords = vec![corners.map(uv).collect()];
    let mut triangles = Vec::new();
    for block in &BLOCKS {
        let [columns, rows] = CLASSES[block.class as usize].cells;
        for [x, y] in (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y])) {
            for face in faces(block.class) {
                let locals: Vec<[u32; 2]> = face.iter().map(|at| [x + at[0], y + at[1]]).collect();
                let vertex = |at: &[u32; 2]| (block.at[1] + at[1]) * (SIZE[0] + 1) + block.at[0] + at[0];
                let vertices: Vec<u32> = locals.iter().map(vertex).collect();
                let face = match *vertices.as_slice() {
                    [a, b, c] => Face::triangle([a, b, c]),
                    _ => Face::quad([vertices[0], vertices[1], vertices[2], vertices[3]]),
                };
                triangles.extend(face.triangles().iter().map(|corners| FinishedTriangle {
                    vertices: corners.map(|corner| face.corners[corner]),
                    corners: corners.map(|c| Vec2::new(locals[c][0] as f32, locals[c][1] as f32)),
                    anchor: Anchor::Block { class: block.class, number: block.number },
                }));
                primitive.faces.push(face);
            }
        }
    }
    let mut material = Material { name: "Sheet".to_owned(), normal_scale: 1.0, ..Material::default() };
    material.slots.insert(
        Slot::Occlusion,
        TextureRef { image: 0, wrap: Wrap::default(), texcoord: 0, transform: UvTransform::default() },
    );
    let texture = FinishedTexture {
        materials: vec![0],
        part: 0,
        slots: vec![Slot::Occlusion],
        transfer: Transfer::Linear,
        levels: (0..LEVEL_COUNT).map(level_image).collect(),
        ranges: BTreeMap::new(),
        value_scale: None,
    };
    let piece = FinishedPrimitive {
        mesh: 0,
        primitive: 0,
        material: 0,
        part: 0,
        coordinates: Coordinates::Indexed(Arc::new(table())),
        triangles,
        frames: Vec::new(),
        cuts: Vec::new(),
    };
    let source = image(SIZE.map(|size| (size + 1) * 16), |x, y| {
        let [x, y] = [x, y].map(|at| (at as f32 + 0.5) / 16.0 - 0.5);
        value(x, y)
    });
    let asset = Asset {
        images: vec![source],
        materials: vec![material],
        meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
        ..Asset::default()
    };
    (asset, Finished { textures: vec![texture], primitives: vec![piece], ..Finished::default() })
}

/// The faces of one cell of a class, by the cell's own corners.
fn faces(class: u32) -> Vec<Vec<[u32; 2]>> {
    let quad = vec![[0, 0], [1, 0], [1, 1], [0, 1]];
    let (first, second) = (vec![[0, 0], [1, 0], [0, 1]], vec![[1, 1], [0, 1], [1, 0]]);
    match class {
        1 => vec![first, second],
        2 => vec![first],
        3 => vec![second],
        _ => vec![quad],
    }
}

/// What is no block's is white.
fn level_image(level: usize) -> Image {
    let mut texels: BTreeMap<[u32; 2], [u8; 3]> = BTreeMap::new();
    let table = table();
    for block in &BLOCKS {
        let BlockClass { exponents, cells, gap, shift } = CLASSES[block.class as usize];
        let [k, m] = exponents.map(|exponent| 1u32 << usize::from(exponent).saturating_sub(level));
        let TableLevel { columns, firsts, origins } = &table.levels[level];
        let (columns, [left, top]) = (columns[block.class as usize], origins[block.class as usize]);
        let place = firsts[block.class as usize] + block.number;
        // Lone triangles of one segment stand closer.
        let [gap_x, shift_x] = if k == 1 { [gap[0].min(3), shift[0].min(2)] } else { [gap[0], shift[0]] };
        let left = left + shift_x + place % columns * (cells[0] * k + gap_x);
        let top = top + shift[1] + place / columns * (cells[1] * m + gap[1]);
        for [i, j] in (0..=cells[1] * m).flat_map(|j| (0..=cells[0] * k).map(move |i| [i, j])) {
            // A lone triangle has its samples and one line of border texels.
            let is_own = match block.class {
                2 => i + j <= k + 1,
                3 => i + j + 1 >= k,
                _ => true,
            };
            if is_own {
                let at = Vec2::new(i as f32 / k as f32, j as f32 / m as f32);
                let at = at + Vec2::new(block.at[0] as f32, block.at[1] as f32);
                let before = texels.insert([left + i, top + j], value(at.x, at.y));
                assert_eq!(before, None, "two blocks have a texel in common");
            }
        }
    }
    let end = |axis: usize| texels.keys().map(|at| at[axis] + 1).max().unwrap();
    image([end(0), end(1)], |x, y| texels.get(&[x, y]).copied().unwrap_or([255; 3]))
}

fn image(size: [u32; 2], value: impl Fn(u32, u32) -> [u8; 3]) -> Image {
    let codes = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).flat_map(|(x, y)| value(x, y));
    Image { width: size[0], height: size[1], components: 3, pixels: Pixels::U8(codes.collect()) }
}

/// The primitive's geometry as it has to be in any file made of it: a vertex for each corner of each block.
pub const VERTEX_COUNT: usize = 2 * 4 + 4 + 2 * 3 + 9 + 4;
