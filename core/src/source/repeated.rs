//! Faces that show a part of a picture that other faces show too: mirrored halves, stamps, tiles.

use std::collections::HashMap;

use glam::Vec2;

use super::SurfaceSource;
use super::texture::period_texels;
use crate::math::frame::Frame;
use crate::mesh::CanvasMesh;

/// Corners this near are one, in texels.
const NEAR_TEXELS: f32 = 1.0 / 64.0;

/// A face's corners in the picture, in an order of their own.
type Corners = [[i64; 2]; 4];

impl SurfaceSource<'_> {
    /// By face of a normal map: the source's frames at its corners, where it shows what another face shows too. In these
    /// frames both store the same, since they were painted by the same texels: also where one is the other's mirror
    /// image, whose frames have the other handedness.
    pub fn repeated_frames(&self, canvas: &CanvasMesh) -> Vec<Option<[Frame; 4]>> {
        let corners: Vec<Option<Corners>> =
            (0..canvas.faces.len()).map(|face| self.corners_shown(canvas, face)).collect();
        let mut counts: HashMap<Corners, u32> = HashMap::new();
        for &corners in corners.iter().flatten() {
            *counts.entry(corners).or_default() += 1;
        }
        let is_repeated = |corners: &Option<Corners>| corners.is_some_and(|corners| counts[&corners] > 1);
        let frames = |(face, corners): (usize, &Option<Corners>)| {
            is_repeated(corners).then(|| self.frames_of(canvas, face)).flatten()
        };
        corners.iter().enumerate().map(frames).collect()
    }

    /// `None` where a quad's triangles show the ends of its diagonal in different places.
    fn corners_shown(&self, canvas: &CanvasMesh, face: usize) -> Option<Corners> {
        let [a, b, c, d] = joined(*self.places(face), canvas.faces[face].is_triangle())?;
        let all = [a, b, c, d];
        let least = all.into_iter().fold(Vec2::INFINITY, Vec2::min);
        let whole =
            ((least + NEAR_TEXELS) / period_texels(self.channel)).floor() * period_texels(self.channel);
        let whole = Vec2::select(whole.is_finite_mask(), whole, Vec2::ZERO);
        let mut corners =
            all.map(|place| ((place - whole) / NEAR_TEXELS).round().to_array().map(|at| at as i64));
        corners.sort_unstable();
        Some(corners)
    }

    /// The frames of a face's corners, orthonormal; `None` where they are no frame for both of its triangles, or not
    /// all of one handedness.
    fn frames_of(&self, canvas: &CanvasMesh, face: usize) -> Option<[Frame; 4]> {
        let frames = joined(*self.frames.get(face)?, canvas.faces[face].is_triangle())?;
        let handedness = frames[0].tangent.w;
        let mut orthonormal = frames;
        for frame in &mut orthonormal {
            let tangent = frame.tangent.truncate();
            let across = (tangent - frame.normal * frame.normal.dot(tangent)).try_normalize()?;
            if frame.tangent.w != handedness {
                return None;
            }
            frame.tangent = across.extend(handedness);
        }
        Some(orthonormal)
    }
}

/// What stands at a face's corners (of a triangle the third twice), where both of its triangles have the same at the
/// diagonal's ends.
fn joined<T: Copy + PartialEq>([[a, b, c], [e, f, d]]: [[T; 3]; 2], is_triangle: bool) -> Option<[T; 4]> {
    if is_triangle {
        return Some([a, b, c, c]);
    }
    (a == e && c == f).then_some([a, b, c, d])
}
