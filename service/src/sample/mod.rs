//! The demo's model, made in code: a knotted tube in nine pieces whose islands lie at odd angles in one
//! atlas. The picture is a function of the place in space, so it runs on across every border of an
//! island; and it is padded by two texels only, as happens, so mip maps bleed the background in.

mod file;
mod paint;
mod shape;
#[cfg(test)]
mod tests;

/// The model as a GLB, the same bytes on every call.
pub fn model() -> Vec<u8> {
    let shape = shape::knot();
    let color = paint::base_color(&shape);
    let normals = paint::normal_map(&shape);
    file::glb(&shape, &color, &normals)
}
