//! Meshes with Ptex files for black-box tests, and what Ptex's own filters show on them. The files are written from the
//! format's description and evaluated from the numbers that were written: nothing here reads a file.

#[path = "../../core/src/read/ptex/tests/writer.rs"]
pub mod writer;

use std::collections::BTreeMap;
use std::fmt::Write;

use glam::Vec3;
use meshcolor::math::transfer::srgb_to_linear;
use meshcolor::read::{MemoryFiles, Upload};

use crate::patches::Random;
use writer::{Face, Ptex, Stored};

/// A mesh of faces with equally many corners, and its texture.
pub struct Painted {
    pub positions: Vec<Vec3>,
    pub faces: Vec<Vec<u32>>,
    pub file: Ptex,
}

/// A sphere of `6 side²` quads from a cube: eight vertices of valence 3, the others regular.
pub fn ball(side: u32) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let mut positions = Vec::new();
    let mut known = BTreeMap::new();
    let mut faces = Vec::new();
    for axis in 0..3 {
        for is_far in [false, true] {
            let mut vertex = |x: u32, y: u32| {
                let mut cell = [0; 3];
                cell[axis] = if is_far { side } else { 0 };
                let (first, second) = if is_far { (1, 2) } else { (2, 1) };
                cell[(axis + first) % 3] = x;
                cell[(axis + second) % 3] = y;
                *known.entry(cell).or_insert_with(|| {
                    let at = Vec3::from(cell.map(|k| k as f32 / side as f32 * 2.0 - 1.0));
                    positions.push(at.normalize());
                    positions.len() as u32 - 1
                })
            };
            for y in 0..side {
                for x in 0..side {
                    faces.push(
                        [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]].map(|[x, y]| vertex(x, y)).to_vec(),
                    );
                }
            }
        }
    }
    (positions, faces)
}

/// A patch of a plane, slightly bent: with borders, all inner vertices regular.
pub fn sheet(side: u32) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let row = side + 1;
    let at = |k: u32| Vec3::new((k % row) as f32, (k / row) as f32, ((k % row) * (k / row)) as f32 * 0.01);
    let quad = |k: u32| {
        let first = k / side * row + k % side;
        vec![first, first + 1, first + row + 1, first + row]
    };
    ((0..row * row).map(at).collect(), (0..side * side).map(quad).collect())
}

/// Each quad as two triangles.
pub fn triangles(faces: &[Vec<u32>]) -> Vec<Vec<u32>> {
    faces.iter().flat_map(|face| [vec![face[0], face[1], face[2]], vec![face[0], face[2], face[3]]]).collect()
}

/// Begins faces at other corners.
pub fn turn(faces: &mut [Vec<u32>], random: &mut Random) {
    for face in faces {
        let by = random.below(face.len());
        face.rotate_left(by);
    }
}

/// What is painted: a color in codes over 255 at a point.
pub fn picture(at: Vec3, noise: f32, random: &mut Random) -> Vec3 {
    let waves = Vec3::new((at.x * 5.0).sin(), (at.y * 7.0 + at.x).cos(), (at.z * 4.0 - at.y * 3.0).sin());
    let grain = Vec3::new(random.unit(), random.unit(), random.unit()) * 2.0 - 1.0;
    (Vec3::splat(0.5) + waves * (0.4 * (1.0 - noise)) + grain * (0.5 * noise)).clamp(Vec3::ZERO, Vec3::ONE)
}

impl Painted {
    /// Paints every texel at its center. `data` is the header's number; halves and floats are linear light.
    pub fn new(
        (positions, faces): (Vec<Vec3>, Vec<Vec<u32>>),
        data: u32,
        noise: f32,
        random: &mut Random,
        log2: impl Fn(usize) -> [u8; 2],
    ) -> Self {
        let neighbours = writer::neighbours(&faces);
        let is_triangles = faces[0].len() == 3;
        let made = neighbours.into_iter().enumerate().map(|(number, neighbours)| {
            let log2 = log2(number);
            let size = log2.map(|log2| 1usize << log2);
            let corners: Vec<Vec3> = faces[number].iter().map(|&v| positions[v as usize]).collect();
            let mut numbers = Vec::new();
            for v in 0..size[1] {
                for u in 0..size[0] {
                    let at = point(&corners, texel_center(is_triangles, size, [u, v]));
                    let color = picture(at, noise, random);
                    numbers.extend(color.to_array().map(|share| match data {
                        writer::U8 => (share * 255.0).round(),
                        writer::U16 => (share * 65535.0).round(),
                        _ => srgb_to_linear(share),
                    }));
                }
            }
            let stored =
                [Stored::DiffZipped, Stored::Zipped, Stored::Tiled([log2[0].min(2), log2[1].min(1)])];
            Face { log2, neighbours, is_subface: false, stored: stored[number % 3], numbers }
        });
        let made = made.collect();
        let file = Ptex { is_triangles, data, channels: 3, alpha: None, faces: made };
        Self { positions, faces, file }
    }

