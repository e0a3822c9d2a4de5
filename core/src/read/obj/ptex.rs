//! Ptex files that an OBJ file's materials name, or that stand beside it: which faces they belong to, and the texture
//! coordinates that these get.

use glam::Vec2;

use super::super::made_up::{Coordinates, ImageFiles, NONE, Polygon, Soup};
pub(super) use super::super::ptex::Kind;
use super::super::ptex::{Mesh, Part, is_ptex};
use super::super::warnings::Warnings;
use super::super::{Context, ptex};
use super::mtl::{Definition, Map};
use super::parse::Parsed;
use super::split::{Origin, split};
use crate::asset::{Material, TextureRef, UvTransform};
use crate::error::{Error, Result};
use crate::image::{Wrap, WrapMode};

/// Ptex images and who reads them.
#[derive(Debug, Default)]
pub(super) struct Uses {
    list: Vec<Use>,
    /// Materials that have ordinary textures too.
    keeps_own: Vec<usize>,
}

#[derive(Debug)]
struct Use {
    image: usize,
    kind: Kind,
    /// Numbers of materials, ascending.
    materials: Vec<usize>,
}

impl Uses {
    pub fn add(&mut self, image: usize, kind: Kind) {
        self.list.push(Use { image, kind, materials: Vec::new() });
    }

    pub fn contains(&self, image: usize) -> bool {
        self.list.iter().any(|known| known.image == image)
    }

    pub fn keep_own(&mut self, material: usize) {
        self.keeps_own.push(material);
    }

    /// What a map's options ask of an ordinary texture means nothing here.
    pub fn check(&self, map: &Map, warnings: &mut Warnings) {
        if map.transform != UvTransform::default() {
            let detail = "scales and offsets of Ptex files, which have no coordinates; they are ignored";
            warnings.add("ptex_transform", &map.place, detail);
        }
    }

    /// A material's slot that reads a Ptex image; its set of coordinates is not numbered yet.
    pub fn reference(&mut self, material: usize, image: usize) -> TextureRef {
        for known in self.list.iter_mut().filter(|known| known.image == image) {
            if known.materials.last() != Some(&material) {
                known.materials.push(material);
            }
        }
        let mode = WrapMode::ClampToEdge;
        let wrap = Wrap { s: mode, t: mode };
        TextureRef { image, wrap, texcoord: 0, transform: UvTransform::default() }
    }

    /// Numbers the sets of coordinates of a material whose slots are all known: the file's own first, where a slot
    /// reads them.
    pub fn number_sets(&self, material: usize, slots: &mut Material) {
        let own = usize::from(self.keeps_own.last() == Some(&material));
        let images: Vec<usize> = self.of(material).map(|(_, known)| known.image).collect();
        for slot in slots.slots.values_mut() {
            if let Some(set) = images.iter().position(|&image| image == slot.image) {
                slot.texcoord = own + set;
            }
        }
    }

    fn of(&self, material: usize) -> impl Iterator<Item = (usize, &Use)> {
        let uses = self.list.iter().enumerate();
        uses.filter(move |(_, known)| known.materials.contains(&material))
    }
}

/// Where the OBJ file names no material, a Ptex file of its name beside it is its color: then all faces get a material that
/// reads it, which is returned.
pub(super) fn beside(parsed: &mut Parsed, file: &str, context: &mut Context) -> Result<Option<Definition>> {
    if !parsed.materials.list.is_empty() {
        return Ok(None);
    }
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let name = format!("{stem}.ptx");
    let folder = context.resources.folder().to_owned();
    if context.resources.check_name(name.as_bytes(), &folder, file).is_err() {
        return Ok(None);
    }
    let found = context.resources.find_name(name.as_bytes(), &folder, file, &mut context.budget)?;
    if !found.is_some_and(|(_, bytes)| is_ptex(&bytes)) {
        return Ok(None);
    }
    let material = parsed.materials.number(stem.as_bytes()) as u32;
    parsed.soup.polygons.iter_mut().for_each(|polygon| polygon.material = material);
    let map = Map {
        file: name.clone().into_bytes(),
        place: name,
        transform: UvTransform::default(),
        clamp: true,
        bump_multiplier: 1.0,
    };
    Ok(Some(Definition { name: stem.into(), diffuse_map: Some(map), ..Definition::default() }))
}

