//! The value of every sample: the source at its place, or integrated against its hat function, or fitted.
//!
//! Work goes face by face over rows of the face's grid. Samples inside a face are written at once; what a
//! face sees at its border is handed out, and edges and vertices are the area-weighted mean of what their
//! faces see.

use glam::Vec4;
use rayon::prelude::*;

use super::BAND;
use super::fitted::{Fit, fit};
use super::gather::{Borders, Means, cell_areas, interiors, mean, weighted};
use super::quadrature::{Quadrature, Subject};
use crate::colors::{LevelNumbering, Shape};
use crate::error::Result;
use crate::source::SurfaceSource;
use crate::watch::{self, Watch};

/// A cell of the grid is cut into at most this many strata a side.
const STRATA_MAX: f32 = 8.0;
/// And a face's side into this many, so that no face takes forever; a coarser look aliases.
const STRATA_PER_SIDE_MAX: u32 = 4096;

/// How a sample gets its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// The source at the sample's position.
    Point,
    /// The source times the sample's hat function (1 at the sample, 0 at its neighbors), in strata: so many
    /// along a side of a cell of the grid, or as many as it is wide in source texels (at most 8).
    Filtered(Option<u8>),
    /// The samples whose interpolation is nearest to the source (L2 projection).
    Fitted,
}

/// All samples of a level, by their numbers.
#[derive(Clone, Debug)]
pub struct Samples {
    pub values: Vec<Vec4>,
    /// How [`Sampling::Fitted`] went.
    pub fit: Option<Fit>,
}

/// All samples of level 0, in a buffer that may hold anything.
pub fn sample(
    source: &SurfaceSource<'_>,
    numbering: &LevelNumbering<'_>,
    room: Vec<Vec4>,
    sampling: Sampling,
    watch: &dyn Watch,
) -> Result<Samples> {
    match sampling {
        Sampling::Point => Ok(Samples { values: point(source, numbering, room, watch)?, fit: None }),
        Sampling::Filtered(strata) => {
            Ok(Samples { values: filtered(source, numbering, room, strata, watch)?, fit: None })
        }
        Sampling::Fitted => {
            let start = point(source, numbering, room, watch)?;
            let (values, fit) = fit(source, numbering, start, watch)?;
            Ok(Samples { values, fit: Some(fit) })
        }
    }
}

/// The source at every sample; at a shared one the mean of what its faces see.
fn point(
    source: &SurfaceSource<'_>,
    numbering: &LevelNumbering<'_>,
    room: Vec<Vec4>,
    watch: &dyn Watch,
) -> Result<Vec<Vec4>> {
    let by_alpha = source.channel.is_alpha_weighted();
    gathered(source, numbering, room, true, |room, face, interior, border| {
        let shape = numbering.shape(face);
        let [n, m] = shape.segments;
        room.reader.open(source, face, shape);
        let mut slots = interior.iter_mut();
        for bottom in (0..m).step_by(BAND as usize) {
            watch::check(watch)?;
            let top = (bottom + BAND).min(m);
            let last = if top == m { top } else { top - 1 };
            fetch_band(source, room, shape, [bottom, last]);
            for (j, row) in (bottom..=last).zip(room.rows.chunks_exact(n as usize + 1)) {
                shape.put_row(j, &row[..shape.point_count(j) as usize], &mut slots, border);
            }
        }
        if by_alpha {
            border.iter_mut().for_each(|value| *value = weighted(*value, true));
        }
        Ok(())
    })
}

/// Fetches the rows from `first` to `last` into `room.rows`.
fn fetch_band(source: &SurfaceSource<'_>, room: &mut Quadrature, shape: Shape, [first, last]: [u32; 2]) {
    let [n, m] = shape.segments;
    let side = n + 1;
    room.rows.resize((BAND.min(m) * side + side) as usize, Vec4::ZERO);
    for left in (0..shape.point_count(first)).step_by(BAND as usize) {
        let right = (left + BAND).min(side);
        let count = (right - left) * (last + 1 - first);
        let most = [right.min(n), last];
        room.reader.open_window(source, [left, first], most, count as usize);
        for (j, row) in (first..=last).zip(room.rows.chunks_exact_mut(side as usize)) {
            let end = right.min(shape.point_count(j));
            if end > left {
                room.reader.row(source, left as f32, j as f32, 1.0, &mut row[left as usize..end as usize]);
            }
        }
    }
}

/// The source integrated against the samples' hats.
fn filtered(
    source: &SurfaceSource<'_>,
    numbering: &LevelNumbering<'_>,
    room: Vec<Vec4>,
    strata: Option<u8>,
    watch: &dyn Watch,
) -> Result<Vec<Vec4>> {
    let by_alpha = source.channel.is_alpha_weighted();
    let mut values = gathered(source, numbering, room, false, |room, face, interior, border| {
        let shape = numbering.shape(face);
        let strata = strata.map_or_else(|| strata_of(source, numbering, face), u32::from);
        let subject = Subject { source, numbering, face, strata, by_alpha, watch };
        let mut slots = interior.iter_mut();
        room.integrate(&subject, |_, _| (), |j, row| shape.put_row(j, row, &mut slots, border))?;
        if by_alpha {
            interior.iter_mut().for_each(|value| *value = mean(*value, 1.0, true));
        }
        Ok(())
    })?;
    if let Some(bounds) = source.channel.bounds() {
        // A mean of what is in range is out of it by rounding at most.
        let [low, high] = bounds.map(Vec4::splat);
        values.par_iter_mut().for_each(|value| *value = value.clamp(low, high));
    }
    Ok(values)
}

/// Strata along a side of a cell: one for each source texel, by area.
pub fn strata_of(source: &SurfaceSource<'_>, numbering: &LevelNumbering<'_>, face: usize) -> u32 {
    let shape = numbering.shape(face);
    let texels = source.area_texels(numbering.canvas, face) / shape.square_count();
    let strata = texels.sqrt().round().clamp(1.0, STRATA_MAX) as u32;
    strata.min((STRATA_PER_SIDE_MAX / shape.segments[0].max(shape.segments[1])).max(1))
}

/// Fills every face's interior and border, then gathers what is shared.
fn gathered(
    source: &SurfaceSource<'_>,
    numbering: &LevelNumbering<'_>,
    room: Vec<Vec4>,
    is_point: bool,
    fill: impl Fn(&mut Quadrature, usize, &mut [Vec4], &mut [Vec4]) -> Result<()> + Sync,
) -> Result<Vec<Vec4>> {
    let mut values = numbering.values_in(room);
    let (shared, inner) = values.split_at_mut(numbering.shared_count());
    let mut borders = Borders::new(numbering);
    let faces = interiors(numbering, inner).into_par_iter().zip(borders.parts()).enumerate();
    faces.try_for_each_init(Quadrature::default, |room, (face, (interior, border))| {
        fill(room, face, interior, border)
    })?;
    let by_alpha = source.channel.is_alpha_weighted();
    let means = Means { numbering, cell_areas: &cell_areas(numbering), is_point, by_alpha };
    means.gather(&borders, shared);
    Ok(values)
}
