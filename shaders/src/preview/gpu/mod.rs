//! The renderer on a GPU through wgpu, off screen, with the WGSL that users get. Any Vulkan adapter will
//! do, software ones too. Nothing here panics: what the device reports comes back as `Device`.

mod device;
mod draw;
mod pipelines;
mod stack;
mod textures;

use super::PreviewError;
use super::picture::{Picture, Renderer};
use super::scene::Shot;
use super::scene::texture::Texture;

pub use self::device::{Gpu, NoGpu};
use self::pipelines::Pipelines;
use self::textures::TextureStore;

/// Draws on one adapter.
pub struct GpuRenderer {
    gpu: Gpu,
    pipelines: Pipelines,
    textures: TextureStore,
}

impl GpuRenderer {
    /// # Errors
    /// `NoGpu`, saying whether there is no adapter or it refuses.
    pub fn open() -> Result<Self, NoGpu> {
        let gpu = Gpu::open()?;
        let pipelines = Pipelines::new(&gpu);
        let textures = TextureStore::new(&gpu);
        gpu.check().map_err(|error| NoGpu::Refused(error.to_string()))?;
        Ok(Self { gpu, pipelines, textures })
    }
}

impl Renderer for GpuRenderer {
    fn label(&self) -> String {
        format!("wgpu: {}", self.gpu.adapter_name)
    }

    fn draw(&mut self, textures: &[Texture<'_>], shot: &Shot<'_>) -> Result<Picture, PreviewError> {
        if shot.batches.iter().any(|batch| batch.surface.painted.is_some()) {
            // Whoever chooses renderers draws these on the CPU.
            return Err(self.gpu.failure("mesh colors themselves have no filter here".to_owned()));
        }
        for binding in shot.batches.iter().flat_map(|batch| batch.surface.bindings.iter().flatten()) {
            self.textures.upload(&self.gpu, textures, binding)?;
        }
        draw::draw(&self.gpu, &mut self.pipelines, &self.textures, shot)
    }
}
