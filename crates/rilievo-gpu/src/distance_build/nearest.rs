//! Distance maps of the kinds with nodes made on a device (`shaders/nearest.wgsl`), code for code those of the CPU.
//!
//! The shader encloses the distance of a node, in sums of two floats, as far as it takes to tell its code; where what it rounds leaves two
//! codes, or a search grows long, the CPU finds the code of the node ([`NodeSearch`]). So the codes are the CPU's whatever a device
//! rounds, and what it does not round well only takes longer.

use rilievo::map::{
    Code, Codes, DistanceBits, DistanceKind, DistanceMap, DistanceOptions, DistanceParts,
    HeightMap, Layout, NodeSearch, Pyramid, Samples,
};
use std::ops::Range;
use wgpu::BufferUsages;

use super::pace::Pace;
use super::refused;
use crate::bounds;
use crate::device::{Gpu, Kernel};
use crate::error::GpuError;
use crate::pages::Paged;
use crate::records::{NEAREST_TASK_WORDS, Words};

/// Nodes whose codes are brought back at once.
const CHUNK: u32 = 1 << 20;

/// Nodes of the first dispatch.
const FIRST_DISPATCH: u32 = 1 << 12;

/// What the shader writes for a node that it leaves to the CPU.
const UNKNOWN: u32 = u32::MAX;

/// The map of a kind with nodes.
pub(super) fn distances(
    gpu: &Gpu,
    heights: &HeightMap,
    kind: DistanceKind,
    options: &DistanceOptions,
) -> Result<DistanceMap, GpuError> {
    let pyramid = Pyramid::build_as(heights, Layout::Default);
    let search = NodeSearch::new(heights, &pyramid, kind, options).map_err(refused)?;
    let (mut codes, unknown) = codes(gpu, (heights, &pyramid), &search, options)?;
    for (&at, code) in unknown.iter().zip(search.codes(&unknown)) {
        codes[at] = code as u16;
    }
    let codes = match options.bits {
        DistanceBits::U16 => Codes::U16(codes),
        DistanceBits::U8 => Codes::U8(codes.into_iter().map(|code| code as u8).collect()),
    };
    let parts = DistanceParts {
        kind,
        size: options.size,
        cells: [heights.x().cells(), heights.y().cells()],
        raw_range: heights.raw_range(),
        metric: options.metric,
        quantum: search.quantum,
        codes,
    };
    DistanceMap::from_parts(parts).map_err(refused)
}

/// The codes of all nodes, x fastest, and which nodes have none yet.
pub(super) fn codes(
    gpu: &Gpu,
    maps: (&HeightMap, &Pyramid),
    search: &NodeSearch<'_>,
    options: &DistanceOptions,
) -> Result<(Vec<u16>, Vec<usize>), GpuError> {
    match Shares::of(search, maps.0) {
        Some(shares) => Build::new(gpu, maps, (search, shares), options)?.codes(),
        None => {
            let nodes = options.size.iter().map(|&n| n as usize).product();
            Ok((vec![0; nodes], (0..nodes).collect()))
        }
    }
}

/// Lengths as shares of the depth of a map, as the shader has them.
#[derive(Clone, Copy, Debug)]
struct Shares {
    /// Of a cell along x and y, and of a raw height.
    metric: [f64; 3],
    step: f64,
    /// The least distance that is surely coded no steps.
    above: f64,
    /// Shares of a step: what the codes of distances little below and little above a step are not told by.
    before_next: f64,
    after_own: f64,
    /// What bounds are widened by, raw heights.
    wider: f64,
}

impl Shares {
    /// Those of a map, unless its numbers leave what floats hold well or codes could hardly ever be told.
    fn of(search: &NodeSearch<'_>, heights: &HeightMap) -> Option<Self> {
        let (low, high) = heights.raw_range();
        let range = f64::from(high) - f64::from(low);
        let (metric, depth) = (search.metric(), search.depth);
        let metric = [metric.x, metric.y, metric.z].map(|side| side / depth);
        let held = range >= 1e-22 && metric[..2].iter().all(|side| (1e-12..=1e6).contains(side));
        let [quantum, margin, error, scale] =
            [search.quantum, search.margin, search.error, search.scale].map(|x| x / depth);
        // A node's place is off by 2^-49 of itself; sums and products of what lies as near as the surface by some 20 units of 2^-48.
        let rounding = (scale + 32.0 * (1.0 + metric[0] + metric[1])) * 2.0f64.powi(-48);
        let slack = error + 2.0 * rounding;
        let told = slack + margin < 0.1 * quantum;
        (held && told).then(|| Self {
            metric,
            step: quantum,
            above: margin + slack,
            before_next: (slack + rounding + margin / 32.0) / quantum,
            after_own: rounding / quantum,
            wider: f64::from(low.abs().max(high.abs())) * 2.0f64.powi(-21),
        })
    }
}

/// Buffers of a build.
struct Build<'a> {
    gpu: &'a Gpu,
    heights: &'a HeightMap,
    code: Code,
    shares: Shares,
    kind: DistanceKind,
    options: &'a DistanceOptions,
    samples: Paged,
    bounds: Paged,
    places: wgpu::Buffer,
    codes: wgpu::Buffer,
}

