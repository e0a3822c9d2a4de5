//! Which materials take their vertex colors: these multiply the base color then, and leave the vertices.

use std::collections::BTreeSet;

use glam::Vec4;

use crate::asset::{Asset, Primitive, VERTEX_COLORS};
use crate::error::Warning;
use crate::write::shows_textures;

/// What becomes of `COLOR_0`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexColors {
    /// It stays an attribute of the vertices.
    Keep,
    /// It becomes the base color of materials that have no texture at all.
    Auto,
    /// It becomes a part of every converted material's base color.
    Bake,
}

const VARIANTS: &str = "primitives whose vertex colors went into their base color, and whose other materials \
                        (KHR_materials_variants) are drawn without them now; `vertex-colors` = keep leaves them";
const UNBOUNDED: &str = "vertices whose color is not within [0, 1], which is all that a texture slot holds; the nearest in it was taken";
const MOVING: &str = "primitives whose morph targets move their vertex colors, which no texture does; they kept them as they are";

/// The materials that take them. One with mesh colors never does: what its base color is stands there. Nor does one whose vertices are
/// all white, as many programs write them: that changes nothing.
pub fn takers(asset: &Asset, rung: VertexColors) -> BTreeSet<usize> {
    let takes = |material: &usize| {
        let own = || primitives(asset, *material);
        let is_allowed = match rung {
            VertexColors::Keep => false,
            VertexColors::Auto => !has_texture(asset, *material),
            VertexColors::Bake => true,
        };
        is_allowed
            && asset.materials[*material].mesh_colors.is_none()
            && own().any(|(_, primitive)| is_colored(primitive))
            && !own().any(|(_, primitive)| is_moving(primitive))
    };
    (0..asset.materials.len()).filter(takes).collect()
}

/// Which vertex colors a rung takes, in words.
pub fn rule(rung: VertexColors) -> &'static str {
    match rung {
        VertexColors::Keep => "which `vertex-colors` = keep leaves alone",
        VertexColors::Auto => {
            "COLOR_0 of a material without any texture, or with `vertex-colors` = bake of any"
        }
        VertexColors::Bake => "COLOR_0",
    }
}

/// What could not be done as it was asked for, or shows elsewhere.
pub fn warnings(asset: &Asset, rung: VertexColors, takers: &BTreeSet<usize>) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = Vec::new();
    let mut add = |code: &str, detail: &str, pointer: &str, count: u64| {
        if count == 0 {
            return;
        }
        match warnings.iter_mut().find(|known| known.code == code) {
            Some(known) => known.count += count,
            None => warnings.push(Warning {
                code: code.to_owned(),
                detail: detail.to_owned(),
                pointer: pointer.to_owned(),
                count,
            }),
        }
    };
    for material in 0..asset.materials.len() {
        let is_taker = takers.contains(&material);
        for (pointer, primitive) in primitives(asset, material) {
            if is_taker {
                let json = asset.document.json.pointer(&pointer);
                let variants = json.and_then(|json| json.pointer("/extensions/KHR_materials_variants"));
                add("variants_without_vertex_colors", VARIANTS, &pointer, u64::from(variants.is_some()));
                add("clamped_vertex_color", UNBOUNDED, &pointer, primitive.unbounded_color_count());
            } else if rung == VertexColors::Bake {
                add("moving_vertex_colors", MOVING, &pointer, u64::from(is_moving(primitive)));
            }
        }
    }
    warnings
}

/// The primitives with faces of a material, each with its place.
fn primitives(asset: &Asset, material: usize) -> impl Iterator<Item = (String, &Primitive)> {
    asset.meshes.iter().enumerate().flat_map(move |(mesh, content)| {
        let own = content.primitives.iter().enumerate();
        let own = own.filter(move |(_, own)| own.material == Some(material) && !own.faces.is_empty());
        own.map(move |(number, own)| (format!("/meshes/{mesh}/primitives/{number}"), own))
    })
}

/// Whether a material shows any texture, those of extensions too.
fn has_texture(asset: &Asset, material: usize) -> bool {
    let json = asset.document.json.get("materials").and_then(|materials| materials.get(material));
    asset.materials[material].slots.keys().any(|slot| !slot.is_attribute())
        || json.is_some_and(shows_textures)
}

fn is_colored(primitive: &Primitive) -> bool {
    // Those that are white since they are clamped are none.
    primitive.unbounded_color_count() > 0
        || primitive.vertex_colors().is_some_and(|colors| colors.iter().any(|color| *color != Vec4::ONE))
}

fn is_moving(primitive: &Primitive) -> bool {
    let mut moved = primitive.targets.iter().flat_map(|target| &target.attributes);
    moved.any(|attribute| attribute.semantic == VERTEX_COLORS)
}
