//! Texture coordinates beside the file's own, which materials may read.

use glam::Vec2;

/// Sets of coordinates, each for all corners of a [`Soup`](super::Soup).
#[derive(Debug, Default)]
pub struct Coordinates {
    pub sets: Vec<Vec<Vec2>>,
    /// By material, which sets it reads, and whether the file's own. Of one that is not here: the file's own.
    pub materials: Vec<(Vec<usize>, bool)>,
}

/// The sets that a material's vertices have.
pub struct OfMaterial<'a> {
    /// The file's own, as the first set.
    pub keeps_own: bool,
    /// Those behind it.
    pub sets: Vec<&'a [Vec2]>,
}

impl Coordinates {
    pub fn of_material(&self, material: Option<usize>) -> OfMaterial<'_> {
        match material.and_then(|material| self.materials.get(material)) {
            Some((sets, keeps_own)) if !sets.is_empty() => OfMaterial {
                keeps_own: *keeps_own,
                sets: sets.iter().map(|&set| self.sets[set].as_slice()).collect(),
            },
            _ => OfMaterial { keeps_own: true, sets: Vec::new() },
        }
    }
}
