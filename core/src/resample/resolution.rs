//! Resolution exponents (method: matched area, a fixed value, or texels per world unit).

use glam::{Affine3A, Vec2};

use crate::asset::{Asset, Face};
use crate::colors::Resolutions;
use crate::mesh::{CanvasFace, CanvasMesh};
use crate::source::SurfaceSource;

/// Sides of `2^12` segments are the finest a face gets.
const EXPONENT_MAX: f32 = 12.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ResolutionRule {
    /// Texels per source texel.
    Area(f32),
    /// Exponent.
    Fixed(u8),
    /// Texels per world unit of length.
    Density(f32),
}

/// One exponent for each face. A face of `n = 2^r` segments has `n²` cells as a quad and `n²/2` as a
/// triangle; they are matched with the area asked for, to the nearest exponent.
pub fn resolutions(
    rule: ResolutionRule,
    asset: &Asset,
    canvas: &CanvasMesh,
    sources: &[SurfaceSource<'_>],
) -> Resolutions {
    let scales = world_scales(asset);
    let faces = canvas.faces.iter().enumerate().map(|(number, face)| {
        let cells = match rule {
            ResolutionRule::Fixed(exponent) => return exponent,
            ResolutionRule::Area(factor) => factor * source_area_texels(sources, number, face),
            ResolutionRule::Density(texels) => {
                let scale = scales[face.mesh as usize];
                texels * texels * face.area * scale * scale
            }
        };
        let segments = (cells * if face.is_triangle() { 2.0 } else { 1.0 }).sqrt();
        segments.max(1.0).log2().round().clamp(0.0, EXPONENT_MAX) as u8
    });
    Resolutions { faces: faces.collect() }
}

/// Area of the face in texels of the source channel that has most of them.
fn source_area_texels(sources: &[SurfaceSource<'_>], number: usize, face: &CanvasFace) -> f32 {
    let shape = Face { corners: face.vertices, count: face.count };
    let area = |source: &SurfaceSource<'_>| {
        let places = source.places(number);
        let doubled: f32 = shape
            .triangles()
            .iter()
            .map(|&[a, b, c]| Vec2::perp_dot(places[b] - places[a], places[c] - places[a]).abs())
            .sum();
        doubled * 0.5
    };
    sources.iter().map(area).fold(0.0, f32::max)
}

/// The largest linear scale at which each mesh stands in the scene; 1 where it stands nowhere.
fn world_scales(asset: &Asset) -> Vec<f32> {
    let mut scales = vec![0.0f32; asset.meshes.len()];
    for instance in &asset.instances {
        let scale = &mut scales[instance.mesh];
        *scale = scale.max(linear_scale(&instance.transform));
    }
    scales.iter_mut().filter(|scale| **scale == 0.0).for_each(|scale| *scale = 1.0);
    scales
}

fn linear_scale(transform: &Affine3A) -> f32 {
    transform.matrix3.determinant().abs().cbrt()
}
