//! How a caller looks into a running conversion and stops it. The conversion itself has no clock:
//! it announces stage boundaries and progress, and asks whether to go on.

use serde::Serialize;

use crate::error::{Error, ErrorCode, Result};

/// The stages that a caller sees, in order. A conversion goes through `Resample` to `Solve` once for
/// every channel, so a stage may be entered several times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    Read,
    Resample,
    Mip,
    Layout,
    Assign,
    Solve,
    Measure,
    Write,
}

impl Stage {
    pub const ALL: [Stage; 8] = [
        Stage::Read,
        Stage::Resample,
        Stage::Mip,
        Stage::Layout,
        Stage::Assign,
        Stage::Solve,
        Stage::Measure,
        Stage::Write,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Stage::Read => "read",
            Stage::Resample => "resample",
            Stage::Mip => "mip",
            Stage::Layout => "layout",
            Stage::Assign => "assign",
            Stage::Solve => "solve",
            Stage::Measure => "measure",
            Stage::Write => "write",
        }
    }
}

/// Called from any thread of the conversion; every method returns at once.
pub trait Watch: Sync {
    /// The conversion enters a stage (and leaves the one before it).
    fn stage(&self, _stage: Stage) {}

    /// A named step inside the current stage, for finer clocks than stages: image decoding
    /// (`"decode"`) and encoding (`"encode"`, `"compress"`, `"refit"`, `"textures"`). Steps do not nest; `None` ends the step.
    fn step(&self, _name: Option<&'static str>) {}

    /// Share of the whole conversion that is done, 0 to 1, never falling.
    fn progress(&self, _done: f32) {}

    /// Asked often; `true` ends the conversion with [`ErrorCode::Canceled`].
    fn canceled(&self) -> bool {
        false
    }
}

/// A watch that looks away.
pub struct Unwatched;

impl Watch for Unwatched {}

/// Returns the error that ends a canceled conversion. Call it at least once per face batch.
pub fn check(watch: &dyn Watch) -> Result<()> {
    if watch.canceled() {
        return Err(Error::new(ErrorCode::Canceled, "the conversion was canceled"));
    }
    Ok(())
}
