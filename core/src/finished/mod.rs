//! What a conversion ends in: level images and coordinates. `write` stores it, `measure` judges it,
//! a preview draws it; reading a converted file gives it back. Nothing here remembers how it was made.

mod check;
mod coordinates;
mod extract;
#[cfg(test)]
pub mod hand_made;
mod sets;

pub use coordinates::{Anchor, BlockClass, BlockTable, Coordinates, LevelMap, TableLevel};
pub use extract::{BLOCK_ATTRIBUTE, EXTENSION, LOCAL_ATTRIBUTE, OFFSET_ATTRIBUTE, SCALED_ATTRIBUTE, extract};

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec2;

use crate::asset::{Face, Primitive, Slot};
use crate::image::{Image, LevelRange, Transfer};

pub use crate::math::frame::Frame;

/// All converted materials of one asset, and the coordinates of every primitive that uses them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finished {
    pub textures: Vec<FinishedTexture>,
    /// In order of mesh, primitive and part; primitives of unconverted materials are left out.
    pub primitives: Vec<FinishedPrimitive>,
    /// Materials whose base color holds the vertex colors of their primitives (`COLOR_0`) too; these do not have them any more.
    pub vertex_colors: BTreeSet<usize>,
}

/// One channel at every level.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishedTexture {
    /// The materials that show it, as indices into `Asset::materials`: ascending, at least one. Several where
    /// materials share their textures.
    pub materials: Vec<usize>,
    /// Which of their parts: faces of one material may stand in several sets of textures, each with sizes of its own.
    /// 0 where there is one.
    pub part: usize,
    /// The glTF slots that read this channel (several where the source's slots share one image).
    pub slots: Vec<Slot>,
    pub transfer: Transfer,
    /// Level 0 first. All textures of one material and part have the same sizes, level by level.
    pub levels: Vec<Image>,
    /// Levels that hold other values than codes of [0, 1]: images of 16 bits; level 0 of attributes alone.
    pub ranges: BTreeMap<usize, LevelRange>,
    /// Of attributes that hold numbers of any size: what a value of 1 stands for, above 0. Every level has a range then.
    pub value_scale: Option<f32>,
}

impl FinishedTexture {
    /// Whether the stored values are tangent-space normals.
    pub fn is_normal(&self) -> bool {
        self.slots.contains(&Slot::Normal)
    }

    /// Whether faces of a material that stand in one of its parts show this texture.
    pub fn is_of(&self, material: usize, part: usize) -> bool {
        self.part == part && self.materials.contains(&material)
    }
}

/// The drawn triangles of one primitive that stand in one part of its material, in the asset's order. A quad is the
/// two triangles of its fan, in a row.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishedPrimitive {
    pub mesh: usize,
    pub primitive: usize,
    pub material: usize,
    /// The part of the material whose textures these triangles read.
    pub part: usize,
    /// How `triangles` name texels.
    pub coordinates: Coordinates,
    pub triangles: Vec<FinishedTriangle>,
    /// The frame of each corner of each triangle, as a viewer interpolates it; where the material has a
    /// normal map (empty otherwise).
    pub frames: Vec<[Frame; 3]>,
    pub cuts: Vec<PrimitiveCuts>,
}

/// A drawn triangle and where it stands in the level images, see [`Coordinates`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinishedTriangle {
    /// Vertices of the asset's primitive.
    pub vertices: [u32; 3],
    /// By corner: of 4D coordinates `u_s`, texels of level 0; of indexed ones the place in the block, counted in
    /// faces.
    pub corners: [Vec2; 3],
    pub anchor: Anchor,
}

/// The faces that drawn triangles come from, each given by its vertices. `None` where they are not some of those that the
/// primitive's faces are drawn as, in their order.
pub fn faces_of(primitive: &Primitive, triangles: impl Iterator<Item = [u32; 3]>) -> Option<Vec<u32>> {
    let sorted = |mut triangle: [u32; 3]| {
        triangle.sort_unstable();
        triangle
    };
    let of_face = |(number, face): (usize, &Face)| {
        let corners = face.corners;
        face.triangles().iter().map(move |drawn| (number as u32, sorted(drawn.map(|k| corners[k]))))
    };
    let mut drawn = primitive.faces.iter().enumerate().flat_map(of_face);
    // Triangles of one part are in the asset's order: none before the last one found is looked at again.
    triangles
        .map(|triangle| {
            let wanted = sorted(triangle);
            drawn.find(|(_, own)| *own == wanted).map(|(number, _)| number)
        })
        .collect()
}

/// Which edges of a primitive one texture does not join.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrimitiveCuts {
    /// Index into `Finished::textures`.
    pub texture: usize,
    /// One value for each triangle: bit k set where the edge from corner k to k + 1 is a cut.
    pub bits: Vec<u8>,
}
