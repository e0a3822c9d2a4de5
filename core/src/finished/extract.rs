//! Reads a conversion back from its own file: level images by the texture's extension, coordinates from
//! the vertex attributes, cuts from the primitives' extension. What the file says is checked before it
//! is believed; the images themselves were decoded by `read`.

mod coordinates;
mod cuts;
mod parts;
mod ranges;
mod table;
mod textures;

use std::collections::BTreeMap;

use crate::asset::{Asset, Slot};
use crate::error::{Error, Result};

use parts::PartOf;

use super::{Coordinates, Finished, FinishedPrimitive, FinishedTexture, Frame};

/// The glTF extension that a converted file uses (never requires).
pub use crate::asset::TEXTURE_EXTENSION as EXTENSION;
/// Vertex attribute of indexed coordinates: number of the block, and its class.
pub const BLOCK_ATTRIBUTE: &str = "_MCT_BLOCK";
/// Vertex attribute of indexed coordinates: place in the block, in faces.
pub const LOCAL_ATTRIBUTE: &str = "_MCT_LOCAL";
/// Vertex attribute with `u_s`.
pub const SCALED_ATTRIBUTE: &str = "_MCT_SCALED";
/// Vertex attribute with `u_δ`.
pub const OFFSET_ATTRIBUTE: &str = "_MCT_OFFSET";

/// The conversion that a file holds, or `None` where it holds none. glTF materials that are parts of one have its
/// number, and primitives are the file's. Cuts that are all zero, and
/// primitives without faces, are not in the file and so not in the answer.
///
/// # Errors
/// `InvalidModel` with the place and the rule where the file contradicts itself: levels that are no
/// images, sizes that differ among the textures of one material's part, materials that cannot be parts of one, ranges that do not fit their images, attributes that
/// are missing or of another type, an offset or block that varies over a triangle, what
/// [`Finished::check`] refuses, cuts that are not one byte for each triangle.
pub fn extract(asset: &Asset) -> Result<Option<Finished>> {
    let places = parts::of(asset)?;
    let textures = textures::of(asset, &places)?;
    if textures.is_empty() {
        return Ok(None);
    }
    let mut primitives = Vec::new();
    let mut known = BTreeMap::new();
    for (mesh, source) in asset.meshes.iter().enumerate() {
        for (primitive, source) in source.primitives.iter().enumerate() {
            let part_of = source.material.filter(|_| !source.faces.is_empty());
            let Some(&part_of) = part_of.and_then(|number| places.get(number)) else { continue };
            let PartOf { material, part } = part_of;
            let own = |texture: &&FinishedTexture| texture.is_of(material, part);
            let mut textures_here = textures.iter().filter(own).peekable();
            if textures_here.peek().is_none() {
                continue;
            }
            let has_normal_map = textures_here.any(|texture| texture.slots.contains(&Slot::Normal));
            let place = Place { asset, mesh, primitive };
            let (coordinates, triangles) = coordinates::of(&place)?;
            let coordinates = shared(&mut known, part_of, coordinates);
            primitives.push(FinishedPrimitive {
                mesh,
                primitive,
                material,
                part,
                coordinates,
                frames: if has_normal_map { coordinates::frames(&place, &triangles)? } else { Vec::new() },
                cuts: cuts::of(&place, part_of, &textures, triangles.len())?,
                triangles,
            });
        }
    }
    let finished = Finished { textures, primitives, ..Finished::default() };
    finished.check()?;
    Ok(Some(finished))
}

/// The table of a material's part, held once where its primitives have the same.
fn shared(
    known: &mut BTreeMap<PartOf, Coordinates>,
    part_of: PartOf,
    coordinates: Coordinates,
) -> Coordinates {
    let first = known.entry(part_of).or_insert_with(|| coordinates.clone());
    if *first == coordinates { first.clone() } else { coordinates }
}

/// A primitive of a converted file.
struct Place<'a> {
    asset: &'a Asset,
    mesh: usize,
    primitive: usize,
}

impl<'a> Place<'a> {
    fn source(&self) -> &'a crate::asset::Primitive {
        &self.asset.meshes[self.mesh].primitives[self.primitive]
    }

    fn json(&self) -> Option<&'a serde_json::Value> {
        self.asset.document.json.get("meshes")?.get(self.mesh)?.get("primitives")?.get(self.primitive)
    }

    /// An error about this primitive; `below` continues its JSON pointer.
    fn lie(&self, below: &str, rule: impl Into<String>) -> Error {
        Error::invalid(rule).at(format!("/meshes/{}/primitives/{}{below}", self.mesh, self.primitive))
    }
}

/// The frame of each corner, as it stands at a vertex of the file.
fn frame(source: &crate::asset::Primitive, vertex: u32) -> Option<Frame> {
    let vertex = vertex as usize;
    Some(Frame { normal: *source.normals.get(vertex)?, tangent: *source.tangents.get(vertex)? })
}
