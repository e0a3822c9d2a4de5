//! The CPU twins of `mesh_color_texture.wgsl`: same names, same arithmetic, f32 throughout.
//!
//! A test runs both on random inputs. The CPU renderer of the preview is built on these.

use glam::{Vec2, Vec4, Vec4Swizzles};
use meshcolor::image::{Image, Transfer, Wrap, WrapMode, bilinear};

#[cfg(test)]
mod adapter;
pub mod indexed;
#[cfg(test)]
mod tests;

/// What a mesh color texture's sampler does outside the image.
pub const CLAMP: Wrap = Wrap { s: WrapMode::ClampToEdge, t: WrapMode::ClampToEdge };

/// Where one level stands in a stack, texels of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MctLevel {
    pub origin: Vec2,
    pub size: Vec2,
}

/// The two levels of a trilinear fetch; `fraction` is the coarser one's weight, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MctPick {
    pub finer: u32,
    pub coarser: u32,
    pub fraction: f32,
}

/// What a filtered texel of a level stands for: scale 1 and bias 0 for all but scaled 16-bit levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MctRange {
    pub scale: Vec4,
    pub bias: Vec4,
}

/// The place of a 4D coordinate (`u_s`, `u_δ`) in the image of `level`, in texels (MCT equation 2).
pub fn mct_place(coordinate: Vec4, level: u32) -> Vec2 {
    let shrink = f32::from_bits((127 - level.min(126)) << 23);
    coordinate.xy() * shrink + coordinate.zw()
}

/// log2 of texels of level 0 per pixel, from the screen-space derivatives of `u_s`; the larger one decides.
pub fn mct_lambda(scaled_dx: Vec2, scaled_dy: Vec2) -> f32 {
    let longest_squared = scaled_dx.length_squared().max(scaled_dy.length_squared());
    0.5 * longest_squared.max(1e-30).log2()
}

/// The two levels around `lambda` among `level_count` (at least 1), and the mix between them.
pub fn mct_pick(lambda: f32, level_count: u32) -> MctPick {
    let last = (level_count.max(1) - 1) as f32;
    let within = lambda.clamp(0.0, last);
    let finer = within.floor();
    MctPick { finer: finer as u32, coarser: (finer + 1.0).min(last) as u32, fraction: within - finer }
}

/// The texture coordinate, 0 to 1, of a place in a level that is a texture of its own.
pub fn mct_texcoord(place: Vec2, size: Vec2) -> Vec2 {
    place / size
}

/// The texture coordinate of a place of `level` in a stack of levels of `stack_size` texels.
pub fn mct_in_stack(place: Vec2, level: MctLevel, stack_size: Vec2) -> Vec2 {
    let inside = place.max(Vec2::splat(0.5)).min(level.size - 0.5);
    (level.origin + inside) / stack_size
}

/// The value of a filtered texel of a level with a range.
pub fn mct_decode(filtered: Vec4, range: MctRange) -> Vec4 {
    filtered * range.scale + range.bias
}

/// The bilinear value of one level of a stack, in linear light for color.
pub fn mct_sample_level(stack: &Image, transfer: Transfer, place: Vec2, level: MctLevel) -> Vec4 {
    let stack_size = Vec2::new(stack.width as f32, stack.height as f32);
    bilinear(stack, transfer, CLAMP, mct_in_stack(place, level, stack_size) * stack_size)
}

/// The trilinear value of a stack; `levels` are the table's entries for `pick.finer` and `pick.coarser`.
pub fn mct_sample_stack(
    stack: &Image,
    transfer: Transfer,
    coordinate: Vec4,
    pick: MctPick,
    levels: [MctLevel; 2],
) -> Vec4 {
    let finer = mct_sample_level(stack, transfer, mct_place(coordinate, pick.finer), levels[0]);
    let coarser = mct_sample_level(stack, transfer, mct_place(coordinate, pick.coarser), levels[1]);
    finer.lerp(coarser, pick.fraction)
}
