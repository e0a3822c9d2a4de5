//! A color at a surface point: what the model showed before the conversion.

mod reader;
pub mod tangents;
pub mod texture;

pub use reader::FaceReader;
pub use texture::{ChannelKind, SourceChannel, SurfaceSource, channels, edge_ends};
