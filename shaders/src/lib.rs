//! What runs on a GPU with mesh color textures: the WGSL that users paste into their engines, its twins
//! for the CPU, and the seam-check sheet that is drawn with either.

pub mod preview;
pub mod twins;

/// The sampling functions, complete in one file that declares no bindings.
pub const WGSL: &str = include_str!("../wgsl/mesh_color_texture.wgsl");

/// What indexed coordinates need besides: it goes behind [`WGSL`].
pub const WGSL_INDEXED: &str = include_str!("../wgsl/mesh_color_texture_indexed.wgsl");

/// The font of every picture: Ubuntu Light, under the Ubuntu font licence; its package carries the text.
pub const FONT: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;
