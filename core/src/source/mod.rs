//! A color at a surface point: what the model showed before the conversion.

mod kinks;
pub mod painted;
mod reader;
mod repeated;
pub mod tangents;
pub mod texture;

pub use kinks::kink_codes;
pub use reader::FaceReader;
pub use texture::{ChannelKind, SourceChannel, SurfaceSource, channels, edge_ends};
