//! The repository's own files, for the tests that hold documents against code.

use std::path::{Path, PathBuf};

/// The folder of the workspace.
pub fn root() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().unwrap_or(tests).to_owned()
}

/// A file's text, by its path from the root.
///
/// # Panics
/// Where it is missing.
pub fn file(path: &str) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The rows of the first Markdown table whose first heading is `heading`, by cell; empty without one.
pub fn table(markdown: &str, heading: &str) -> Vec<Vec<String>> {
    let start = format!("| {heading} |");
    let lines = markdown.lines().skip_while(|line| !line.starts_with(&start));
    let rows = lines.take_while(|line| line.starts_with('|')).skip(2);
    rows.map(|row| {
        let cells = row.trim().trim_matches('|').replace("\\|", "\u{0}");
        cells.split('|').map(|cell| cell.replace('\u{0}', "|").trim().to_owned()).collect()
    })
    .collect()
}

/// What stands between backticks, in order.
pub fn backticked(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}
