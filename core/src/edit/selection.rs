//! Which faces an edit is about.

use crate::error::{Error, ErrorCode, Result};

use super::painting::Painting;

/// Faces of painted materials, all by default.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Index into the model's materials. Needed where faces are named and several materials are painted.
    pub material: Option<usize>,
    /// First and last of ranges of this material's faces, as docs/mesh_colors.md numbers them, two partners being one.
    pub faces: Option<Vec<[u32; 2]>>,
}

impl Selection {
    /// By painting and face.
    ///
    /// # Errors
    /// `InvalidOptions` where the selection names what is not there, or does not say of which material.
    pub fn of(&self, paintings: &[Painting]) -> Result<Vec<Vec<bool>>> {
        let refuse = |detail: String| Err(Error::new(ErrorCode::InvalidOptions, detail));
        let numbers =
            paintings.iter().map(|painting| painting.material.to_string()).collect::<Vec<_>>().join(", ");
        if let Some(material) = self.material
            && paintings.iter().all(|painting| painting.material != material)
        {
            return refuse(format!("material {material} has no mesh colors; materials that have: {numbers}"));
        }
        if self.faces.is_some() && self.material.is_none() && paintings.len() > 1 {
            return refuse(format!(
                "faces are numbered by material; say which one with `material`: {numbers}"
            ));
        }
        let mut selected = Vec::with_capacity(paintings.len());
        for painting in paintings {
            let count = painting.canvas.faces.len();
            let is_meant = self.material.is_none_or(|material| material == painting.material);
            let mut own = vec![is_meant && self.faces.is_none(); count];
            for &[first, last] in self.faces.iter().flatten().filter(|_| is_meant) {
                let Some(range) = own.get_mut(first as usize..=last as usize) else {
                    return refuse(format!(
                        "there are no faces {first} to {last}; those of material {} are numbered 0 to {}",
                        painting.material,
                        count.saturating_sub(1)
                    ));
                };
                range.fill(true);
            }
            selected.push(own);
        }
        Ok(selected)
    }
}
