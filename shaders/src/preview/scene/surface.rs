//! What a renderer needs to know of a material on one side of the sheet, reduced to what the asset has
//! and the picture shows.

use glam::{Vec3, Vec4};
use meshcolor::asset::{AlphaMode, Asset, Material, Slot, UvTransform};
use meshcolor::finished::Finished;
use meshcolor::image::Wrap;

use super::texture::TextureList;

/// Which half of the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Source,
    Converted,
}

/// What a picture shows of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// All of the material, lit.
    Lit,
    /// One channel alone, unlit.
    Flat(Slot),
}

/// How a slot finds its place in its texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinate {
    /// Texture coordinates: number in `Surface::uv_sets`.
    Uv { set: usize, wrap: Wrap },
    /// The mesh coordinate, 4D or indexed.
    Mesh,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Binding {
    /// Number in `Scene::textures`.
    pub texture: usize,
    pub coordinate: Coordinate,
}

/// A texture coordinate set of the primitive with the transform that its slot asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvSet {
    pub texcoord: usize,
    pub transform: UvTransform,
}

/// A material as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Indexed as [`Slot::CORE`]; in the base color's place what [`base_of`] says.
    pub bindings: [Option<Binding>; 5],
    /// The slot that is drawn as base color.
    pub base: Slot,
    pub uv_sets: Vec<UvSet>,
    pub base_color_factor: Vec4,
    pub metallic_factor: f32,
    pub roughness_factor: f32,
    pub emissive_factor: Vec3,
    pub normal_scale: f32,
    pub occlusion_strength: f32,
    pub alpha_mode: AlphaMode,
    pub double_sided: bool,
    /// Number in `Scene::painted`: mesh colors instead of textures.
    pub painted: Option<usize>,
    /// Whether the vertex colors multiply the base color: those that went into the converted one, on the source's side.
    pub is_tinted: bool,
}

impl Surface {
    /// The surface of a material without textures.
    fn plain(material: &Material) -> Self {
        Self {
            bindings: [None; 5],
            base: Slot::BaseColor,
            uv_sets: Vec::new(),
            base_color_factor: material.base_color_factor,
            metallic_factor: material.metallic_factor,
            roughness_factor: material.roughness_factor,
            emissive_factor: material.emissive_factor,
            normal_scale: material.normal_scale,
            occlusion_strength: material.occlusion_strength,
            alpha_mode: material.alpha_mode,
            double_sided: material.double_sided,
            painted: None,
            is_tinted: false,
        }
    }

    /// A material (`None`: glTF's default one) on one side: a part of it on the converted one. That one reads a slot by mesh
    /// coordinate where that slot was converted and the primitive has such coordinates.
    pub fn new(
        list: &mut TextureList<'_>,
        asset: &Asset,
        finished: &Finished,
        part: Option<usize>,
        material: Option<usize>,
    ) -> Self {
        let Some(index) = material else { return Self::plain(&default_material()) };
        let material = &asset.materials[index];
        let mut surface = Self::plain(material);
        surface.show(base_of(asset, finished, index));
        for (place, slot) in Slot::CORE.into_iter().enumerate() {
            let slot = if slot == Slot::BaseColor { surface.base } else { slot };
            let converted = part.and_then(|part| {
                finished.textures.iter().position(|t| t.is_of(index, part) && t.slots.contains(&slot))
            });
            surface.bindings[place] = match (converted, material.slot(slot)) {
                (Some(texture), _) => Some(Binding { texture, coordinate: Coordinate::Mesh }),
                (None, Some(reference)) => {
                    let texture = list.source(reference.image, slot.is_color());
                    let set = UvSet { texcoord: reference.texcoord, transform: reference.transform };
                    let set = surface.uv_set(set);
                    Some(Binding { texture, coordinate: Coordinate::Uv { set, wrap: reference.wrap } })
                }
                (None, None) => None,
            };
        }
        surface
    }

    /// Draws a slot as base color: data on a dull surface, without a factor.
    fn show(&mut self, base: Slot) {
        self.base = base;
        if base == Slot::BaseColor {
            return;
        }
        (self.base_color_factor, self.metallic_factor, self.roughness_factor) = (Vec4::ONE, 0.0, 1.0);
    }

    fn uv_set(&mut self, set: UvSet) -> usize {
        match self.uv_sets.iter().position(|known| *known == set) {
            Some(number) => number,
            None => {
                self.uv_sets.push(set);
                self.uv_sets.len() - 1
            }
        }
    }

    pub fn binding(&self, slot: Slot) -> Option<&Binding> {
        let place = Slot::CORE.iter().position(|own| *own == slot)?;
        self.bindings[place].as_ref()
    }

    pub fn uses_mesh_coordinates(&self) -> bool {
        self.bindings.iter().flatten().any(|binding| binding.coordinate == Coordinate::Mesh)
    }

    /// Only what `look` shows: a flat picture reads one channel, and base color where alpha is tested.
    pub fn reduced(&self, look: Look) -> Self {
        let Look::Flat(shown) = look else { return self.clone() };
        let mut surface = self.clone();
        let is_tested = matches!(self.alpha_mode, AlphaMode::Mask(_));
        for (place, slot) in Slot::CORE.into_iter().enumerate() {
            let is_base = slot == Slot::BaseColor;
            let is_needed = slot == shown || is_base && (is_tested || shown.is_attribute());
            if !is_needed {
                surface.bindings[place] = None;
            }
        }
        if surface.alpha_mode == AlphaMode::Blend {
            surface.alpha_mode = AlphaMode::Opaque;
        }
        surface
    }
}

/// What is drawn as a material's base color: where it has none, the first of its attributes.
pub fn base_of(asset: &Asset, finished: &Finished, material: usize) -> Slot {
    let converted = finished.textures.iter().filter(|texture| texture.materials.contains(&material));
    let slots =
        || converted.clone().flat_map(|texture| &texture.slots).chain(asset.materials[material].slots.keys());
    if slots().any(|slot| *slot == Slot::BaseColor) {
        return Slot::BaseColor;
    }
    slots().filter(|slot| slot.is_attribute()).min().copied().unwrap_or(Slot::BaseColor)
}

/// glTF 2.0, section 3.9: what a primitive without a material has.
fn default_material() -> Material {
    Material {
        base_color_factor: Vec4::ONE,
        metallic_factor: 1.0,
        roughness_factor: 1.0,
        normal_scale: 1.0,
        occlusion_strength: 1.0,
        ..Material::default()
    }
}
