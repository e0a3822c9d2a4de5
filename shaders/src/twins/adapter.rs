//! Runs WGSL with its inputs on an adapter, for the tests of the twins.

use half::f16;
use meshcolor::image::Image;
use wgpu::util::DeviceExt;

/// Numbers in [0, 1) that are the same in every run (splitmix64).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }

    pub fn whole(&mut self, count: f32) -> f32 {
        (self.next() * count).floor()
    }
}

/// A compute shader `main` over rows of floats. Binding 0 has the input, 1 the output, 3 the stack, 4 its sampler.
pub struct Job<'a> {
    pub wgsl: String,
    pub input: &'a [u8],
    pub output_byte_count: usize,
    pub stack: &'a Image,
    /// Further storage buffers, with their bindings.
    pub tables: &'a [(u32, &'a [u8])],
    pub workgroup_count: u32,
}

impl Job<'_> {
    /// The output; `None` where there is no adapter.
    pub fn run(self) -> Option<Vec<f32>> {
        let (device, queue) = device()?;
        let filled = |bytes: &[u8], usage| {
            let label = None;
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label, contents: bytes, usage })
        };
        let storage = wgpu::BufferUsages::STORAGE;
        let input = filled(self.input, storage);
        let output = filled(&vec![0; self.output_byte_count], storage | wgpu::BufferUsages::COPY_SRC);
        let tables: Vec<_> = self.tables.iter().map(|(at, bytes)| (*at, filled(bytes, storage))).collect();
        let texture = upload(&device, &queue, self.stack);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(self.wgsl.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut entries = vec![
            wgpu::BindGroupEntry { binding: 0, resource: input.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: output.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(&view) },
            wgpu::BindGroupEntry { binding: 4, resource: wgpu::BindingResource::Sampler(&sampler) },
        ];
        entries.extend(tables.iter().map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: buffer.as_entire_binding(),
        }));
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let run = |encoder: &mut wgpu::CommandEncoder| {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(self.workgroup_count, 1, 1);
        };
        Some(read_back(&device, &queue, &output, run))
    }
}

fn device() -> Option<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::VULKAN,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapter = match pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
    {
        Ok(adapter) => adapter,
        Err(wgpu::RequestAdapterError::NotFound { .. }) => return None,
        Err(error) => panic!("{error}"),
    };
    let device = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()));
    Some(device.expect("the adapter has a device"))
}

/// Encodes and runs `run`, then fetches a buffer.
fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    run: impl FnOnce(&mut wgpu::CommandEncoder),
) -> Vec<f32> {
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    run(&mut encoder);
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    queue.submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |result| result.expect("the buffer is mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device answers");
    let bytes = copy.get_mapped_range(..).expect("the buffer is mapped");
    bytemuck::pod_collect_to_vec(&bytes[..])
}

/// As half floats: those are filtered without rounding weights on every driver that we know.
fn upload(device: &wgpu::Device, queue: &wgpu::Queue, image: &Image) -> wgpu::Texture {
    let texels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    let values = texels.flat_map(|(x, y)| image.normalized(x, y));
    let bytes: Vec<u8> = values.flat_map(|value| f16::from_f32(value).to_le_bytes()).collect();
    device.create_texture_with_data(
        queue,
        &wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: image.width, height: image.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        &bytes,
    )
}
