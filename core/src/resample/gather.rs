//! From the borders of the faces to the samples that they share.

use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::colors::LevelNumbering;
use crate::math::mean::TRANSPARENT_WEIGHT;

/// A value as it enters a sum: with `by_alpha` the color times its alpha.
pub fn weighted(value: Vec4, by_alpha: bool) -> Vec4 {
    if by_alpha { (value.xyz() * (value.w + TRANSPARENT_WEIGHT)).extend(value.w) } else { value }
}

/// The mean behind a sum of [`weighted`] values over `weight`, with straight alpha.
pub fn mean(sum: Vec4, weight: f32, by_alpha: bool) -> Vec4 {
    if by_alpha {
        (sum.xyz() / (sum.w + TRANSPARENT_WEIGHT * weight)).extend(sum.w / weight)
    } else {
        sum / weight
    }
}

/// One value for each border point of every face, in the order of [`Shape`](crate::colors::Shape).
pub struct Borders {
    values: Vec<Vec4>,
    first: Vec<usize>,
}

impl Borders {
    pub fn new(numbering: &LevelNumbering<'_>) -> Self {
        let mut first = vec![0];
        for face in 0..numbering.canvas.faces.len() {
            first.push(first[face] + numbering.shape(face).border_count());
        }
        Self { values: vec![Vec4::ZERO; first[first.len() - 1]], first }
    }

    fn of(&self, face: usize) -> &[Vec4] {
        &self.values[self.first[face]..self.first[face + 1]]
    }

    /// The border of each face.
    pub fn parts(&mut self) -> Vec<&mut [Vec4]> {
        parts(&mut self.values, self.first.windows(2).map(|range| range[1] - range[0]))
    }
}

/// The interior of each face, in the samples that follow the shared ones.
pub fn interiors<'v>(numbering: &LevelNumbering<'_>, values: &'v mut [Vec4]) -> Vec<&'v mut [Vec4]> {
    parts(values, (0..numbering.canvas.faces.len()).map(|face| numbering.face_range(face).len()))
}

fn parts(mut rest: &mut [Vec4], lengths: impl Iterator<Item = usize>) -> Vec<&mut [Vec4]> {
    lengths.map(|length| rest.split_off_mut(..length).unwrap_or_default()).collect()
}

/// The area of a cell of each face, the face being measured in shares of the mean face. A face of no area
/// still has a say where no other has; where no face has any all count the same.
pub fn cell_areas(numbering: &LevelNumbering<'_>) -> Vec<f32> {
    /// Of the mean face.
    const AREA_FLOOR: f32 = 1e-9;
    let faces = &numbering.canvas.faces;
    let total: f64 = faces.iter().map(|face| f64::from(face.area)).sum();
    let mean = total / faces.len() as f64;
    let share = |area: f32| if mean > 0.0 { (f64::from(area) / mean) as f32 } else { 1.0 };
    let cells = |face: usize| {
        let [n, m] = numbering.shape(face).segments;
        n as f32 * m as f32
    };
    faces.iter().enumerate().map(|(k, face)| share(face.area).max(AREA_FLOOR) / cells(k)).collect()
}

/// How shared samples come from sums over hats at the borders.
pub struct Means<'a> {
    pub numbering: &'a LevelNumbering<'a>,
    pub cell_areas: &'a [f32],
    /// The borders hold single values, not sums over hats.
    pub is_point: bool,
    pub by_alpha: bool,
}

impl Means<'_> {
    /// Shared samples as means of what their faces see, by area.
    pub fn gather(&self, borders: &Borders, shared: &mut [Vec4]) {
        let add = |total: &mut (Vec4, f32), face: usize, at: usize, factor: f32| {
            let factor = factor * self.cell_areas[face];
            let area = if self.is_point { 1.0 } else { self.numbering.shape(face).hat_area(at) };
            total.0 += borders.of(face)[at] * factor;
            total.1 += area * factor;
        };
        let (fans, strips) = shared.split_at_mut(self.numbering.topology.fan_count());
        fans.par_iter_mut().enumerate().for_each(|(fan, value)| {
            let mut total = (Vec4::ZERO, 0.0);
            for &(face, corner) in self.numbering.topology.corners(fan) {
                let border = self.numbering.shape(face as usize).edge_first(corner.into());
                add(&mut total, face as usize, border, 1.0);
            }
            *value = mean(total.0, total.1, self.by_alpha);
        });
        for_strips(self.numbering, strips, |sides, at| {
            let mut total = (Vec4::ZERO, 0.0);
            for view in sides {
                // On a finer face all that the strip's hat covers, widened so that the face does not count
                // less for its narrower band.
                let step = view.step as f32;
                let reach = if self.is_point { 0 } else { view.step - 1 };
                view.around(at, reach, |index, hat| add(&mut total, view.face, index, hat * step));
            }
            mean(total.0, total.1, self.by_alpha)
        });
    }
}

