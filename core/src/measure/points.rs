//! Random points of a surface, the same in every run: a counter-based generator, and one point in each of
//! equal shares of the area, triangle after triangle.

use glam::{DVec3, Vec3};

use super::surface::Surface;

/// A point inside a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    pub part: u32,
    pub triangle: u32,
    /// Barycentrics, sum 1.
    pub at: Vec3,
}

/// As many points as asked for, or none where the surface has no area.
pub fn scatter(surface: &Surface<'_>, count: usize) -> Vec<SurfacePoint> {
    let mut ends = Vec::with_capacity(surface.triangle_count());
    let mut total = 0.0f64;
    for (number, part) in surface.parts.iter().enumerate() {
        for triangle in 0..part.triangles.len() {
            let [a, b, c] = part.corners(triangle).map(|corner| corner.as_dvec3());
            total += area(a, b, c);
            ends.push((total, number as u32, triangle as u32));
        }
    }
    if total <= 0.0 || !total.is_finite() {
        return Vec::new();
    }
    let mut found = 0;
    (0..count as u64)
        .map(|stratum| {
            let wanted = (stratum as f64 + uniform(stratum, 0)) / count as f64 * total;
            while found + 1 < ends.len() && ends[found].0 <= wanted {
                found += 1;
            }
            let (_, part, triangle) = ends[found];
            // Uniform over the triangle: the square root evens out the strips from its first corner.
            let (depth, along) = (uniform(stratum, 1).sqrt(), uniform(stratum, 2));
            let (second, third) = (depth * (1.0 - along), depth * along);
            let at = Vec3::new((1.0 - second - third) as f32, second as f32, third as f32);
            SurfacePoint { part, triangle, at }
        })
        .collect()
}

fn area(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// A number in [0, 1) for a counter and a dimension.
fn uniform(counter: u64, dimension: u64) -> f64 {
    (bits(counter * 4 + dimension) >> 11) as f64 / (1u64 << 53) as f64
}

/// Random bits for a counter: the finalizer of SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom
/// number generators", OOPSLA 2014).
pub fn bits(counter: u64) -> u64 {
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut z = counter.wrapping_add(1).wrapping_mul(GOLDEN);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::asset::{Asset, Face, Material, Mesh, Primitive};
    use crate::measure::hand_made::source_surface;

    fn asset(positions: Vec<Vec3>) -> Asset {
        let faces =
            (0..positions.len() as u32 / 3).map(|i| Face::triangle([3 * i, 3 * i + 1, 3 * i + 2])).collect();
        let primitive = Primitive { material: Some(0), positions, faces, ..Primitive::default() };
        Asset {
            materials: vec![Material::default()],
            meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
            ..Asset::default()
        }
    }

    #[test]
    fn points_go_by_area_and_fill_the_triangle() {
        let wide = [Vec3::ZERO, Vec3::X * 3.0, Vec3::Y];
        let needle = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
        let small = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let model = asset([wide, needle, small].concat());
        let surface = source_surface(&model);
        let points = scatter(&surface, 4096);
        let count = |triangle| points.iter().filter(|point| point.triangle == triangle).count();
        assert_eq!((count(0), count(1), count(2)), (3072, 0, 1024));
        let middle = points[..3072].iter().map(|point| point.at).sum::<Vec3>() / 3072.0;
        assert!(middle.distance(Vec3::splat(1.0 / 3.0)) < 0.01, "{middle}");
        assert!(points.iter().all(|point| point.at.min_element() >= -1e-6));
        assert_eq!(points, scatter(&surface, 4096));
    }

    #[test]
    fn no_area_no_points() {
        let model = asset(vec![Vec3::ONE; 3]);
        assert!(scatter(&source_surface(&model), 16).is_empty());
    }
}