impl<'a> Build<'a> {
    fn new(
        gpu: &'a Gpu,
        (heights, pyramid): (&'a HeightMap, &Pyramid),
        (search, shares): (&NodeSearch<'_>, Shares),
        options: &'a DistanceOptions,
    ) -> Result<Self, GpuError> {
        let mut words = Vec::new();
        bounds::write_bounds(&mut words, 0, pyramid);
        let samples = Paged::of_samples(gpu, heights)?;
        let bounds = Paged::new(gpu, "bounds", words.len() as u64)?;
        gpu.check_pages(samples.pages().count + bounds.pages().count, heights.bytes())?;
        bounds.write(gpu, 0, bytemuck::cast_slice(&words));
        let mut places = Vec::new();
        (0..3).flat_map(|axis| search.places(axis)).for_each(|place| places.double(place));
        let nodes = options.size.iter().map(|&n| u64::from(n)).product::<u64>();
        let codes = 4 * nodes.min(CHUNK.into());
        Ok(Self {
            gpu,
            heights,
            code: pyramid.code(),
            shares,
            kind: search.kind(),
            options,
            samples,
            bounds,
            places: gpu.upload("nodes", bytemuck::cast_slice(&places))?,
            codes: gpu.allocate("codes", codes, BufferUsages::STORAGE | BufferUsages::COPY_SRC)?,
        })
    }

    /// The codes of all nodes, x fastest, and which nodes have none yet.
    fn codes(&self) -> Result<(Vec<u16>, Vec<usize>), GpuError> {
        let nodes: u32 = self.options.size.iter().product();
        let pages = [self.samples.pages(), self.bounds.pages()];
        let pipeline = self.gpu.pipeline(Kernel::Nearest, pages);
        let (mut codes, mut unknown) = (Vec::with_capacity(nodes as usize), Vec::new());
        let mut pace = Pace::new(FIRST_DISPATCH, CHUNK);
        for chunk in (0..nodes).step_by(CHUNK as usize) {
            let end = nodes.min(chunk.saturating_add(CHUNK));
            let mut first = chunk;
            while first < end {
                let next = first + pace.next(end - first);
                self.dispatch(&pipeline, chunk, first..next, &mut pace)?;
                first = next;
            }
            let bytes = self.gpu.copy_out(&self.codes)?;
            let words: Vec<u32> =
                bytemuck::pod_collect_to_vec(&bytes[..4 * (end - chunk) as usize]);
            for code in words {
                if code == UNKNOWN {
                    unknown.push(codes.len());
                }
                codes.push(code as u16);
            }
        }
        Ok((codes, unknown))
    }

    /// Finds the codes of some nodes of a chunk, and waits for them.
    fn dispatch(
        &self,
        pipeline: &wgpu::ComputePipeline,
        chunk: u32,
        nodes: Range<u32>,
        pace: &mut Pace,
    ) -> Result<(), GpuError> {
        let (gpu, count) = (self.gpu, nodes.end - nodes.start);
        let task = gpu.upload("task", bytemuck::cast_slice(&self.task(chunk, nodes)))?;
        let group = |index: u32, buffers: &[&wgpu::Buffer]| {
            let entries: Vec<_> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("nearest"),
                layout: &pipeline.get_bind_group_layout(index),
                entries: &entries,
            })
        };
        let own = [&task, &self.places, &self.codes];
        let pages = [&self.bounds, &self.samples].map(|side| side.buffers().iter().collect());
        let [bounds, samples]: [Vec<&wgpu::Buffer>; 2] = pages;
        let groups = [group(0, &own), group(1, &bounds), group(2, &samples)];
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        let mut pass = commands.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        for (index, group) in (0..).zip(&groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.dispatch_workgroups(count.div_ceil(64), 1, 1);
        drop(pass);
        pace.run(gpu, commands)
    }

    /// The struct `Task` of `shaders/nearest.wgsl`, field by field.
    fn task(&self, chunk: u32, nodes: Range<u32>) -> Vec<u32> {
        let (map, shares) = (self.heights, self.shares);
        let mut words = vec![map.width(), map.height(), map.x().cells(), map.y().cells()];
        let floats = matches!(map.samples(), Samples::F32(_));
        words.extend([map.x().first_cell() < 0, floats].map(u32::from));
        words.extend([0, 0]);
        words.extend(self.options.size);
        words.extend([nodes.start, nodes.end, bounds::levels(map)]);
        words.extend([
            u32::from(self.kind == DistanceKind::Published),
            self.options.bits.max_code(),
        ]);
        words.float(self.code.base);
        words.float(self.code.step);
        for share in [shares.wider, shares.before_next, shares.after_own] {
            words.float(share as f32);
        }
        words.push(chunk);
        for share in shares.metric.into_iter().chain([shares.above, shares.step]) {
            words.double(share);
        }
        debug_assert_eq!(words.len(), NEAREST_TASK_WORDS);
        words
    }
}
