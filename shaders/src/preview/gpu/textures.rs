//! Images to the device: sources with their mip maps, converted textures as stacks of levels.

use std::collections::BTreeMap;

use half::f16;
use meshcolor::image::{Image, LevelRange, Pixels, Transfer, WrapMode};
use rayon::prelude::*;

use super::device::Gpu;
use super::stack::{Stack, stack};
use crate::preview::PreviewError;
use crate::preview::scene::surface::{Binding, Coordinate};
use crate::preview::scene::texture::Texture;
use crate::twins::MctLevel;

/// A texture on the device.
pub struct Uploaded {
    pub view: wgpu::TextureView,
    /// Where the levels stand, of a stack; empty for one with mip maps.
    pub levels: Vec<MctLevel>,
}

/// What has been uploaded, by number of texture and whether it is a stack.
pub struct TextureStore {
    uploaded: BTreeMap<(usize, bool), Uploaded>,
    /// Stands in for slots without a texture.
    pub nothing: wgpu::TextureView,
}

fn key(binding: &Binding) -> (usize, bool) {
    (binding.texture, binding.coordinate == Coordinate::Mesh)
}

impl TextureStore {
    pub fn new(gpu: &Gpu) -> Self {
        let texture = create(gpu, [1, 1], 1, wgpu::TextureFormat::Rgba8Unorm);
        let nothing = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { uploaded: BTreeMap::new(), nothing }
    }

    pub fn get(&self, binding: &Binding) -> Option<&Uploaded> {
        self.uploaded.get(&key(binding))
    }

    /// # Errors
    /// `Device` where the texture is larger than the adapter allows.
    pub fn upload(
        &mut self,
        gpu: &Gpu,
        textures: &[Texture<'_>],
        binding: &Binding,
    ) -> Result<(), PreviewError> {
        if self.uploaded.contains_key(&key(binding)) {
            return Ok(());
        }
        let texture = &textures[binding.texture];
        let uploaded = match binding.coordinate {
            Coordinate::Mesh => upload_stack(gpu, texture)?,
            Coordinate::Uv { .. } => upload_mip_maps(gpu, texture)?,
        };
        self.uploaded.insert(key(binding), uploaded);
        // Copies on their way are held until they are handed over; a model's textures are large.
        gpu.finish(None)
    }
}

fn upload_mip_maps(gpu: &Gpu, texture: &Texture<'_>) -> Result<Uploaded, PreviewError> {
    let size = texture.level(0).size();
    ensure_size(gpu, size)?;
    let format = format_of(texture);
    let created = create(gpu, size, texture.levels.len() as u32, format);
    for (level, image) in texture.levels.iter().enumerate() {
        write(gpu, &created, level as u32, [0, 0], (image, texture.transfer, None));
    }
    Ok(Uploaded { view: created.create_view(&wgpu::TextureViewDescriptor::default()), levels: vec![] })
}

fn upload_stack(gpu: &Gpu, texture: &Texture<'_>) -> Result<Uploaded, PreviewError> {
    let sizes: Vec<_> = texture.levels.iter().map(|level| level.size()).collect();
    let Stack { size, levels } = stack(&sizes);
    ensure_size(gpu, size)?;
    let created = create(gpu, size, 1, format_of(texture));
    for (number, (image, level)) in texture.levels.iter().zip(&levels).enumerate() {
        let origin = [level.origin.x as u32, level.origin.y as u32];
        write(gpu, &created, 0, origin, (image, texture.transfer, texture.range(number)));
    }
    Ok(Uploaded { view: created.create_view(&wgpu::TextureViewDescriptor::default()), levels })
}

fn ensure_size(gpu: &Gpu, size: [u32; 2]) -> Result<(), PreviewError> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if size.into_iter().all(|side| side <= limit) {
        return Ok(());
    }
    let [width, height] = size;
    Err(gpu.failure(format!("a texture of {width} × {height} is over its limit of {limit}")))
}

