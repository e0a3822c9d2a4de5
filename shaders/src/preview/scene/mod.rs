//! What is drawn, ready for either renderer: textures with levels, surfaces, corners in view space.

pub mod camera;
pub mod check;
mod contrast;
pub mod geometry;
mod mips;
pub mod painted;
pub mod surface;
pub mod texture;
pub mod views;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use meshcolor::asset::{AlphaMode, Asset, Instance};
use meshcolor::finished::{Coordinates, Finished, FinishedPrimitive};
use meshcolor::source::painted::PaintedSource;

use self::camera::Camera;
use self::geometry::{Batch, BatchInput, batch};
use self::painted::PaintedPrimitive;
use self::surface::{Look, Side, Surface};
use self::texture::{Texture, TextureList};
use super::PreviewError;
use crate::twins::indexed::MctBlockTable;

/// How textures are filtered between levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    Trilinear,
    /// This level everywhere, the coarsest one where a texture has fewer.
    Level(u32),
}

/// Everything that a renderer needs for one picture.
pub struct Shot<'a> {
    pub batches: &'a [Batch],
    pub camera: Camera,
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub filter: Filter,
    pub look: Look,
    /// What batches of a source with mesh colors read.
    pub painted: &'a [PaintedSource<'a>],
}

/// Which part of the asset stands before the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Subject {
    /// Every instance, in the world.
    World,
    /// One mesh in its own space, and only what touches a box in view space.
    Mesh { mesh: usize, keep: [DVec3; 2] },
}

/// Triangles that a picture draws before it leaves further instances out (and says so): an asset of a
/// few kilobytes can ask for any number.
const DRAWN_TRIANGLES_MAX: usize = 2_000_000;

pub struct Scene<'a> {
    asset: &'a Asset,
    finished: &'a Finished,
    pub textures: Vec<Texture<'a>>,
    /// The mesh colors of the source's materials that have some.
    pub painted: &'a [PaintedSource<'a>],
    source: Surfaces,
    converted: Surfaces,
    /// By mesh and primitive: its pieces, one for each part of its material that it has faces in.
    converted_primitives: BTreeMap<(usize, usize), Vec<&'a FinishedPrimitive>>,
    /// By material and part: of indexed coordinates, which its primitives have in common.
    tables: BTreeMap<(usize, usize), Arc<MctBlockTable>>,
    /// How many of `Asset::instances`, from the first, are drawn.
    pub drawn_instance_count: usize,
}

/// By material and part; `None` is the default one. Materials that nothing uses are not there, and of the source only
/// parts 0.
type Surfaces = BTreeMap<(Option<usize>, usize), Surface>;

/// What pieces may be drawn together by: the surface, and whether it is converted.
type BatchKey = (Option<usize>, usize, bool);

