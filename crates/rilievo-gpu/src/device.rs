//! [`Gpu`]: an adapter of the system, opened.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use wgpu::{DeviceType, PollType};

use crate::error::GpuError;
use crate::shaders;

/// How long a dispatch may take before the device counts as lost; dispatches are cut to take a small part
/// of it.
const PATIENCE: Duration = Duration::from_secs(60);

/// Bytes that no record in a buffer exceeds: devices refuse a buffer that holds less than one.
const LARGEST_RECORD: u64 = 512;

/// An opened GPU.
pub struct Gpu {
    name: String,
    software: bool,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// The shader of [`shaders::CLOSEST`].
    pub(crate) closest: wgpu::ComputePipeline,
    /// The first thing that went wrong, told by the driver at any time.
    fault: Arc<Mutex<Option<Fault>>>,
}

/// What a driver tells outside of any call.
#[derive(Clone, Debug)]
enum Fault {
    OutOfMemory,
    Lost(String),
}

impl Gpu {
    /// Opens the system's fastest adapter: Vulkan, Metal or Direct3D 12. `WGPU_BACKEND` and
    /// `VK_DRIVER_FILES` narrow the choice.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], or [`GpuError::NoDevice`] if the adapter cannot do what is needed:
    /// eight storage buffers in a compute shader.
    pub fn open() -> Result<Self, GpuError> {
        pollster::block_on(Self::open_async())
    }

    async fn open_async() -> Result<Self, GpuError> {
        let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        let instance = wgpu::Instance::new(descriptor);
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = instance
            .request_adapter(&options)
            .await
            .map_err(|error| GpuError::NoAdapter { reason: error.to_string() })?;
        let info = adapter.get_info();
        let name = format!("{} ({})", info.name, info.backend);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("rilievo"),
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = adapter.request_device(&descriptor).await.map_err(|error| {
            GpuError::NoDevice { adapter: name.clone(), reason: error.to_string() }
        })?;
        let fault = Arc::new(Mutex::new(None));
        let told = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error| {
            let fault = match error {
                wgpu::Error::OutOfMemory { .. } => Fault::OutOfMemory,
                other => Fault::Lost(other.to_string()),
            };
            tell(&told, fault);
        }));
        let told = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                tell(&told, Fault::Lost(message));
            }
        });
        let software = info.device_type == DeviceType::Cpu;
        let closest = pipeline(&device);
        let gpu = Self { name, software, device, queue, closest, fault };
        gpu.check()?;
        Ok(gpu)
    }

    /// The adapter's name and its interface.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the adapter is a program on the CPU.
    pub fn is_software(&self) -> bool {
        self.software
    }

    /// A buffer with these bytes; at least with room for one record of any kind.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub(crate) fn upload(
        &self,
        what: &'static str,
        bytes: &[u8],
    ) -> Result<wgpu::Buffer, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let buffer = self.allocate(what, (bytes.len() as u64).max(LARGEST_RECORD), usage)?;
        let whole = bytes.len() / 4 * 4;
        self.queue.write_buffer(&buffer, 0, &bytes[..whole]);
        if whole < bytes.len() {
            let mut rest = [0; 4];
            rest[..bytes.len() - whole].copy_from_slice(&bytes[whole..]);
            self.queue.write_buffer(&buffer, whole as u64, &rest);
        }
        self.check()?;
        Ok(buffer)
    }

    /// A buffer of this many bytes, rounded up to a multiple of sixteen.
    ///
    /// # Errors
    /// As [`Gpu::upload`].
    pub(crate) fn allocate(
        &self,
        what: &'static str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let size = bytes.div_ceil(16).max(1) * 16;
        let limits = self.device.limits();
        let allowed = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        if size > allowed {
            let adapter = self.name.clone();
            return Err(GpuError::TooLarge { what, adapter, needed: size, allowed });
        }
        let descriptor =
            wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
        let buffer = self.device.create_buffer(&descriptor);
        self.check()?;
        Ok(buffer)
    }

    /// Waits until everything submitted is done.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        // A program on a busy processor may take any time, and no driver resets it.
        let timeout = (!self.software).then_some(PATIENCE);
        let poll = PollType::Wait { submission_index: None, timeout };
        let polled = self.device.poll(poll);
        self.check()?;
        polled.map(|_| ()).map_err(|error| self.lost(error.to_string()))
    }

    /// The bytes of a buffer made with [`wgpu::BufferUsages::MAP_READ`].
    ///
    /// # Errors
    /// As [`Gpu::wait`].
    pub(crate) fn read(&self, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
        let slice = buffer.slice(..bytes);
        slice.map_async(wgpu::MapMode::Read, |_| {});
        self.wait()?;
        let view = slice.get_mapped_range().map_err(|error| self.lost(error.to_string()))?;
        let read = view.to_vec();
        drop(view);
        buffer.unmap();
        Ok(read)
    }

    /// What the driver told since the device was opened.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        let fault = self.fault.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
        match fault {
            None => Ok(()),
            Some(Fault::OutOfMemory) => Err(GpuError::OutOfMemory { adapter: self.name.clone() }),
            Some(Fault::Lost(reason)) => Err(self.lost(reason)),
        }
    }

    fn lost(&self, reason: String) -> GpuError {
        GpuError::Lost { adapter: self.name.clone(), reason }
    }
}

/// Keeps the first fault.
fn tell(told: &Mutex<Option<Fault>>, fault: Fault) {
    told.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(fault);
}

fn pipeline(device: &wgpu::Device) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("closest"),
        source: wgpu::ShaderSource::Wgsl(shaders::CLOSEST.into()),
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("closest"),
        layout: None,
        module: &module,
        entry_point: Some("closest"),
        compilation_options: Default::default(),
        cache: None,
    })
}
