//! One picture: buffers, one render pass, and the way back to the CPU.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;
use meshcolor::asset::AlphaMode;
use meshcolor::math::transfer::srgb_to_linear;
use wgpu::util::DeviceExt;

use super::device::Gpu;
use super::pipelines::{COLOR_FORMAT, DEPTH_FORMAT, Pipelines, SAMPLE_COUNT};
use super::textures::{TextureStore, sampler};
use crate::preview::PreviewError;
use crate::preview::picture::{BACKGROUND_SRGB, Picture};
use crate::preview::scene::geometry::Batch;
use crate::preview::scene::surface::Surface;
use crate::preview::scene::{Filter, Shot};

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ShotUniform {
    projection: [[f32; 4]; 4],
    forced_level: f32,
    padding: [f32; 3],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SurfaceUniform {
    base_color_factor: [f32; 4],
    emissive_metallic: [f32; 4],
    scalars: [f32; 4],
    slots: [[u32; 4]; 5],
}

/// A run of triangles of one batch, ready to draw.
struct Draw {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    vertex_count: u32,
}

pub fn draw(
    gpu: &Gpu,
    pipelines: &mut Pipelines,
    textures: &TextureStore,
    shot: &Shot<'_>,
) -> Result<Picture, PreviewError> {
    let uniform = ShotUniform {
        projection: shot.camera.projection.to_cols_array_2d(),
        forced_level: match shot.filter {
            Filter::Trilinear => -1.0,
            Filter::Level(level) => level as f32,
        },
        padding: [0.0; 3],
    };
    let uniform = filled(gpu, bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM);
    let shot_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipelines.shot_layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
    });
    let mut draws = Vec::new();
    for batch in shot.batches {
        draws.extend(batch_draws(gpu, pipelines, textures, batch, shot)?);
    }
    gpu.check()?;
    let [width, height] = shot.size;
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if width > limit || height > limit {
        return Err(gpu.failure(format!("a picture of {width} × {height} is over its limit of {limit}")));
    }
    let target = |format, samples, usage| attachment(gpu, shot.size, format, samples, usage);
    let attach = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let many = target(COLOR_FORMAT, SAMPLE_COUNT, attach);
    let depth = target(DEPTH_FORMAT, SAMPLE_COUNT, attach);
    let resolved = target(COLOR_FORMAT, 1, attach | wgpu::TextureUsages::COPY_SRC);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    pass(&mut encoder, [&many, &depth, &resolved], &shot_group, &draws);
    read_back(gpu, encoder, &resolved)
}

fn filled(gpu: &Gpu, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
}

fn attachment(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    sample_count: u32,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// Draws of one batch: several where its records are more than one binding may hold.
fn batch_draws(
    gpu: &Gpu,
    pipelines: &mut Pipelines,
    textures: &TextureStore,
    batch: &Batch,
    shot: &Shot<'_>,
) -> Result<Vec<Draw>, PreviewError> {
    let pipeline = pipelines.get(gpu, batch, shot.look);
    let (uniform, table) = surface_uniform(&batch.surface, textures);
    let uniform = filled(gpu, bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM);
    let table = filled(gpu, bytemuck::cast_slice(&table), wgpu::BufferUsages::STORAGE);
    let blocks = block_buffers(gpu, batch);
    let bindings = batch.surface.bindings;
    let samplers = bindings.each_ref().map(|binding| sampler(gpu, binding.as_ref()));
    let views = bindings.each_ref().map(|binding| {
        binding.as_ref().and_then(|b| textures.get(b)).map_or(&textures.nothing, |uploaded| &uploaded.view)
    });
    let triangle_floats = 3 * batch.layout.stride;
    let limits = gpu.device.limits();
    let most_bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let most_triangles = (most_bytes as usize / (4 * triangle_floats)).max(1);
    let mut draws = Vec::new();
    for records in batch.records.chunks(most_triangles * triangle_floats) {
        let vertex_count = u32::try_from(records.len() / batch.layout.stride)
            .map_err(|_| gpu.failure("a part of the model has too many corners"))?;
        let records = filled(gpu, bytemuck::cast_slice(records), wgpu::BufferUsages::STORAGE);
        let resources = [&records, &uniform, &table].map(|buffer| buffer.as_entire_binding());
        let resources = resources
            .into_iter()
            .chain(views.map(wgpu::BindingResource::TextureView))
            .chain(samplers.each_ref().map(wgpu::BindingResource::Sampler))
            .chain(blocks.each_ref().map(|buffer| buffer.as_entire_binding()));
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipelines.batch_layout,
            entries: &entries,
        });
        draws.push(Draw { pipeline: pipeline.clone(), group, vertex_count });
    }
    Ok(draws)
}

