//! How many samples each face of an asset gets, and where they stand.

use crate::asset::Asset;
use crate::colors::{Cuts, Resolutions, Shape, level_count};
use crate::error::{Error, ErrorCode, Result};
use crate::layout::{Coordinates, Layout, LayoutRequest, arrange, block_texels};
use crate::mesh::{CanvasFace, CanvasMesh};
use crate::read::Limits;
use crate::resample::{Candidates, Choice, Rates, spend, wanted_exponents};
use crate::watch::{self, Watch};

use super::options::Options;
use super::prepare::Prepared;

/// Layouts are arranged anew up to so many times until they keep to a number of texels.
const TRIES_MAX: usize = 10;
/// A layout that comes so near to the number is as large as can be.
const ALL_SPENT: f64 = 0.98;
/// What a layout is expected to leave empty, and what is taken off more at each try.
const SPARE: f64 = 0.99;

/// Of one material.
pub struct Arranged {
    pub resolutions: Resolutions,
    pub layout: Layout,
}

/// Arranges all materials together.
///
/// # Errors
/// `Canceled`; `TextureTooLarge`; `InvalidOptions` where so few texels are asked for that some face would have none.
pub fn arrange_all(
    asset: &Asset,
    materials: &[Prepared<'_>],
    options: &Options,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<Vec<Arranged>> {
    let is_elongated = options.coordinates.are_elongated();
    let finest = |material: &Prepared<'_>| {
        let wanted =
            wanted_exponents(options.resolution, is_elongated, asset, &material.canvas, &material.sources);
        let all = if is_elongated {
            wanted.agreeing(&material.canvas, &material.joinable)
        } else {
            wanted.nearest()
        };
        if options.texels.is_some() && options.max_error.is_none() { all.finer() } else { all }
    };
    let finest: Vec<Resolutions> = materials.iter().map(finest).collect();
    let set = |resolutions: Vec<Resolutions>| -> Result<Vec<Arranged>> {
        let each = materials.iter().zip(resolutions);
        each.map(|(material, resolutions)| lay_out(material, resolutions, options, limits)).collect()
    };
    if options.max_error.is_none() && options.texels.is_none() {
        return set(finest);
    }
    let rates: Vec<Rates> = (materials.iter().zip(&finest))
        .map(|(material, finest)| {
            Rates::new(&material.canvas, &material.sources, finest, is_elongated, watch)
        })
        .collect::<Result<_>>()?;
    let texels = |shape: Shape| block_texels(options.coordinates, shape);
    let candidates: Vec<Candidates<'_>> = (materials.iter().zip(&rates))
        .map(|(material, rates)| Candidates { canvas: &material.canvas, rates, texels: &texels })
        .collect();
    let most: Vec<Choice> = (candidates.iter())
        .map(|material| match options.max_error {
            Some(bound) => material.within(bound),
            None => Choice::finest(material.rates),
        })
        .collect();
    let resolved = |choices: &[Choice], least_gain: f64| -> Vec<Resolutions> {
        let each = choices.iter().zip(&candidates).zip(materials);
        each.map(|((choice, candidates), material)| {
            let is_shared = |edge: usize| material.cuts.iter().any(|cuts| !cuts.edges[edge]);
            candidates.meet(choice, is_shared, least_gain)
        })
        .collect()
    };
    let Some(wanted) = options.texels else { return set(resolved(&most, 0.0)) };
    // What is spent and what that comes to are not the same: layouts leave some empty, and edges want their share.
    let mut spendable = wanted as f64 * SPARE;
    let (mut enough, mut too_much) = (0.0, f64::INFINITY);
    let mut best = None;
    let mut least = u64::MAX;
    for _ in 0..TRIES_MAX {
        watch::check(watch)?;
        let spent = spend(&candidates, &most, spendable);
        let arranged = set(resolved(&spent.choices, spent.least_gain))?;
        let allocated = allocated_texels(&arranged);
        let share = wanted as f64 / allocated as f64;
        if allocated <= wanted {
            best = Some(arranged);
            enough = spendable;
            let is_all = spent.texels < ALL_SPENT * spendable;
            if share * ALL_SPENT < 1.0 || (is_all && too_much.is_infinite()) {
                break;
            }
        } else {
            least = least.min(allocated);
            // What was spent may be less than there was to spend.
            too_much = spendable.min(spent.texels);
        }
        spendable = match (best.is_some(), too_much.is_finite()) {
            (true, true) => 0.5 * (enough + too_much),
            (true, false) => enough * share,
            _ => too_much * share * SPARE,
        };
    }
    if let Some(arranged) = best {
        return Ok(arranged);
    }
    let detail = format!(
        "texels = \"{wanted}\" is too few: every face has one cell at least, and level 0 came down to {least} texels; \
         ask for at least as many, or for a coarser mesh"
    );
    Err(Error::new(ErrorCode::InvalidOptions, detail).at("/texels").limit(least, wanted))
}

/// Texels of level 0 over all materials, one channel counting.
fn allocated_texels(arranged: &[Arranged]) -> u64 {
    arranged
        .iter()
        .map(|one| one.layout.sizes[0])
        .map(|[width, height]| u64::from(width) * u64::from(height))
        .sum()
}

fn lay_out(
    material: &Prepared<'_>,
    resolutions: Resolutions,
    options: &Options,
    limits: &Limits,
) -> Result<Arranged> {
    let canvas = &material.canvas;
    let layout = arrange(&LayoutRequest {
        canvas,
        resolutions: &resolutions,
        diagonals: &diagonals(canvas, &material.cuts),
        level_count: level_count(canvas, &resolutions),
        side_limit: match options.coordinates {
            // Not to be split.
            Coordinates::Scaled | Coordinates::ScaledInRows => limits.texture_side.min(options.max_side),
            Coordinates::Indexed => limits.texture_side,
        },
        coordinates: options.coordinates,
    })?;
    Ok(Arranged { resolutions, layout })
}

/// The edge that a triangle would put on its diagonal if it stays alone: one with nothing on the other side
/// where there is one, so that the border texels bind nobody.
fn diagonals(canvas: &CanvasMesh, cuts: &[Cuts]) -> Vec<u8> {
    let burden = |edge: u32| {
        let edge = edge as usize;
        if canvas.sides(&canvas.edges[edge]).len() == 1 {
            return 0;
        }
        cuts.iter().filter(|cuts| !cuts.edges[edge]).count()
    };
    let least =
        |face: &CanvasFace| (0..face.count).min_by_key(|&k| burden(face.edges[usize::from(k)])).unwrap_or(0);
    canvas.faces.iter().map(least).collect()
}
