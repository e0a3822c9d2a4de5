//! Mip levels of mesh colors: each coarse sample is the fine samples around it, weighted by its hat
//! function and normalized (MC equations 5 and 6, and the 1-2-1 product on quads).
//!
//! Faces fall by one exponent each level down to vertex colors; from there on equation 6 runs over the
//! neighboring vertices (`one-ring`). On both sides of a cut each side is filtered alone, because the two
//! sides have samples of their own.

mod coverage;
mod exchange;
mod filter;
mod hats;
mod heat;
mod interior;
#[cfg(test)]
mod tests;

pub use coverage::{coverage, keep_coverage};

use glam::Vec4;

use crate::colors::LevelNumbering;
use crate::error::Result;
use crate::watch::{self, Watch};

use exchange::Network;
use filter::Filter;

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

/// How one channel is filtered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rungs {
    pub filter: MipFilter,
    pub beyond: Beyond,
    /// Whether colors are weighted by alpha.
    pub by_alpha: bool,
}

/// Filters one channel from level to level.
pub struct Coarsener {
    rungs: Rungs,
    network: Network,
}

impl Coarsener {
    pub fn new(rungs: Rungs) -> Self {
        Self { rungs, network: Network::default() }
    }

    /// Computes the samples of `coarse` from those of `fine`, the level before it, into a buffer that may hold
    /// anything.
    ///
    /// Normals are averaged as vectors: they shorten where they differ, which is what the next level has to
    /// weigh them by; whoever stores them normalizes.
    ///
    /// # Errors
    /// `Canceled`; `Internal` where the heat flow's system cannot be factored.
    pub fn coarsen(
        &mut self,
        [fine, coarse]: [&LevelNumbering<'_>; 2],
        values: &[Vec4],
        room: Vec<Vec4>,
        watch: &dyn Watch,
    ) -> Result<Vec<Vec4>> {
        watch::check(watch)?;
        let filter = Filter::new(fine, coarse, values, self.rungs);
        let mut out = coarse.values_in(room);
        let [fans, strips, inner] = coarse.parts(&mut out);
        let borders = interior::interiors(&filter, inner);
        watch::check(watch)?;
        filter.fans(fans);
        filter.strips(coarse.by_strip(strips), &borders);
        if self.rungs.beyond == Beyond::Heat {
            watch::check(watch)?;
            let shared = &mut out[..coarse.shared_count()];
            heat::flow(fine, coarse, &mut self.network, shared, self.rungs.by_alpha)?;
        }
        Ok(out)
    }
}
