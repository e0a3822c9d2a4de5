//! One device, and what it says when something goes wrong.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::preview::PreviewError;

/// After this a device counts as lost. A software one draws a large scene in a few seconds.
const PATIENCE: Duration = Duration::from_secs(60);

/// A device with its queue.
pub struct Gpu {
    pub adapter_name: String,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// The first error that the device has reported.
    error: Arc<Mutex<Option<String>>>,
}

/// Why there is no device to draw with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoGpu {
    /// The machine has no Vulkan adapter.
    NoAdapter,
    /// It has one, which cannot be used.
    Refused(String),
}

impl Gpu {
    /// # Errors
    /// See [`NoGpu`].
    pub fn open() -> Result<Self, NoGpu> {
        let descriptor = wgpu::InstanceDescriptor {
            // GL would be taken silently where Vulkan is missing, and is not compliant there.
            backends: wgpu::Backends::VULKAN,
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        };
        let instance = wgpu::Instance::new(descriptor);
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = match pollster::block_on(instance.request_adapter(&options)) {
            Ok(adapter) => adapter,
            Err(wgpu::RequestAdapterError::NotFound { .. }) => return Err(NoGpu::NoAdapter),
            Err(error) => return Err(NoGpu::Refused(error.to_string())),
        };
        let adapter_name = adapter.get_info().name;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("preview"),
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| NoGpu::Refused(format!("{adapter_name}: {error}")))?;
        let error = Arc::new(Mutex::new(None));
        let seen = Arc::clone(&error);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut first = seen.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert_with(|| error.to_string());
        }));
        Ok(Self { adapter_name, device, queue, error })
    }

    /// # Errors
    /// `Device` with the first thing that the device has complained of.
    pub fn check(&self) -> Result<(), PreviewError> {
        let error = self.error.lock().unwrap_or_else(PoisonError::into_inner);
        match error.as_ref() {
            Some(error) => Err(self.failure(error)),
            None => Ok(()),
        }
    }

    /// Hands over what is queued, with `commands`, and waits until it is done.
    ///
    /// # Errors
    /// `Device`, also where it takes longer than [`PATIENCE`].
    pub fn finish(&self, commands: Option<wgpu::CommandBuffer>) -> Result<(), PreviewError> {
        let index = self.queue.submit(commands);
        self.check()?;
        self.wait(index)?;
        self.check()
    }

    fn wait(&self, index: wgpu::SubmissionIndex) -> Result<(), PreviewError> {
        let wait = wgpu::PollType::Wait { submission_index: Some(index), timeout: Some(PATIENCE) };
        self.device.poll(wait).map(|_| ()).map_err(|error| self.failure(error))
    }

    /// An error that names the adapter. wgpu tells a chain of causes over several lines: one line here.
    pub fn failure(&self, what: impl ToString) -> PreviewError {
        let what = what.to_string();
        let words: Vec<_> = what.split_whitespace().collect();
        PreviewError::Device(format!("{}: {}", self.adapter_name, words.join(" ")))
    }
}
