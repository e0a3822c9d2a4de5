//! Light: the CPU twin of the functions of the same names in `preview.wgsl`. Everything is in view
//! space, so that the lights stand with the camera. Colors are linear.

use glam::{Vec2, Vec3};

const KEY_DIRECTION: Vec3 = Vec3::new(-0.485, 0.606, 0.631);
const KEY_COLOR: Vec3 = Vec3::new(0.94, 0.90, 0.84);
const FILL_DIRECTION: Vec3 = Vec3::new(0.873, 0.087, 0.480);
const FILL_COLOR: Vec3 = Vec3::new(0.16, 0.19, 0.23);
const SKY_COLOR: Vec3 = Vec3::new(0.30, 0.32, 0.35);
const GROUND_COLOR: Vec3 = Vec3::new(0.11, 0.105, 0.10);
/// Above this a soft shoulder keeps highlights from clipping.
const SHOULDER: f32 = 0.8;

/// A surface as light finds it.
#[derive(Clone, Copy, Debug)]
pub struct Shaded {
    pub base_color: Vec3,
    pub metallic: f32,
    pub roughness: f32,
    pub occlusion: f32,
    pub emissive: Vec3,
    /// Unit length.
    pub normal: Vec3,
    /// Toward the eye, unit length.
    pub eye: Vec3,
}

pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The light that one direction gives, over π.
pub fn direct(shaded: &Shaded, direction: Vec3, light: Vec3) -> Vec3 {
    let facing = shaded.normal.dot(direction).max(0.0);
    let halfway = (direction + shaded.eye).normalize_or(shaded.normal);
    let alpha = (shaded.roughness * shaded.roughness).max(0.06);
    let shininess = 2.0 / (alpha * alpha) - 2.0;
    let lobe = (shininess + 2.0) / 8.0 * shaded.normal.dot(halfway).max(1e-4).powf(shininess);
    let reflectance = Vec3::splat(0.04).lerp(shaded.base_color, shaded.metallic);
    // Metal keeps a little diffuse: there are no surroundings for it to mirror.
    let diffuse = shaded.base_color * (1.0 - 0.7 * shaded.metallic);
    light * facing * (diffuse + reflectance * lobe.min(6.0))
}

/// The light from all around: a sky above, a ground below, and their blurred mirror image.
pub fn ambient(shaded: &Shaded) -> Vec3 {
    let around = GROUND_COLOR.lerp(SKY_COLOR, 0.5 + 0.5 * shaded.normal.y);
    let mirrored = 2.0 * shaded.normal.dot(shaded.eye) * shaded.normal - shaded.eye;
    let blur = 0.15 + 0.85 * shaded.roughness;
    let reflected = GROUND_COLOR.lerp(SKY_COLOR * 2.0, smoothstep(-blur, blur, mirrored.y));
    let reflectance = Vec3::splat(0.04).lerp(shaded.base_color, shaded.metallic);
    let diffuse = shaded.base_color * (1.0 - 0.7 * shaded.metallic);
    shaded.occlusion * (diffuse * around + reflectance * reflected)
}

/// The color that the eye sees.
pub fn lit(shaded: &Shaded) -> Vec3 {
    let light = direct(shaded, KEY_DIRECTION, KEY_COLOR)
        + direct(shaded, FILL_DIRECTION, FILL_COLOR)
        + ambient(shaded)
        + shaded.emissive;
    let over = (light - SHOULDER).max(Vec3::ZERO);
    let bent = SHOULDER + (1.0 - SHOULDER) * (1.0 - (-over / (1.0 - SHOULDER)).exp());
    light.min(bent)
}

/// A stored normal map value as a direction in the frame of `normal` and `tangent`.
pub fn mapped_normal(stored: Vec3, scale: f32, normal: Vec3, tangent: Vec3, handedness: f32) -> Vec3 {
    let local = (stored * 2.0 - 1.0) * Vec3::new(scale, scale, 1.0);
    let bitangent = normal.cross(tangent) * handedness;
    (tangent * local.x + bitangent * local.y + normal * local.z).normalize_or(normal)
}

/// log2 of source texels per pixel: what a GPU computes for a texture with mip maps.
pub fn source_lambda(uv_dx: Vec2, uv_dy: Vec2, size: Vec2) -> f32 {
    crate::twins::mct_lambda(uv_dx * size, uv_dy * size)
}
