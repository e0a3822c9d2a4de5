//! One rising figure for the whole journey.

use crate::watch::Watch;

/// Shares the span between two figures among parts of known weight.
pub struct Progress<'a> {
    watch: &'a dyn Watch,
    done: f32,
    /// What one unit of the current part is worth.
    scale: f32,
}

impl<'a> Progress<'a> {
    pub fn new(watch: &'a dyn Watch) -> Self {
        Self { watch, done: 0.0, scale: 1.0 }
    }

    /// From here on [`Progress::advance`] counts in shares of `span`.
    pub fn part(&mut self, span: f32) {
        self.scale = span;
    }

    pub fn advance(&mut self, share: f32) {
        self.done = (self.done + share * self.scale).min(1.0);
        self.watch.progress(self.done);
    }
}
