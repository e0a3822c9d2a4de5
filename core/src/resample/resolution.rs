//! Resolution exponents (method: matched area, a fixed value, or texels per world unit).

use glam::Mat3A;

use crate::asset::{Asset, Face};
use crate::colors::Resolutions;
use crate::mesh::{CanvasFace, CanvasMesh};
use crate::source::SurfaceSource;

/// Sides of `2^12` segments are the finest a face gets.
const EXPONENT_MAX: f32 = 12.0;
/// What lies half way goes up, however it was rounded.
const TIE: f32 = 1e-3;
/// No face is taken to be more elongated than this.
const ASPECT_MAX: f32 = 256.0;

/// How many samples a face gets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Texels per source texel.
    Area(f32),
    /// One exponent for every face: sides of `2^r` segments.
    Fixed(u8),
    /// Texels per world unit of length.
    Density(f32),
}

/// Exponents for each face. A face of `n` by `m` segments has `n m` cells as a quad and `n²/2` as a triangle; they are
/// matched with the area asked for, to the nearest exponents. Where faces may be elongated (MCT 3.6) a quad's cells
/// are as nearly square as its sides are long in the source; else, and where the rule is a fixed exponent, its two are equal.
pub fn resolutions(
    rule: Resolution,
    is_elongated: bool,
    asset: &Asset,
    canvas: &CanvasMesh,
    sources: &[SurfaceSource<'_>],
) -> Resolutions {
    let places = largest_instances(asset);
    let faces = canvas.faces.iter().enumerate().map(|(number, face)| {
        let cells = match rule {
            Resolution::Fixed(exponent) => return [exponent; 2],
            Resolution::Area(factor) => {
                let areas = sources.iter().map(|source| source.area_texels(canvas, number));
                factor * areas.fold(0.0, f32::max)
            }
            Resolution::Density(texels) => {
                texels * texels * world_area(canvas, face, &places[face.mesh as usize])
            }
        };
        if face.is_triangle() || !is_elongated {
            let segments = (cells * if face.is_triangle() { 2.0 } else { 1.0 }).sqrt();
            return [exponent(segments); 2];
        }
        let aspect = match rule {
            Resolution::Density(_) => aspect(world_sides(canvas, face)),
            _ => {
                // Of the source that the cells are counted by.
                let area = |source: &&SurfaceSource<'_>| source.area_texels(canvas, number);
                let finest = sources.iter().max_by(|a, b| area(a).total_cmp(&area(b)));
                finest.map_or(1.0, |source| aspect(source.quad_sides(number)))
            }
        };
        [exponent((cells * aspect).sqrt()), exponent((cells / aspect).sqrt())]
    });
    Resolutions { faces: faces.collect() }
}

impl Resolutions {
    /// One exponent more along each axis: four times the texels.
    pub fn finer(&self) -> Self {
        let more = |exponent: u8| (exponent + 1).min(EXPONENT_MAX as u8);
        Self { faces: self.faces.iter().map(|exponents| exponents.map(more)).collect() }
    }
}

fn exponent(segments: f32) -> u8 {
    (segments.max(1.0).log2() + TIE).round().clamp(0.0, EXPONENT_MAX) as u8
}

/// How much longer a quad is along its first axis than along its second, by the means of opposite sides.
fn aspect([a, b, c, d]: [f32; 4]) -> f32 {
    let aspect = (a + c) / (b + d);
    if aspect.is_finite() && aspect > 0.0 { aspect.clamp(ASPECT_MAX.recip(), ASPECT_MAX) } else { 1.0 }
}

fn world_sides(canvas: &CanvasMesh, face: &CanvasFace) -> [f32; 4] {
    let at = |k: usize| canvas.positions[face.vertices[k % 4] as usize];
    [0, 1, 2, 3].map(|k| at(k).distance(at(k + 1)))
}

/// Instances of one mesh that are looked at: those of the largest matrices.
const INSTANCES_MAX: usize = 8;

/// By mesh, the matrices of its largest instances.
fn largest_instances(asset: &Asset) -> Vec<Vec<Mat3A>> {
    let mut places: Vec<Vec<Mat3A>> = vec![Vec::new(); asset.meshes.len()];
    let size = |m: &Mat3A| m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared();
    for instance in &asset.instances {
        let of_mesh = &mut places[instance.mesh];
        of_mesh.push(instance.transform.matrix3);
        if of_mesh.len() > INSTANCES_MAX {
            of_mesh.sort_by(|a, b| size(b).total_cmp(&size(a)));
            of_mesh.truncate(INSTANCES_MAX);
        }
    }
    places
}

/// The largest area of a face over the places where its mesh stands; its own where it stands nowhere.
fn world_area(canvas: &CanvasMesh, face: &CanvasFace, places: &[Mat3A]) -> f32 {
    let shape = Face { corners: face.vertices, count: face.count };
    let at = |k: usize| canvas.positions[face.vertices[k] as usize];
    let area = |matrix: &Mat3A| -> f32 {
        let triangles = shape.triangles().iter();
        let doubled = triangles.map(|&[a, b, c]| {
            let [side, other] = [at(b) - at(a), at(c) - at(a)].map(|edge| *matrix * edge);
            side.cross(other).length()
        });
        doubled.sum::<f32>() * 0.5
    };
    if places.is_empty() { face.area } else { places.iter().map(area).fold(0.0, f32::max) }
}
