//! Planes of texels: stored codes, their meaning, and how a sampler reads them.

pub mod planes;
pub mod range;
pub mod sample;
mod tile;
pub mod wrap;

pub use planes::{Image, Pixels, Transfer, Values};
pub use range::LevelRange;
pub use sample::bilinear;
pub use tile::Tile;
pub use wrap::{Wrap, WrapMode};
