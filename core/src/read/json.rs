//! JSON text to a tree, with its size and depth limited before the parser sees it, and [`At`]: a value
//! that knows its JSON pointer, so that every refusal names its place.

use serde_json::Value;

use super::container::without_bom;
use super::{Limits, text::quoted};
use crate::error::{Error, ErrorCode, Result};

/// The parser refuses deeper nesting by itself; this keeps its stack out of reach of any setting.
const PARSER_DEPTH: u32 = 127;

/// A value in memory takes some 70 bytes, however short its text; of the bytes allowed, so many go to
/// each value. glTF writes more than ten.
const BYTES_PER_VALUE: u64 = 8;

pub(super) fn parse(bytes: &[u8], limits: &Limits) -> Result<Value> {
    let text = without_bom(bytes);
    check_size(text, limits)?;
    serde_json::from_slice(text).map_err(|error| Error::invalid(format!("the JSON cannot be read: {error}")))
}

fn check_size(text: &[u8], limits: &Limits) -> Result<()> {
    let too_large = |what: &str, name: &str, limit: u64, actual: u64| {
        let detail = format!("the JSON {what} {actual}; the limit is {limit} (limit `{name}`)");
        Err(Error::new(ErrorCode::ModelTooLarge, detail).limit(limit, actual))
    };
    let length = text.len() as u64;
    if length > limits.json_bytes {
        return too_large("has bytes:", "json_bytes", limits.json_bytes, length);
    }
    let depth_limit = limits.json_depth.min(PARSER_DEPTH);
    let value_limit = limits.json_bytes / BYTES_PER_VALUE;
    let (mut depth, mut value_count) = (0u32, 0u64);
    let (mut in_string, mut escaped) = (false, false);
    for &byte in text {
        if in_string {
            match byte {
                _ if escaped => escaped = false,
                b'\\' => escaped = true,
                b'"' => in_string = false,
                _ => {}
            }
            continue;
        }
        match byte {
            b'"' => in_string = true,
            b'[' | b'{' => {
                depth += 1;
                value_count += 1;
                if depth > depth_limit {
                    return too_large("is nested to depth", "json_depth", depth_limit.into(), depth.into());
                }
            }
            b']' | b'}' => depth = depth.saturating_sub(1),
            b',' => value_count += 1,
            _ => {}
        }
    }
    if value_count > value_limit {
        return too_large("has values:", "json_bytes", value_limit, value_count);
    }
    Ok(())
}

/// A value with its place.
#[derive(Clone, Debug)]
pub(super) struct At<'a> {
    pub value: &'a Value,
    pub pointer: String,
}

impl<'a> At<'a> {
    pub fn root(value: &'a Value) -> Self {
        Self { value, pointer: String::new() }
    }

    pub fn error(&self, detail: impl Into<String>) -> Error {
        let error = Error::invalid(detail);
        if self.pointer.is_empty() { error } else { error.at(self.pointer.clone()) }
    }