    pub fn obj(&self, head: &str) -> String {
        let mut text = head.to_owned();
        for at in &self.positions {
            writeln!(text, "v {} {} {}", at.x, at.y, at.z).unwrap();
        }
        for face in &self.faces {
            let corners: Vec<String> = face.iter().map(|v| (v + 1).to_string()).collect();
            writeln!(text, "f {}", corners.join(" ")).unwrap();
        }
        text
    }

    /// The mesh with its texture beside it, and no material.
    pub fn upload(&self) -> Upload {
        let files = [("ball.obj", self.obj("").into_bytes()), ("ball.ptx", self.file.bytes())];
        let files = files.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect();
        Upload { main: "ball.obj".to_owned(), files: Box::new(MemoryFiles(files)) }
    }

    pub fn texel_count(&self) -> usize {
        self.file.faces.iter().map(|face| 1 << (face.log2[0] + face.log2[1])).sum()
    }

    /// A texel as linear light.
    pub fn texel(&self, face: usize, u: usize, v: usize) -> Vec3 {
        let of = &self.file.faces[face];
        let at = (v << of.log2[0] | u) * 3;
        let number = Vec3::from_slice(&of.numbers[at..at + 3]);
        match self.file.data {
            writer::U8 => number.map(|code| srgb_to_linear(code / 255.0)),
            writer::U16 => number.map(|code| srgb_to_linear(code / 65535.0)),
            writer::HALF => number.map(|value| half::f16::from_f32(value).to_f32()),
            _ => number,
        }
    }

    /// Ptex's bilinear filter at a point of a quad, in linear light: between the four nearest texel centers, of which those beyond an edge
    /// are the neighbour's. `None` in the quarter texel at an extraordinary vertex, and beside a neighbour of another resolution.
    pub fn bilinear(&self, face: usize, [s, t]: [f32; 2]) -> Option<Vec3> {
        let size = self.file.faces[face].log2.map(|log2| 1i64 << log2);
        let (x, y) = (s * size[0] as f32 - 0.5, t * size[1] as f32 - 0.5);
        let (i, j) = (x.floor() as i64, y.floor() as i64);
        let (p, q) = (x - i as f32, y - j as f32);
        let at = |di: i64, dj: i64| self.walk(face, [i + di, j + dj]);
        let row = |dj: i64| Some(at(0, dj)?.lerp(at(1, dj)?, p));
        Some(row(0)?.lerp(row(1)?, q))
    }

