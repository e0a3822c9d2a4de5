//! Polygons to meshes: an object is a mesh, its faces of one material are a primitive, and the distinct
//! corners of a primitive are its vertices, in the order of first use.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{Vec2, Vec3, Vec4};

use super::super::{Context, geometry};
use super::coordinates::OfMaterial;
use super::polygon;
use super::{Coordinates, Corner, NONE, Polygon, Soup};
use crate::asset::{Attribute, Face, Mesh, Primitive};
use crate::error::{Error, Result};
use crate::watch;

/// Faces between two looks at the watch, and corners of a face that is worth one of its own.
const WATCH_FACES: usize = 1 << 14;
const WATCH_CORNERS: usize = 64;

/// A primitive that is being filled.
struct Builder<'a> {
    object: usize,
    primitive: Primitive,
    /// Which texture coordinates its vertices have.
    coordinates: OfMaterial<'a>,
    /// By corner, and its number where it has texture coordinates of its own.
    vertices: HashMap<(Corner, usize), u32>,
    corners: Vec<Corner>,
    /// The first corner of each vertex.
    numbers: Vec<usize>,
}

/// Stands for "a corner like others".
const SHARED: usize = usize::MAX;

/// `objects`: names of the meshes by the polygons' `object`; one without a name gets the file's.
pub fn meshes(
    soup: &Soup,
    objects: &[Vec<u8>],
    coordinates: &Coordinates,
    context: &mut Context,
) -> Result<Vec<Mesh>> {
    let unnamed = soup.file.rsplit_once('.').map_or(soup.file.as_str(), |(stem, _)| stem);
    let mut builders: Vec<Builder<'_>> = Vec::new();
    let mut numbers: HashMap<(usize, u32), usize> = HashMap::new();
    for (count, polygon) in soup.polygons.iter().enumerate() {
        if count % WATCH_FACES == 0 || polygon.count > WATCH_CORNERS {
            watch::check(context.watch)?;
        }
        let number = *numbers.entry((polygon.object, polygon.material)).or_insert_with(|| {
            let material = (polygon.material != NONE).then_some(polygon.material as usize);
            let primitive = Primitive { material, ..Primitive::default() };
            builders.push(Builder {
                object: polygon.object,
                primitive,
                coordinates: coordinates.of_material(material),
                vertices: HashMap::new(),
                corners: Vec::new(),
                numbers: Vec::new(),
            });
            builders.len() - 1
        });
        builders[number].add(soup, polygon, context)?;
    }
    let colored = colored(soup, context);
    let mut meshes: Vec<Mesh> = Vec::new();
    let mut mesh_of = vec![None; objects.len()];
    for mut builder in builders {
        watch::check(context.watch)?;
        let mesh = *mesh_of[builder.object].get_or_insert_with(|| {
            let name = String::from_utf8_lossy(&objects[builder.object]).into_owned();
            let name = if name.is_empty() { unnamed.to_owned() } else { name };
            meshes.push(Mesh { name, primitives: Vec::new() });
            meshes.len() - 1
        });
        let pointer = format!("/meshes/{mesh}/primitives/{}", meshes[mesh].primitives.len());
        builder.fill(soup, colored, &pointer, context);
        geometry::finish(&mut builder.primitive, &pointer, &mut context.warnings);
        meshes[mesh].primitives.push(builder.primitive);
    }
    Ok(meshes)
}

/// Whether every position has a color.
fn colored(soup: &Soup, context: &mut Context) -> bool {
    let (colors, positions) = (soup.colors.len(), soup.positions.len());
    if 0 < colors && colors < positions {
        let detail =
            "vertices without a color in a file where others have one; all vertex colors were left out";
        context.warnings.add_many("partial_vertex_colors", &soup.file, detail, (positions - colors) as u64);
    }
    soup.is_colored()
}

/// The corners of a polygon that are not what the one before them is; all, where too few are left.
fn without_repeats(indices: &[u32]) -> Vec<usize> {
    let all = 0..indices.len();
    let is_new = |slot: &usize| *slot == 0 || indices[*slot] != indices[slot - 1];
    let mut ring: Vec<usize> = all.clone().filter(is_new).collect();
    // The last one is before the first.
    ring.pop_if(|last| *last > 0 && indices[*last] == indices[0]);
    if ring.len() < 3 { all.collect() } else { ring }
}