impl<'a> Scene<'a> {
    /// # Errors
    /// `Inconsistent` where an index of `finished` points past the asset, or `painted` is not the asset's.
    pub fn new(
        asset: &'a Asset,
        finished: &'a Finished,
        painted: &'a [PaintedSource<'a>],
    ) -> Result<Self, PreviewError> {
        check::check(asset, finished)?;
        painted::check(asset, painted)?;
        let mut list = TextureList::new(asset, finished);
        let (mut source, mut converted) = (Surfaces::new(), Surfaces::new());
        for mesh in &asset.meshes {
            for primitive in mesh.primitives.iter().filter(|primitive| !primitive.faces.is_empty()) {
                let material = primitive.material;
                source.entry((material, 0)).or_insert_with(|| Surface {
                    is_tinted: material.is_some_and(|own| finished.vertex_colors.contains(&own)),
                    painted: painted.iter().position(|source| Some(source.material) == material),
                    ..Surface::new(&mut list, asset, finished, None, material)
                });
            }
        }
        let mut converted_primitives: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for piece in &finished.primitives {
            converted_primitives.entry((piece.mesh, piece.primitive)).or_default().push(piece);
            let (material, part) = (Some(piece.material), piece.part);
            converted
                .entry((material, part))
                .or_insert_with(|| Surface::new(&mut list, asset, finished, Some(part), material));
        }
        Ok(Self {
            asset,
            finished,
            textures: list.textures,
            painted,
            source,
            converted,
            converted_primitives,
            tables: tables(finished),
            drawn_instance_count: drawn_instances(asset),
        })
    }

    /// Every corner that is drawn of the world, in the world.
    pub fn each_world_point(&self, visit: &mut dyn FnMut(DVec3)) {
        for instance in &self.asset.instances[..self.drawn_instance_count] {
            let to_world = affine(instance);
            for primitive in &self.asset.meshes[instance.mesh].primitives {
                for vertex in primitive.faces.iter().flat_map(|face| face.corners()) {
                    visit(to_world.transform_point3(primitive.positions[*vertex as usize].as_dvec3()));
                }
            }
        }
    }

    /// The batches of one side as a camera sees them, one for each surface, blended ones last.
    pub fn batches(&self, subject: Subject, camera: &Camera, side: Side, look: Look) -> Vec<Batch> {
        let mut merged: Vec<Batch> = Vec::new();
        let mut numbers: BTreeMap<BatchKey, usize> = BTreeMap::new();
        let mut add = |mesh: usize, to_world: DAffine3, keep| {
            let to_view = camera.to_view * to_world;
            for number in 0..self.asset.meshes[mesh].primitives.len() {
                for (key, batch) in self.batches_of((mesh, number), Placed { to_view, keep }, side, look) {
                    match numbers.get(&key) {
                        Some(known) => {
                            merged[*known].records.extend(batch.records);
                            merged[*known].painted.extend(batch.painted);
                        }
                        None => {
                            numbers.insert(key, merged.len());
                            merged.push(batch);
                        }
                    }
                }
            }
        };
        match subject {
            Subject::Mesh { mesh, keep } => add(mesh, DAffine3::IDENTITY, Some(keep)),
            Subject::World => {
                for instance in &self.asset.instances[..self.drawn_instance_count] {
                    add(instance.mesh, affine(instance), None);
                }
            }
        }
        merged.sort_by_key(|batch| batch.surface.alpha_mode == AlphaMode::Blend);
        merged
    }

    /// The batches of a primitive: one, or on the converted side one for each of its pieces.
    fn batches_of(
        &self,
        place: (usize, usize),
        placed: Placed,
        side: Side,
        look: Look,
    ) -> Vec<(BatchKey, Batch)> {
        let pieces = self.converted_primitives.get(&place).filter(|_| side == Side::Converted);
        let batch = |finished| self.batch(place, finished, placed, look);
        match pieces {
            Some(pieces) => pieces.iter().filter_map(|piece| batch(Some(*piece))).collect(),
            None => batch(None).into_iter().collect(),
        }
    }

    fn batch(
        &self,
        (mesh, number): (usize, usize),
        finished: Option<&FinishedPrimitive>,
        placed: Placed,
        look: Look,
    ) -> Option<(BatchKey, Batch)> {
        let primitive = &self.asset.meshes[mesh].primitives[number];
        let (surfaces, material, part) = match finished {
            Some(piece) => (&self.converted, Some(piece.material), piece.part),
            None => (&self.source, primitive.material, 0),
        };
        let surface = surfaces.get(&(material, part))?.reduced(look);
        let Placed { to_view, keep } = placed;
        let table = finished.and_then(|piece| self.tables.get(&(piece.material, piece.part))).cloned();
        let source = surface.painted.map(|own| &self.painted[own]);
        let painted = source.map(|source| PaintedPrimitive { source, place: [mesh, number] });
        let batch = batch(BatchInput { primitive, finished, table, painted, surface, to_view, keep });
        (batch.triangle_count() > 0).then_some(((material, part, finished.is_some()), batch))
    }

    /// The first drawn instance of a mesh: mesh to world.
    pub fn first_instance(&self, mesh: usize) -> Option<DAffine3> {
        let instances = &self.asset.instances[..self.drawn_instance_count];
        instances.iter().find(|instance| instance.mesh == mesh).map(affine)
    }

    pub fn asset(&self) -> &'a Asset {
        self.asset
    }

    pub fn finished(&self) -> &'a Finished {
        self.finished
    }

    /// Triangles of all drawn instances.
    pub fn triangle_count(&self) -> usize {
        let instances = self.asset.instances[..self.drawn_instance_count].iter();
        instances.map(|instance| mesh_triangles(self.asset, instance.mesh)).sum()
    }
}

fn tables(finished: &Finished) -> BTreeMap<(usize, usize), Arc<MctBlockTable>> {
    let mut tables = BTreeMap::new();
    for primitive in &finished.primitives {
        if let Coordinates::Indexed(table) = &primitive.coordinates {
            let place = (primitive.material, primitive.part);
            tables.entry(place).or_insert_with(|| Arc::new(MctBlockTable::new(table)));
        }
    }
    tables
}

#[derive(Clone, Copy)]
struct Placed {
    to_view: DAffine3,
    keep: Option<[DVec3; 2]>,
}

fn affine(instance: &Instance) -> DAffine3 {
    let transform = &instance.transform;
    let columns = transform.matrix3.to_cols_array().map(f64::from);
    DAffine3 {
        matrix3: DMat3::from_cols_array(&columns),
        translation: glam::Vec3::from(transform.translation).as_dvec3(),
    }
}

fn mesh_triangles(asset: &Asset, mesh: usize) -> usize {
    let faces = asset.meshes[mesh].primitives.iter().flat_map(|primitive| &primitive.faces);
    faces.map(|face| face.triangles().len()).sum()
}

fn drawn_instances(asset: &Asset) -> usize {
    let by_mesh: Vec<usize> = (0..asset.meshes.len()).map(|mesh| mesh_triangles(asset, mesh)).collect();
    let mut drawn = 0_usize;
    for (count, instance) in asset.instances.iter().enumerate() {
        drawn = drawn.saturating_add(by_mesh[instance.mesh]);
        if drawn > DRAWN_TRIANGLES_MAX && count > 0 {
            return count;
        }
    }
    asset.instances.len()
}
