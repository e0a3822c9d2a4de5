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
use super::prepare::{Content, Prepared};

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

/// Arranges all materials together. `sets`: which have their textures in common.
///
/// # Errors
/// `Canceled`; `TextureTooLarge`; `InvalidOptions` where so few texels are asked for that some face would have none.
pub fn arrange_all(
    asset: &Asset,
    materials: &[Prepared<'_>],
    sets: &[Vec<usize>],
    options: &Options,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<Vec<Arranged>> {
    let is_elongated = options.coordinates.are_elongated();
    check_painted(materials, options)?;
    let finest = |material: &Prepared<'_>| {
        let sources = match &material.content {
            Content::Textures(sources) => sources,
            Content::Painted(painted) => return painted.resolutions.clone(),
        };
        let wanted = wanted_exponents(options.resolution, is_elongated, asset, &material.canvas, sources);
        let all = if is_elongated {
            wanted.agreeing(&material.canvas, &material.joinable)
        } else {
            wanted.nearest()
        };
        if options.texels.is_some() && options.max_error.is_none() { all.finer() } else { all }
    };
    let finest: Vec<Resolutions> = materials.iter().map(finest).collect();
    let set = |resolutions: Vec<Resolutions>| lay_out(materials, resolutions, sets, options, limits);
    if options.max_error.is_none() && options.texels.is_none() {
        return set(finest);
    }
    let rates: Vec<Rates> = (materials.iter().zip(&finest))
        .map(|(material, finest)| {
            let Content::Textures(sources) = &material.content else {
                return Err(Error::internal("a budget reached mesh colors"));
            };
            Rates::new(&material.canvas, sources, finest, is_elongated, watch)
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
        let allocated = allocated_texels(&arranged, sets, options.coordinates);
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

/// Mesh colors have their resolution: whatever asks for another is refused.
fn check_painted(materials: &[Prepared<'_>], options: &Options) -> Result<()> {
    let painted = materials.iter().find_map(|material| match &material.content {
        Content::Painted(painted) => Some((material.material, painted)),
        Content::Textures(_) => None,
    });
    let Some((material, painted)) = painted else { return Ok(()) };
    let refused = |name: &str, detail: &str| {
        Error::new(ErrorCode::InvalidOptions, format!("material {material} has mesh colors, {detail}"))
            .at(name)
    };
    if options.texels.is_some() || options.max_error.is_some() {
        let name = if options.texels.is_some() { "/texels" } else { "/max-error" };
        return Err(refused(name, "whose resolution is the file's: convert it without texels and max-error"));
    }
    let is_elongated = painted.resolutions.faces.iter().any(|[r, s]| r != s);
    if is_elongated && !options.coordinates.are_elongated() {
        let detail = "some faces of which have two exponents, which 4d-rows cannot hold; use 4d or indexed";
        return Err(refused("/coordinates", detail));
    }
    Ok(())
}

/// Texels of level 0 over all materials, one channel counting.
fn allocated_texels(arranged: &[Arranged], sets: &[Vec<usize>], coordinates: Coordinates) -> u64 {
    let own = sets.iter().map(|set| match coordinates {
        // The images of the first are those of all.
        Coordinates::Scaled | Coordinates::ScaledInRows => &set[..1],
        Coordinates::Indexed => &set[..],
    });
    own.flatten().map(|&material| arranged[material].layout.texel_count(0)).sum()
}

fn lay_out(
    materials: &[Prepared<'_>],
    resolutions: Vec<Resolutions>,
    sets: &[Vec<usize>],
    options: &Options,
    limits: &Limits,
) -> Result<Vec<Arranged>> {
    let diagonals: Vec<Vec<u8>> =
        materials.iter().map(|material| diagonals(&material.canvas, &material.cuts)).collect();
    let mut layouts: Vec<Layout> = vec![Layout::default(); materials.len()];
    for set in sets {
        let levels = |&material: &usize| level_count(&materials[material].canvas, &resolutions[material]);
        let most = set.iter().map(levels).max().unwrap_or(0);
        let request = |material: &usize| LayoutRequest {
            canvas: &materials[*material].canvas,
            resolutions: &resolutions[*material],
            diagonals: &diagonals[*material],
            level_count: match options.coordinates {
                Coordinates::Scaled | Coordinates::ScaledInRows => most,
                Coordinates::Indexed => levels(material),
            },
            side_limit: limits.texture_side,
            part_side: limits.texture_side.min(options.max_side),
            coordinates: options.coordinates,
        };
        let requests: Vec<LayoutRequest<'_>> = set.iter().map(request).collect();
        for (&material, layout) in set.iter().zip(arrange(&requests)?) {
            layouts[material] = layout;
        }
    }
    let each = resolutions.into_iter().zip(layouts);
    Ok(each.map(|(resolutions, layout)| Arranged { resolutions, layout }).collect())
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
