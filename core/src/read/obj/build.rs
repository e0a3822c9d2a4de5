//! Polygons to meshes: an object is a mesh, its faces of one material are a primitive, and the distinct
//! corners of a primitive are its vertices, in the order of first use.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{Vec2, Vec3};

use super::super::{Context, geometry};
use super::parse::{Corner, NONE, Parsed, Polygon};
use super::polygon;
use crate::asset::{Attribute, Face, Mesh, Primitive};
use crate::error::{Error, Result};
use crate::watch;

/// Faces between two looks at the watch, and corners of a face that is worth one of its own.
const WATCH_FACES: usize = 1 << 14;
const WATCH_CORNERS: usize = 64;

/// A primitive that is being filled.
struct Builder {
    object: usize,
    primitive: Primitive,
    vertices: HashMap<Corner, u32>,
    corners: Vec<Corner>,
}

/// The name of a mesh before the first `o` is `unnamed`.
pub(super) fn meshes(parsed: &Parsed, unnamed: &str, file: &str, context: &mut Context) -> Result<Vec<Mesh>> {
    let mut builders: Vec<Builder> = Vec::new();
    let mut numbers: HashMap<(usize, u32), usize> = HashMap::new();
    for (count, polygon) in parsed.polygons.iter().enumerate() {
        if count % WATCH_FACES == 0 || polygon.count > WATCH_CORNERS {
            watch::check(context.watch)?;
        }
        let number = *numbers.entry((polygon.object, polygon.material)).or_insert_with(|| {
            let material = (polygon.material != NONE).then_some(polygon.material as usize);
            let primitive = Primitive { material, ..Primitive::default() };
            let (vertices, corners) = (HashMap::new(), Vec::new());
            builders.push(Builder { object: polygon.object, primitive, vertices, corners });
            builders.len() - 1
        });
        builders[number].add(parsed, polygon, file, context)?;
    }
    let colored = colored(parsed, file, context);
    let mut meshes: Vec<Mesh> = Vec::new();
    let mut mesh_of = vec![None; parsed.objects.list.len()];
    for mut builder in builders {
        watch::check(context.watch)?;
        let mesh = *mesh_of[builder.object].get_or_insert_with(|| {
            let name = String::from_utf8_lossy(&parsed.objects.list[builder.object]).into_owned();
            let name = if name.is_empty() { unnamed.to_owned() } else { name };
            meshes.push(Mesh { name, primitives: Vec::new() });
            meshes.len() - 1
        });
        let pointer = format!("/meshes/{mesh}/primitives/{}", meshes[mesh].primitives.len());
        builder.fill(parsed, colored, &pointer, context);
        geometry::finish(&mut builder.primitive, &pointer, &mut context.warnings);
        meshes[mesh].primitives.push(builder.primitive);
    }
    Ok(meshes)
}

/// Whether every position has a color.
fn colored(parsed: &Parsed, file: &str, context: &mut Context) -> bool {
    let (colors, positions) = (parsed.colors.len(), parsed.positions.len());
    if 0 < colors && colors < positions {
        let detail =
            "vertices without a color in a file where others have one; all vertex colors were left out";
        context.warnings.add_many("partial_vertex_colors", file, detail, (positions - colors) as u64);
    }
    colors == positions
}

impl Builder {
    fn add(&mut self, parsed: &Parsed, polygon: &Polygon, file: &str, context: &mut Context) -> Result<()> {
        let at = |error: Error| error.at(format!("{file}:{}", polygon.line));
        let corners = &parsed.corners[polygon.first..][..polygon.count];
        let mut indices = Vec::with_capacity(corners.len());
        for corner in corners {
            indices.push(match self.vertices.entry(*corner) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(place) => {
                    context.budget.take_vertices(1, "").map_err(at)?;
                    self.corners.push(*corner);
                    *place.insert((self.corners.len() - 1) as u32)
                }
            });
        }
        match indices[..] {
            [a, b, c] => self.primitive.faces.push(Face::triangle([a, b, c])),
            [a, b, c, d] => self.primitive.faces.push(Face::quad([a, b, c, d])),
            _ => {
                let position = |corner: &Corner| parsed.positions[corner.position as usize].as_dvec3();
                let points: Vec<_> = corners.iter().map(position).collect();
                let cut = polygon::cut(&points);
                if !cut.simple {
                    let detail = "polygons that cross themselves, have no area or are too intricate; they \
                                  were cut into triangles around one corner";
                    context.warnings.add("polygon_not_simple", &format!("{file}:{}", polygon.line), detail);
                }
                let face = |triangle: [usize; 3]| Face::triangle(triangle.map(|corner| indices[corner]));
                self.primitive.faces.extend(cut.triangles.into_iter().map(face));
            }
        }
        Ok(())
    }

    /// The attributes of the gathered corners.
    fn fill(&mut self, parsed: &Parsed, colored: bool, pointer: &str, context: &mut Context) {
        let corners = &self.corners;
        let of = |index: u32| index as usize;
        self.primitive.positions =
            corners.iter().map(|corner| parsed.positions[of(corner.position)]).collect();
        let without_texcoord = corners.iter().filter(|corner| corner.texcoord == NONE).count();
        if without_texcoord < corners.len() {
            let texcoord = |corner: &Corner| parsed.texcoords.get(of(corner.texcoord)).copied();
            let texcoords = corners.iter().map(|corner| texcoord(corner).unwrap_or(Vec2::ZERO));
            self.primitive.texcoords = vec![texcoords.collect()];
            let detail =
                "vertices without texture coordinates among others that have them; they are at (0, 0)";
            context.warnings.add_many("missing_texcoord", pointer, detail, without_texcoord as u64);
        }
        if corners.iter().any(|corner| corner.normal != NONE) {
            // Those without stay zero here, and get their face's normal with the other repairs.
            let normal = |corner: &Corner| parsed.normals.get(of(corner.normal)).copied();
            self.primitive.normals = corners.iter().map(|c| normal(c).unwrap_or(Vec3::ZERO)).collect();
        }
        if colored {
            let colors = corners.iter().flat_map(|corner| parsed.colors[of(corner.position)].to_array());
            self.primitive.attributes.push(Attribute {
                semantic: "COLOR_0".to_owned(),
                component_type: 5126,
                kind: "VEC3".to_owned(),
                normalized: false,
                element_bytes: 12,
                bytes: colors.flat_map(f32::to_le_bytes).collect(),
            });
        }
    }
}
