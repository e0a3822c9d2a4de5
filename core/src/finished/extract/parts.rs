//! Which glTF materials are parts of one converted material.

use std::collections::BTreeMap;

use serde_json::Value;

use super::EXTENSION;
use crate::asset::Asset;
use crate::error::{Error, Result};

/// Parts are counted in 16 bits.
const PART_MAX: u64 = 65_535;

/// A glTF material's place: it is one part of a material, mostly the only one of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PartOf {
    pub material: usize,
    pub part: usize,
}

/// By glTF material.
///
/// # Errors
/// `InvalidModel` where a material is said to be a part of itself, of a part, or of one that is not there, and where
/// two are the same part.
pub fn of(asset: &Asset) -> Result<Vec<PartOf>> {
    let json = asset.document.json.get("materials");
    let own = |material: usize, name: &str| -> Option<&Value> {
        json?.get(material)?.get("extensions")?.get(EXTENSION)?.get(name)
    };
    let count = asset.materials.len();
    let mut places = Vec::with_capacity(count);
    let mut known: BTreeMap<PartOf, usize> = BTreeMap::new();
    for material in 0..count {
        let lie = |name: &str, rule: String| {
            Error::invalid(rule).at(format!("/materials/{material}/extensions/{EXTENSION}/{name}"))
        };
        let whole = |name: &str, end: u64, rule: &str| match own(material, name) {
            None => Ok(None),
            Some(value) => match value.as_u64().filter(|&value| value < end) {
                Some(value) => Ok(Some(value as usize)),
                None => Err(lie(name, format!("\"{name}\" has to be {rule}, and it is {value}"))),
            },
        };
        let base = whole("partOf", count as u64, "the number of another material")?;
        let part = whole("part", PART_MAX + 1, "a whole number from 0 to 65535")?.unwrap_or(0);
        if let Some(base) = base
            && (base == material || own(base, "partOf").is_some())
        {
            let rule = format!("material {base} cannot have parts: it is this one, or a part itself");
            return Err(lie("partOf", rule));
        }
        let place = PartOf { material: base.unwrap_or(material), part };
        if let Some(other) = known.insert(place, material) {
            let PartOf { material: base, part } = place;
            let rule = format!("materials {other} and {material} are both part {part} of material {base}");
            return Err(lie("part", rule));
        }
        places.push(place);
    }
    Ok(places)
}
