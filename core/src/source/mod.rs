//! A color at a surface point: what the model showed before the conversion.

pub mod tangents;
pub mod texture;

pub use texture::{ChannelKind, SourceChannel, SurfaceSource, channels};
