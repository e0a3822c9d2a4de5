//! The repository's own files, for the tests that hold documents against code.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

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

/// Whether the tests write what they would compare: after a change that is meant to move figures.
pub fn writes_documents() -> bool {
    std::env::var_os("MESHCOLOR_WRITE_DOCS").is_some_and(|value| value == "1")
}

/// Tests of one process may write one document.
static WRITING: Mutex<()> = Mutex::new(());

/// Holds the part of a document between `<!-- mark -->` and `<!-- end mark -->` against what belongs there.
///
/// # Panics
/// Where they differ, with the first line that does.
pub fn hold(document: &str, mark: &str, text: &str) {
    let _one_at_a_time = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let all = file(document);
    let [start, end] = [format!("<!-- {mark} -->\n"), format!("<!-- end {mark} -->")];
    let parts = all.split_once(&start).and_then(|(head, rest)| Some((head, rest.split_once(&end)?)));
    let (head, (shown, tail)) = parts.unwrap_or_else(|| panic!("{document} has no marks for {mark}"));
    if writes_documents() {
        let written = format!("{head}{start}\n{}\n\n{end}{tail}", text.trim());
        std::fs::write(root().join(document), written).unwrap_or_else(|error| panic!("{document}: {error}"));
        return;
    }
    let (shown, text) = (shown.trim(), text.trim());
    let differs = shown.lines().zip(text.lines()).find(|(shown, now)| shown != now);
    assert!(
        shown == text,
        "{document} is stale at {mark}, first where (there, now) are {differs:#?}; after a look at why, \
         MESHCOLOR_WRITE_DOCS=1 writes it anew"
    );
}

/// A Markdown table.
pub fn markdown(heading: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let rule = "|---".repeat(heading.len());
    let rows: String = rows.map(|cells| format!("| {} |\n", cells.join(" | "))).collect();
    format!("| {} |\n{rule}|\n{rows}", heading.join(" | "))
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
