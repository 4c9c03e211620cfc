//! Device times, for benchmarks: rays that stay on the device are traced again and again.
//!
//! Where the device counts its own time (`TIMESTAMP_QUERY`), that of a pass counts, without the way there and back;
//! elsewhere the time on the wall from submitting a pass to its end.

use std::time::Instant;

use rilievo::Ray;
use wgpu::BufferUsages;

use crate::device::Gpu;
use crate::error::GpuError;
use crate::records;
use crate::world::{Answer, BATCH, GpuWorld};

/// Rays on a device, with room for their hits.
pub struct GpuRays {
    parts: Vec<Part>,
}

struct Part {
    rays: wgpu::Buffer,
    hits: wgpu::Buffer,
    count: u32,
}

impl Gpu {
    /// Whether [`Gpu::time_pass`] reads the device's own clock.
    pub fn has_timestamps(&self) -> bool {
        self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Seconds that a compute pass takes on the device; waits for its end.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn time_pass(
        &self,
        encode: impl FnOnce(&mut wgpu::ComputePass<'_>),
    ) -> Result<f64, GpuError> {
        let mut commands = self.device.create_command_encoder(&Default::default());
        if !self.has_timestamps() {
            encode(&mut commands.begin_compute_pass(&Default::default()));
            let begin = Instant::now();
            self.queue.submit([commands.finish()]);
            self.wait()?;
            return Ok(begin.elapsed().as_secs_f64());
        }
        let times = self.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2,
        });
        encode(&mut commands.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("timed"),
            timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                query_set: &times,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            }),
        }));
        let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        let resolved = self.allocate("times", 16, usage)?;
        commands.resolve_query_set(&times, 0..2, &resolved, 0);
        self.queue.submit([commands.finish()]);
        let bytes = self.copy_out(&resolved)?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes[..16]);
        Ok(ticks[1].saturating_sub(ticks[0]) as f64
            * 1e-9
            * f64::from(self.queue.get_timestamp_period()))
    }

    /// The bytes of a buffer made with [`wgpu::BufferUsages::COPY_SRC`].
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn copy_out(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let read = self.allocate("read", buffer.size(), usage)?;
        let mut commands = self.device.create_command_encoder(&Default::default());
        commands.copy_buffer_to_buffer(buffer, 0, &read, 0, buffer.size());
        self.queue.submit([commands.finish()]);
        self.read(&read, buffer.size())
    }
}

impl GpuWorld<'_> {
    /// Brings rays to the device.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn hold(&self, rays: &[Ray]) -> Result<GpuRays, GpuError> {
        let part = |rays: &[Ray]| {
            let mut words = Vec::with_capacity(rays.len() * records::RAY_WORDS);
            rays.iter().for_each(|ray| records::write_ray(&mut words, ray, self.anchor()));
            let bytes = (rays.len() * records::HIT_WORDS * 4) as u64;
            Ok(Part {
                rays: self.gpu().upload("rays", bytemuck::cast_slice(&words))?,
                hits: self.gpu().allocate("hits", bytes, BufferUsages::STORAGE)?,
                count: rays.len() as u32,
            })
        };
        Ok(GpuRays { parts: rays.chunks(BATCH).map(part).collect::<Result<_, _>>()? })
    }

    /// Seconds that finding the nearest hits of rays takes on the device. The hits stay there.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn time_closest(&self, rays: &GpuRays) -> Result<f64, GpuError> {
        let pipeline = self.gpu().pipeline(self.maps().closest(), self.maps().pages());
        let mut seconds = 0.0;
        for part in &rays.parts {
            let groups = self.groups(&pipeline, &part.rays, &part.hits);
            self.set_params(0..part.count, Answer::Nearest);
            seconds += self.gpu().time_pass(|pass| {
                pass.set_pipeline(&pipeline);
                for (index, group) in (0..).zip(&groups) {
                    pass.set_bind_group(index, group, &[]);
                }
                pass.dispatch_workgroups(part.count.div_ceil(64), 1, 1);
            })?;
        }
        Ok(seconds)
    }

    /// Seconds that making the pyramids of all maps from their heights takes on the device.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn time_build(&self) -> Result<f64, GpuError> {
        let build = self.maps().full_build();
        let prepared = build.prepared(self.gpu(), self.maps())?;
        self.gpu().time_pass(|pass| prepared.encode(pass))
    }
}
