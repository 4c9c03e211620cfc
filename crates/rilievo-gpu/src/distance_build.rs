//! Distance maps made on a device, code for code those of the CPU: kind boxes here (`shaders/boxes.wgsl`), the kinds with nodes in
//! `nearest`.
//!
//! Squared distances are whole numbers of 64 bits. What the CPU computes in `f64` before it counts, the shader computes in
//! integers rounded as `f64` rounds (`shaders/exact.wgsl`), and the code of a number of steps is looked up in a table that the
//! CPU makes ([`BoxSteps`]): no device can flush, fuse or reorder any of it. Slabs go in batches, so
//! that what is written between is small, and rows by the time they take, so that no dispatch is long.

mod nearest;
mod pace;

use rilievo::map::{
    BoxSteps, Codes, DistanceBits, DistanceKind, DistanceMap, DistanceMapError, DistanceOptions,
    DistanceParts, HeightMap, Samples,
};
use wgpu::BufferUsages;

use crate::device::{Gpu, Kernel};
use crate::distances;
use crate::error::GpuError;
use crate::pages::{Paged, Pages};
use crate::records::BOX_TASK_WORDS;
use pace::Pace;

/// Bytes of steps that a batch of slabs is to take at most, in each of two buffers.
const BATCH_BYTES: u64 = 32 << 20;

/// Voxels along x and y, and slabs at once: workgroups of a dispatch along an axis.
const LARGEST_SIDE: u32 = 65_535;

/// Cells along an axis of a column that the CPU looks through.
const LARGEST_COLUMN: u32 = 128;

/// Voxels of the first dispatch that searches along the map.
const FIRST_VOXELS: u32 = 1 << 16;

/// The steps of the build, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum BoxKernel {
    /// Heights under each column.
    Columns,
    /// Squared distances straight up or down.
    Rises,
    /// Those within a row.
    Rows,
    /// Codes, from all rows.
    Codes,
}

impl BoxKernel {
    /// The entry point.
    pub fn name(self) -> &'static str {
        match self {
            Self::Columns => "find_columns",
            Self::Rises => "find_rises",
            Self::Rows => "find_rows",
            Self::Codes => "find_codes",
        }
    }

    /// What it binds of group 0.
    fn bindings(self) -> &'static [u32] {
        match self {
            Self::Columns => &[0, 2],
            Self::Rises => &[0, 1, 2, 3],
            Self::Rows => &[0, 3, 4],
            Self::Codes => &[0, 1, 4, 5],
        }
    }
}

impl Gpu {
    /// The distance map of `heights`, made on the device: what [`DistanceMap::from_height`] makes, code for code.
    ///
    /// # Errors
    /// [`GpuError::Distances`] for options that are not allowed, [`GpuError::TooLarge`] past what the device holds,
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn distance_map(
        &self,
        heights: &HeightMap,
        kind: DistanceKind,
        options: &DistanceOptions,
    ) -> Result<DistanceMap, GpuError> {
        match kind {
            DistanceKind::Boxes => self.boxes(heights, options),
            DistanceKind::Corrected | DistanceKind::Published => {
                nearest::distances(self, heights, kind, options)
            }
        }
    }

    fn boxes(
        &self,
        heights: &HeightMap,
        options: &DistanceOptions,
    ) -> Result<DistanceMap, GpuError> {
        let steps = BoxSteps::new(heights, options).map_err(refused)?;
        let codes = Build::new(self, (heights, options), &steps)?.codes(&steps)?;
        let codes = match options.bits {
            DistanceBits::U16 => Codes::U16(codes),
            DistanceBits::U8 => Codes::U8(codes.into_iter().map(|code| code as u8).collect()),
        };
        let parts = DistanceParts {
            kind: DistanceKind::Boxes,
            size: options.size,
            cells: [heights.x().cells(), heights.y().cells()],
            raw_range: heights.raw_range(),
            metric: options.metric,
            quantum: steps.quantum,
            codes,
        };
        DistanceMap::from_parts(parts).map_err(refused)
    }
}

fn refused(error: DistanceMapError) -> GpuError {
    GpuError::Distances { reason: error.to_string() }
}

/// Buffers of a build.
struct Build<'a> {
    gpu: &'a Gpu,
    heights: &'a HeightMap,
    size: [u32; 3],
    /// Slabs of a batch.
    batch: u32,
    samples: Paged,
    /// Whether heights under columns are found on the device.
    finds_columns: bool,
    /// Bindings 1 to 5 of group 0.
    buffers: [wgpu::Buffer; 5],
}

