//! Random models for property tests: sheets of triangles and quads with holes, odd texture coordinates
//! and edges of three faces, as OBJ uploads.

use std::collections::BTreeMap;
use std::fmt::Write;

use glam::{Vec2, Vec3};
use meshcolor::image::{Image, Pixels};
use meshcolor::read::{MemoryFiles, Upload};

/// A small generator of our own: the same models everywhere.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed ^ 0x9E37_79B9_7F4A_7C15)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    pub fn below(&mut self, end: usize) -> usize {
        (self.unit() * end as f32) as usize % end
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

/// A corner: position number and texture coordinate (v down).
pub type Corner = (u32, Vec2);

/// Faces of 3 or 4 corners.
#[derive(Clone, Debug)]
pub struct Patch {
    pub positions: Vec<Vec3>,
    pub faces: Vec<Vec<Corner>>,
}

/// The corners of a grid cell that its faces use: a quad, two triangles along either diagonal, one
/// triangle, or nothing.
const CELLS: [&[&[usize]]; 6] = [
    &[&[0, 1, 2, 3]],
    &[&[0, 1, 2], &[0, 2, 3]],
    &[&[0, 1, 3], &[1, 2, 3]],
    &[&[0, 1, 2]],
    &[&[3, 0, 2]],
    &[],
];

impl Patch {
    /// A grid of `side * side` cells of random kinds; a position is whole sixty-fourths. `place` gives the
    /// texture coordinate at a grid point for a face.
    pub fn grid(
        random: &mut Random,
        side: usize,
        mut place: impl FnMut(&mut Random, usize, [usize; 2]) -> Vec2,
    ) -> Self {
        let row = side + 1;
        let height = |x: usize, y: usize| ((x * 7 + y * 13) % 5) as f32 * 0.25;
        let positions = (0..row * row).map(|k| (k % row, k / row));
        let positions = positions.map(|(x, y)| Vec3::new(x as f32, y as f32, height(x, y))).collect();
        let mut faces = Vec::new();
        for y in 0..side {
            for x in 0..side {
                let square = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
                for corners in CELLS[random.below(CELLS.len())] {
                    let number = faces.len();
                    let corner = |&k: &usize| {
                        ((square[k][1] * row + square[k][0]) as u32, place(random, number, square[k]))
                    };
                    faces.push(corners.iter().map(corner).collect());
                }
            }
        }
        if faces.is_empty() {
            let corner = |at: [usize; 2]| ((at[1] * row + at[0]) as u32, place(random, 0, at));
            faces.push([[0, 0], [1, 0], [0, 1]].map(corner).to_vec());
        }
        Self { positions, faces }
    }

    /// A grid whose faces see unrelated pieces of the picture, of very different sizes, with a third face
    /// at some edges.
    pub fn wild(random: &mut Random, side: usize) -> Self {
        let mut scale = (usize::MAX, 1.0);
        let mut patch = Self::grid(random, side, |random, face, _| {
            if scale.0 != face {
                scale = (face, 0.5f32.powi(random.below(7) as i32));
            }
            Vec2::new(random.unit(), random.unit()) * scale.1
        });
        for _ in 0..side {
            let of = random.below(patch.faces.len());
            let [a, b] = [patch.faces[of][0], patch.faces[of][1]];
            let middle = (patch.positions[a.0 as usize] + patch.positions[b.0 as usize]) * 0.5;
            patch.positions.push(middle + Vec3::new(0.25, -0.5, 1.5));
            let tip = (patch.positions.len() as u32 - 1, Vec2::new(random.unit(), random.unit()));
            patch.faces.push(vec![a, b, tip]);
        }
        patch
    }

    /// The model as OBJ, MTL and PNG.
    pub fn upload(&self, picture: &Image) -> Upload {
        Upload { main: OBJ.to_owned(), files: Box::new(MemoryFiles(files(&[(self, picture)]))) }
    }
}

/// The main one of [`files`].
pub const OBJ: &str = "p.obj";

/// Patches as one OBJ model, by the names of its files: each patch has a material of its own with a picture of its own.
pub fn files(parts: &[(&Patch, &Image)]) -> BTreeMap<String, Vec<u8>> {
    let mut text = String::from("mtllib p.mtl\n");
    let mut materials = String::new();
    let mut files = BTreeMap::new();
    let (mut first_position, mut corner_count) = (1, 0);
    for (number, (patch, picture)) in parts.iter().enumerate() {
        let name = if number == 0 { "p".to_owned() } else { format!("p{number}") };
        let written = patch.write(&mut text, &name, first_position, &mut corner_count);
        written.expect("a string takes all");
        write!(materials, "newmtl {name}\nmap_Kd {name}.png\n").expect("a string takes all");
        files.insert(format!("{name}.png"), meshcolor::write::png(picture).expect("a sound image"));
        first_position += patch.positions.len();
    }
    files.insert(OBJ.to_owned(), text.into_bytes());
    files.insert("p.mtl".to_owned(), materials.into_bytes());
    files
}

impl Patch {
    /// Its faces and what they use.
    fn write(
        &self,
        text: &mut String,
        material: &str,
        first_position: usize,
        corner_count: &mut usize,
    ) -> std::fmt::Result {
        writeln!(text, "usemtl {material}")?;
        for position in &self.positions {
            writeln!(text, "v {} {} {}", position.x, position.y, position.z)?;
        }
        for face in &self.faces {
            let mut line = String::from("f");
            for (vertex, place) in face {
                *corner_count += 1;
                writeln!(text, "vt {} {}", place.x, 1.0 - place.y)?;
                write!(line, " {}/{corner_count}", *vertex as usize + first_position)?;
            }
            text.push_str(&line);
            text.push('\n');
        }
        Ok(())
    }
}

/// Noise with many texels at black: the worst that a picture can be.
pub fn noise(random: &mut Random, width: u32, height: u32) -> Image {
    picture(width, height, |_, _| {
        [0; 3].map(|_: u8| if random.unit() < 0.5 { 0 } else { (random.unit() * 255.0) as u8 })
    })
}

/// Smooth, periodic, and far from both ends of the range.
pub fn smooth(side: u32) -> Image {
    let wave = |at: u32, turns: f32| (at as f32 / side as f32 * std::f32::consts::TAU * turns).sin();
    let code = |value: f32| (140.0 + 25.0 * value).round() as u8;
    picture(side, side, |x, y| [code(wave(x, 1.0)), code(wave(y, 1.0)), code(wave(x, 2.0) * wave(y, 1.0))])
}

pub fn picture(width: u32, height: u32, mut color: impl FnMut(u32, u32) -> [u8; 3]) -> Image {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let codes = places.flat_map(|(x, y)| color(x, y)).collect();
    Image { width, height, components: 3, pixels: Pixels::U8(codes) }
}
