//! Which required extensions are understood; any other is refused by name.

use super::super::json::At;
use super::super::text::quoted;
use crate::asset::TEXTURE_EXTENSION;
use crate::error::{Error, ErrorCode, Result};

const UNDERSTOOD: [&str; 10] = [
    "KHR_texture_transform",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    "FB_ngon_encoding",
    TEXTURE_EXTENSION,
    "MCT_mesh_colors",
];

/// Extensions that only add to a material pass through unchanged.
const UNDERSTOOD_PREFIX: &str = "KHR_materials_";

pub(super) fn check_required(root: &At) -> Result<()> {
    for (index, value) in root.list("extensionsRequired")?.iter().enumerate() {
        let pointer = format!("/extensionsRequired/{index}");
        let Some(name) = value.as_str() else {
            return Err(Error::invalid("must be a string").at(pointer));
        };
        if !UNDERSTOOD.contains(&name) && !name.starts_with(UNDERSTOOD_PREFIX) {
            let detail = format!(
                "the asset requires the extension {}, which is not understood; understood are {} and \
                 {UNDERSTOOD_PREFIX}*: export without it",
                quoted(name),
                UNDERSTOOD.join(", ")
            );
            return Err(Error::new(ErrorCode::UnsupportedExtension, detail).at(pointer));
        }
    }
    Ok(())
}