impl<'a> Build<'a> {
    fn new(
        gpu: &'a Gpu,
        (heights, options): (&'a HeightMap, &DistanceOptions),
        steps: &BoxSteps,
    ) -> Result<Self, GpuError> {
        let size = options.size;
        let [nx, ny, nz] = size.map(u64::from);
        let slab = 8 * nx * ny;
        let largest = gpu.largest_binding();
        if size[0].max(size[1]) > LARGEST_SIDE || slab > largest {
            return Err(gpu.too_large("slabs of a distance map", slab, largest));
        }
        let batch = (BATCH_BYTES.min(largest) / slab).clamp(1, nz.min(LARGEST_SIDE.into()));
        let samples = Paged::of_samples(gpu, heights)?;
        gpu.check_pages(samples.pages().count, heights.bytes())?;
        let slabs = steps.slabs.iter().map(|height| height.to_bits());
        let tables: Vec<u64> = slabs.chain(steps.least.iter().copied()).collect();
        let storage = BufferUsages::STORAGE;
        let codes = 4 * nx.div_ceil(2) * ny * nz;
        // One invocation reads all samples of a column.
        let cells = [heights.x().cells(), heights.y().cells()];
        let finds_columns = (0..2).all(|k| cells[k] / size[k] < LARGEST_COLUMN);
        let columns = if finds_columns {
            gpu.allocate("columns", slab, storage)?
        } else {
            let columns = distances::columns(heights, [size[0], size[1]]);
            gpu.upload("columns", bytemuck::cast_slice(&columns))?
        };
        let buffers = [
            gpu.upload("distance tables", bytemuck::cast_slice(&tables))?,
            columns,
            gpu.allocate("steps", slab * batch, storage)?,
            gpu.allocate("steps", slab * batch, storage)?,
            gpu.allocate("distance codes", codes, storage | BufferUsages::COPY_SRC)?,
        ];
        Ok(Self { gpu, heights, size, batch: batch as u32, samples, finds_columns, buffers })
    }

    /// All codes, x fastest.
    fn codes(&self, steps: &BoxSteps) -> Result<Vec<u16>, GpuError> {
        let [nx, ny, nz] = self.size;
        for first in (0..nz).step_by(self.batch as usize) {
            let slabs = self.batch.min(nz - first);
            let task = self.task(steps, [first, 0]);
            let task = self.gpu.upload("task", bytemuck::cast_slice(&task))?;
            let mut commands = self.gpu.device.create_command_encoder(&Default::default());
            let mut pass = commands.begin_compute_pass(&Default::default());
            if first == 0 && self.finds_columns {
                let groups = [nx.div_ceil(8), ny.div_ceil(8), 1];
                self.encode(&mut pass, (BoxKernel::Columns, &task), groups);
            }
            let groups = [nx.div_ceil(64), ny, slabs];
            self.encode(&mut pass, (BoxKernel::Rises, &task), groups);
            drop(pass);
            self.gpu.queue.submit([commands.finish()]);
            for kernel in [BoxKernel::Rows, BoxKernel::Codes] {
                self.search(kernel, steps, [first, slabs])?;
            }
        }
        let bytes = self.gpu.copy_out(&self.buffers[4])?;
        let row = 4 * nx.div_ceil(2) as usize;
        let rows = bytes.chunks_exact(row).take(ny as usize * nz as usize);
        Ok(rows.flat_map(|row| bytemuck::pod_collect_to_vec(&row[..2 * nx as usize])).collect())
    }

    /// Runs a kernel that searches along the map, over some slabs: so many rows at a time as take a dispatch's time.
    fn search(
        &self,
        kernel: BoxKernel,
        steps: &BoxSteps,
        [first, slabs]: [u32; 2],
    ) -> Result<(), GpuError> {
        let [nx, ny, _] = self.size;
        let across = if kernel == BoxKernel::Codes { nx.div_ceil(2) } else { nx };
        let mut pace = Pace::new((FIRST_VOXELS / (nx * slabs)).max(1), ny);
        let mut row = 0;
        while row < ny {
            let rows = pace.next(ny - row);
            let task = self.task(steps, [first, row]);
            let task = self.gpu.upload("task", bytemuck::cast_slice(&task))?;
            let mut commands = self.gpu.device.create_command_encoder(&Default::default());
            let mut pass = commands.begin_compute_pass(&Default::default());
            self.encode(&mut pass, (kernel, &task), [across.div_ceil(64), rows, slabs]);
            drop(pass);
            pace.run(self.gpu, commands)?;
            row += rows;
        }
        Ok(())
    }

    fn encode(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        (kernel, task): (BoxKernel, &wgpu::Buffer),
        [x, y, z]: [u32; 3],
    ) {
        let device = &self.gpu.device;
        let pages = [self.samples.pages(), Pages::of(0, 4)];
        let pipeline = self.gpu.pipeline(Kernel::Boxes(kernel), pages);
        let entry = |&binding: &u32| {
            let buffer = if binding == 0 { task } else { &self.buffers[binding as usize - 1] };
            wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
        };
        let entries: Vec<_> = kernel.bindings().iter().map(entry).collect();
        pass.set_pipeline(&pipeline);
        let group = |index, entries: &[wgpu::BindGroupEntry<'_>]| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(kernel.name()),
                layout: &pipeline.get_bind_group_layout(index),
                entries,
            })
        };
        pass.set_bind_group(0, &group(0, &entries), &[]);
        if kernel == BoxKernel::Columns {
            let entries: Vec<_> = (0..)
                .zip(self.samples.buffers())
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            pass.set_bind_group(1, &group(1, &entries), &[]);
        }
        pass.dispatch_workgroups(x, y, z);
    }

    /// The struct `Task` of `shaders/boxes.wgsl`, field by field.
    fn task(&self, steps: &BoxSteps, [first, row]: [u32; 2]) -> Vec<u32> {
        let map = self.heights;
        let mut words = vec![map.width(), map.height(), map.x().cells(), map.y().cells()];
        let floats = matches!(map.samples(), Samples::F32(_));
        words.extend([map.x().first_cell() < 0, floats].map(u32::from));
        words.extend([0, steps.least.len() as u32]);
        words.extend(self.size);
        words.push(first);
        let [height, per_unit] = [steps.height, steps.per_unit].map(f64::to_bits);
        let [x, y] = steps.weights;
        for whole in [x, y, height, per_unit] {
            words.extend([whole as u32, (whole >> 32) as u32]);
        }
        words.extend([row, 0, 0, 0]);
        debug_assert_eq!(words.len(), BOX_TASK_WORDS);
        words
    }
}

#[cfg(test)]
mod tests;
