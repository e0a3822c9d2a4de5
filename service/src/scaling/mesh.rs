//! The torus: a grid of triangle pairs as OBJ, under a picture that repeats every few of them.

use std::f64::consts::TAU;
use std::fmt::Write;

use meshcolor::image::{Image, Pixels};
use meshcolor::read::{MemoryFiles, Upload};

/// Texels of the picture along each side.
const SIDE_TEXELS: u32 = 32;
/// Texels under each of the pairs of triangles that one repeat of the picture covers, along each side.
/// They differ, so exponents do, and some faces are beyond vertex colors while others have levels left.
const PAIR_TEXELS: [u64; 8] = [2, 2, 10, 2, 2, 2, 10, 2];
const RADII: [f64; 2] = [2.0, 0.7];

/// Pairs around the tube; along it are twice as many.
fn around(face_count: u64) -> u64 {
    ((face_count as f64 / 4.0).sqrt().round() as u64).max(3)
}

/// The faces that a torus of about `face_count` has.
pub fn face_count(face_count: u64) -> u64 {
    4 * around(face_count).pow(2)
}

/// Texture coordinate of the line of vertices with this number.
fn coordinate(number: u64) -> f64 {
    let (tiles, rest) = (number / PAIR_TEXELS.len() as u64, number as usize % PAIR_TEXELS.len());
    let texels: u64 = PAIR_TEXELS[..rest].iter().sum();
    tiles as f64 + texels as f64 / f64::from(SIDE_TEXELS)
}

/// A torus of about `face_count` triangles.
pub fn torus(face_count: u64) -> Upload {
    let around = around(face_count);
    let along = 2 * around;
    let mut text = "mtllib torus.mtl\nusemtl torus\n".to_owned();
    for i in 0..along {
        for j in 0..around {
            let (sin_u, cos_u) = (i as f64 / along as f64 * TAU).sin_cos();
            let (sin_v, cos_v) = (j as f64 / around as f64 * TAU).sin_cos();
            let radius = RADII[0] + RADII[1] * cos_v;
            // Writing to a string cannot fail.
            let _ = writeln!(text, "v {:.6} {:.6} {:.6}", radius * cos_u, radius * sin_u, RADII[1] * sin_v);
        }
    }
    for i in 0..=along {
        for j in 0..=around {
            let _ = writeln!(text, "vt {} {}", coordinate(i), coordinate(j));
        }
    }
    let corner = |i: u64, j: u64| {
        let position = (i % along) * around + j % around + 1;
        format!("{position}/{}", i * (around + 1) + j + 1)
    };
    for i in 0..along {
        for j in 0..around {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            let _ = writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}");
        }
    }
    let mut files = MemoryFiles::default();
    files.0.insert("torus.obj".to_owned(), text.into_bytes());
    files.0.insert("torus.mtl".to_owned(), b"newmtl torus\nmap_Kd torus.png\n".to_vec());
    // The picture is made here, with as many codes as its size says, which is all that can fail.
    files.0.insert("torus.png".to_owned(), meshcolor::write::png(&picture()).unwrap_or_default());
    Upload { main: "torus.obj".to_owned(), files: Box::new(files) }
}

/// Soft checks between black and white: the range's ends are met, so the solver has work.
fn picture() -> Image {
    let mut codes = Vec::new();
    for y in 0..SIDE_TEXELS {
        for x in 0..SIDE_TEXELS {
            let wave = |at: u32, waves: f64| (f64::from(at) / f64::from(SIDE_TEXELS) * TAU * waves).sin();
            let value = |waves: f64| (0.5 + 0.9 * wave(x, waves) * wave(y, waves + 1.0)).clamp(0.0, 1.0);
            codes.extend([1.0, 2.0, 3.0].map(|waves| (value(waves) * 255.0).round() as u8));
        }
    }
    Image { width: SIDE_TEXELS, height: SIDE_TEXELS, components: 3, pixels: Pixels::U8(codes) }
}
