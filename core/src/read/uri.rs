//! Where a URI or a file name of a model points: at a file inside the upload, or nowhere.
//!
//! A path is decoded once and then must be plain: relative, forward slashes, no `..` component, no
//! scheme, no drive letter, no NUL. Nothing here opens anything.

use super::text::quoted;
use crate::error::{Error, ErrorCode, Result};

/// The path inside the upload that a glTF URI names, relative to `folder` (empty, or a path that ends
/// in `/`). `data:` URIs are not paths: see [`super::data_uri`].
pub(super) fn resolve(uri: &str, folder: &str, pointer: &str) -> Result<String> {
    let decoded = percent_decode(uri.as_bytes());
    let Ok(path) = String::from_utf8(decoded) else {
        return Err(refuse(uri, ErrorCode::UnsafeUri, "is not UTF-8 after percent-decoding", pointer));
    };
    check(&path, uri, pointer)?;
    // Decoded a second time, by whoever reads the result, it must not turn into a way out either.
    if let Ok(again) = String::from_utf8(percent_decode(path.as_bytes()))
        && again != path
        && check(&again, uri, pointer).is_err()
    {
        return Err(refuse(
            uri,
            ErrorCode::UnsafeUri,
            "is percent-encoded twice and hides a way out",
            pointer,
        ));
    }
    join(&path, folder, uri, pointer)
}

/// The paths that a file name of an OBJ or MTL file may mean: the name as it stands, then, where that is
/// something else, percent-decoded. Both are checked.
pub(super) fn resolve_name(name: &[u8], folder: &str, pointer: &str) -> Result<Vec<String>> {
    let Ok(name) = str::from_utf8(name) else {
        let shown = String::from_utf8_lossy(name);
        return Err(refuse(&shown, ErrorCode::UnsafeUri, "is not UTF-8", pointer));
    };
    check(name, name, pointer)?;
    let mut paths = vec![join(name, folder, name, pointer)?];
    let decoded = resolve(name, folder, pointer)?;
    if paths[0] != decoded {
        paths.push(decoded);
    }
    Ok(paths)
}

/// Whether a name inside an archive may be used as a path of the upload.
pub(super) fn check_entry_name(name: &str) -> Result<String> {
    check(name, name, name)?;
    join(name, "", name, name)
}

fn refuse(uri: &str, code: ErrorCode, rule: &str, pointer: &str) -> Error {
    let detail = format!(
        "{} {rule}; name a file of the upload by its relative path with forward slashes",
        quoted(uri)
    );
    Error::new(code, detail).at(pointer)
}

fn check(path: &str, uri: &str, pointer: &str) -> Result<()> {
    let refused = |rule: &str| Err(refuse(uri, ErrorCode::UnsafeUri, rule, pointer));
    if path.contains('\0') {
        return refused("holds a NUL character");
    }
    if path.contains('\\') {
        return refused("holds a backslash");
    }
    if path.starts_with('/') {
        return refused("is an absolute path");
    }
    if let Some(scheme) = scheme(path) {
        let scheme_lower = scheme.to_ascii_lowercase();
        if scheme.len() == 1 {
            return refused("begins with a drive letter");
        }
        let network = path[scheme.len() + 1..].starts_with("//") && scheme_lower != "file";
        if network || NETWORK_SCHEMES.contains(&scheme_lower.as_str()) {
            let rule =
                format!("points at the network (scheme {}), where nothing is fetched from", quoted(scheme));
            return Err(refuse(uri, ErrorCode::ExternalUri, &rule, pointer));
        }
        return refused(&format!("has the scheme {}", quoted(scheme)));
    }
    if path.split('/').any(|component| component == "..") {
        return refused("leaves its folder by a `..` component");
    }
    Ok(())
}

/// Schemes that mean the network even without `//`.
const NETWORK_SCHEMES: [&str; 6] = ["http", "https", "ftp", "ftps", "gopher", "ws"];

/// What stands before a colon, where it has the form of a scheme (RFC 3986, section 3.1).
fn scheme(path: &str) -> Option<&str> {
    let (head, _) = path.split_once(':')?;
    let mut chars = head.chars();
    let first = chars.next()?;
    let rest = chars.all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'));
    (first.is_ascii_alphabetic() && rest).then_some(head)
}

/// Appends a checked path to its folder, without the `.` and empty components.
fn join(path: &str, folder: &str, uri: &str, pointer: &str) -> Result<String> {
    let mut joined = folder.to_owned();
    let folder_length = joined.len();
    for component in path.split('/').filter(|c| !c.is_empty() && *c != ".") {
        if joined.len() > folder_length {
            joined.push('/');
        }
        joined.push_str(component);
    }
    if joined.len() == folder_length {
        return Err(refuse(uri, ErrorCode::InvalidModel, "names no file", pointer));
    }
    Ok(joined)
}

/// `%41` to `A`, once. A percent sign without two hexadecimal digits stands for itself, as in the many
/// files whose names were never encoded.
pub(super) fn percent_decode(bytes: &[u8]) -> Vec<u8> {
    let hex = |at: usize| bytes.get(at).and_then(|&b| char::from(b).to_digit(16));
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], hex(at + 1), hex(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((high * 16 + low) as u8);
                at += 3;
            }
            (byte, _, _) => {
                decoded.push(byte);
                at += 1;
            }
        }
    }
    decoded
}

/// The folder of a path: empty, or ending in `/`.
pub(super) fn folder_of(path: &str) -> &str {
    path.rfind('/').map_or("", |at| &path[..=at])
}
