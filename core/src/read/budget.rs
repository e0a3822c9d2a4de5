//! What one model has used of its limits. Counts are taken before the memory for them is allocated.

use super::Limits;
use crate::error::{Error, ErrorCode, Result};

/// Running totals over the whole model.
#[derive(Debug)]
pub(super) struct Budget<'a> {
    pub limits: &'a Limits,
    bytes: u64,
    triangles: u64,
    vertices: u64,
    pixels: u64,
}

impl<'a> Budget<'a> {
    pub fn new(limits: &'a Limits) -> Self {
        Self { limits, bytes: 0, triangles: 0, vertices: 0, pixels: 0 }
    }

    /// Memory for file contents and raw attributes. References multiply (a thousand images may name one
    /// file), so what they resolve to is limited together, by what an archive may unpack to.
    pub fn take_bytes(&mut self, bytes: u64, pointer: &str) -> Result<()> {
        let limit = self.limits.archive_bytes;
        self.bytes = self.bytes.saturating_add(bytes);
        if self.bytes <= limit {
            return Ok(());
        }
        let detail = format!(
            "files and attributes resolve to {} bytes so far; the limit is {limit} (limit `archive_bytes`)",
            self.bytes
        );
        Err(Error::new(ErrorCode::ModelTooLarge, detail).at(pointer).limit(limit, self.bytes))
    }

    pub fn take_triangles(&mut self, count: u64, pointer: &str) -> Result<()> {
        let limit = self.limits.triangles;
        self.triangles = self.triangles.saturating_add(count);
        if self.triangles <= limit {
            return Ok(());
        }
        let detail = format!(
            "the model has at least {} triangles; the limit is {limit} (limit `triangles`)",
            self.triangles
        );
        Err(Error::new(ErrorCode::TooManyTriangles, detail).at(pointer).limit(limit, self.triangles))
    }

    /// Of images.
    pub fn take_pixels(&mut self, count: u64) -> Result<()> {
        self.pixels = with_pixels(self.pixels, count, self.limits)?;
        Ok(())
    }

    /// What was taken so far.
    pub fn pixels(&self) -> u64 {
        self.pixels
    }

    pub fn take_vertices(&mut self, count: u64, pointer: &str) -> Result<()> {
        let limit = self.limits.vertices;
        self.vertices = self.vertices.saturating_add(count);
        if self.vertices <= limit {
            return Ok(());
        }
        let detail = format!(
            "the model has at least {} vertices; the limit is {limit} (limit `vertices`)",
            self.vertices
        );
        Err(Error::new(ErrorCode::ModelTooLarge, detail).at(pointer).limit(limit, self.vertices))
    }
}

/// A total with the pixels of one image more, within what all may have together.
pub(super) fn with_pixels(total: u64, count: u64, limits: &Limits) -> Result<u64> {
    let total = total.saturating_add(count);
    if total <= limits.job_pixels {
        return Ok(total);
    }
    let detail = format!(
        "the images together have at least {total} pixels; the limit is {} (limit `job_pixels`)",
        limits.job_pixels
    );
    Err(Error::new(ErrorCode::ImageTooLarge, detail).limit(limits.job_pixels, total))
}
