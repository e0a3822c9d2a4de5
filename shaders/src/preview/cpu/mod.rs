//! The renderer for machines without a Vulkan adapter, built on the CPU twins of the shaders: four
//! samples a pixel, bands of rows in parallel, the same picture with any number of threads.

mod fragment;
mod raster;
mod sample;

use glam::{DVec2, Vec3, Vec4};
use meshcolor::asset::AlphaMode;
use meshcolor::math::transfer::{linear_to_srgb, srgb_to_linear};
use rayon::prelude::*;

use self::fragment::Fragment;
use self::raster::{SAMPLES, Triangle, Weights};
use super::PreviewError;
use super::picture::{BACKGROUND_SRGB, Picture, Renderer};
use super::scene::Shot;
use super::scene::geometry::Batch;
use super::scene::texture::Texture;

/// Rows that one task draws.
const BAND_ROWS: u32 = 12;

/// Draws on the CPU. `label` says why, on the sheet.
pub struct CpuRenderer {
    pub label: String,
}

impl Renderer for CpuRenderer {
    fn label(&self) -> String {
        self.label.clone()
    }

    fn draw(&mut self, textures: &[Texture<'_>], shot: &Shot<'_>) -> Result<Picture, PreviewError> {
        let [width, height] = shot.size;
        let prepared: Vec<Prepared<'_>> = shot.batches.iter().map(|batch| prepare(batch, shot)).collect();
        let bands: Vec<Vec<u8>> = (0..height.div_ceil(BAND_ROWS))
            .into_par_iter()
            .map(|band| {
                let first = band * BAND_ROWS;
                let rows = [first, (first + BAND_ROWS).min(height)];
                let mut target = Band::new(width, rows);
                for batch in &prepared {
                    target.draw(batch, textures, shot);
                }
                target.resolve()
            })
            .collect();
        Ok(Picture { size: shot.size, rgb: bands.concat() })
    }
}

/// A batch with the triangles that can be seen, in its own order.
struct Prepared<'a> {
    batch: &'a Batch,
    /// With the triangle's number in the batch.
    triangles: Vec<(usize, Triangle)>,
}

fn prepare<'a>(batch: &'a Batch, shot: &Shot<'_>) -> Prepared<'a> {
    let triangles = (0..batch.triangle_count()).into_par_iter().filter_map(|number| {
        let positions = batch.triangle(number).map(|record| Vec3::new(record[0], record[1], record[2]));
        let triangle = Triangle::new(positions, &shot.camera.projection, shot.size)?;
        (triangle.is_front || batch.surface.double_sided).then_some((number, triangle))
    });
    Prepared { batch, triangles: triangles.collect() }
}

/// Some rows of the picture while they are drawn.
struct Band {
    width: u32,
    /// First row, and the one past the last.
    rows: [u32; 2],
    /// Linear; four samples a pixel.
    colors: Vec<[Vec3; 4]>,
    depths: Vec<[f32; 4]>,
}

impl Band {
    fn new(width: u32, rows: [u32; 2]) -> Self {
        let pixel_count = (width * (rows[1] - rows[0])) as usize;
        let background =
            Vec3::from_array(BACKGROUND_SRGB.map(|code| srgb_to_linear(f32::from(code) / 255.0)));
        Self { width, rows, colors: vec![[background; 4]; pixel_count], depths: vec![[1.0; 4]; pixel_count] }
    }

    fn draw(&mut self, prepared: &Prepared<'_>, textures: &[Texture<'_>], shot: &Shot<'_>) {
        for (number, triangle) in &prepared.triangles {
            let first = triangle.rows[0].max(self.rows[0]);
            for y in first..=triangle.rows[1].min(self.rows[1] - 1) {
                for x in triangle.columns[0]..=triangle.columns[1] {
                    self.draw_pixel([x, y], (*number, triangle), prepared.batch, textures, shot);
                }
            }
        }
    }

    #[inline]
    fn draw_pixel(
        &mut self,
        [x, y]: [u32; 2],
        (number, triangle): (usize, &Triangle),
        batch: &Batch,
        textures: &[Texture<'_>],
        shot: &Shot<'_>,
    ) {
        let corner = DVec2::new(f64::from(x), f64::from(y));
        let at = ((y - self.rows[0]) * self.width + x) as usize;
        let mut visible = [None; 4];
        let mut covered = (DVec2::ZERO, 0.0);
        for (sample, offset) in SAMPLES.into_iter().enumerate() {
            let point = corner + offset;
            if !triangle.covers(point) {
                continue;
            }
            covered = (covered.0 + point, covered.1 + 1.0);
            let depth = triangle.depth(point);
            if (0.0..=1.0).contains(&depth) && depth < self.depths[at][sample] {
                visible[sample] = Some(depth);
            }
        }
        if visible.iter().all(Option::is_none) {
            return;
        }
        let fragment = Fragment {
            batch,
            triangle: number,
            corners: batch.triangle(number),
            is_front: triangle.is_front,
            weights: weights(triangle, corner + 0.5, covered.0 / covered.1),
            textures,
            painted: shot.painted,
            filter: shot.filter,
        };
        let Some(color) = fragment.color(shot.look) else { return };
        let is_blended = batch.surface.alpha_mode == AlphaMode::Blend;
        for (sample, depth) in visible.into_iter().enumerate() {
            if let Some(depth) = depth {
                let target = &mut self.colors[at][sample];
                *target = if is_blended { over(color, *target) } else { color.truncate() };
                self.depths[at][sample] = depth;
            }
        }
    }

    fn resolve(&self) -> Vec<u8> {
        let mean = |samples: &[Vec3; 4]| samples.iter().sum::<Vec3>() / 4.0;
        let encode = |linear: f32| (linear_to_srgb(linear).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        self.colors.iter().flat_map(|samples| mean(samples).to_array().map(encode)).collect()
    }
}

/// Values are taken at the pixel's middle where the triangle covers it, else among the samples that it
/// covers; derivatives always at the middle, as on a GPU.
fn weights(triangle: &Triangle, middle: DVec2, covered_mean: DVec2) -> Weights {
    let at_middle = triangle.weights(middle);
    if triangle.covers(middle) {
        return at_middle;
    }
    Weights { at: triangle.weights(covered_mean).at, ..at_middle }
}

fn over(color: Vec4, below: Vec3) -> Vec3 {
    color.truncate() * color.w + below * (1.0 - color.w)
}
