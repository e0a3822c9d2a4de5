//! What a model with mesh colors shows: its samples as they are filtered, and where the triangles that it draws stand among
//! them.
//!
//! A drawn triangle lies in one face of the canvas, whose unit domain ([`crate::filter`]) is linear over it: its corners' places there,
//! weighted by barycentrics, are the place of any of its points.

mod places;

pub use places::DrawnPlace;

use crate::asset::Slot;
use crate::filter::MeshColors;
use crate::mesh::CanvasMesh;

use places::DrawnPlaces;

/// The mesh colors of one material, ready to be filtered.
pub struct PaintedSource<'a> {
    /// Index into the model's materials.
    pub material: usize,
    channels: Vec<PaintedChannel<'a>>,
    places: DrawnPlaces,
}

/// One channel of these.
pub struct PaintedChannel<'a> {
    /// The slots that it stands for; at least one.
    pub slots: &'a [Slot],
    /// How many components count: 1 gray, 2 gray and alpha, 3 RGB or a normal, 4 RGB and alpha.
    pub components: u8,
    /// Faces are those of the source's canvas. Linear light for color, data as it is, normals in the mesh's space.
    pub colors: MeshColors<'a>,
}

impl<'a> PaintedSource<'a> {
    /// `channels` are on the faces of `canvas`, which are the material's.
    pub fn new(material: usize, canvas: &CanvasMesh, channels: Vec<PaintedChannel<'a>>) -> Self {
        Self { material, channels, places: DrawnPlaces::new(canvas) }
    }

    /// The channel that stands for a slot.
    pub fn channel(&self, slot: Slot) -> Option<&PaintedChannel<'a>> {
        self.channels.iter().find(|channel| channel.slots.contains(&slot))
    }

    /// Where three corners of a face of the model stand; `None` where the face does not show the material. A face is named by its mesh, its
    /// primitive there and its number there; corners count from 0.
    pub fn place(&self, face: [usize; 3], corners: [usize; 3]) -> Option<DrawnPlace> {
        self.places.of(face, corners)
    }
}
