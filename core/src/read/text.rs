//! Words of a file, shown to a person: cut short and with control characters escaped, so that a hostile
//! name can neither flood a log nor forge a line of it.

/// Characters of a name that an error message shows.
const SHOWN_CHARS: usize = 120;

/// A name in quotes, escaped and cut.
pub(super) fn quoted(name: &str) -> String {
    let mut chars = name.chars();
    let head: String = chars.by_ref().take(SHOWN_CHARS).collect();
    let more = if chars.next().is_some() { "…" } else { "" };
    format!("\"{}{more}\"", head.escape_debug())
}

/// Bytes of a text file as a name; what is not UTF-8 shows as a replacement character.
pub(super) fn quoted_bytes(name: &[u8]) -> String {
    // A character has at most four bytes, so this much is enough to fill the line.
    quoted(&String::from_utf8_lossy(&name[..name.len().min(4 * SHOWN_CHARS + 4)]))
}

/// The last part of a path, fit for `file:line`.
pub(super) fn file_label(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.chars().take(SHOWN_CHARS).flat_map(char::escape_debug).collect()
}
