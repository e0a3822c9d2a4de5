//! Values of options as text: names of tables, lists of names, numbers.

use std::collections::BTreeSet;

/// No list, no figure.
pub const NONE: &str = "none";

/// The names of a table, for [`OptionSpec::rungs`].
pub const fn names<T, const COUNT: usize>(table: &[(&'static str, T)]) -> [&'static str; COUNT] {
    assert!(table.len() == COUNT);
    let mut names = [""; COUNT];
    let mut at = 0;
    while at < COUNT {
        names[at] = table[at].0;
        at += 1;
    }
    names
}

pub fn named<T: Copy>(table: &[(&str, T)], value: &str) -> Option<T> {
    table.iter().find(|(name, _)| *name == value).map(|(_, rung)| *rung)
}

pub fn name_of<T: PartialEq>(table: &[(&'static str, T)], value: T) -> &'static str {
    table.iter().find(|(_, rung)| *rung == value).map_or("", |(name, _)| name)
}

pub fn parse_list<T: Copy + Ord>(table: &[(&str, T)], value: &str) -> Option<BTreeSet<T>> {
    if value == NONE {
        return Some(BTreeSet::new());
    }
    value.split(',').map(|name| named(table, name.trim())).collect()
}

pub fn list<T: Copy + Ord>(table: &[(&'static str, T)], formats: &BTreeSet<T>) -> String {
    if formats.is_empty() {
        return NONE.to_owned();
    }
    formats.iter().map(|format| name_of(table, *format)).collect::<Vec<_>>().join(",")
}

pub fn in_range(value: &str, low: f32, high: f32) -> Option<f32> {
    value.parse::<f32>().ok().filter(|v| (low..=high).contains(v))
}

/// [`NONE`], or what `parse` makes of the value; `None` where it makes nothing of it.
pub fn optional<T>(value: &str, parse: impl Fn(&str) -> Option<T>) -> Option<Option<T>> {
    if value == NONE { Some(None) } else { parse(value).map(Some) }
}
