//! How near a conversion is to its source at level 0, at random points of the surface, beside the
//! [yardstick](super::yardstick) at the same points.

use glam::Vec3;
use rayon::prelude::*;

use super::histogram::Histogram;
use super::judge::{Meaning, degrees_between, interpolated, object_normal};
use super::origin::Origin;
use super::painted::PaintedOrigin;
use super::points::SurfacePoint;
use super::report::Fidelity;
use super::seams::Converted;
use super::texels::{Texels, stored_components};
use super::yardstick::{Extent, Yardstick};
use crate::image::Pixels;

/// Random points of a material's surface, the same for all its channels: one for each texel of level 0,
/// within these bounds. With the most, the PSNR's own error is under 0.05 dB.
const POINTS_LEAST: u64 = 1024;
const POINTS_MOST: u64 = 65_536;

/// How many points judge a material whose largest texture has this many texels at level 0.
pub fn point_count(texel_count: u64) -> usize {
    texel_count.clamp(POINTS_LEAST, POINTS_MOST) as usize
}

/// Stands for "no difference".
const PSNR_CEILING_DB: f64 = 99.0;

/// Points summed in one go; part of the order of summation, and so of the figures' last digits.
const CHUNK: usize = 4096;

/// The share of the errors that lie at or under the percentile.
const P99: (u64, u64) = (99, 100);

/// Compares at `points`; `None` where there are none. The yardstick has `texel_count` texels.
pub fn fidelity(
    origin: &Origin<'_>,
    converted: &Converted<'_>,
    points: &[SurfacePoint],
    (extent, texel_count): (Extent, usize),
) -> Option<Fidelity> {
    let finest = converted.textures.first()?.levels.first()?;
    if points.is_empty() {
        return None;
    }
    let bits = if matches!(finest.pixels, Pixels::U8(_)) { 8 } else { 16 };
    let area_texels = extent.area_texels(origin, converted.surface);
    let comparison = Comparison {
        origin,
        converted,
        source: origin.texels(origin.image),
        levels: (0..converted.surface.parts.len()).map(|part| converted.texels(part, 0)).collect(),
        yardstick: Yardstick::new(origin, area_texels, texel_count, bits),
    };
    let chunks: Vec<[Errors; 2]> = points.par_chunks(CHUNK).map(|points| comparison.errors(points)).collect();
    let [mut ours, mut yardstick] = <[Errors; 2]>::default();
    for chunk in &chunks {
        ours.join(&chunk[0]);
        yardstick.join(&chunk[1]);
    }
    let is_normal = matches!(origin.meaning, Meaning::Normal { .. });
    Some(Fidelity {
        yardstick_psnr_db: Some(yardstick.psnr_db()),
        yardstick_rms: Some(yardstick.rms(is_normal)),
        ..ours.figures(is_normal, points)
    })
}

/// The same for mesh colors, which are held against their samples as the reference filter reads them. There is no
/// yardstick: nothing of the source is an image.
pub fn painted_fidelity(
    painted: &PaintedOrigin<'_>,
    converted: &Converted<'_>,
    points: &[SurfacePoint],
) -> Option<Fidelity> {
    if points.is_empty() || converted.level_count() == 0 {
        return None;
    }
    let levels: Vec<_> = (0..converted.surface.parts.len()).map(|part| converted.texels(part, 0)).collect();
    let which = stored_components(painted.channel.components);
    let errors = |points: &[SurfacePoint]| {
        let mut errors = Errors::default();
        for point in points {
            let (number, triangle) = (point.part as usize, point.triangle as usize);
            let part = &converted.surface.parts[number];
            let wanted = painted.shown(number, triangle, point.at);
            let ours = levels[number].bilinear(part.place_at(triangle, point.at, 0));
            match painted.meaning {
                Meaning::Normal { scale } => {
                    let Some(frames) = part.frames().get(triangle) else { continue };
                    let frame = interpolated(frames, point.at);
                    // Samples that cancel out show the surface itself.
                    let wanted = wanted.truncate().normalize_or(frame.normal.normalize_or(Vec3::Z));
                    errors.add_normals(wanted, object_normal(ours, scale, &frame));
                }
                meaning => errors.add_codes(which, meaning.codes(wanted.to_array()), meaning.codes(ours)),
            }
        }
        errors
    };
    let mut sum = Errors::default();
    let chunks: Vec<Errors> = points.par_chunks(CHUNK).map(errors).collect();
    chunks.iter().for_each(|chunk| sum.join(chunk));
    Some(sum.figures(matches!(painted.meaning, Meaning::Normal { .. }), points))
}

