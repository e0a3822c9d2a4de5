//! What the sheet says about a conversion and its pictures.

use std::collections::BTreeSet;

use meshcolor::asset::{Material, Slot};
use meshcolor::pipeline::{Conversion, Focus};
use serde_json::Value;

use super::scene::surface::{Look, base_of};
use super::scene::views::View;
use super::scene::{Filter, Scene, Subject};

/// The name that a model gives itself: its scene's, where an exporter has not just written "Scene", else
/// its first mesh's.
pub fn model_name(conversion: &Conversion) -> String {
    let json = &conversion.asset.document.json;
    let scene = json.get("scene").and_then(Value::as_u64).unwrap_or(0);
    let names = [json.pointer(&format!("/scenes/{scene}/name")), json.pointer("/meshes/0/name")];
    let mut names = names.into_iter().flatten().filter_map(Value::as_str).map(str::trim);
    names
        .find(|name| !name.is_empty() && !name.eq_ignore_ascii_case("scene"))
        .unwrap_or("Untitled model")
        .to_owned()
}

/// Figures of the whole model, one line.
pub fn subtitle(scene: &Scene<'_>) -> String {
    let textures = &scene.finished().textures;
    let levels = textures.iter().map(|texture| texture.levels.len()).max().unwrap_or(0);
    let largest = textures.iter().map(|texture| texture.levels[0].size()).max_by_key(|[w, h]| w * h);
    let mut parts = vec![
        "Seam check".to_owned(),
        counted(scene.triangle_count(), "triangle"),
        counted(textures.len(), "converted texture"),
        counted(levels, "level"),
    ];
    if let Some([width, height]) = largest {
        parts.push(format!("{width} × {height} texels at level 0"));
    }
    parts.join("   ·   ")
}

fn counted(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {what}{plural}", grouped(count))
}

/// Digits in groups of three, apart by a thin space.
fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            out.push('\u{a0}');
        }
        out.push(digit);
    }
    out
}

/// What the source's column shows, for its heading.
pub fn source_words(scene: &Scene<'_>) -> &'static str {
    let is_painted = |material| scene.painted.iter().any(|source| source.material == material);
    let is_pictured = |(number, material): (usize, &Material)| {
        !is_painted(number) && Slot::CORE.iter().any(|slot| material.slot(*slot).is_some())
    };
    let has_pictures = scene.asset().materials.iter().enumerate().any(is_pictured);
    match (scene.painted.is_empty(), has_pictures) {
        (true, _) => "ordinary mip maps",
        (false, true) => "mesh colors, mip maps elsewhere",
        (false, false) => "mesh colors, filtered as they are",
    }
}

/// A row's title and detail.
pub fn row_words(view: &View, filter: Filter, focus: Option<&Focus>) -> (String, String) {
    let title = match (view.subject, filter) {
        (Subject::World, _) => "Whole asset".to_owned(),
        (Subject::Mesh { .. }, Filter::Level(level)) => format!("Level {level}"),
        (Subject::Mesh { .. }, Filter::Trilinear) => "Close-up".to_owned(),
    };
    let look = match view.look {
        Look::Lit => "lit".to_owned(),
        Look::Flat(slot) => format!("{}, unlit", channel(&slot)),
    };
    let detail = match filter {
        Filter::Trilinear if view.mark.is_some() => {
            format!("{look}, trilinear filtering; the arrows point to the seam below")
        }
        Filter::Trilinear => format!("{look}, trilinear filtering"),
        Filter::Level(_) if view.mark.is_none() => format!("where the source's colors vary most; {look}"),
        Filter::Level(level) => {
            let jump = focus.and_then(|focus| focus.source_jumps_codes.get(level as usize));
            let jump = jump.filter(|jump| jump.is_finite() && **jump > 0.0);
            let jump = jump.map_or(String::new(), |jump| format!("; the source jumps by {jump:.1} codes"));
            format!("the source's worst seam, between the arrows; {look}{jump}")
        }
    };
    (title, detail)
}

fn channel(slot: &Slot) -> &str {
    match slot {
        Slot::BaseColor => "base color",
        Slot::MetallicRoughness => "metallic-roughness as stored",
        Slot::Normal => "normals as seen by the camera",
        Slot::Occlusion => "occlusion",
        Slot::Emissive => "emissive",
        Slot::Attribute(name) => name.as_str(),
    }
}

/// What the sheet does not show.
pub fn notes(conversion: &Conversion, scene: &Scene<'_>, has_close_up: bool) -> Vec<String> {
    let mut notes = Vec::new();
    let instances = conversion.asset.instances.len();
    if scene.drawn_instance_count < instances {
        notes.push(format!(
            "The first {} of {} instances are drawn.",
            grouped(scene.drawn_instance_count),
            grouped(instances)
        ));
    }
    if scene.triangle_count() == 0 {
        notes.push("The default scene has no triangles to draw.".to_owned());
    }
    notes.extend(stand_in(conversion));
    if !scene.painted.is_empty() {
        notes.push(
            "The source is mesh colors: its column is their samples as their own filters read them, linear in a level and mip-mapped \
             between levels."
                .to_owned(),
        );
    }
    if !has_close_up && scene.painted.is_empty() {
        notes.push(
            "No close-up: the source has no seam whose two sides agree at level 0 and part in its mip maps."
                .to_owned(),
        );
    }
    notes
}

/// Which attributes are shown and which are not.
fn stand_in(conversion: &Conversion) -> Option<String> {
    let (asset, finished) = (&conversion.asset, &conversion.finished);
    let bases: BTreeSet<Slot> = (0..asset.materials.len()).map(|own| base_of(asset, finished, own)).collect();
    let shown = bases.iter().filter(|slot| slot.is_attribute()).map(channel).collect::<Vec<_>>().join(", ");
    let slots = finished.textures.iter().flat_map(|texture| &texture.slots);
    let hidden: BTreeSet<&Slot> = slots.filter(|slot| slot.is_attribute() && !bases.contains(slot)).collect();
    let hidden = hidden.into_iter().map(channel).collect::<Vec<_>>().join(", ");
    match (shown.is_empty(), hidden.is_empty()) {
        (true, true) => None,
        (true, false) => Some(format!("Channels that a material does not show are not drawn: {hidden}.")),
        (false, true) => Some(format!("There is no base color; drawn in its place: {shown}.")),
        (false, false) => {
            Some(format!("There is no base color; drawn in its place: {shown}. Not drawn: {hidden}."))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_stand_in_groups() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(123), "123");
        assert_eq!(grouped(15_452), "15\u{a0}452");
        assert_eq!(grouped(1_015_452), "1\u{a0}015\u{a0}452");
    }

    #[test]
    fn one_is_singular() {
        assert_eq!(counted(1, "level"), "1 level");
        assert_eq!(counted(0, "level"), "0 levels");
    }
}
