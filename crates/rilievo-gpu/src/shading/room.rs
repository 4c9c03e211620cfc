//! [`Room`]: buffers in which camera rays are on their way, and how shaders are given them.

use wgpu::BufferUsages;

use super::{COUNT_WORDS, SLOT_WORDS};
use crate::device::Gpu;
use crate::error::GpuError;
use crate::records::{HIT_WORDS, RAY_WORDS};
use crate::shaders::Light;

/// Buffers of slots.
pub(super) struct Room {
    pub slots: usize,
    pub rays: wgpu::Buffer,
    pub hits: wgpu::Buffer,
    pub of_slots: wgpu::Buffer,
    pub trees: wgpu::Buffer,
    pub read: wgpu::Buffer,
    pub count: wgpu::Buffer,
}

impl Room {
    pub fn new(gpu: &Gpu, slots: usize, kernel: Light) -> Result<Self, GpuError> {
        let rays = if kernel.parts.path { 2 * slots } else { slots };
        let bytes = |count: usize, words: usize| 4 * (count * words) as u64;
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let source = storage | BufferUsages::COPY_SRC;
        let read = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let state = bytes(slots, kernel.state_words()) + 4 * COUNT_WORDS as u64;
        Ok(Self {
            slots,
            rays: gpu.allocate("rays", bytes(rays, RAY_WORDS), storage)?,
            hits: gpu.allocate("hits", bytes(rays, HIT_WORDS), storage)?,
            of_slots: gpu.allocate("slots", bytes(slots, SLOT_WORDS), source)?,
            trees: gpu.allocate("paths", state, source)?,
            read: gpu.allocate("slots", bytes(slots, SLOT_WORDS), read)?,
            count: gpu.allocate("parameters", 16, read)?,
        })
    }
}

/// A group of buffers.
pub(super) fn bind(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    index: u32,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("advance"),
        layout: &pipeline.get_bind_group_layout(index),
        entries: &entries,
    })
}

/// Adds a step of so many slots.
pub(super) fn encode(
    pipeline: &wgpu::ComputePipeline,
    groups: &[wgpu::BindGroup],
    slots: u32,
    commands: &mut wgpu::CommandEncoder,
) {
    let mut pass = commands.begin_compute_pass(&Default::default());
    pass.set_pipeline(pipeline);
    for (index, group) in (0..).zip(groups) {
        pass.set_bind_group(index, group, &[]);
    }
    pass.dispatch_workgroups(slots.div_ceil(64), 1, 1);
}
