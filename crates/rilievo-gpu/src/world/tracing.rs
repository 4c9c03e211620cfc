//! Rays to a GPU, their answers back: the work is cut into dispatches that take about a tenth of a second each.

use std::ops::Range;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use wgpu::BufferUsages;

use super::GpuWorld;
use crate::error::GpuError;
use crate::records::{HIT_WORDS, NOTHING, RAY_WORDS};

/// Rays uploaded at once.
pub(crate) const BATCH: usize = 1 << 20;

/// Rays that one thread writes at a time.
const CHUNK: usize = 4096;

/// What a ray is answered by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// The record of its nearest hit.
    Nearest,
    /// One word: whether it meets anything.
    Whether,
}

impl Answer {
    fn words(self) -> usize {
        match self {
            Self::Nearest => HIT_WORDS,
            Self::Whether => 1,
        }
    }
}

impl GpuWorld<'_> {
    /// The answers to at most [`BATCH`] rays, given how one is written.
    pub(super) fn trace<R: Sync>(
        &self,
        rays: &[R],
        write: impl Fn(&mut Vec<u32>, &R) + Sync,
        answer: Answer,
    ) -> Result<Vec<u32>, GpuError> {
        let gpu = self.gpu;
        let written = rays.par_chunks(CHUNK).map(|rays| {
            let mut words = Vec::with_capacity(rays.len() * RAY_WORDS);
            rays.iter().for_each(|ray| write(&mut words, ray));
            words
        });
        let words = written.collect::<Vec<_>>().concat();
        let rays_buffer = gpu.upload("rays", bytemuck::cast_slice(&words))?;
        let bytes = (rays.len() * answer.words() * 4) as u64;
        let hits = gpu.allocate("hits", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC)?;
        let read = gpu.allocate("hits", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let pipeline = gpu.pipeline(self.maps.closest(), self.maps.pages());
        let groups = self.groups(&pipeline, &rays_buffer, &hits);
        let count = rays.len() as u32;
        let mut first = 0;
        while first < count {
            if self.is_stopped() {
                return Ok(vec![NOTHING; rays.len() * answer.words()]);
            }
            let end = count.min(first + self.paces().rays.get());
            self.dispatch(&pipeline, &groups, first..end, answer)?;
            first = end;
        }
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        commands.copy_buffer_to_buffer(&hits, 0, &read, 0, bytes.div_ceil(16) * 16);
        gpu.queue.submit([commands.finish()]);
        let bytes = gpu.read(&read, bytes)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// What the kernel binds, for rays and hits in these buffers.
    pub(crate) fn groups(
        &self,
        pipeline: &wgpu::ComputePipeline,
        rays: &wgpu::Buffer,
        hits: &wgpu::Buffer,
    ) -> Vec<wgpu::BindGroup> {
        let own = [&self.params, rays, hits];
        let entries: Vec<_> = (0..)
            .zip(own.into_iter().chain(&self.buffers))
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let mut groups = vec![self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("closest"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        })];
        groups.extend(self.maps.groups(self.gpu, pipeline));
        groups
    }

    /// Tells the next dispatch its rays and what is asked of them.
    pub(crate) fn set_params(&self, rays: Range<u32>, answer: Answer) {
        let whether = u32::from(answer == Answer::Whether);
        let params = [whether, rays.start, rays.end, self.surfaces];
        self.gpu.queue.write_buffer(&self.params, 0, bytemuck::cast_slice(&params));
    }

    /// Traces the first `count` rays of a buffer that stay on the device: with the next commands, and then the answer is
    /// true, or before them, where they are too many for one dispatch.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub(crate) fn trace_slots(
        &self,
        pipeline: &wgpu::ComputePipeline,
        groups: &[wgpu::BindGroup],
        count: u32,
        commands: &mut wgpu::CommandEncoder,
    ) -> Result<bool, GpuError> {
        if count <= self.paces().rays.get() {
            self.set_params(0..count, Answer::Nearest);
            Self::pass(pipeline, groups, count, commands);
            return Ok(true);
        }
        let mut first = 0;
        while first < count && !self.is_stopped() {
            let end = count.min(first + self.paces().rays.get());
            self.dispatch(pipeline, groups, first..end, Answer::Nearest)?;
            first = end;
        }
        Ok(false)
    }

    /// Adds the tracing of so many rays.
    fn pass(
        pipeline: &wgpu::ComputePipeline,
        groups: &[wgpu::BindGroup],
        rays: u32,
        commands: &mut wgpu::CommandEncoder,
    ) {
        let mut pass = commands.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        for (index, group) in (0..).zip(groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.dispatch_workgroups(rays.div_ceil(64), 1, 1);
    }

    /// Makes the next dispatches as long as the time that one of so many rays took says.
    pub(crate) fn took(&self, rays: u32, took: Duration) {
        self.paces().rays.took(rays, took, self.patience());
    }

    /// Traces some of the rays and waits for them; the next dispatch is as long as the time says.
    fn dispatch(
        &self,
        pipeline: &wgpu::ComputePipeline,
        groups: &[wgpu::BindGroup],
        rays: Range<u32>,
        answer: Answer,
    ) -> Result<(), GpuError> {
        let gpu = self.gpu;
        self.set_params(rays.clone(), answer);
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        let count = rays.end - rays.start;
        Self::pass(pipeline, groups, count, &mut commands);
        let begin = Instant::now();
        gpu.queue.submit([commands.finish()]);
        gpu.wait()?;
        self.took(count, begin.elapsed());
        Ok(())
    }
}
