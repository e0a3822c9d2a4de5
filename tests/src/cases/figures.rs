//! The key figures of a conversion: few enough to read, and a hash for all the rest.

use glam::{Vec3, Vec4};
use meshcolor::asset::{Asset, Slot};
use meshcolor::finished::{Finished, FinishedTexture};
use meshcolor::image::{Transfer, Wrap, WrapMode, bilinear};
use meshcolor::math::transfer::linear_to_srgb;
use meshcolor::measure::{ChannelReport, EffectState, LayoutReport};
use meshcolor::pipeline::Conversion;
use meshcolor::read::{Limits, Upload, read};
use meshcolor::watch::Unwatched;
use serde_json::{Map, Value, json};

pub fn of(conversion: &Conversion) -> Value {
    let Conversion { asset, finished, report, files, .. } = conversion;
    let warnings: Map<String, Value> =
        report.warnings.iter().map(|warning| (warning.code.clone(), warning.count.into())).collect();
    let run = report.effects.iter().filter(|effect| effect.state == EffectState::Run);
    let channels = report.channels.iter().zip(&finished.textures);
    json!({
        "verdict": report.verdict,
        "warnings": warnings,
        "effects": run.map(|effect| effect.name.clone()).collect::<Vec<_>>(),
        "materials": report.layouts.iter().map(material).collect::<Vec<_>>(),
        "channels": channels.map(|(report, texture)| channel(report, texture, finished)).collect::<Vec<_>>(),
        "document": document(asset, &files[0].bytes),
        "asset_glb_blake3": blake3::hash(&files[0].bytes).to_hex().as_str(),
    })
}

/// JSON for people and diffs: objects over several lines, lists of numbers on one.
pub fn text(value: &Value, depth: usize) -> String {
    let is_open = |value: &Value| {
        value.is_object() || value.as_array().is_some_and(|list| list.iter().any(Value::is_object))
    };
    let indent = "  ".repeat(depth + 1);
    let close = "  ".repeat(depth);
    match value {
        Value::Object(members) if !members.is_empty() => {
            let member = |(name, value): (&String, &Value)| {
                format!("{indent}{}: {}", json!(name), text(value, depth + 1))
            };
            format!("{{\n{}\n{close}}}", members.iter().map(member).collect::<Vec<_>>().join(",\n"))
        }
        Value::Array(list) if is_open(value) => {
            let element = |value: &Value| format!("{indent}{}", text(value, depth + 1));
            format!("[\n{}\n{close}]", list.iter().map(element).collect::<Vec<_>>().join(",\n"))
        }
        _ => value.to_string(),
    }
}

fn material(layout: &LayoutReport) -> Value {
    json!({
        "faces": layout.face_count,
        "quads": layout.quad_count,
        "pairs": layout.merged_pair_count,
        "lone": layout.lone_triangle_count,
        "exponents": layout.exponents,
        "sizes": layout.levels.iter().map(|level| level.size).collect::<Vec<_>>(),
    })
}

fn channel(report: &ChannelReport, texture: &FinishedTexture, finished: &Finished) -> Value {
    let seams = report.levels.iter().filter_map(|level| level.seams);
    let round = |value: f64| (value * 1000.0).round() / 1000.0;
    json!({
        "slots": report.slots.join(" "),
        "components": report.components,
        "bits": report.bits,
        "seam_edges": report.cuts.seam_edge_count,
        "welded_share": round(report.cuts.welded_share),
        "cut_share": round(report.cuts.cut_share),
        "cut_edges": report.cuts.cut_edge_count,
        "max_seam": round(seams.map(|seams| seams.max).fold(0.0, f64::max)),
        "psnr_db": report.fidelity.map(|fidelity| round(fidelity.psnr_db)),
        "corners": corners(texture, finished),
    })
}

/// The 8-bit codes that the first triangle shows at its corners at level 0.
fn corners(texture: &FinishedTexture, finished: &Finished) -> Vec<Vec<u32>> {
    let clamp = Wrap { s: WrapMode::ClampToEdge, t: WrapMode::ClampToEdge };
    let piece = finished.primitives.iter().find(|piece| texture.is_of(piece.material, piece.part));
    let piece = piece.expect("a converted material has triangles");
    let image = &texture.levels[0];
    let shown = |corner: usize| {
        let value = bilinear(image, texture.transfer, clamp, piece.place(0, corner, 0));
        let color = Vec3::new(value.x, value.y, value.z);
        let color = if texture.transfer == Transfer::Srgb { color.map(linear_to_srgb) } else { color };
        let codes = Vec4::from((color, value.w)) * 255.0;
        let components: &[usize] = match image.components {
            1 => &[0],
            2 => &[0, 3],
            3 => &[0, 1, 2],
            _ => &[0, 1, 2, 3],
        };
        components.iter().map(|&k| codes[k].round() as u32).collect()
    };
    (0..3).map(shown).collect()
}

/// What passes through, as the written file has it. `kept`: nodes, scenes, skins and mesh extras are the
/// source's to the letter, and so are the movements of its animations.
fn document(asset: &Asset, glb: &[u8]) -> Value {
    let written = read(&Upload::single("asset.glb", glb.to_vec()), &Limits::default(), &Unwatched);
    let back = written.unwrap_or_else(|error| panic!("the written file: {error}"));
    let (old, new) = (&asset.document.json, &back.document.json);
    let count = |name: &str| new[name].as_array().map_or(0, Vec::len);
    let targets =
        back.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|primitive| primitive.targets.len());
    let same = |name: &str| old[name] == new[name];
    let joints = |json: &Value| json.pointer("/skins/0/joints").cloned();
    let extras = |json: &Value| json.pointer("/meshes/0/extras").cloned();
    let moves = |json: &Value| json.pointer("/animations/0/channels").cloned();
    let kept = same("nodes")
        && same("scenes")
        && joints(old) == joints(new)
        && extras(old) == extras(new)
        && moves(old) == moves(new)
        && back.instances == asset.instances;
    json!({
        "kept": kept,
        "nodes": count("nodes"),
        "meshes": count("meshes"),
        "primitives": back.meshes.iter().map(|mesh| mesh.primitives.len()).sum::<usize>(),
        "skins": count("skins"),
        "animations": count("animations"),
        "targets": targets.sum::<usize>(),
        "images": count("images"),
        "attributes": attributes(new),
        "extensions": new["extensionsUsed"],
        "slots": Slot::CORE.into_iter().filter(|&slot| back.materials.iter().any(|m| m.slot(slot).is_some())).count(),
    })
}

/// Semantics of the first primitive, sorted, without POSITION and the converter's own.
fn attributes(json: &Value) -> Vec<String> {
    let members = json.pointer("/meshes/0/primitives/0/attributes").and_then(Value::as_object);
    let names = members.into_iter().flatten().map(|(name, _)| name.clone());
    let mut names: Vec<String> =
        names.filter(|name| name != "POSITION" && !name.starts_with("_MCT_")).collect();
    names.sort();
    names
}
