//! Which triangles meet at edges, over all parts of a surface, and which of them lie near a point.

use glam::DVec3;

use super::points::SurfacePoint;
use super::surface::Surface;
use crate::math::partition::Partition;

/// The other triangle at an edge.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    pub triangle: u32,
    /// Index into the surface's pairs.
    pub pair: u32,
}

/// Triangles numbered through all parts, with their neighbors. An edge of several triangles joins each of
/// the others with the first, as the surface's pairs do.
pub struct Graph {
    /// The number of each part's first triangle.
    firsts: Vec<u32>,
    /// By triangle, where its links begin; and the end.
    starts: Vec<u32>,
    links: Vec<Link>,
    /// Mesh space.
    pub corners: Vec<[DVec3; 3]>,
}

impl Graph {
    pub fn new(surface: &Surface<'_>) -> Self {
        let mut firsts = Vec::with_capacity(surface.parts.len());
        let mut corners = Vec::with_capacity(surface.triangle_count());
        for part in &surface.parts {
            firsts.push(corners.len() as u32);
            corners.extend((0..part.triangles.len()).map(|t| part.corners(t).map(|p| p.as_dvec3())));
        }
        let ends = |pair: &super::edges::EdgePair| {
            [pair.a, pair.b].map(|side| firsts[side.part as usize] + side.triangle)
        };
        let mut starts = vec![0u32; corners.len() + 1];
        for triangle in surface.pairs.iter().flat_map(ends) {
            starts[triangle as usize + 1] += 1;
        }
        for triangle in 1..starts.len() {
            starts[triangle] += starts[triangle - 1];
        }
        let mut next = starts.clone();
        let mut links = vec![Link { triangle: 0, pair: 0 }; surface.pairs.len() * 2];
        for (number, pair) in surface.pairs.iter().enumerate() {
            let [a, b] = ends(pair);
            for (from, to) in [(a, b), (b, a)] {
                links[next[from as usize] as usize] = Link { triangle: to, pair: number as u32 };
                next[from as usize] += 1;
            }
        }
        Self { firsts, starts, links, corners }
    }

    pub fn links(&self, triangle: u32) -> &[Link] {
        let triangle = triangle as usize;
        &self.links[self.starts[triangle] as usize..self.starts[triangle + 1] as usize]
    }

    pub fn number(&self, point: &SurfacePoint) -> u32 {
        self.firsts[point.part as usize] + point.triangle
    }

    /// A triangle's part, and its number there.
    pub fn place(&self, triangle: u32) -> (usize, usize) {
        let part = self.firsts.partition_point(|&first| first <= triangle) - 1;
        (part, (triangle - self.firsts[part]) as usize)
    }

    /// Where a point stands, mesh space.
    pub fn position(&self, point: &SurfacePoint) -> DVec3 {
        let [a, b, c] = self.corners[self.number(point) as usize];
        let at = point.at.as_dvec3();
        a * at.x + b * at.y + c * at.z
    }

    /// Twice the area, along the normal.
    pub fn cross(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners[triangle as usize];
        (b - a).cross(c - a)
    }

    /// By triangle, a number that all have in common that pairs join, those named by `cut_flags` left out.
    pub fn components(&self, cut_flags: &[bool]) -> Vec<u32> {
        let mut partition = Partition::new(self.corners.len());
        for triangle in 0..self.corners.len() as u32 {
            for link in self.links(triangle).iter().filter(|link| !cut_flags[link.pair as usize]) {
                partition.join(triangle, link.triangle);
            }
        }
        (0..self.corners.len() as u32).map(|triangle| partition.root(triangle)).collect()
    }

    /// The triangles within `radius` of a point of `first`, as far as a chain of such triangles reaches
    /// them that face its side (or have no area); `first` comes first. `None` when they are more than
    /// `limit`. `marks` holds a 0 for each triangle, before and after.
    pub fn near(
        &self,
        first: u32,
        center: DVec3,
        radius: f64,
        limit: usize,
        marks: &mut [u32],
    ) -> Option<Vec<u32>> {
        let normal = self.cross(first);
        let mut near = vec![first];
        let mut seen = vec![first];
        marks[first as usize] = 1;
        let mut at = 0;
        while at < near.len() && near.len() <= limit {
            for link in self.links(near[at]) {
                let other = link.triangle;
                if std::mem::replace(&mut marks[other as usize], 1) == 1 {
                    continue;
                }
                seen.push(other);
                let cross = self.cross(other);
                let faces = cross.dot(normal) > 0.0 || cross == DVec3::ZERO;
                if faces && distance_squared(self.corners[other as usize], center) <= radius * radius {
                    near.push(other);
                }
            }
            at += 1;
        }
        seen.iter().for_each(|&triangle| marks[triangle as usize] = 0);
        (near.len() <= limit).then_some(near)
    }

    /// Of `near` (as [`Graph::near`] gives them), those that can be reached from the first without
    /// crossing a pair that `cut_flags` names. `marks` as there.
    pub fn joined(&self, near: &[u32], cut_flags: &[bool], marks: &mut [u32]) -> Vec<bool> {
        near.iter().enumerate().for_each(|(local, &triangle)| marks[triangle as usize] = local as u32 + 1);
        let mut is_joined = vec![false; near.len()];
        is_joined[0] = true;
        let mut open = vec![near[0]];
        while let Some(triangle) = open.pop() {
            for link in self.links(triangle).iter().filter(|link| !cut_flags[link.pair as usize]) {
                let local = marks[link.triangle as usize];
                if local > 0 && !std::mem::replace(&mut is_joined[local as usize - 1], true) {
                    open.push(link.triangle);
                }
            }
        }
        near.iter().for_each(|&triangle| marks[triangle as usize] = 0);
        is_joined
    }
}

/// From a point to the nearest of a triangle, by the regions of its plane (Ericson, "Real-Time Collision
/// Detection", 2005, section 5.1.5).
fn distance_squared([a, b, c]: [DVec3; 3], point: DVec3) -> f64 {
    let normal = (b - a).cross(c - a);
    let sides = [(a, b), (b, c), (c, a)];
    let is_inside = sides.iter().all(|(from, to)| normal.cross(*to - *from).dot(point - *from) >= 0.0);
    let area_squared = normal.length_squared();
    if is_inside && area_squared > 0.0 {
        return normal.dot(point - a).powi(2) / area_squared;
    }
    let to_side = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let share = along.dot(point - from) / along.length_squared();
        // A side of no length is its end: a share that is no number is not above 0.
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        (point - from - along * share).length_squared()
    };
    sides.into_iter().map(to_side).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_inside_sides_and_corners() {
        let triangle = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        let squared = |x, y, z| distance_squared(triangle, DVec3::new(x, y, z));
        assert_eq!((squared(1.0, 1.0, 3.0), squared(2.0, -2.0, 0.0)), (9.0, 4.0));
        assert_eq!((squared(-3.0, -4.0, 0.0), squared(4.0, 4.0, 0.0)), (25.0, 8.0));
        assert_eq!(distance_squared([DVec3::ONE; 3], DVec3::ZERO), 3.0);
        let needle = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        assert_eq!(distance_squared(needle, DVec3::new(1.5, 2.0, 0.0)), 4.0);
    }
}