struct Comparison<'a> {
    origin: &'a Origin<'a>,
    converted: &'a Converted<'a>,
    source: Texels<'a>,
    /// Level 0 by part of the surface.
    levels: Vec<Texels<'a>>,
    yardstick: Yardstick<'a>,
}

impl Comparison<'_> {
    /// Of the conversion, and of the yardstick.
    fn errors(&self, points: &[SurfacePoint]) -> [Errors; 2] {
        let mut sums = <[Errors; 2]>::default();
        let size_texels = self.source.size_texels();
        for point in points {
            let (number, triangle) = (point.part as usize, point.triangle as usize);
            let part = &self.converted.surface.parts[number];
            let place = self.origin.place(number, part.triangles[triangle], point.at, size_texels);
            let vertices = part.triangles[triangle];
            let tinted = |value| self.origin.tinted(number, vertices, point.at, value);
            let wanted = tinted(self.source.bilinear(place));
            let ours = self.levels[number].bilinear(part.place_at(triangle, point.at, 0));
            let resampled = tinted(self.yardstick.bilinear(place));
            match self.origin.meaning {
                Meaning::Normal { scale } => {
                    let (Some(of_source), Some(of_ours)) =
                        (self.origin.corner_frames(number, triangle), part.frames().get(triangle))
                    else {
                        continue;
                    };
                    let (of_source, of_ours) =
                        (interpolated(of_source, point.at), interpolated(of_ours, point.at));
                    let wanted = object_normal(wanted, scale, &of_source);
                    sums[0].add_normals(wanted, object_normal(ours, scale, &of_ours));
                    sums[1].add_normals(wanted, object_normal(resampled, scale, &of_source));
                }
                meaning => {
                    let wanted = meaning.codes(wanted);
                    let which = stored_components(self.origin.components);
                    sums[0].add_codes(which, wanted, meaning.codes(ours));
                    sums[1].add_codes(which, wanted, meaning.codes(resampled));
                }
            }
        }
        sums
    }
}

#[derive(Default)]
struct Errors {
    /// In the channel's unit: every component of every point, or every angle.
    sizes: Histogram,
    squared_codes: f64,
    code_count: u64,
    squared_degrees: f64,
    normal_count: u64,
}

impl Errors {
    fn add_codes(&mut self, which: &[usize], a: [f32; 4], b: [f32; 4]) {
        for &component in which {
            let error = a[component] - b[component];
            self.sizes.add(error.abs());
            self.squared_codes += f64::from(error).powi(2);
            self.code_count += 1;
        }
    }

    /// Normals count in codes as an object-space map would store them: `n · 0.5 + 0.5`, times 255.
    fn add_normals(&mut self, a: Vec3, b: Vec3) {
        self.squared_codes += f64::from(((a - b) * 127.5).length_squared());
        self.code_count += 3;
        let degrees = degrees_between(a, b);
        self.sizes.add(degrees);
        self.squared_degrees += f64::from(degrees).powi(2);
        self.normal_count += 1;
    }

    fn join(&mut self, other: &Self) {
        self.sizes.join(&other.sizes);
        self.squared_codes += other.squared_codes;
        self.code_count += other.code_count;
        self.squared_degrees += other.squared_degrees;
        self.normal_count += other.normal_count;
    }

    /// Without a yardstick.
    fn figures(&self, is_normal: bool, points: &[SurfacePoint]) -> Fidelity {
        Fidelity {
            psnr_db: self.psnr_db(),
            rms: self.rms(is_normal),
            p99: self.sizes.percentile(P99),
            max: self.sizes.max(),
            yardstick_psnr_db: None,
            yardstick_rms: None,
            point_count: points.len() as u64,
        }
    }

    fn psnr_db(&self) -> f64 {
        let mean = self.squared_codes / self.code_count.max(1) as f64;
        if mean > 0.0 {
            (10.0 * (255.0f64.powi(2) / mean).log10()).min(PSNR_CEILING_DB)
        } else {
            PSNR_CEILING_DB
        }
    }

    fn rms(&self, is_normal: bool) -> f64 {
        let (sum, count) = if is_normal {
            (self.squared_degrees, self.normal_count)
        } else {
            (self.squared_codes, self.code_count)
        };
        (sum / count.max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests;
