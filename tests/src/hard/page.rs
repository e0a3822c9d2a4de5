//! The table of `docs/hard-cases.md`, from what `expected.json` has of each case (the cases' own tests hold that),
//! and from times, which no two machines share: whoever makes the table brings them.

use std::collections::BTreeMap;

use serde_json::Value;

use super::{HardCase, RUNS, names};
use crate::repository::{file, markdown, table};

pub const DOCUMENT: &str = "docs/hard-cases.md";
pub const MARK: &str = "hard cases";

const HEADING: &[&str] = &[
    "case",
    "what it is",
    "levels",
    "residual",
    "max seam",
    "of `local`",
    "of `clamp`",
    "max change",
    "from `exact`",
    "ms",
];

/// The whole table; `times` by case.
pub fn text(times: &BTreeMap<String, String>) -> String {
    let rows = names().into_iter().map(|name| {
        let hard = HardCase::load(&name);
        row(&hard, &hard.recorded(), times.get(&name).map_or("", String::as_str))
    });
    markdown(HEADING, rows)
}

/// The times that the page has now.
pub fn times() -> BTreeMap<String, String> {
    let rows = table(&file(DOCUMENT), HEADING[0]).into_iter();
    let time = |row: Vec<String>| Some((row.first()?.trim_matches('`').to_owned(), row.last()?.clone()));
    rows.filter_map(time).collect()
}

fn row(hard: &HardCase, recorded: &Value, time: &str) -> Vec<String> {
    let head = [format!("`{}`", hard.name), hard.case.purpose.clone()];
    if let Some(code) = recorded.pointer("/error/code").and_then(Value::as_str) {
        let refused = std::iter::once(format!("`{code}`"));
        let blank = std::iter::repeat_n(String::new(), HEADING.len() - 3);
        return head.into_iter().chain(refused).chain(blank).collect();
    }
    // Columns of their own show what the others leave.
    let kept = || RUNS.iter().filter(|run| run.keeps_edges()).map(|run| run.name);
    let largest = |figure: &str| {
        let figures = kept().filter_map(|run| recorded[run][figure].as_f64());
        figures.fold(None, |most: Option<f64>, figure| Some(most.map_or(figure, |most| most.max(figure))))
    };
    let seam = |run: &str| codes(recorded[run]["seam_max"].as_f64());
    let residual = largest("residual_below");
    let solved = |text: String| if residual.is_some() { text } else { String::new() };
    let figures = [
        recorded["standard"]["levels"].to_string(),
        residual.map_or_else(String::new, |power| format!("< 1e{power}")),
        codes(largest("seam_max")),
        seam("local"),
        seam("clamp"),
        solved(codes(largest("change_max"))),
        solved(codes(recorded["library"]["from_global_codes"].as_f64())),
        time.to_owned(),
    ];
    head.into_iter().chain(figures).collect()
}

fn codes(figure: Option<f64>) -> String {
    figure.map_or_else(|| "?".to_owned(), |figure| format!("{figure:.1}"))
}
