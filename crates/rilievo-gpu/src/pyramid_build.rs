//! [`PyramidBuild`]: pyramids made on a device (`shaders/pyramid.wgsl`), whole or above an edit.
//!
//! A dispatch makes a rectangle of one level from the heights or from the level below. What it writes is, bit for bit,
//! what [`Pyramid`] holds.

use std::ops::Range;

use rilievo::map::{Code, NodeRuns, Pyramid};

use crate::device::{Gpu, Kernel};
use crate::error::GpuError;
use crate::maps::{LevelPlace, Maps, Shape};
use crate::records::{TASK_WORDS, Words};

/// Bytes from one task to the next: no device asks for more.
const TASK_STRIDE: usize = 256;

/// Invocations of a workgroup along an axis.
const GROUP: u32 = 8;

/// Workgroups of a dispatch along an axis.
const LARGEST_GROUPS: u32 = 65_535;

/// Dispatches that wait to be run, in their order.
#[derive(Default)]
pub(crate) struct PyramidBuild {
    tasks: Vec<u32>,
    /// Kernel and workgroups of each.
    dispatches: Vec<(Kernel, [u32; 2])>,
}

/// The least number that every device tells from 0, and so do its sums and differences.
const LEAST: f32 = 7.9e-31;

impl PyramidBuild {
    /// Whether codes are such that a device builds with them: no number is so small that it may be
    /// taken for 0.
    pub fn knows(code: Code) -> bool {
        [code.base, code.step].iter().all(|x| *x == 0.0 || x.abs() >= LEAST)
    }

    /// Adds the build of the nodes of the finest level in `runs`, along x and y, and of what lies above them.
    pub fn add(&mut self, shape: &Shape, code: Code, runs: [NodeRuns; 2]) {
        let mut runs = runs;
        let mut below = None;
        for level in &shape.levels {
            for y in runs[1].iter().filter(|run| !run.is_empty()) {
                for x in runs[0].iter().filter(|run| !run.is_empty()) {
                    // Two words and four rows of blocks a node.
                    let rect = [2 * x.start..2 * x.end, 4 * y.start..4 * y.end];
                    self.add_rect(shape, code, (level, below), rect);
                }
            }
            runs = [Pyramid::parent_nodes(&runs[0]), Pyramid::parent_nodes(&runs[1])];
            below = Some(level);
        }
    }

    fn add_rect(
        &mut self,
        shape: &Shape,
        code: Code,
        (level, below): (&LevelPlace, Option<&LevelPlace>),
        [x, y]: [Range<u32>; 2],
    ) {
        let side = (LARGEST_GROUPS * GROUP) as usize;
        for first_y in y.clone().step_by(side) {
            for first_x in x.clone().step_by(side) {
                let last = |first: u32, end: u32| end.min(first.saturating_add(side as u32));
                let (first, end) =
                    ([first_x, first_y], [last(first_x, x.end), last(first_y, y.end)]);
                let groups = [0, 1].map(|axis| (end[axis] - first[axis]).div_ceil(GROUP));
                let kernel = if below.is_none() { Kernel::Ground } else { Kernel::Coarser };
                self.dispatches.push((kernel, groups));
                let at = self.tasks.len();
                write_task(&mut self.tasks, (shape, code), (level, below), [first, end]);
                debug_assert_eq!(self.tasks.len() - at, TASK_WORDS);
                self.tasks.resize(at + TASK_STRIDE / 4, 0);
            }
        }
    }

    /// Submits everything that was added; later work on the device finds it done.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn run(&self, gpu: &Gpu, maps: &Maps) -> Result<(), GpuError> {
        if self.dispatches.is_empty() {
            return Ok(());
        }
        let prepared = self.prepared(gpu, maps)?;
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        prepared.encode(&mut commands.begin_compute_pass(&Default::default()));
        gpu.queue.submit([commands.finish()]);
        gpu.check()
    }

    /// Everything that was added, ready to be encoded.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn prepared(&self, gpu: &Gpu, maps: &Maps) -> Result<Prepared<'_>, GpuError> {
        let tasks = gpu.upload("tasks", bytemuck::cast_slice(&self.tasks))?;
        let pipelines = [Kernel::Ground, Kernel::Coarser].map(|kernel| {
            let pipeline = gpu.pipeline(kernel, maps.pages());
            let groups = maps.build_groups(gpu, &pipeline, kernel == Kernel::Ground);
            (pipeline, groups)
        });
        let task = |(number, &(kernel, _)): (u64, &(Kernel, [u32; 2]))| {
            let binding = wgpu::BufferBinding {
                buffer: &tasks,
                offset: number * TASK_STRIDE as u64,
                size: wgpu::BufferSize::new(4 * TASK_WORDS as u64),
            };
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("task"),
                layout: &pipelines[side(kernel)].0.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::Buffer(binding),
                }],
            })
        };
        let tasks = (0..).zip(&self.dispatches).map(task).collect();
        Ok(Prepared { build: self, pipelines, tasks })
    }
}

/// Which of the two pipelines a kernel is.
fn side(kernel: Kernel) -> usize {
    usize::from(kernel != Kernel::Ground)
}

/// A build with all that its dispatches bind.
pub(crate) struct Prepared<'a> {
    build: &'a PyramidBuild,
    pipelines: [(wgpu::ComputePipeline, Vec<wgpu::BindGroup>); 2],
    tasks: Vec<wgpu::BindGroup>,
}

impl Prepared<'_> {
    /// Encodes all dispatches, in their order.
    pub fn encode(&self, pass: &mut wgpu::ComputePass<'_>) {
        for (&(kernel, [x, y]), task) in self.build.dispatches.iter().zip(&self.tasks) {
            let (pipeline, groups) = &self.pipelines[side(kernel)];
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, task, &[]);
            for (index, group) in (1..).zip(groups) {
                pass.set_bind_group(index, group, &[]);
            }
            pass.dispatch_workgroups(x, y, 1);
        }
    }
}

/// The struct `Task` of `shaders/pyramid.wgsl`, field by field.
fn write_task(
    words: &mut Vec<u32>,
    (shape, code): (&Shape, Code),
    (level, below): (&LevelPlace, Option<&LevelPlace>),
    [first, end]: [[u32; 2]; 2],
) {
    words.extend(shape.samples);
    words.extend(shape.cells);
    let [padded, floats] = [shape.padded, shape.floats].map(u32::from);
    words.extend([padded, floats, shape.place.heights, 0]);
    words.extend(first);
    words.extend(end);
    words.extend([level.nodes[0], level.maxima, level.minima, 0]);
    match below {
        Some(below) => {
            words.extend(below.nodes);
            words.extend([below.maxima, below.minima]);
        }
        None => words.extend([0; 4]),
    }
    words.float(code.base);
    words.float(code.step);
    words.extend([0; 2]);
}
