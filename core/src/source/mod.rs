//! The source as it came: the surface that a texture coordinate addresses and its tangent frames.

pub mod tangents;
