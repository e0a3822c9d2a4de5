//! What the levels of a converted texture hold where it is not codes of [0, 1].

use std::collections::BTreeMap;

use glam::Vec4;
use half::f16;
use serde_json::Value;

use crate::error::{Error, Result};
use crate::image::{Image, LevelRange, Pixels};

/// Reads `ranges` beside the `levels` that it is about; `place` is its JSON pointer. Levels before `first` have none.
///
/// # Errors
/// `InvalidModel` where a level is named twice or is not there, where its image has no 16 bits or holds
/// half floats that are no numbers, and where a scale or bias is not finite or a scale not above 0.
pub fn of(
    ranges: Option<&Value>,
    levels: &[Image],
    first: usize,
    place: &str,
) -> Result<BTreeMap<usize, LevelRange>> {
    let mut found = BTreeMap::new();
    let Some(ranges) = ranges else { return Ok(found) };
    let entries = ranges.as_array();
    let entries =
        entries.ok_or_else(|| Error::invalid("\"ranges\" has to be a list of objects").at(place))?;
    for (number, entry) in entries.iter().enumerate() {
        let lie = |rule: String| Error::invalid(rule).at(format!("{place}/{number}"));
        let level = entry.get("level").and_then(Value::as_u64).and_then(|level| usize::try_from(level).ok());
        let level = level.filter(|level| (first..levels.len()).contains(level)).ok_or_else(|| {
            lie(format!("\"level\" has to be one of {first} to {}", levels.len().saturating_sub(1)))
        })?;
        let image = &levels[level];
        let Pixels::U16(codes) = &image.pixels else {
            return Err(lie(format!("the image of level {level} has to have 16 bits")));
        };
        let range = match entry.get("format").and_then(Value::as_str) {
            Some("scaled16") => scaled(entry, image.components).map_err(lie)?,
            Some("float16") if codes.iter().all(|&code| f16::from_bits(code).is_finite()) => {
                LevelRange::Float16
            }
            Some("float16") => {
                return Err(lie(format!("the image of level {level} holds half floats that are no numbers")));
            }
            _ => return Err(lie("\"format\" has to be \"scaled16\" or \"float16\"".to_owned())),
        };
        if found.insert(level, range).is_some() {
            return Err(lie(format!("level {level} has two ranges")));
        }
    }
    Ok(found)
}

fn scaled(entry: &Value, components: u8) -> std::result::Result<LevelRange, String> {
    let [scale, bias] = ["scale", "bias"].map(|name| {
        let list = entry.get(name).and_then(Value::as_array);
        let numbers: Option<Vec<f32>> =
            list.and_then(|list| list.iter().map(|value| value.as_f64().map(|value| value as f32)).collect());
        numbers.filter(|numbers| numbers.len() == usize::from(components)).filter(|numbers| {
            // A positive number beyond 32 bits is infinite here.
            numbers.iter().all(|value| value.is_finite() && (name == "bias" || *value > 0.0))
        })
    });
    match (scale, bias) {
        (Some(scale), Some(bias)) => {
            Ok(LevelRange::Scaled16 { scale: by_color(&scale, 1.0), bias: by_color(&bias, 0.0) })
        }
        (None, _) => Err(format!("\"scale\" has to be {components} finite numbers above 0")),
        (_, None) => Err(format!("\"bias\" has to be {components} finite numbers")),
    }
}

/// Stored components to red, green, blue, alpha; `absent` for an alpha that is not there.
fn by_color(stored: &[f32], absent: f32) -> Vec4 {
    match *stored {
        [gray] => Vec4::new(gray, gray, gray, absent),
        [gray, alpha] => Vec4::new(gray, gray, gray, alpha),
        [red, green, blue] => Vec4::new(red, green, blue, absent),
        [red, green, blue, alpha, ..] => Vec4::new(red, green, blue, alpha),
        [] => Vec4::splat(absent),
    }
}