    /// The member of an object, where it is there.
    pub fn get(&self, key: &str) -> Option<At<'a>> {
        let value = self.value.get(key)?;
        Some(At { value, pointer: pointer_to(&self.pointer, key) })
    }

    /// The object at `key`; absent counts as none.
    pub fn object(&self, key: &str) -> Result<Option<At<'a>>> {
        match self.get(key) {
            Some(at) if !at.value.is_object() => Err(at.error("must be an object")),
            other => Ok(other),
        }
    }

    /// The values of an array of this object; absent counts as empty.
    pub fn list(&self, key: &str) -> Result<&'a [Value]> {
        match self.value.get(key) {
            None => Ok(&[]),
            Some(Value::Array(list)) => Ok(list),
            Some(_) => Err(self.error(format!("`{key}` must be an array"))),
        }
    }

    /// The elements of an array of objects, each with its place.
    pub fn objects(&self, key: &str) -> Result<Vec<At<'a>>> {
        let base = pointer_to(&self.pointer, key);
        let elements = self.list(key)?.iter().enumerate();
        elements
            .map(|(index, value)| {
                let at = At { value, pointer: format!("{base}/{index}") };
                if value.is_object() { Ok(at) } else { Err(at.error("must be an object")) }
            })
            .collect()
    }

    /// The members of this object, each with its place, in the file's order.
    pub fn members(&self) -> impl Iterator<Item = (&'a str, At<'a>)> + use<'a, '_> {
        self.value
            .as_object()
            .into_iter()
            .flatten()
            .map(|(key, value)| (key.as_str(), At { value, pointer: pointer_to(&self.pointer, key) }))
    }

    /// A whole number, written as one or as a float without fraction.
    pub fn whole(&self) -> Result<u64> {
        const EXACT: f64 = 9_007_199_254_740_992.0;
        let number = self.value.as_u64().or_else(|| {
            let float = self.value.as_f64()?;
            (float.fract() == 0.0 && (0.0..=EXACT).contains(&float)).then_some(float as u64)
        });
        number.ok_or_else(|| self.error("must be a whole number, not negative"))
    }

    pub fn size(&self, key: &str) -> Result<Option<usize>> {
        let Some(at) = self.get(key) else { return Ok(None) };
        let number = usize::try_from(at.whole()?).map_err(|_| at.error("is too large"))?;
        Ok(Some(number))
    }

    pub fn need_size(&self, key: &str) -> Result<usize> {
        self.size(key)?.ok_or_else(|| self.error(format!("`{key}` is missing")))
    }

    /// An index into a list of `length` elements.
    pub fn index_below(&self, length: usize, what: &str) -> Result<usize> {
        let index = self.whole()?;
        match usize::try_from(index) {
            Ok(index) if index < length => Ok(index),
            _ => Err(self.error(format!("index {index} is out of range: there are {length} {what}"))),
        }
    }

    pub fn index(&self, key: &str, length: usize, what: &str) -> Result<Option<usize>> {
        self.get(key).map(|at| at.index_below(length, what)).transpose()
    }

    pub fn need_index(&self, key: &str, length: usize, what: &str) -> Result<usize> {
        self.index(key, length, what)?.ok_or_else(|| self.error(format!("`{key}` is missing")))
    }

    pub fn string(&self, key: &str) -> Result<Option<&'a str>> {
        let Some(at) = self.get(key) else { return Ok(None) };
        at.value.as_str().map(Some).ok_or_else(|| at.error("must be a string"))
    }

    pub fn flag(&self, key: &str) -> Result<bool> {
        let Some(at) = self.get(key) else { return Ok(false) };
        at.value.as_bool().ok_or_else(|| at.error("must be true or false"))
    }

    /// A number that single precision holds.
    pub fn number(&self, key: &str) -> Result<Option<f32>> {
        let Some(at) = self.get(key) else { return Ok(None) };
        finite(at.value).map(Some).ok_or_else(|| at.error("must be a number within single precision"))
    }

    pub fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f32; N]>> {
        let Some(at) = self.get(key) else { return Ok(None) };
        let wrong = || at.error(format!("must be {N} numbers within single precision"));
        let list = at.value.as_array().filter(|list| list.len() == N).ok_or_else(wrong)?;
        let mut numbers = [0.0; N];
        for (number, value) in numbers.iter_mut().zip(list) {
            *number = finite(value).ok_or_else(wrong)?;
        }
        Ok(Some(numbers))
    }
}

fn finite(value: &Value) -> Option<f32> {
    value.as_f64().map(|number| number as f32).filter(|number| number.is_finite())
}

/// Characters of a key that a pointer shows; longer keys are cut, they are nobody's real names.
const KEY_CHARS: usize = 200;

fn pointer_to(base: &str, key: &str) -> String {
    if key.chars().any(|c| matches!(c, '~' | '/') || c.is_control()) || key.len() > KEY_CHARS {
        let cut: String = key.chars().take(KEY_CHARS).collect();
        let escaped = cut.replace('~', "~0").replace('/', "~1").escape_debug().to_string();
        return format!("{base}/{escaped}");
    }
    format!("{base}/{key}")
}

/// Refuses what `asset.version` and `asset.minVersion` rule out.
pub(super) fn check_version(root: &At) -> Result<()> {
    let asset =
        root.object("asset")?.ok_or_else(|| root.error("`asset` is missing: this is not glTF 2.0"))?;
    let version = asset.string("version")?.ok_or_else(|| asset.error("`version` is missing"))?;
    let needed = asset.string("minVersion")?.unwrap_or("2.0");
    if version.split('.').next() != Some("2") || needed != "2.0" {
        let detail = format!(
            "the asset is of version {} and needs {}; glTF 2.0 is read",
            quoted(version),
            quoted(needed)
        );
        return Err(asset.error(detail));
    }
    Ok(())
}