/// 16-bit codes and a source's values become half floats in linear light: there is no 16-bit sRGB format, and this one is
/// filtered everywhere. So do all levels of a stack that has one in a range, decoded.
fn format_of(texture: &Texture<'_>) -> wgpu::TextureFormat {
    match (&texture.level(0).pixels, texture.transfer) {
        _ if !texture.ranges.is_empty() => wgpu::TextureFormat::Rgba16Float,
        (Pixels::U16(_) | Pixels::F32(_), _) => wgpu::TextureFormat::Rgba16Float,
        (Pixels::U8(_), Transfer::Srgb) => wgpu::TextureFormat::Rgba8UnormSrgb,
        (Pixels::U8(_), Transfer::Linear) => wgpu::TextureFormat::Rgba8Unorm,
    }
}

fn create(gpu: &Gpu, [width, height]: [u32; 2], levels: u32, format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// What the texels of an image mean.
type Meaning<'a> = (&'a Image, Transfer, Option<&'a LevelRange>);

fn write(gpu: &Gpu, to: &wgpu::Texture, level: u32, [x, y]: [u32; 2], meaning: Meaning<'_>) {
    let image = meaning.0;
    let bytes = texels(meaning, to.format() == wgpu::TextureFormat::Rgba16Float);
    let bytes_per_row = (bytes.len() / image.height as usize) as u32;
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture: to,
            mip_level: level,
            origin: wgpu::Origin3d { x, y, z: 0 },
            aspect: wgpu::TextureAspect::All,
        },
        &bytes,
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(bytes_per_row), rows_per_image: None },
        wgpu::Extent3d { width: image.width, height: image.height, depth_or_array_layers: 1 },
    );
}

/// Four components a texel, in the device's format.
fn texels((image, transfer, range): Meaning<'_>, as_half: bool) -> Vec<u8> {
    let components = image.components as usize;
    match &image.pixels {
        Pixels::U8(codes) if !as_half => {
            let mut bytes = vec![255_u8; image.texel_count() * 4];
            bytes.par_chunks_mut(4).zip(codes.par_chunks(components)).for_each(|(out, texel)| match *texel {
                [r, g, b] => out[..3].copy_from_slice(&[r, g, b]),
                [r, g, b, a] => out.copy_from_slice(&[r, g, b, a]),
                [gray, a] => out.copy_from_slice(&[gray, gray, gray, a]),
                [gray] => out[..3].fill(gray),
                _ => {}
            });
            bytes
        }
        _ => {
            let rows = (0..image.height).into_par_iter();
            let value = |x: u32, y: u32| match range {
                None => image.linear(x, y, transfer),
                Some(range) => range.texel(image, x, y).to_array(),
            };
            let values =
                rows.flat_map_iter(|y| (0..image.width).flat_map(move |x| value(x, y).map(f16::from_f32)));
            let values: Vec<f16> = values.collect();
            values.iter().flat_map(|value| value.to_le_bytes()).collect()
        }
    }
}

/// The sampler of a slot: trilinear with the source's wrap modes, or bilinear and clamped for a stack.
pub fn sampler(gpu: &Gpu, binding: Option<&Binding>) -> wgpu::Sampler {
    let (u, v, mipmap_filter) = match binding.map(|binding| binding.coordinate) {
        Some(Coordinate::Uv { wrap, .. }) => {
            (address(wrap.s), address(wrap.t), wgpu::MipmapFilterMode::Linear)
        }
        _ => {
            let clamp = wgpu::AddressMode::ClampToEdge;
            (clamp, clamp, wgpu::MipmapFilterMode::Nearest)
        }
    };
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: u,
        address_mode_v: v,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter,
        ..wgpu::SamplerDescriptor::default()
    })
}

fn address(mode: WrapMode) -> wgpu::AddressMode {
    match mode {
        WrapMode::Repeat => wgpu::AddressMode::Repeat,
        WrapMode::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
        WrapMode::ClampToEdge => wgpu::AddressMode::ClampToEdge,
    }
}
