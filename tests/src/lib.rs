//! What the black-box tests share.

pub mod baked;
pub mod cases;
pub mod faces;
pub mod gltf;
pub mod hard;
pub mod models;
pub mod openimageio;
pub mod patches;
pub mod ptex;
pub mod reading;
pub mod repository;
pub mod solids;
pub mod validator;

/// Whether a missing tool is a failure: `tests/run` says so, because it has installed them.
pub fn requires_tools() -> bool {
    std::env::var_os("MESHCOLOR_REQUIRE_TOOLS").is_some_and(|value| value == "1")
}
