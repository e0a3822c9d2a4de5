//! Checks and repairs that every format's primitives go through: unit normals and tangents, degenerate
//! faces counted.

use glam::{DVec3, Vec3, Vec4};

use super::warnings::Warnings;
use crate::asset::{Face, Primitive};
use crate::error::{Error, Result};

/// Texture coordinates beyond this many repetitions are noise in single precision, so they are refused.
pub(super) const UV_MAX: f32 = 1e6;

/// Positions beyond this overflow single precision once they are squared and multiplied.
pub(super) const POSITION_MAX: f32 = 1e9;

/// A triangle counts as without area when its height is this small a share of its longest edge: far
/// below what rounding of single-precision positions leaves of a real one.
const FLAT: f64 = 1e-9;

/// Refuses the first value that is not finite or is larger than `max`. `values` are the components of
/// elements of `width` each; `place(element)` says where an element stands.
pub(super) fn check_finite(
    values: impl Iterator<Item = f32>,
    width: usize,
    max: f32,
    place: impl Fn(usize) -> String,
) -> Result<()> {
    for (at, value) in values.enumerate() {
        if value.is_nan() || value.abs() > max {
            let element = at / width;
            let detail =
                format!("{}: the value {value} is not allowed: finite, within ±{max:e}", place(element));
            return Err(Error::invalid(detail));
        }
    }
    Ok(())
}

/// Whether neighboring corners of a quad stand in one place, as at the pole of a sphere. It looks like a triangle then: as a quad
/// it would show half of its samples, and those of an edge not where the face beside it has them.
pub(super) fn has_side_without_length(corners: [Vec3; 4]) -> bool {
    (0..4).any(|corner| corners[corner] == corners[(corner + 1) % 4])
}

/// Makes normals and tangents unit length, replaces those without a direction, and counts degenerate
/// faces. Positions are finite; faces index into them.
pub(super) fn finish(primitive: &mut Primitive, pointer: &str, warnings: &mut Warnings) {
    count_degenerate(primitive, pointer, warnings);
    repair_normals(primitive, pointer, warnings);
    repair_tangents(primitive, pointer, warnings);
}

fn count_degenerate(primitive: &Primitive, pointer: &str, warnings: &mut Warnings) {
    let (mut repeated, mut flat) = (0, 0);
    for face in &primitive.faces {
        let corners = face.corners();
        if (0..corners.len()).any(|i| corners[i + 1..].contains(&corners[i])) {
            repeated += 1;
        } else if is_flat(&primitive.positions, face) {
            flat += 1;
        }
    }
    let detail = "faces that use one vertex twice; they are kept and converted as they are";
    warnings.add_many("degenerate_face", pointer, detail, repeated);
    let detail = "faces without area; they are kept and converted as they are";
    warnings.add_many("zero_area_face", pointer, detail, flat);
}

fn position(positions: &[Vec3], vertex: u32) -> DVec3 {
    positions[vertex as usize].as_dvec3()
}

/// Whether no triangle of the face has area.
fn is_flat(positions: &[Vec3], face: &Face) -> bool {
    let at = |corner: usize| position(positions, face.corners[corner]);
    face.triangles().iter().all(|&[a, b, c]| {
        let (ab, ac, bc) = (at(b) - at(a), at(c) - at(a), at(c) - at(b));
        let longest = ab.length_squared().max(ac.length_squared()).max(bc.length_squared());
        ab.cross(ac).length() <= FLAT * longest
    })
}

fn repair_normals(primitive: &mut Primitive, pointer: &str, warnings: &mut Warnings) {
    let mut missing_count = 0;
    for normal in &mut primitive.normals {
        *normal = unit(*normal).unwrap_or_else(|| {
            missing_count += 1;
            Vec3::ZERO
        });
    }
    if missing_count == 0 {
        return;
    }
    // Area-weighted: the cross product's length is twice the area.
    let mut sums = vec![DVec3::ZERO; primitive.positions.len()];
    for face in &primitive.faces {
        for &[a, b, c] in face.triangles() {
            let corners = [face.corners[a], face.corners[b], face.corners[c]];
            let [a, b, c] = corners.map(|vertex| position(&primitive.positions, vertex));
            let weighted = (b - a).cross(c - a);
            for vertex in corners {
                sums[vertex as usize] += weighted;
            }
        }
    }
    for (normal, sum) in primitive.normals.iter_mut().zip(sums) {
        if *normal == Vec3::ZERO {
            // A vertex of faces without area has no normal at all; any direction is as good.
            *normal = sum.try_normalize().map_or(Vec3::Z, |exact| exact.as_vec3());
        }
    }
    let detail = "normals without a direction; the normal of the vertex's faces took their place";
    warnings.add_many("zero_normal", pointer, detail, missing_count);
}

fn repair_tangents(primitive: &mut Primitive, pointer: &str, warnings: &mut Warnings) {
    let mut repaired_count = 0;
    for (vertex, tangent) in primitive.tangents.iter_mut().enumerate() {
        let direction = unit(tangent.truncate());
        let handed = tangent.w == 1.0 || tangent.w == -1.0;
        if direction.is_none() || !handed {
            repaired_count += 1;
        }
        let direction = direction.unwrap_or_else(|| {
            primitive.normals.get(vertex).map_or(Vec3::X, |normal| normal.any_orthonormal_vector())
        });
        let handedness = if tangent.w < 0.0 { -1.0 } else { 1.0 };
        *tangent = Vec4::from((direction, handedness));
    }
    let detail = "tangents without a direction or with a handedness other than ±1; any tangent at right \
                  angles to the normal and the nearest handedness took their place";
    warnings.add_many("bad_tangent", pointer, detail, repaired_count);
}

/// A vector whose squared length is this near to 1 is unit up to rounding, and stays as it was written.
const UNIT_TOLERANCE: f64 = 1e-6;

/// In double precision: the square of a small single-precision vector would vanish.
fn unit(vector: Vec3) -> Option<Vec3> {
    let exact = vector.as_dvec3();
    if (exact.length_squared() - 1.0).abs() <= UNIT_TOLERANCE {
        return Some(vector);
    }
    exact.try_normalize().map(|exact| exact.as_vec3())
}
