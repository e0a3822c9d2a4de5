//! Many values of one face at once, along rows of its grid.
//!
//! A face is drawn as one or two triangles, and on each of them places and frames are affine in the grid's
//! coordinates. So a row costs one multiply-add a point, and texels are decoded once for a whole window.

use glam::{Mat4, Vec2, Vec3, Vec4, Vec4Swizzles};

use super::SurfaceSource;
use crate::colors::Shape;
use crate::image::{Tile, bilinear};
use crate::math::frame::Frame;

/// A window whose texels are more than this many for each fetch is read texel by texel.
const TEXELS_PER_FETCH: f32 = 8.0;
/// And one with more texels than this.
const TILE_TEXELS_MAX: f32 = 262_144.0;
/// Squared length of an interpolated normal or tangent below which the careful way is taken.
const SHORTEST_SQUARED: f32 = 1e-8;

/// A face of a source, read in rows. Reused from face to face.
#[derive(Clone, Debug, Default)]
pub struct FaceReader {
    face: usize,
    is_triangle: bool,
    segments: [f32; 2],
    /// The drawn triangles: a triangle has one, a quad one below its diagonal (and on it) and one above.
    pieces: [Piece; 2],
    tile: Tile,
    is_tiled: bool,
}

/// Affine in grid coordinates: `at + x along.0 + y along.1`.
#[derive(Clone, Copy, Debug, Default)]
struct Affine<T> {
    at: T,
    along: [T; 2],
}

#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    /// Which drawn triangle.
    triangle: usize,
    place: Affine<Vec2>,
    normal: Affine<Vec3>,
    tangent: Affine<Vec3>,
    handedness: f32,
    /// What multiplies the values, of channels with vertex colors.
    tint: Affine<Vec4>,
}

impl FaceReader {
    /// Turns to a face, to read it on a grid.
    pub fn open(&mut self, source: &SurfaceSource<'_>, face: usize, shape: Shape) {
        self.face = face;
        self.is_triangle = shape.is_triangle;
        self.segments = shape.segments.map(|segments| segments as f32);
        self.is_tiled = false;
        let scale = self.segments.map(f32::recip);
        for (triangle, piece) in self.pieces.iter_mut().enumerate() {
            let kind = if self.is_triangle { 2 } else { triangle };
            let [a, b, c] = source.places(face)[triangle];
            *piece =
                Piece { triangle, place: Affine { at: a, along: steps(kind, a, b, c, scale) }, ..*piece };
            if source.channel.is_normal() {
                let [a, b, c] = source.frames[face][triangle];
                let normals = steps(kind, a.normal, b.normal, c.normal, scale);
                let [ta, tb, tc] = [a, b, c].map(|frame| frame.tangent.xyz());
                piece.normal = Affine { at: a.normal, along: normals };
                piece.tangent = Affine { at: ta, along: steps(kind, ta, tb, tc, scale) };
                piece.handedness = a.tangent.w;
            }
            if let Some(tints) = source.tints.get(face) {
                let [a, b, c] = tints[triangle];
                piece.tint = Affine { at: a, along: steps(kind, a, b, c, scale) };
            }
        }
    }

    /// Announces about `fetch_count` fetches at grid coordinates from `least` to `most`. Rows may leave them
    /// by rounding only.
    pub fn open_window(
        &mut self,
        source: &SurfaceSource<'_>,
        least: [u32; 2],
        most: [u32; 2],
        fetch_count: usize,
    ) {
        let mut bounds = [Vec2::INFINITY, Vec2::NEG_INFINITY];
        let is_finite = self.outline(least, most).into_iter().all(|(piece, [x, y])| {
            let place = self.pieces[piece].place.at(x, y);
            bounds = [bounds[0].min(place), bounds[1].max(place)];
            place.is_finite()
        });
        let needed = Tile::needed_texels(bounds[0], bounds[1]);
        self.is_tiled = is_finite && needed <= (TEXELS_PER_FETCH * fetch_count as f32).min(TILE_TEXELS_MAX);
        if self.is_tiled {
            let channel = source.channel;
            self.tile.fill(channel.image, channel.transfer, channel.texture.wrap, bounds[0], bounds[1]);
        }
    }

