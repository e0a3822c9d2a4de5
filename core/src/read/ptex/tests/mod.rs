//! Ptex files written by [`writer`], as textures on the meshes of [`Model`].

mod continuity;
mod format;
mod hostile;
pub mod writer;

use glam::{Vec2, Vec4};

use super::super::budget::Budget;
use super::super::resources::Resources;
use super::super::warnings::Warnings;
use super::super::{Context, Limits, MemoryFiles};
use super::*;
use crate::error::{ErrorCode, Warning};
use crate::image::{Transfer, Wrap, bilinear};
use crate::watch::Unwatched;
use writer::{Face, Ptex, Stored};

/// xorshift64*.
#[derive(Clone)]
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % limit
    }
}

/// A mesh's faces as vertices, with the file that paints it.
struct Model {
    faces: Vec<Vec<u32>>,
    file: Ptex,
}

impl Model {
    /// Random texels; `log2` gives a face's resolution.
    fn random(
        faces: Vec<Vec<u32>>,
        data: u32,
        random: &mut Random,
        log2: impl Fn(&mut Random) -> [u8; 2],
    ) -> Self {
        const CHANNELS: usize = 3;
        let neighbours = writer::neighbours(&faces);
        let is_triangles = faces[0].len() == 3;
        let made = neighbours.into_iter().map(|neighbours| {
            let log2 = log2(random);
            let mut number = || match data {
                writer::U8 => random.below(256) as f32,
                writer::U16 => random.below(65536) as f32,
                _ => random.below(1025) as f32 / 1024.0,
            };
            let numbers = (0..CHANNELS << (log2[0] + log2[1])).map(|_| number()).collect();
            Face { log2, neighbours, is_subface: false, stored: Stored::Zipped, numbers }
        });
        let faces_made = made.collect();
        let file = Ptex { is_triangles, data, channels: CHANNELS, alpha: None, faces: faces_made };
        Self { faces, file }
    }

    fn read(&self) -> Result<(Painted, Vec<Warning>)> {
        read_as(&self.file.bytes(), &self.faces, Kind::Color, &Limits::default())
    }

    /// The function at a point of a face: `s` and `t` along u and v.
    fn at(&self, painted: &Painted, face: usize, s: f32, t: f32) -> Vec4 {
        let corners = &painted.texcoords[face * self.faces[face].len()..];
        let (a, along_u) = (corners[0], corners[1] - corners[0]);
        let along_v = corners[self.faces[face].len() - 1] - a;
        let size = Vec2::new(painted.image.width as f32, painted.image.height as f32);
        bilinear(&painted.image, Transfer::Srgb, Wrap::default(), (a + along_u * s + along_v * t) * size)
    }
}

fn read_as(bytes: &[u8], faces: &[Vec<u32>], kind: Kind, limits: &Limits) -> Result<(Painted, Vec<Warning>)> {
    let files = MemoryFiles::default();
    let mut context = Context {
        resources: Resources::new(&files, "m.obj"),
        budget: Budget::new(limits),
        warnings: Warnings::default(),
        watch: &Unwatched,
    };
    let painted = read(bytes, Mesh { vertices: faces.concat(), parts: None }, kind, "m.ptx", &mut context)?;
    Ok((painted, context.warnings.into_list()))
}