/// Shared samples as sums of what the borders hold, each border point counting for the samples that it is
/// interpolated from: the transpose of [`LevelNumbering::edge_tap`].
pub fn gather_sums(numbering: &LevelNumbering<'_>, borders: &Borders, shared: &mut [Vec4]) {
    let (fans, strips) = shared.split_at_mut(numbering.topology.fan_count());
    fans.par_iter_mut().enumerate().for_each(|(fan, value)| {
        let mut sum = Vec4::ZERO;
        for &(face, corner) in numbering.topology.corners(fan) {
            let (face, corner) = (face as usize, usize::from(corner));
            let (border, shape) = (borders.of(face), numbering.shape(face));
            let count = shape.edge_count();
            sum += border[shape.edge_first(corner)];
            for (edge, is_start) in [(corner, true), ((corner + count - 1) % count, false)] {
                let strip = numbering.topology.strip_of[face][edge] as usize;
                let n = shape.edge_segments(edge) as usize;
                let step = n / numbering.strip_segments(strip) as usize;
                for along in 1..step {
                    let index = shape.edge_first(edge) + if is_start { along } else { n - along };
                    sum += border[index] * (1.0 - along as f32 / step as f32);
                }
            }
        }
        *value = sum;
    });
    for_strips(numbering, strips, |sides, at| {
        let mut sum = Vec4::ZERO;
        for view in sides {
            view.around(at, view.step - 1, |index, hat| sum += borders.of(view.face)[index] * hat);
        }
        sum
    });
}

/// Sets every sample of every strip, given the strip's sides and its place in it, from 1.
fn for_strips(
    numbering: &LevelNumbering<'_>,
    samples: &mut [Vec4],
    value: impl Fn(&[SideView], u32) -> Vec4 + Sync,
) {
    let lengths = (0..numbering.topology.strips.len()).map(|strip| numbering.strip_range(strip).len());
    let strips = parts(samples, lengths).into_par_iter().enumerate();
    strips.for_each_init(Vec::new, |sides, (strip, samples)| {
        sides.clear();
        sides.extend(self::sides(numbering, strip));
        samples.iter_mut().zip(1..).for_each(|(sample, at)| *sample = value(sides, at));
    });
}

/// A face's border along one strip, which may have fewer samples.
struct SideView {
    face: usize,
    segments: u32,
    /// Its first border point.
    first: u32,
    reversed: bool,
    /// Face segments for each segment of the strip.
    step: u32,
}

fn sides(numbering: &LevelNumbering<'_>, strip: usize) -> impl Iterator<Item = SideView> {
    numbering.topology.sides(&numbering.topology.strips[strip]).iter().map(move |side| {
        let (face, edge) = (side.face as usize, usize::from(side.edge));
        let shape = numbering.shape(face);
        let segments = shape.edge_segments(edge);
        SideView {
            face,
            segments,
            first: shape.edge_first(edge) as u32,
            reversed: numbering.canvas.faces[face].is_reversed(edge),
            step: segments / numbering.strip_segments(strip),
        }
    })
}

impl SideView {
    /// The border points up to `reach` around strip sample `at`, with the strip's hat there.
    fn around(&self, at: u32, reach: u32, mut visit: impl FnMut(usize, f32)) {
        for from_low in at * self.step - reach..=at * self.step + reach {
            let along = if self.reversed { self.segments - from_low } else { from_low };
            let distance = from_low.abs_diff(at * self.step) as f32 / self.step as f32;
            visit((self.first + along) as usize, 1.0 - distance);
        }
    }
}
