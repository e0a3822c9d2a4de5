//! Every face into one quad for each of its corners: the corner, the middles of its two edges, the middle of the face. So a mesh
//! with faces of other than four corners gets the faces that a Ptex file for quads has for them.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};

use super::super::Context;
use super::super::made_up::{Corner, NONE, Polygon, Soup};
use crate::error::{Error, ErrorCode, Result};

/// Which face, and which of its corners, a face was made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Origin {
    pub polygon: usize,
    pub corner: usize,
}

/// Splits all faces; the new ones of a face follow each other in the order of its corners.
///
/// # Errors
/// `TooManyTriangles` and `ModelTooLarge` where the new mesh is over a limit.
pub(super) fn split(soup: &mut Soup, context: &mut Context) -> Result<Vec<Origin>> {
    let polygons = std::mem::take(&mut soup.polygons);
    let old = std::mem::take(&mut soup.corners);
    check(soup, &polygons, context)?;
    let mut origins = Vec::with_capacity(old.len());
    soup.corners.reserve(4 * old.len());
    let mut middles = HashMap::new();
    for (number, polygon) in polygons.into_iter().enumerate() {
        let corners = &old[polygon.first..][..polygon.count];
        let center = soup.mean(corners);
        let edges: Vec<Corner> = (0..corners.len()).map(|k| soup.middle(corners, k, &mut middles)).collect();
        for k in 0..corners.len() {
            let before = edges[(k + corners.len() - 1) % corners.len()];
            let first = soup.corners.len();
            soup.corners.extend([corners[k], edges[k], center, before]);
            soup.polygons.push(Polygon { first, count: 4, ..polygon });
            origins.push(Origin { polygon: number, corner: k });
        }
    }
    Ok(origins)
}

/// Counts what there will be before it is made.
fn check(soup: &Soup, polygons: &[Polygon], context: &mut Context) -> Result<()> {
    let corner_count: usize = polygons.iter().map(|polygon| polygon.count).sum();
    // A face of n corners was n - 2 triangles and becomes 2 n.
    context.budget.take_triangles((corner_count + 2 * polygons.len()) as u64, &soup.file)?;
    let limit = context.budget.limits.vertices.min(u64::from(NONE) - 1);
    let lists = [soup.positions.len(), soup.texcoords.len(), soup.normals.len()];
    let most = (lists.into_iter().max().unwrap_or(0) + corner_count + polygons.len()) as u64;
    if most <= limit {
        return Ok(());
    }
    let detail = format!(
        "the mesh has faces of other than four corners, which its Ptex file needs split, and up to {most} vertices then; the limit \
         is {limit} (limit `vertices`)"
    );
    Err(Error::new(ErrorCode::ModelTooLarge, detail).at(&soup.file).limit(limit, most))
}

impl Soup {
    /// A corner in the middle of others, with as much as all of them have.
    fn mean(&mut self, corners: &[Corner]) -> Corner {
        let share = 1.0 / corners.len() as f32;
        let is_colored = self.is_colored();
        let position: Vec3 =
            corners.iter().map(|corner| self.positions[corner.position as usize] * share).sum();
        if is_colored {
            let color: Vec4 =
                corners.iter().map(|corner| self.colors[corner.position as usize] * share).sum();
            self.colors.push(color);
        }
        self.positions.push(position);
        Corner { position: self.positions.len() as u32 - 1, ..self.shading(corners) }
    }

    /// The middle of an edge; at one position for all faces that have it.
    fn middle(&mut self, corners: &[Corner], edge: usize, known: &mut HashMap<[u32; 2], u32>) -> Corner {
        let ends = [corners[edge], corners[(edge + 1) % corners.len()]];
        let [a, b] = ends.map(|corner| corner.position);
        match known.get(&[a.min(b), a.max(b)]) {
            Some(&position) => Corner { position, ..self.shading(&ends) },
            None => {
                let middle = self.mean(&ends);
                known.insert([a.min(b), a.max(b)], middle.position);
                middle
            }
        }
    }

    /// The mean of what corners have besides positions; the position is to be set.
    fn shading(&mut self, corners: &[Corner]) -> Corner {
        let share = 1.0 / corners.len() as f32;
        let (mut texcoord, mut normal) = (NONE, NONE);
        if corners.iter().all(|corner| corner.texcoord != NONE) {
            let mean: Vec2 = corners.iter().map(|c| self.texcoords[c.texcoord as usize] * share).sum();
            texcoord = self.texcoords.len() as u32;
            self.texcoords.push(mean);
        }
        if corners.iter().all(|corner| corner.normal != NONE) {
            let mean: Vec3 = corners.iter().map(|c| self.normals[c.normal as usize] * share).sum();
            normal = self.normals.len() as u32;
            self.normals.push(mean);
        }
        Corner { position: NONE, texcoord, normal }
    }
}
