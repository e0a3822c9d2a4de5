//! Reads a conversion back from its own file: level images by the texture's extension, coordinates from
//! the vertex attributes, cuts from the primitives' extension. What the file says is checked before it
//! is believed; the images themselves were decoded by `read`.

mod coordinates;
mod cuts;
mod ranges;
mod table;
mod textures;

use std::collections::BTreeMap;

use crate::asset::{Asset, Slot};
use crate::error::{Error, Result};

use super::{Coordinates, Finished, FinishedPrimitive, FinishedTexture, Frame};

/// The glTF extension that a converted file uses (never requires).
pub const EXTENSION: &str = "MCT_mesh_color_texture";
/// Vertex attribute of indexed coordinates: number of the block, and its class.
pub const BLOCK_ATTRIBUTE: &str = "_MCT_BLOCK";
/// Vertex attribute of indexed coordinates: place in the block, in faces.
pub const LOCAL_ATTRIBUTE: &str = "_MCT_LOCAL";
/// Vertex attribute with `u_s`.
pub const SCALED_ATTRIBUTE: &str = "_MCT_SCALED";
/// Vertex attribute with `u_δ`.
pub const OFFSET_ATTRIBUTE: &str = "_MCT_OFFSET";

/// The conversion that a file holds, or `None` where it holds none. Cuts that are all zero, and
/// primitives without faces, are not in the file and so not in the answer.
///
/// # Errors
/// `InvalidModel` with the place and the rule where the file contradicts itself: levels that are no
/// images, sizes that differ among one material's textures, ranges that do not fit their images, attributes that
/// are missing or of another type, an offset or block that varies over a triangle, what
/// [`Finished::check_coordinates`] refuses, cuts that are not one byte for each triangle.
pub fn extract(asset: &Asset) -> Result<Option<Finished>> {
    let textures = textures::of(asset)?;
    if textures.is_empty() {
        return Ok(None);
    }
    let mut primitives = Vec::new();
    let mut known = BTreeMap::new();
    for (mesh, source) in asset.meshes.iter().enumerate() {
        for (primitive, source) in source.primitives.iter().enumerate() {
            let Some(material) = source.material.filter(|_| !source.faces.is_empty()) else { continue };
            let own = |texture: &&FinishedTexture| texture.is_of(material, 0);
            let mut textures_here = textures.iter().filter(own).peekable();
            if textures_here.peek().is_none() {
                continue;
            }
            let has_normal_map = textures_here.any(|texture| texture.slots.contains(&Slot::Normal));
            let place = Place { asset, mesh, primitive };
            let (coordinates, triangles) = coordinates::of(&place)?;
            let coordinates = shared(&mut known, material, coordinates);
            primitives.push(FinishedPrimitive {
                mesh,
                primitive,
                material,
                part: 0,
                coordinates,
                frames: if has_normal_map { coordinates::frames(&place, &triangles)? } else { Vec::new() },
                cuts: cuts::of(&place, material, &textures, triangles.len())?,
                triangles,
            });
        }
    }
    let finished = Finished { textures, primitives };
    finished.check_coordinates()?;
    Ok(Some(finished))
}

/// The material's table, held once where its primitives have the same.
fn shared(
    known: &mut BTreeMap<usize, Coordinates>,
    material: usize,
    coordinates: Coordinates,
) -> Coordinates {
    let first = known.entry(material).or_insert_with(|| coordinates.clone());
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