    /// Corners of the parts of a window that lie on each drawn triangle, with its number.
    fn outline(&self, least: [u32; 2], most: [u32; 2]) -> [(usize, [f32; 2]); 8] {
        let [[x0, y0], [x1, y1]] = [least, most].map(|at| at.map(|v| v as f32));
        if self.is_triangle {
            let [n, _] = self.segments;
            let (x1, y1) = (x1.min(n - y0), y1.min(n - x0));
            let (right, top) = ([x1, y1.min(n - x1)], [x1.min(n - y1), y1]);
            let first = [x0, y0];
            [first, [x1, y0], [x0, y1], right, top, first, first, first].map(|at| (0, at))
        } else {
            // Where the diagonal crosses the window, by its share of the face.
            let [n, m] = self.segments;
            let (low, high) = ((x0 / n).max(y0 / m), (x1 / n).min(y1 / m));
            let at = |share: f32| [share * n, share * m];
            let corner = |x: f32, y: f32| (usize::from(self.is_above(x, y)), [x, y]);
            let first = corner(x0, y0);
            let [a, b, c, d] = match low <= high {
                true => [(0, at(low)), (0, at(high)), (1, at(low)), (1, at(high))],
                false => [first; 4],
            };
            [first, corner(x1, y0), corner(x0, y1), corner(x1, y1), a, b, c, d]
        }
    }

    /// Whether a point of a quad lies on its second drawn triangle.
    fn is_above(&self, x: f32, y: f32) -> bool {
        let [n, m] = self.segments;
        y * n > x * m
    }

    /// The values at `x, x + step, x + 2 step, …` on the row `y`, in grid coordinates (segments).
    pub fn row(&self, source: &SurfaceSource<'_>, x: f32, y: f32, step: f32, values: &mut [Vec4]) {
        if self.is_triangle {
            return self.piece_row(source, &self.pieces[0], [x, y], step, values);
        }
        let [n, m] = self.segments;
        let above = (((y * (n / m) - x) / step).ceil().max(0.0) as usize).min(values.len());
        let (high, low) = values.split_at_mut(above);
        self.piece_row(source, &self.pieces[1], [x, y], step, high);
        self.piece_row(source, &self.pieces[0], [x + above as f32 * step, y], step, low);
    }

    fn piece_row(
        &self,
        source: &SurfaceSource<'_>,
        piece: &Piece,
        [x, y]: [f32; 2],
        step: f32,
        values: &mut [Vec4],
    ) {
        let Affine { at, along } = piece.place;
        let stride = along[0] * step;
        if self.is_tiled {
            let start = (at - self.tile.offset()) + along[1] * y + along[0] * x;
            let mut count = 0.0;
            for value in values.iter_mut() {
                *value = self.tile.bilinear(start + stride * count);
                count += 1.0;
            }
        } else {
            let start = at + along[1] * y + along[0] * x;
            let channel = source.channel;
            for (count, value) in values.iter_mut().enumerate() {
                let place = start + stride * count as f32;
                *value = bilinear(channel.image, channel.transfer, channel.texture.wrap, place);
            }
        }
        if source.channel.is_tinted {
            let (start, stride) = (piece.tint.at(x, y), piece.tint.along[0] * step);
            let mut count = 0.0;
            for value in values.iter_mut() {
                *value *= start + stride * count;
                count += 1.0;
            }
        }
        if let Some(scale) = source.channel.normal_scale() {
            let steps = Vec4::new(0.0, 1.0, 2.0, 3.0) * step;
            let mut first = x;
            for four in values.chunks_mut(4) {
                let mut stored = [Vec4::Z; 4];
                stored[..four.len()].copy_from_slice(four);
                let at = Vec4::splat(first) + steps;
                let found = piece.object_normals(stored, scale, at, y).unwrap_or_else(|| {
                    let careful =
                        |k: usize| self.object_normal(source, piece, [at[k], y], (stored[k], scale));
                    std::array::from_fn(careful)
                });
                four.copy_from_slice(&found[..four.len()]);
                first += 4.0 * step;
            }
        }
    }

