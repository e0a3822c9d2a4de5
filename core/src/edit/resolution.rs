//! Other resolutions of painted faces.

use crate::asset::{Asset, MeshColors};
use crate::error::{Error, ErrorCode, Result};
use crate::mip::MipFilter;
use crate::pipeline::painted::ModelFaces;
use crate::read::Limits;
use crate::watch::Watch;

use super::carry::{Origin, Sketch};
use super::coarsen::coarsened;
use super::painting::{Painting, paintings};
use super::{EditReport, Edited, MaterialEdit, Selection, written};

/// By how much, and how what is left out counts in what stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResolutionChange {
    /// What is added to both exponents of a face. Below zero faces end at vertex colors.
    pub by: i8,
    /// Of going down.
    pub filter: MipFilter,
}

/// Changes the resolution of faces. Upwards nothing that the model shows changes: new samples lie on what was
/// interpolated before. Downwards samples are those of mip level `-by` (MC equations 5 and 6) wherever all faces
/// around them go down; a vertex between other faces keeps its sample.
///
/// # Errors
/// `NothingToConvert` without mesh colors; `InvalidModel` where they do not fit; `InvalidOptions` where the selection names
/// what is not there or an exponent would be above the largest; `ModelTooLarge` where there would be more samples than
/// `limits.job_pixels`; `Canceled`.
pub fn resolution(
    asset: &Asset,
    selection: &Selection,
    change: ResolutionChange,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<Edited> {
    if change.by == 0 {
        let detail = "`by` is 0, which changes nothing; above 0 refines, below 0 coarsens";
        return Err(Error::new(ErrorCode::InvalidOptions, detail));
    }
    let paintings = paintings(asset)?;
    let selected = selection.of(&paintings)?;
    let mut report = EditReport::default();
    let mut materials = Vec::with_capacity(paintings.len());
    for (painting, selected) in paintings.iter().zip(&selected) {
        let by = change.by.unsigned_abs();
        let colors = match change.by > 0 {
            true => refined(asset, painting, selected, by, limits, watch)?,
            false => coarsened(asset, painting, selected, (by, change.filter), watch)?,
        };
        report.materials.push(MaterialEdit::of(painting, &colors));
        materials.push((painting.material, colors));
    }
    Ok(Edited { glb: written(asset, materials, false, None, watch)?, report })
}

fn refined(
    asset: &Asset,
    painting: &Painting,
    selected: &[bool],
    by: u8,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<MeshColors> {
    let origins = Origin::of_model_faces(painting, &ModelFaces::of(asset, painting.material));
    let raise = |face: u32| if selected[face as usize] { by } else { 0 };
    let sketch = Sketch::new(painting, asset, (painting.partners.clone(), &origins), raise)?;
    sketch.colors(painting, limits.job_pixels, watch)
}
