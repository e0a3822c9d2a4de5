//! Mesh color textures: UV-textured meshes in, seamless textures with 4D coordinates out.
//!
//! Pure computation: no async, network, environment, clock, GPU or global state. The modules are the
//! stages of one journey and stand here in the order in which data flows; `pipeline::convert` is the
//! table of contents. Which module may use which is fixed in `ARCHITECTURE.md` and tested.
//!
//! The method is that of C. Yuksel, "Mesh Color Textures", HPG 2017 (cited as MCT), on the samples of
//! C. Yuksel, J. Keyser, D. House, "Mesh Colors", ACM TOG 29(2), 2010 (cited as MC).

pub mod error;
pub mod watch;

pub mod math;

pub mod image;

pub mod mesh;

pub mod colors;

pub mod filter;

pub mod vertex_codec;

pub mod asset;

pub mod read;

pub mod source;

pub mod resample;

pub mod mip;

pub mod layout;

pub mod assign;

pub mod pack;

pub mod solve;

pub mod finished;

pub mod measure;

pub mod write;

pub mod pipeline;

pub mod edit;

pub use error::{Error, ErrorCode, Result};
