//! Tangent frames as a viewer interpolates them.

use glam::{Mat3, Vec3, Vec4};

/// The tangent frame at a corner: unit normal, unit tangent, `w` the handedness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub normal: Vec3,
    pub tangent: Vec4,
}

impl Frame {
    /// The orthonormal frame at barycentrics `at` of three corners: columns tangent, bitangent, normal.
    /// Normal and tangent are interpolated and normalized, the tangent made orthogonal to the normal, the
    /// bitangent is their cross product times the handedness (glTF 2.0, section 3.7.2.1).
    pub fn blend(corners: [&Frame; 3], at: Vec3) -> Mat3 {
        let [a, b, c] = corners;
        let normal = a.normal * at.x + b.normal * at.y + c.normal * at.z;
        let normal = normal.try_normalize().unwrap_or(a.normal);
        let tangent = a.tangent.truncate() * at.x + b.tangent.truncate() * at.y + c.tangent.truncate() * at.z;
        let tangent = (tangent - normal * normal.dot(tangent))
            .try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        Mat3::from_cols(tangent, normal.cross(tangent) * a.tangent.w, normal)
    }
}
