//! [`Gpu`]: an adapter of the system, opened.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use wgpu::{DeviceType, PollType};

use crate::distance_build::BoxKernel;
use crate::error::GpuError;
use crate::pages::Pages;
use crate::shaders::{self, Light, Walks};
use crate::traffic::Traffic;

/// How long a dispatch may take before the device counts as lost; dispatches are cut to take a small part
/// of it.
const PATIENCE: Duration = Duration::from_secs(60);

/// Bytes that no record in a buffer exceeds: devices refuse a buffer that holds less than one.
const LARGEST_RECORD: u64 = 512;

/// Storage buffers that a shader binds beside the pages of maps; the least of devices binds eight.
pub(crate) const OTHER_BUFFERS: u32 = 6;

/// An opened GPU.
pub struct Gpu {
    name: String,
    software: bool,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) traffic: Traffic,
    /// What was compiled so far.
    pipelines: Mutex<HashMap<(Kernel, [Pages; 2]), wgpu::ComputePipeline>>,
    /// Bytes that a shader binds at once.
    largest_binding: u64,
    /// The first thing that went wrong, told by the driver at any time.
    fault: Arc<Mutex<Option<Fault>>>,
}

/// A shader's entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kernel {
    /// The nearest hit of every ray.
    Closest(Walks),
    /// The next step of every slot.
    Advance(Light),
    /// The finest level of a pyramid.
    Ground,
    /// The other levels.
    Coarser,
    /// A step of making a distance map of kind boxes.
    Boxes(BoxKernel),
    /// The codes of the nodes of a distance map of another kind.
    Nearest,
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
            // For benchmarks alone.
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
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
        let limits = device.limits();
        let largest_binding = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        let pipelines = Mutex::default();
        let traffic = Traffic::default();
        let gpu =
            Self { name, software, device, queue, traffic, pipelines, largest_binding, fault };
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

    /// The device, for shaders of a program's own beside these.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue that everything here is submitted to.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// A buffer with these bytes.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub(crate) fn upload(
        &self,
        what: &'static str,
        bytes: &[u8],
    ) -> Result<wgpu::Buffer, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let buffer = self.allocate(what, bytes.len() as u64, usage)?;
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

    /// A buffer of this many bytes, rounded up to a multiple of sixteen and at least one record of any kind.
    ///
    /// # Errors
    /// As [`Gpu::upload`].
    pub(crate) fn allocate(
        &self,
        what: &'static str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let size = bytes.max(LARGEST_RECORD).div_ceil(16) * 16;
        if size > self.largest_binding {
            return Err(self.too_large(what, size, self.largest_binding));
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
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match fault {
            None => Ok(()),
            Some(Fault::OutOfMemory) => Err(GpuError::OutOfMemory { adapter: self.name.clone() }),
            Some(Fault::Lost(reason)) => Err(self.lost(reason)),
        }
    }

    /// A kernel for maps that are cut into these pages; compiled when it is asked for first.
    pub(crate) fn pipeline(&self, kernel: Kernel, pages: [Pages; 2]) -> wgpu::ComputePipeline {
        let known = || self.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = known().get(&(kernel, pages)) {
            return pipeline.clone();
        }
        // That takes seconds on some devices; others may ask for other kernels meanwhile.
        let pipeline = self.compiled(kernel, pages);
        known().entry((kernel, pages)).or_insert(pipeline).clone()
    }

    fn compiled(&self, kernel: Kernel, pages: [Pages; 2]) -> wgpu::ComputePipeline {
        let (name, text) = match kernel {
            Kernel::Closest(walks) => ("closest", shaders::closest(walks, pages)),
            Kernel::Advance(light) => ("advance", shaders::advance(light, pages[0])),
            Kernel::Ground => ("ground", shaders::pyramid(pages)),
            Kernel::Coarser => ("coarser", shaders::pyramid(pages)),
            Kernel::Boxes(kernel) => (kernel.name(), shaders::boxes(pages)),
            Kernel::Nearest => ("find_nearest", shaders::nearest(pages)),
        };
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &module,
            entry_point: Some(name),
            compilation_options: Default::default(),
            cache: None,
        })
    }

    /// The same device, as if it bound no more bytes at once.
    #[cfg(test)]
    pub(crate) fn with_largest_binding(self, bytes: u64) -> Self {
        Self { largest_binding: bytes, ..self }
    }

    /// Bytes that a shader binds at once.
    pub(crate) fn largest_binding(&self) -> u64 {
        self.largest_binding
    }

    /// Refuses maps that are cut into more pages than a shader binds.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub(crate) fn check_pages(&self, pages: u32, bytes: u64) -> Result<(), GpuError> {
        let bound = self.device.limits().max_storage_buffers_per_shader_stage;
        let room = bound.saturating_sub(OTHER_BUFFERS);
        if pages <= room.max(2) {
            return Ok(());
        }
        Err(self.too_large("height maps", bytes, u64::from(room) * self.largest_binding))
    }

    pub(crate) fn too_large(&self, what: &'static str, needed: u64, allowed: u64) -> GpuError {
        GpuError::TooLarge { what, adapter: self.name.clone(), needed, allowed }
    }

    fn lost(&self, reason: String) -> GpuError {
        GpuError::Lost { adapter: self.name.clone(), reason }
    }
}

/// Keeps the first fault.
fn tell(told: &Mutex<Option<Fault>>, fault: Fault) {
    told.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
}
