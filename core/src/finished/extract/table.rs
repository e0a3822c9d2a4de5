//! The table of a primitive's indexed coordinates. What its figures have to hold among themselves and for their
//! images is checked with the triangles, see `Finished::check_coordinates`; here they are whole numbers that fit.

use serde_json::Value;

use super::{EXTENSION, Place};
use crate::error::Result;
use crate::finished::{BlockClass, BlockTable, TableLevel};

/// The table, or `None` where the primitive's coordinates are not indexed.
pub fn of(place: &Place<'_>) -> Result<Option<BlockTable>> {
    let json = place.json().and_then(|json| json.get("extensions")?.get(EXTENSION)?.get("coordinates"));
    let Some(json) = json else { return Ok(None) };
    let lie =
        |below: &str, rule: &str| place.lie(&format!("/extensions/{EXTENSION}/coordinates{below}"), rule);
    let list = |name: &str| {
        let list = json.get(name).and_then(Value::as_array);
        list.ok_or_else(|| lie("", &format!("\"{name}\" has to be a list of objects")))
    };
    let class = |(number, json): (usize, &Value)| {
        let at = format!("/classes/{number}");
        let exponent = |name: &str| {
            let exponent = json.get(name).and_then(Value::as_u64).and_then(|value| u8::try_from(value).ok());
            exponent.ok_or_else(|| lie(&at, "\"r\" and \"s\" have to be 0 to 20"))
        };
        let size = |name: &str| {
            pair(json.get(name)).ok_or_else(|| lie(&at, &format!("\"{name}\" has to be two whole numbers")))
        };
        Ok(BlockClass {
            exponents: [exponent("r")?, exponent("s")?],
            cells: size("cells")?,
            gap: size("gap")?,
            shift: size("shift")?,
        })
    };
    let level = |(number, json): (usize, &Value)| {
        let at = format!("/levels/{number}");
        let columns = each(json.get("columns"), |value| whole(Some(value)));
        let firsts = each(json.get("first"), |value| whole(Some(value)));
        let origins = each(json.get("origin"), |value| pair(Some(value)));
        Ok(TableLevel {
            columns: columns.ok_or_else(|| lie(&at, "\"columns\" has to be a list of whole numbers"))?,
            firsts: firsts.ok_or_else(|| lie(&at, "\"first\" has to be a list of whole numbers"))?,
            origins: origins
                .ok_or_else(|| lie(&at, "\"origin\" has to be a list of pairs of whole numbers"))?,
        })
    };
    Ok(Some(BlockTable {
        classes: list("classes")?.iter().enumerate().map(class).collect::<Result<_>>()?,
        levels: list("levels")?.iter().enumerate().map(level).collect::<Result<_>>()?,
    }))
}

fn whole(value: Option<&Value>) -> Option<u32> {
    value?.as_u64().and_then(|value| u32::try_from(value).ok())
}

fn pair(value: Option<&Value>) -> Option<[u32; 2]> {
    let [x, y] = value?.as_array()?.as_slice() else { return None };
    Some([whole(Some(x))?, whole(Some(y))?])
}

fn each<T>(list: Option<&Value>, one: impl Fn(&Value) -> Option<T>) -> Option<Vec<T>> {
    list?.as_array()?.iter().map(one).collect()
}
