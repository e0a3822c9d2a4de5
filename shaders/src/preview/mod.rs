//! The seam-check sheet: source, converted and their difference, side by side, as one PNG.
//!
//! The scene is prepared once (`scene`) and drawn by a GPU (`gpu`) or, where there is none, by the CPU
//! (`cpu`) with the same filters and the same light. Where the source has mesh colors the CPU draws always, since it has
//! the filters of mesh colors themselves. `page` lays the pictures out.

mod cpu;
mod gpu;
mod page;
mod picture;
mod scene;
mod shade;
#[cfg(test)]
mod tests;
mod words;

use meshcolor::Error;
use meshcolor::pipeline::reference::{Reference, with_filters};
use meshcolor::pipeline::{Conversion, Focus, Options};
use meshcolor::source::painted::PaintedSource;
use meshcolor::watch::Unwatched;

use self::cpu::CpuRenderer;
use self::gpu::{GpuRenderer, NoGpu};
use self::page::{Arrows, Page, Row};
use self::picture::{Picture, Renderer};
use self::scene::surface::Side;
use self::scene::views::{View, close_up, painted_close_up, whole};
use self::scene::{Scene, Shot, Subject};
use self::words::{model_name, notes, row_words, source_words, subtitle};

const NO_ADAPTER: &str = "no Vulkan adapter found; Debian: apt-get install mesa-vulkan-drivers";

/// Both columns: two renderers fill single pixels at edges otherwise, by more than the columns differ.
const FOR_MESH_COLORS: &str = "CPU renderer (the source is mesh colors)";

/// A finished sheet.
#[derive(Clone, Debug)]
pub struct Sheet {
    pub png: Vec<u8>,
    /// What drew it, as the sheet says it.
    pub renderer: String,
}

/// Why there is no sheet.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PreviewError {
    /// The conversion contradicts itself: a fault of the program that made it.
    #[error("the preview cannot be drawn, the conversion is inconsistent: {0}")]
    Inconsistent(String),
    /// The adapter refused or was lost.
    #[error("the graphics device failed: {0}")]
    Device(String),
    #[error("the sheet's font cannot be read: {0}")]
    Font(String),
    #[error("the sheet cannot be encoded: {0}")]
    Encode(String),
}

/// Draws the sheet, titled with the name that the model gives itself.
///
/// # Errors
/// See [`PreviewError`].
pub fn sheet(conversion: &Conversion) -> Result<Sheet, PreviewError> {
    sheet_titled(conversion, &model_name(conversion))
}

/// Draws the sheet under a title of the caller's, such as the name of the model's file.
///
/// # Errors
/// See [`PreviewError`].
pub fn sheet_titled(conversion: &Conversion, title: &str) -> Result<Sheet, PreviewError> {
    let references = references(conversion).map_err(inconsistent)?;
    with_filters(&references, |painted| drawn(conversion, painted, title)).map_err(inconsistent)?
}

/// The mesh colors of the source, at the levels of its conversion.
fn references(conversion: &Conversion) -> Result<Vec<Reference>, Error> {
    let options = Options::from_json(&conversion.report.options)?;
    Reference::beside(&conversion.asset, &conversion.finished, &options, &Unwatched)
}

fn inconsistent(error: Error) -> PreviewError {
    PreviewError::Inconsistent(error.to_string())
}

fn drawn(conversion: &Conversion, painted: &[PaintedSource<'_>], title: &str) -> Result<Sheet, PreviewError> {
    let scene = Scene::new(&conversion.asset, &conversion.finished, painted)?;
    if !scene.painted.is_empty() {
        return compose(conversion, &scene, title, &mut CpuRenderer { label: FOR_MESH_COLORS.to_owned() });
    }
    let reason = match GpuRenderer::open() {
        Ok(mut gpu) => match compose(conversion, &scene, title, &mut gpu) {
            // The sheet is a by-product: a driver's fault must not cost it, but the sheet says so.
            Err(PreviewError::Device(reason)) => reason,
            done => return done,
        },
        Err(NoGpu::NoAdapter) => NO_ADAPTER.to_owned(),
        Err(NoGpu::Refused(reason)) => reason,
    };
    tracing::info!(reason, "the preview is drawn on the CPU");
    let label = format!("CPU renderer ({reason})");
    compose(conversion, &scene, title, &mut CpuRenderer { label })
}

fn compose(
    conversion: &Conversion,
    scene: &Scene<'_>,
    title: &str,
    renderer: &mut dyn Renderer,
) -> Result<Sheet, PreviewError> {
    let focus = conversion.focus.as_ref();
    let close_up = focus.and_then(|focus| close_up(scene, focus)).or_else(|| painted_close_up(scene));
    let notes = notes(conversion, scene, close_up.is_some());
    let mut rows = draw(scene, &whole(scene, focus), focus, renderer)?;
    if let Some(view) = close_up {
        rows.extend(draw(scene, &view, focus, renderer)?);
    }
    let page = Page {
        title: title.to_owned(),
        subtitle: subtitle(scene),
        renderer: renderer.label(),
        source: source_words(scene),
        rows,
        notes,
    };
    Ok(Sheet { png: page::png(&page)?, renderer: page.renderer })
}

/// The rows of one view: each filter, both sides.
fn draw(
    scene: &Scene<'_>,
    view: &View,
    focus: Option<&Focus>,
    renderer: &mut dyn Renderer,
) -> Result<Vec<Row>, PreviewError> {
    // One side after the other: the corners of a large model are not held twice.
    let mut pictures_of = |side: Side| -> Result<Vec<Picture>, PreviewError> {
        let batches = scene.batches(view.subject, &view.camera, side, view.look);
        let shot = |filter| Shot {
            batches: &batches,
            camera: view.camera,
            size: view.size,
            filter,
            look: view.look,
            painted: scene.painted,
        };
        view.filters.iter().map(|filter| renderer.draw(&scene.textures, &shot(*filter))).collect()
    };
    let sources = pictures_of(Side::Source)?;
    let converted = pictures_of(Side::Converted)?;
    let rows = view.filters.iter().zip(sources.into_iter().zip(converted)).map(|(filter, pair)| {
        let (title, detail) = row_words(view, *filter, focus);
        let arrows = match (view.subject, view.mark) {
            (_, None) => Arrows::None,
            (Subject::World, Some([x, y])) => Arrows::Place { x, y },
            (Subject::Mesh { .. }, Some([x, _])) => Arrows::Line { x },
        };
        Row { title, detail, source: pair.0, converted: pair.1, arrows }
    });
    Ok(rows.collect())
}