/// Reads all Ptex images that a material with faces reads. Where one of them has several faces for a face of other than four
/// corners, the whole mesh is split.
pub(super) fn read(
    parsed: &mut Parsed,
    uses: &Uses,
    files: &mut ImageFiles,
    context: &mut Context,
) -> Result<Coordinates> {
    let soup = &mut parsed.soup;
    let mut coordinates = Coordinates::default();
    let mut belongings = Vec::with_capacity(uses.list.len());
    for known in &uses.list {
        let is_read = !known.materials.is_empty();
        let of = || polygons_of(soup, ptex::head(files.bytes(known.image))?, &known.materials);
        let belonging = is_read.then(of).transpose();
        belongings.push(belonging.map_err(|error: Error| error.at(files.place(known.image)))?);
    }
    let is_split = belongings.iter().flatten().any(|of| of.is_split);
    let origins = if is_split { Some(split(soup, context)?) } else { None };
    let welded = if belongings.is_empty() { Vec::new() } else { weld(soup) };
    for (known, belonging) in uses.list.iter().zip(belongings) {
        let mut set = Vec::new();
        if let Some(belonging) = belonging {
            let place = files.place(known.image);
            let at = |error: Error| if error.pointer.is_none() { error.at(place) } else { error };
            let (polygons, parts) = belonging.parts(origins.as_deref()).map_err(at)?;
            let corners = || {
                polygons.iter().flat_map(|&number| {
                    let polygon = &soup.polygons[number];
                    polygon.first..polygon.first + polygon.count
                })
            };
            let vertices = corners().map(|corner| welded[soup.corners[corner].position as usize]).collect();
            let mesh = Mesh { vertices, parts };
            let texture =
                ptex::read(files.bytes(known.image), mesh, known.kind, place, context).map_err(at)?;
            set = vec![Vec2::ZERO; soup.corners.len()];
            for (corner, texcoord) in corners().zip(texture.texcoords) {
                set[corner] = texcoord;
            }
            files.put(known.image, texture.image);
        }
        coordinates.sets.push(set);
    }
    coordinates.materials = (0..parsed.materials.list.len())
        .map(|material| {
            let sets = uses.of(material).map(|(set, _)| set).collect();
            (sets, uses.keeps_own.contains(&material))
        })
        .collect();
    Ok(coordinates)
}

/// The mesh's faces that a file belongs to.
struct Belonging {
    /// By face of the mesh, the file's first face for it, and whether it has one for each corner.
    faces: Vec<Option<(usize, bool)>>,
    is_triangles: bool,
    /// Whether some face has more than one.
    is_split: bool,
}

impl Belonging {
    /// The mesh's faces in an order for [`ptex::read`], and, where the mesh was split, which part of which of the file's faces
    /// each of them shows.
    fn parts(&self, origins: Option<&[Origin]>) -> Result<(Vec<usize>, Option<Vec<Part>>)> {
        let Some(origins) = origins else {
            let numbered = self.faces.iter().enumerate();
            return Ok((numbered.filter_map(|(number, face)| face.map(|_| number)).collect(), None));
        };
        if self.is_triangles {
            let detail = "the file is one for triangles, and another one of this model is for quads and needs the mesh's \
                          triangles split; convert the two one at a time";
            return Err(Error::invalid(detail));
        }
        let mut polygons = Vec::new();
        let mut parts = Vec::new();
        for (number, origin) in origins.iter().enumerate() {
            let Some((first, has_subfaces)) = self.faces[origin.polygon] else { continue };
            polygons.push(number);
            parts.push(if has_subfaces {
                Part { face: first + origin.corner, quarter: None }
            } else {
                Part { face: first, quarter: Some(origin.corner) }
            });
        }
        Ok((polygons, Some(parts)))
    }
}

/// All faces are those of the file, or those whose materials read it. A file for quads has one for each corner of a face of
/// other than four.
fn polygons_of(soup: &Soup, head: ptex::Head, materials: &[usize]) -> Result<Belonging> {
    let count_of =
        |polygon: &Polygon| if head.corner_count == 4 && polygon.count != 4 { polygon.count } else { 1 };
    let reads =
        |polygon: &Polygon| polygon.material != NONE && materials.contains(&(polygon.material as usize));
    let all_count: usize = soup.polygons.iter().map(count_of).sum();
    let own_count: usize = soup.polygons.iter().filter(|polygon| reads(polygon)).map(count_of).sum();
    if ![all_count, own_count].contains(&head.face_count) {
        let (kind, counted) = if head.corner_count == 4 {
            ("quads", " (one for a face of four corners, one for each corner of others)")
        } else {
            ("triangles", "")
        };
        let detail = format!(
            "the Ptex file for {kind} has {} faces; the OBJ file makes {all_count}, and {own_count} of them have a material that \
             reads it{counted}: a Ptex file belongs to the mesh that it was painted on, with all its faces in the same \
             order, so export that",
            head.face_count
        );
        return Err(Error::invalid(detail));
    }
    let is_whole = head.face_count == all_count;
    let mut belonging =
        Belonging { faces: Vec::new(), is_triangles: head.corner_count == 3, is_split: false };
    let mut next = 0;
    for polygon in &soup.polygons {
        if !is_whole && !reads(polygon) {
            belonging.faces.push(None);
            continue;
        }
        if belonging.is_triangles && polygon.count != 3 {
            let detail = format!(
                "the Ptex file is one for triangles; the face in line {} of the OBJ file has {} corners: export the mesh that \
                 it was painted on",
                polygon.number, polygon.count
            );
            return Err(Error::invalid(detail));
        }
        let has_subfaces = !belonging.is_triangles && polygon.count != 4;
        belonging.is_split |= has_subfaces;
        belonging.faces.push(Some((next, has_subfaces)));
        next += count_of(polygon);
    }
    Ok(belonging)
}

/// By position of the file, the first that stands in the same place.
fn weld(soup: &Soup) -> Vec<u32> {
    // Adding 0 makes one zero of two.
    let key = |number: u32| soup.positions[number as usize].to_array().map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..soup.positions.len() as u32).collect();
    order.sort_unstable_by_key(|&number| (key(number), number));
    let mut welded = vec![0; order.len()];
    for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
        same.iter().for_each(|&number| welded[number as usize] = same[0]);
    }
    welded
}
