//! One pipeline for each combination of features that an asset has: what it lacks is compiled away.

use std::collections::BTreeMap;

use meshcolor::asset::{AlphaMode, Slot};

use super::device::Gpu;
use crate::preview::scene::geometry::Batch;
use crate::preview::scene::surface::{Coordinate, Look};
use crate::{WGSL, WGSL_INDEXED};

pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
pub const SAMPLE_COUNT: u32 = 4;

const PREVIEW_WGSL: &str = include_str!("../../../wgsl/preview.wgsl");

/// The overrides of `preview.wgsl` with their values, and the two states that are no override.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    overrides: Vec<(&'static str, u32)>,
    is_double_sided: bool,
    is_blended: bool,
}

impl Key {
    fn new(batch: &Batch, look: Look) -> Self {
        let Batch { surface, layout, table, .. } = batch;
        let how = |slot: usize| match surface.bindings[slot].map(|binding| binding.coordinate) {
            None => 0,
            Some(Coordinate::Mesh) => 1,
            Some(Coordinate::Uv { set, .. }) => 2 + set as u32,
        };
        let alpha = match surface.alpha_mode {
            AlphaMode::Opaque => 0,
            AlphaMode::Mask(_) => 1,
            AlphaMode::Blend => 2,
        };
        let look = match look {
            Look::Lit => 0,
            // An attribute stands where base color does.
            Look::Flat(slot) => 1 + Slot::CORE.iter().position(|own| *own == slot).unwrap_or(0) as u32,
        };
        let overrides = vec![
            ("BASE_COLOR", how(0)),
            ("METALLIC_ROUGHNESS", how(1)),
            ("NORMAL", how(2)),
            ("OCCLUSION", how(3)),
            ("EMISSIVE", how(4)),
            ("LOOK", look),
            ("ALPHA", alpha),
            ("STRIDE", layout.stride as u32),
            ("TANGENT_AT", layout.tangent.unwrap_or(0) as u32),
            ("UV_AT", layout.uv as u32),
            ("UV_SETS", layout.uv_set_count as u32),
            ("MESH_AT", layout.mesh.unwrap_or(0) as u32),
            ("INDEXED", u32::from(table.is_some())),
            ("COLOR_AT", layout.color.unwrap_or(0) as u32),
        ];
        Self { overrides, is_double_sided: surface.double_sided, is_blended: alpha == 2 }
    }
}

pub struct Pipelines {
    module: wgpu::ShaderModule,
    pub shot_layout: wgpu::BindGroupLayout,
    pub batch_layout: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    made: BTreeMap<Key, wgpu::RenderPipeline>,
}

impl Pipelines {
    pub fn new(gpu: &Gpu) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("preview"),
            source: wgpu::ShaderSource::Wgsl(format!("{WGSL}\n{WGSL_INDEXED}\n{PREVIEW_WGSL}").into()),
        });
        let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let uniform = |binding| buffer(binding, wgpu::BufferBindingType::Uniform, both);
        let storage =
            |binding, stages| buffer(binding, wgpu::BufferBindingType::Storage { read_only: true }, stages);
        let mut entries = vec![
            storage(0, wgpu::ShaderStages::VERTEX),
            uniform(1),
            storage(2, wgpu::ShaderStages::FRAGMENT),
        ];
        entries.extend((3..8).map(|binding| {
            let ty = wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: true },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            };
            entry(binding, ty, wgpu::ShaderStages::FRAGMENT)
        }));
        entries.extend((8..13).map(|binding| {
            let ty = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
            entry(binding, ty, wgpu::ShaderStages::FRAGMENT)
        }));
        entries.extend([13, 14].map(|binding| storage(binding, wgpu::ShaderStages::FRAGMENT)));
        let group = |entries: &[wgpu::BindGroupLayoutEntry]| {
            gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries })
        };
        let shot_layout = group(&[uniform(0)]);
        let batch_layout = group(&entries);
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&shot_layout), Some(&batch_layout)],
            immediate_size: 0,
        });
        Self { module, shot_layout, batch_layout, layout, made: BTreeMap::new() }
    }

    pub fn get(&mut self, gpu: &Gpu, batch: &Batch, look: Look) -> wgpu::RenderPipeline {
        let key = Key::new(batch, look);
        if let Some(pipeline) = self.made.get(&key) {
            return pipeline.clone();
        }
        let pipeline = self.make(gpu, &key);
        self.made.insert(key, pipeline.clone());
        pipeline
    }

    fn make(&self, gpu: &Gpu, key: &Key) -> wgpu::RenderPipeline {
        let constants: Vec<_> =
            key.overrides.iter().map(|(name, value)| (*name, f64::from(*value))).collect();
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&self.layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some("vertex"),
                compilation_options: compilation_options.clone(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: (!key.is_double_sided).then_some(wgpu::Face::Back),
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: SAMPLE_COUNT, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &self.module,
                entry_point: Some("fragment"),
                compilation_options,
                targets: &[Some(wgpu::ColorTargetState {
                    format: COLOR_FORMAT,
                    blend: key.is_blended.then_some(wgpu::BlendState::ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

fn buffer(
    binding: u32,
    ty: wgpu::BufferBindingType,
    visibility: wgpu::ShaderStages,
) -> wgpu::BindGroupLayoutEntry {
    entry(
        binding,
        wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        visibility,
    )
}

fn entry(binding: u32, ty: wgpu::BindingType, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}
