//! The lone triangles of a model, as a conversion with the default options has them.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use meshcolor::asset::Asset;
use meshcolor::colors::{Cuts, Resolutions, Shape};
use meshcolor::layout::{Coordinates, block_texels};
use meshcolor::mesh::{CanvasFace, CanvasMesh};
use meshcolor::pipeline::{Content, Options, Prepared, prepare};
use meshcolor::read::{Limits, MemoryFiles, Upload, read};
use meshcolor::resample::wanted_exponents;
use meshcolor::source::{SourceChannel, SurfaceSource, channels};
use meshcolor::watch::Unwatched;

/// As quads are taken to be.
const ASPECT_MAX: f32 = 256.0;
/// What lies half way goes up.
const TIE: f32 = 1e-3;

/// Reads a model with all files that stand beside it.
pub fn load(path: &Path) -> Result<Asset, Box<dyn Error>> {
    let main = path.file_name().and_then(|name| name.to_str()).ok_or("no file name")?.to_owned();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(folder.unwrap_or(".".as_ref()))? {
        let entry = entry?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        let is_wanted = name == main || main.ends_with(".obj");
        if is_wanted && entry.file_type()?.is_file() {
            files.insert(name, std::fs::read(entry.path())?);
        }
    }
    let upload = Upload { main, files: Box::new(MemoryFiles(files)) };
    Ok(read(&upload, &Limits::default(), &Unwatched)?)
}

/// A material's faces, pairs of triangles being quads.
pub struct Surface<'a> {
    pub canvas: CanvasMesh,
    /// By channel.
    pub sources: Vec<SurfaceSource<'a>>,
    cuts: Vec<Cuts>,
    exponents: Resolutions,
}

/// A lone triangle that is longer than wide.
pub struct Elongated {
    pub face: usize,
    /// The corner between the legs, the far end of the long leg, that of the short one.
    pub corners: [usize; 3],
    /// By the rule of today, and by that of quads: along the long leg and along the short one.
    pub one_exponent: u8,
    pub two_exponents: [u8; 2],
    /// By channel: whether the edge on the diagonal has to agree with a neighbor.
    pub is_bound: Vec<bool>,
}

impl<'a> Surface<'a> {
    /// Nothing where the material has no texture or no face.
    pub fn new(
        asset: &'a Asset,
        material: usize,
        channels: &'a [SourceChannel<'a>],
    ) -> Result<Option<Self>, Box<dyn Error>> {
        let options = Options::default();
        let Some(prepared) = prepare(asset, material, channels, &options, &Unwatched)? else {
            return Ok(None);
        };
        let Prepared { canvas, content: Content::Textures(sources), cuts, joinable, .. } = prepared else {
            return Err("the model has mesh colors; give one with textures".into());
        };
        let wanted = wanted_exponents(options.resolution, true, asset, &canvas, &sources);
        let exponents = wanted.agreeing(&canvas, &joinable);
        Ok(Some(Self { canvas, sources, cuts, exponents }))
    }

    pub fn lone_count(&self) -> usize {
        self.canvas.faces.iter().filter(|face| face.is_triangle()).count()
    }

    /// Texels of level 0 that all faces take.
    pub fn texels(&self) -> f64 {
        let faces = self.canvas.faces.iter().zip(&self.exponents.faces);
        let of_face = |(face, exponents): (&CanvasFace, &[u8; 2])| {
            let shape =
                Shape { is_triangle: face.is_triangle(), segments: exponents.map(|exponent| 1 << exponent) };
            block_texels(Coordinates::Indexed, shape)
        };
        faces.map(of_face).sum()
    }

    /// Lone triangles that would have two exponents. As with a quad `n` times `m` cells are twice the area of the
    /// triangle in the source, and `n` is to `m` as the mean of its longer sides is to the shortest.
    pub fn elongated(&self) -> Vec<Elongated> {
        let lone = (0..self.canvas.faces.len()).filter(|&face| self.canvas.faces[face].is_triangle());
        lone.filter_map(|face| self.elongated_one(face)).collect()
    }

    fn elongated_one(&self, face: usize) -> Option<Elongated> {
        let area = |source: &&SurfaceSource<'_>| source.area_texels(&self.canvas, face);
        let finest = self.sources.iter().max_by(|a, b| area(a).total_cmp(&area(b)))?;
        let places = finest.places(face)[0];
        let side = |k: usize| places[k % 3].distance(places[(k + 1) % 3]);
        let short = (0..3).min_by(|&a, &b| side(a).total_cmp(&side(b)))?;
        let aspect = 0.5 * (side(short + 1) + side(short + 2)) / side(short);
        let is_sound = aspect.is_finite() && aspect > 0.0;
        let aspect = if is_sound { aspect.min(ASPECT_MAX) } else { 1.0 };
        let cells = 2.0 * area(&finest);
        let exponent = |segments: f32| (segments.max(1.0).log2() + TIE).round() as u8;
        let two_exponents = [cells * aspect, cells / aspect].map(|squared| exponent(squared.sqrt()));
        if two_exponents[0] == two_exponents[1] {
            return None;
        }
        // The diagonal is one of the two long edges, the short one a leg.
        let bound = |k: usize| -> Vec<bool> {
            let edge = self.canvas.faces[face].edges[k % 3] as usize;
            let is_alone = self.canvas.sides(&self.canvas.edges[edge]).len() == 1;
            self.cuts.iter().map(|cuts| !is_alone && !cuts.edges[edge]).collect()
        };
        let burden = |k: usize| bound(k).iter().filter(|is_bound| **is_bound).count();
        let [first, second, far] = [short, short + 1, short + 2].map(|k| k % 3);
        let (corners, diagonal) = if burden(far) <= burden(second) {
            ([second, far, first], far)
        } else {
            ([first, far, second], second)
        };
        let one_exponent = self.exponents.faces[face][0];
        Some(Elongated { face, corners, one_exponent, two_exponents, is_bound: bound(diagonal) })
    }
}

/// By material of an asset.
pub fn all_channels(asset: &Asset) -> Vec<Vec<SourceChannel<'_>>> {
    (0..asset.materials.len()).map(|material| channels(asset, material, false)).collect()
}