/// The table of indexed coordinates: classes, and their grids by level.
fn block_buffers(gpu: &Gpu, batch: &Batch) -> [wgpu::Buffer; 2] {
    let storage = |bytes: &[u8]| filled(gpu, bytes, wgpu::BufferUsages::STORAGE);
    match &batch.table {
        Some(table) => [
            storage(bytemuck::cast_slice(&table.class_words())),
            storage(bytemuck::cast_slice(&table.grid_words())),
        ],
        // A binding cannot be empty.
        None => [storage(&[0; 32]), storage(&[0; 16])],
    }
}

/// The surface's numbers, and the levels of all its stacks in one table (origin and size of each).
fn surface_uniform(surface: &Surface, textures: &TextureStore) -> (SurfaceUniform, Vec<[f32; 4]>) {
    let mut table = Vec::new();
    let mut slots = [[0; 4]; 5];
    for (slot, binding) in surface.bindings.iter().enumerate() {
        let Some(uploaded) = binding.as_ref().and_then(|binding| textures.get(binding)) else { continue };
        slots[slot] = [table.len() as u32, uploaded.levels.len() as u32, 0, 0];
        table.extend(
            uploaded.levels.iter().map(|level| [level.origin.x, level.origin.y, level.size.x, level.size.y]),
        );
    }
    if table.is_empty() {
        // A binding cannot be empty.
        table.push([0.0; 4]);
    }
    let cutoff = match surface.alpha_mode {
        AlphaMode::Mask(cutoff) => cutoff,
        AlphaMode::Opaque | AlphaMode::Blend => 0.0,
    };
    let uniform = SurfaceUniform {
        base_color_factor: surface.base_color_factor.to_array(),
        emissive_metallic: surface.emissive_factor.extend(surface.metallic_factor).to_array(),
        scalars: Vec4::new(
            surface.roughness_factor,
            surface.normal_scale,
            surface.occlusion_strength,
            cutoff,
        )
        .to_array(),
        slots,
    };
    (uniform, table)
}

/// `targets`: multisampled color, depth, resolved color.
fn pass(
    encoder: &mut wgpu::CommandEncoder,
    targets: [&wgpu::Texture; 3],
    shot_group: &wgpu::BindGroup,
    draws: &[Draw],
) {
    let [many, depth, resolved] =
        targets.map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default()));
    let [r, g, b] = BACKGROUND_SRGB.map(|code| f64::from(srgb_to_linear(f32::from(code) / 255.0)));
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &many,
            depth_slice: None,
            resolve_target: Some(&resolved),
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                store: wgpu::StoreOp::Discard,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(1.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    pass.set_bind_group(0, shot_group, &[]);
    for draw in draws {
        pass.set_pipeline(&draw.pipeline);
        pass.set_bind_group(1, &draw.group, &[]);
        pass.draw(0..draw.vertex_count, 0..1);
    }
}

fn read_back(
    gpu: &Gpu,
    mut encoder: wgpu::CommandEncoder,
    texture: &wgpu::Texture,
) -> Result<Picture, PreviewError> {
    let [width, height] = [texture.width(), texture.height()];
    let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row_bytes) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row_bytes),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    gpu.finish(Some(encoder.finish()))?;
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // Nobody listens any more where waiting has failed.
        let _ = sender.send(result);
    });
    // The copy is done; this turn tells the buffer so.
    gpu.finish(None)?;
    match receiver.try_recv() {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(gpu.failure(error)),
        Err(_) => return Err(gpu.failure("the picture did not come back")),
    }
    let bytes = buffer.get_mapped_range(..).map_err(|error| gpu.failure(error))?;
    let rows = bytes.chunks_exact(row_bytes as usize);
    let texels = rows.flat_map(|row| row[..4 * width as usize].chunks_exact(4));
    let rgb = texels.flat_map(|texel| [texel[0], texel[1], texel[2]]).collect();
    Ok(Picture { size: [width, height], rgb })
}
