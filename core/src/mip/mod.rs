//! Mip levels of mesh colors: each coarse sample is the fine samples around it, weighted by its hat
//! function and normalized (MC equations 5 and 6, and the 1-2-1 product on quads).
//!
//! Faces fall by one exponent each level down to vertex colors; from there on equation 6 runs over the
//! neighboring vertices (`one-ring`). On both sides of a cut each side is filtered alone, because the two
//! sides have samples of their own.

mod coverage;
mod filter;
#[cfg(test)]
mod tests;

pub use coverage::{coverage, keep_coverage};
pub use filter::coarsen;

/// What a coarse sample weighs the fine ones around it by, beside its hat function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MipFilter {
    /// Nothing: MC equations 5 and 6.
    Uniform,
    /// The surface area that each stands for.
    Area,
}

/// How levels go on where a face is at vertex colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// MC equation 6 over the neighboring vertices.
    OneRing,
    /// Implicit heat flow over the surface.
    Heat,
}
