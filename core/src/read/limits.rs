//! How much a model may ask for. The service and the command line set these from their own settings.

/// Hard limits of reading; a count over its limit is an error that names both figures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    pub image_side: u32,
    pub image_pixels: u64,
    /// Over all images of one model together.
    pub job_pixels: u64,
    pub triangles: u64,
    pub vertices: u64,
    pub nodes: u64,
    pub json_bytes: u64,
    pub json_depth: u32,
    pub files: u64,
    /// Unpacked bytes of an archive.
    pub archive_bytes: u64,
    /// Unpacked over packed bytes, for archives that unpack to more than a MiB.
    pub archive_ratio: u64,
    pub archive_entries: u64,
    /// Side of the largest texture that a conversion may write.
    pub texture_side: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            image_side: 16_384,
            image_pixels: 67_108_864,
            job_pixels: 268_435_456,
            triangles: 10_000_000,
            vertices: 20_000_000,
            nodes: 100_000,
            json_bytes: 32 << 20,
            json_depth: 128,
            files: 256,
            archive_bytes: 1 << 30,
            archive_ratio: 100,
            archive_entries: 1_000,
            texture_side: 16_384,
        }
    }
}