    /// A texel of a face, or, one beyond its edges, of a neighbour.
    fn walk(&self, face: usize, at: [i64; 2]) -> Option<Vec3> {
        let size = self.file.faces[face].log2.map(|log2| 1i64 << log2);
        let beyond = [at[1] < 0, at[0] >= size[0], at[1] >= size[1], at[0] < 0];
        let across: Vec<usize> = (0..4).filter(|&edge| beyond[edge]).collect();
        let clamped = [0, 1].map(|axis| at[axis].clamp(0, size[axis] - 1));
        match across[..] {
            [] => Some(self.texel(face, at[0] as usize, at[1] as usize)),
            [edge] => match self.cross(face, edge, at) {
                // At a border of the mesh the edge's own texel is repeated.
                None => Some(self.texel(face, clamped[0] as usize, clamped[1] as usize)),
                Some((other, other_edge, along)) => self.beside(face, edge, other, other_edge, along),
            },
            [first, second] => {
                // Both ways around the corner must come to one face: then four meet there.
                let ways = [(first, second), (second, first)].map(|(first, second)| {
                    let Some((other, other_edge)) = self.file.faces[face].neighbours[first] else {
                        return Err(());
                    };
                    // Beyond the neighbour's edge that the second one goes on in.
                    let turn = if (first + 1) % 4 == second { 3 } else { 1 };
                    Ok(self.file.faces[other as usize].neighbours[(other_edge as usize + turn) % 4])
                });
                let border = |edge: usize| self.file.faces[face].neighbours[edge].is_none();
                match ways {
                    [Ok(Some(a)), Ok(Some(b))] if a.0 == b.0 && !border(first) => {
                        let other = a.0 as usize;
                        let same = self.file.faces[other].log2 == [self.file.faces[face].log2[0]; 2]
                            && self.file.faces[face].log2[0] == self.file.faces[face].log2[1];
                        let vertex = self.faces[face][if (first + 1) % 4 == second { second } else { first }];
                        let corner = self.faces[other].iter().position(|&v| v == vertex)?;
                        same.then(|| self.corner_texel(other, corner))
                    }
                    // One side of the mesh's border: the texel beyond the other edge, repeated.
                    _ if border(first) && !border(second) => self.walk(face, keep(at, clamped, first)),
                    _ if border(second) && !border(first) => self.walk(face, keep(at, clamped, second)),
                    _ if border(first) && border(second) => self.walk(face, clamped),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    fn cross(&self, face: usize, edge: usize, at: [i64; 2]) -> Option<(usize, usize, i64)> {
        let (other, other_edge) = self.file.faces[face].neighbours[edge]?;
        let size = self.file.faces[face].log2.map(|log2| 1i64 << log2);
        let along = match edge {
            0 => at[0],
            1 => at[1],
            2 => size[0] - 1 - at[0],
            _ => size[1] - 1 - at[1],
        };
        Some((other as usize, other_edge as usize, along))
    }

    /// The neighbour's texel that mirrors one at an edge; faces turn the same way, so its edge runs back.
    fn beside(&self, face: usize, edge: usize, other: usize, other_edge: usize, along: i64) -> Option<Vec3> {
        let length = 1i64 << self.file.faces[face].log2[edge % 2];
        let across = self.file.faces[face].log2[(edge + 1) % 2];
        let theirs = self.file.faces[other].log2;
        if 1 << theirs[other_edge % 2] != length || theirs[(other_edge + 1) % 2] != across {
            return None;
        }
        let size = theirs.map(|log2| 1i64 << log2);
        let back = length - 1 - along;
        let [u, v] = match other_edge {
            0 => [back, 0],
            1 => [size[0] - 1, back],
            2 => [size[0] - 1 - back, size[1] - 1],
            _ => [0, size[1] - 1 - back],
        };
        Some(self.texel(other, u as usize, v as usize))
    }

    fn corner_texel(&self, face: usize, corner: usize) -> Vec3 {
        let last = self.file.faces[face].log2.map(|log2| (1usize << log2) - 1);
        let [u, v] = [[0, 0], [last[0], 0], last, [0, last[1]]][corner];
        self.texel(face, u, v)
    }

    /// The Gaussian of Ptex's triangle filter at its sharpest (half a texel's side), inside of a face far from its edges; in the
    /// frame in which the face is equilateral. `None` near the edges.
    pub fn gaussian(&self, face: usize, [s, t]: [f32; 2]) -> Option<Vec3> {
        let n = 1usize << self.file.faces[face].log2[0];
        let side = n as f32;
        let reach = 2.0 / side;
        if s < reach || t < reach || s + t > 1.0 - reach {
            return None;
        }
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for v in 0..n {
            for u in 0..n {
                let [x, y] = texel_center(true, [n, n], [u, v]);
                let (a, b) = ((x - s) * side, (y - t) * side);
                // |a e1 + b e2|² with unit sides at 60 degrees.
                let squared = a * a + a * b + b * b;
                let weight = (-0.5 * squared / 0.25).exp();
                if squared < 1.75 * 1.75 {
                    sum += self.texel(face, u, v) * weight;
                    weights += weight;
                }
            }
        }
        Some(sum / weights)
    }

    /// Means of the triangular texels that meet at the grid's vertices, linear in between; inside of a face.
    pub fn six_means(&self, face: usize, [s, t]: [f32; 2]) -> Option<Vec3> {
        let n = 1usize << self.file.faces[face].log2[0];
        let (x, y) = (s * n as f32, t * n as f32);
        let (i, j) = (x.floor(), y.floor());
        let (p, q) = (x - i, y - j);
        let weighted = if p + q <= 1.0 {
            [(i, j, 1.0 - p - q), (i + 1.0, j, p), (i, j + 1.0, q)]
        } else {
            [(i + 1.0, j + 1.0, p + q - 1.0), (i + 1.0, j, 1.0 - q), (i, j + 1.0, 1.0 - p)]
        };
        let mut value = Vec3::ZERO;
        for (i, j, weight) in weighted {
            let [i, j] = [i as usize, j as usize];
            if i == 0 || j == 0 || i + j >= n {
                return None;
            }
            let even = |a: usize, b: usize| self.texel(face, a, b);
            let odd = |a: usize, b: usize| self.texel(face, n - 1 - b, n - 1 - a);
            let six = even(i, j) + even(i - 1, j) + even(i, j - 1);
            value += (six + odd(i - 1, j - 1) + odd(i - 1, j) + odd(i, j - 1)) * (weight / 6.0);
        }
        Some(value)
    }
}

/// A texel number that is kept inside across one edge.
fn keep(at: [i64; 2], clamped: [i64; 2], edge: usize) -> [i64; 2] {
    let axis = (edge + 1) % 2;
    let mut kept = at;
    kept[axis] = clamped[axis];
    kept
}

/// Where a texel's middle is, as shares along u and v.
fn texel_center(is_triangles: bool, size: [usize; 2], [u, v]: [usize; 2]) -> [f32; 2] {
    let [n, m] = size.map(|side| side as f32);
    if !is_triangles {
        return [(u as f32 + 0.5) / n, (v as f32 + 0.5) / m];
    }
    if u + v < size[0] {
        [(u as f32 + 1.0 / 3.0) / n, (v as f32 + 1.0 / 3.0) / n]
    } else {
        [1.0 - (v as f32 + 1.0 / 3.0) / n, 1.0 - (u as f32 + 1.0 / 3.0) / n]
    }
}

fn point(corners: &[Vec3], [s, t]: [f32; 2]) -> Vec3 {
    match *corners {
        [a, b, c] => a + (b - a) * s + (c - a) * t,
        _ => corners[0].lerp(corners[1], s).lerp(corners[3].lerp(corners[2], s), t),
    }
}