    /// A stored normal in the frame that is interpolated at a point.
    fn object_normal(
        &self,
        source: &SurfaceSource<'_>,
        piece: &Piece,
        [x, y]: [f32; 2],
        (stored, scale): (Vec4, f32),
    ) -> Vec4 {
        let (s, t) = (x / self.segments[0], y / self.segments[1]);
        let weights = match (self.is_triangle, piece.triangle) {
            (true, _) => Vec3::new(1.0 - s - t, s, t),
            (false, 0) => Vec3::new(1.0 - s, s - t, t),
            _ => Vec3::new(1.0 - t, s, t - s),
        };
        let frame = Frame::blend(source.frames[self.face][piece.triangle].each_ref(), weights);
        super::texture::decode_normal(stored.xyz(), scale, frame).extend(1.0)
    }
}

impl Piece {
    /// Four stored normals in the frames that are interpolated at `(x, y)`, as [`Frame::blend`] and the
    /// decoding of single normals have them; nothing where a length is too small to divide by.
    #[inline]
    fn object_normals(&self, stored: [Vec4; 4], scale: f32, x: Vec4, y: f32) -> Option<[Vec4; 4]> {
        let lanes = Mat4::from_cols(stored[0], stored[1], stored[2], stored[3]).transpose();
        let across = (lanes.x_axis * 2.0 - 1.0) * scale;
        let up = (lanes.y_axis * 2.0 - 1.0) * (scale * self.handedness);
        let out = lanes.z_axis * 2.0 - 1.0;
        let normal = Lanes::along(&self.normal, x, y);
        let normal_squared = normal.dot(&normal);
        let tangent = Lanes::along(&self.tangent, x, y);
        let tangent = tangent.plus(&normal, -(normal.dot(&tangent) / normal_squared));
        let tangent_squared = tangent.dot(&tangent);
        // Longer than it should be by the normal's length, which goes away with the result's own.
        let tangent_length = tangent_squared.map(f32::sqrt);
        let found = Lanes([Vec4::ZERO; 3])
            .plus(&tangent, normal_squared.map(f32::sqrt) * across / tangent_length)
            .plus(&normal.cross(&tangent), up / tangent_length)
            .plus(&normal, out);
        let squared = found.dot(&found);
        let shortest = Vec4::splat(SHORTEST_SQUARED);
        let is_sound =
            normal_squared.cmpgt(shortest) & tangent_squared.cmpgt(shortest) & squared.cmpgt(shortest);
        let [x, y, z] = found.0.map(|lane| lane / squared.map(f32::sqrt));
        let found = Mat4::from_cols(x, y, z, Vec4::ONE).transpose();
        is_sound.all().then_some([found.x_axis, found.y_axis, found.z_axis, found.w_axis])
    }
}

/// Four vectors, component by component.
struct Lanes([Vec4; 3]);

impl Lanes {
    fn along(affine: &Affine<Vec3>, x: Vec4, y: f32) -> Self {
        let start = affine.at + affine.along[1] * y;
        Self([0, 1, 2].map(|k| Vec4::splat(start[k]) + x * affine.along[0][k]))
    }

    fn dot(&self, other: &Self) -> Vec4 {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }

    fn cross(&self, other: &Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    fn plus(&self, other: &Self, factor: Vec4) -> Self {
        Self([0, 1, 2].map(|k| self.0[k] + other.0[k] * factor))
    }
}

/// How the corners' values grow along both axes of the grid: of a quad's two triangles (0 and 1), or of a
/// triangle (2); the same map as [`surface_point`](crate::mesh::surface_point).
fn steps<T>(kind: usize, a: T, b: T, c: T, [along_i, along_j]: [f32; 2]) -> [T; 2]
where
    T: Copy + std::ops::Sub<Output = T> + std::ops::Mul<f32, Output = T>,
{
    match kind {
        0 => [(b - a) * along_i, (c - b) * along_j],
        1 => [(b - c) * along_i, (c - a) * along_j],
        _ => [(b - a) * along_i, (c - a) * along_j],
    }
}

impl<T> Affine<T>
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
{
    #[inline(always)]
    fn at(&self, x: f32, y: f32) -> T {
        self.at + self.along[0] * x + self.along[1] * y
    }
}

#[cfg(test)]
mod tests;