impl Builder<'_> {
    fn add(&mut self, soup: &Soup, polygon: &Polygon, context: &mut Context) -> Result<()> {
        let at = |error: Error| error.at(soup.place(polygon));
        let corners = soup.corners(polygon);
        let mut indices = Vec::with_capacity(corners.len());
        for (number, corner) in (polygon.first..).zip(corners) {
            let own = if self.coordinates.sets.is_empty() { SHARED } else { number };
            indices.push(match self.vertices.entry((*corner, own)) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(place) => {
                    context.budget.take_vertices(1, "").map_err(at)?;
                    self.corners.push(*corner);
                    self.numbers.push(number);
                    *place.insert((self.corners.len() - 1) as u32)
                }
            });
        }
        let ring = without_repeats(&indices);
        let (indices, corners): (Vec<u32>, Vec<&Corner>) =
            ring.iter().map(|&slot| (indices[slot], &corners[slot])).unzip();
        let position = |corner: &Corner| soup.positions[corner.position as usize];
        match indices[..] {
            [a, b, c] => self.primitive.faces.push(Face::triangle([a, b, c])),
            [a, b, c, d] => {
                let positions = [0, 1, 2, 3].map(|corner: usize| position(corners[corner]));
                if geometry::has_side_without_length(positions) {
                    self.primitive.faces.extend([[a, b, c], [a, c, d]].map(Face::triangle));
                } else {
                    self.primitive.faces.push(Face::quad([a, b, c, d]));
                }
            }
            _ => {
                let points: Vec<_> = corners.iter().map(|corner| position(corner).as_dvec3()).collect();
                let cut = polygon::cut(&points);
                if !cut.simple {
                    let detail = "polygons that cross themselves, have no area or are too intricate; they \
                                  were cut into triangles around one corner";
                    context.warnings.add("polygon_not_simple", &soup.place(polygon), detail);
                }
                let face = |triangle: [usize; 3]| Face::triangle(triangle.map(|corner| indices[corner]));
                self.primitive.faces.extend(cut.triangles.into_iter().map(face));
            }
        }
        Ok(())
    }

    /// The attributes of the gathered corners.
    fn fill(&mut self, soup: &Soup, colored: bool, pointer: &str, context: &mut Context) {
        let corners = &self.corners;
        let of = |index: u32| index as usize;
        self.primitive.positions = corners.iter().map(|corner| soup.positions[of(corner.position)]).collect();
        let without_texcoord = corners.iter().filter(|corner| corner.texcoord == NONE).count();
        if without_texcoord < corners.len() && self.coordinates.keeps_own {
            let texcoord = |corner: &Corner| soup.texcoords.get(of(corner.texcoord)).copied();
            let texcoords = corners.iter().map(|corner| texcoord(corner).unwrap_or(Vec2::ZERO));
            self.primitive.texcoords = vec![texcoords.collect()];
            let detail =
                "vertices without texture coordinates among others that have them; they are at (0, 0)";
            context.warnings.add_many("missing_texcoord", pointer, detail, without_texcoord as u64);
        }
        for set in &self.coordinates.sets {
            // A set's number counts from the file's own one, also where no corner has that.
            if self.primitive.texcoords.is_empty() && self.coordinates.keeps_own {
                self.primitive.texcoords.push(vec![Vec2::ZERO; corners.len()]);
            }
            self.primitive.texcoords.push(self.numbers.iter().map(|&number| set[number]).collect());
        }
        if corners.iter().any(|corner| corner.normal != NONE) {
            // Those without stay zero here, and get their face's normal with the other repairs.
            let normal = |corner: &Corner| soup.normals.get(of(corner.normal)).copied();
            self.primitive.normals = corners.iter().map(|c| normal(c).unwrap_or(Vec3::ZERO)).collect();
        }
        if colored {
            let colors = corners.iter().map(|corner| soup.colors[of(corner.position)]);
            self.primitive.attributes.push(color_attribute(colors, soup.has_alpha));
        }
    }
}

/// `COLOR_0` of linear colors.
fn color_attribute(colors: impl Iterator<Item = Vec4>, has_alpha: bool) -> Attribute {
    let (kind, width) = if has_alpha { ("VEC4", 4) } else { ("VEC3", 3) };
    Attribute {
        semantic: "COLOR_0".to_owned(),
        component_type: 5126,
        kind: kind.to_owned(),
        normalized: false,
        element_bytes: 4 * width,
        bytes: colors
            .flat_map(|color| color.to_array().into_iter().take(width))
            .flat_map(f32::to_le_bytes)
            .collect(),
    }
}
