//! What kind of file it is, by its first bytes; names say nothing.

use super::{glb, ptex};
use crate::error::{Error, ErrorCode, Result};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Container {
    Glb,
    GltfJson,
    Obj,
    Ply,
    Zip,
}

/// Bytes that are looked at to tell a text file from anything else.
const LOOKED_AT: usize = 64 << 10;

/// Statements that an OBJ file may begin with.
const OBJ_STATEMENTS: [&[u8]; 13] =
    [b"v", b"vt", b"vn", b"vp", b"f", b"o", b"g", b"s", b"l", b"p", b"usemtl", b"mtllib", b"call"];

pub(super) fn detect(bytes: &[u8]) -> Result<Container> {
    if bytes.starts_with(glb::MAGIC) {
        return Ok(Container::Glb);
    }
    // Local file header, or the end record that an empty archive consists of.
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        return Ok(Container::Zip);
    }
    if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        return Ok(Container::Ply);
    }
    let text = without_bom(bytes);
    if text.trim_ascii_start().first() == Some(&b'{') {
        return Ok(Container::GltfJson);
    }
    if looks_like_obj(&text[..text.len().min(LOOKED_AT)]) {
        return Ok(Container::Obj);
    }
    if ptex::is_ptex(bytes) {
        let detail =
            "the file is a Ptex texture; convert the OBJ file of its mesh, with the texture beside it";
        return Err(Error::new(ErrorCode::UnsupportedMediaType, detail));
    }
    let head: Vec<String> = bytes.iter().take(8).map(|b| format!("{b:02x}")).collect();
    let detail = format!(
        "the file is none of glTF (.glb, .gltf), OBJ, PLY or zip by its first bytes ({})",
        if head.is_empty() { "it is empty".to_owned() } else { head.join(" ") }
    );
    Err(Error::new(ErrorCode::UnsupportedMediaType, detail))
}

/// The text without a byte order mark.
pub(super) fn without_bom(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// No NUL, and the first line that is neither empty nor a comment is an OBJ statement. A file whose head
/// is all comments is taken for one: the parser will say what is wrong with it.
fn looks_like_obj(head: &[u8]) -> bool {
    if head.contains(&0) || head.is_empty() {
        return false;
    }
    let mut lines = head.split(|&b| b == b'\n' || b == b'\r').map(<[u8]>::trim_ascii);
    match lines.find(|line| !line.is_empty() && line[0] != b'#') {
        Some(line) => {
            let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            OBJ_STATEMENTS.contains(&word)
        }
        None => head.trim_ascii_start().first() == Some(&b'#'),
    }
}
